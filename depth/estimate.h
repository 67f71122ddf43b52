// Depth for every view of a capture: read this first.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lightfield/depth_map.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"
#include "lightfield/view.h"

namespace lamella {

struct DepthOptions {
  // see estimate.cc: Describe and ApplyQuality
};

OptionTable Describe(DepthOptions& options);
void ApplyQuality(Quality quality, DepthOptions& options);

}  // namespace lamella
