// Exact matching of SIFT descriptors: every descriptor against every other, so that equal images
// give equal matches (COLMAP's own matcher on a CPU is approximate and differs from run to run).
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/poses/database.h"

namespace lamella {

struct FeatureMatch {
  int first = 0, second = 0;  // indices of the keypoints in either image
  friend bool operator==(const FeatureMatch&, const FeatureMatch&) = default;
};

// COLMAP's criteria: with the angle between descriptors as distance, the best match is nearer than
// `max_angle_rad` and than `max_ratio` times the second best (Lowe 2004), from both sides.
struct MatchCriteria {
  double max_ratio = 0.8;
  double max_angle_rad = 0.7;
};

// Descriptors in the order in which the kernel reads them: blocks of 16 features, within a block
// by pairs of elements, each pair as two 16-bit numbers in one word.
class PackedDescriptors {
 public:
  static constexpr int kBlock = 16;                        // features
  static constexpr int kPairs = Descriptors::kLength / 2;  // of elements
  explicit PackedDescriptors(const Descriptors& descriptors);
  int count() const { return count_; }
  int blocks() const { return (count_ + kBlock - 1) / kBlock; }
  // kPairs rows of kBlock words; features beyond the last are 0.
  const std::int32_t* Block(int block) const {
    return words_.data() + static_cast<std::ptrdiff_t>(block) * kPairs * kBlock;
  }

 private:
  int count_ = 0;
  std::vector<std::int32_t> words_;
};

// By rising first index.
std::vector<FeatureMatch> MatchFeatures(const PackedDescriptors& a, const PackedDescriptors& b,
                                        const MatchCriteria& criteria = {});

}  // namespace lamella
