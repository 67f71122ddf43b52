#include "tests/reference/match_reference.h"

#include <algorithm>
#include <cmath>

namespace lamella::reference {
namespace {

int DotProduct(const Descriptors& a, int i, const Descriptors& b, int j) {
  int sum = 0;
  for (int k = 0; k < Descriptors::kLength; ++k) {
    const int of_a = i * Descriptors::kLength + k, of_b = j * Descriptors::kLength + k;
    sum += a.rows[static_cast<std::size_t>(of_a)] * b.rows[static_cast<std::size_t>(of_b)];
  }
  return sum;
}

int BestMatch(const Descriptors& a, int i, const Descriptors& b, const MatchCriteria& criteria) {
  int best = 0, second = 0, index = -1;
  for (int j = 0; j < b.count; ++j) {
    const int dot = DotProduct(a, i, b, j);
    if (dot > best) {
      second = best;
      best = dot;
      index = j;
    } else if (dot > second) {
      second = dot;
    }
  }
  const double best_angle = std::acos(std::min(best / 262144.0, 1.0));
  const double second_angle = std::acos(std::min(second / 262144.0, 1.0));
  if (best_angle > criteria.max_angle_rad) return -1;
  if (best_angle >= criteria.max_ratio * second_angle) return -1;
  return index;
}

}  // namespace

std::vector<FeatureMatch> MatchFeatures(const Descriptors& a, const Descriptors& b,
                                        const MatchCriteria& criteria) {
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < a.count; ++i) {
    const int j = BestMatch(a, i, b, criteria);
    if (j >= 0 && BestMatch(b, j, a, criteria) == i) matches.push_back({i, j});
  }
  return matches;
}

}  // namespace lamella::reference
