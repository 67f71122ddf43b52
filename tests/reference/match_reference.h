// Matching of SIFT descriptors as COLMAP states it, one pair of features at a time.
#pragma once

#include <vector>

#include "pipeline/poses/match.h"

namespace lamella::reference {

std::vector<FeatureMatch> MatchFeatures(const Descriptors& a, const Descriptors& b,
                                        const MatchCriteria& criteria = {});

}  // namespace lamella::reference
