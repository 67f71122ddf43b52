// Exposure differences between the views of a capture.
#pragma once

#include <vector>

#include "depth/sight.h"
#include "lightfield/image.h"

namespace lamella {

// A factor per view and channel that makes the views' colours agree where they see the same
// surface: medians of the log ratios between neighbouring views, joined by least squares (depth.md
// section 4); the geometric mean over the views is 1. Only the views' depth is used; `colors` are
// their pictures. Views that share too little with the others keep 1.
std::vector<Rgb> ExposureGains(const std::vector<SourceView>& views,
                               const std::vector<const Image<Rgb>*>& colors);

}  // namespace lamella
