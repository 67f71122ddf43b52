// Which pairs of a large set of photographs are worth a full matching.
#pragma once

#include <utility>
#include <vector>

#include "lightfield/progress.h"
#include "pipeline/poses/database.h"

namespace lamella {

struct ImageFeatures {
  Descriptors descriptors;
  std::vector<float> sizes;  // of every feature, for their order only
};

// Pairs (i, j) with i < j, in order. All of them for up to 50 images; of more, those that share at
// least 8 matches among the 256 largest features of each (these are seen from far as well as from
// near, and 64 times as cheap to match as 2000), and the 5 next neighbours in the order of names.
std::vector<std::pair<int, int>> SelectPairs(const std::vector<ImageFeatures>& images,
                                             Progress& progress);

}  // namespace lamella
