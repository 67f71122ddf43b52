// Clean-up of label maps: the colour-weighted median.
#pragma once

#include <cstdint>

#include "depth/cost_volume.h"
#include "lightfield/image.h"

namespace lamella {

// The weighted median over (2 radius + 1)^2 pixels, weight exp(-(|dR| + |dG| + |dB|) / 30) in 8-bit
// codes: edges of depth snap to edges of colour. The smallest label whose pixels and those of
// smaller labels have at least half of the weight. Pixels outside of the image do not vote; nor do
// pixels whose label is kNoLabel, and they stay so.
constexpr SubLabel kNoLabel = 65535;
constexpr int kMaxMedianRadius = 5;
Image<SubLabel> WeightedMedian(ImageSpan<const SubLabel> labels, ImageSpan<const Rgb8> guide,
                               int radius);

}  // namespace lamella
