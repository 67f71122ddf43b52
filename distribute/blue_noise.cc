#include "distribute/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace lamella {
namespace {

constexpr double kSigma = 1.5;  // of the Gaussian that measures crowding, columns (Ulichney 1993)

// Points on a torus and how crowded every place is: the sum of a Gaussian over all points.
class Crowd {
 public:
  Crowd(int size, LensletArray::Lattice lattice)
      : size_(size),
        hexagonal_(lattice == LensletArray::Lattice::kHexagonal),
        taken_(Count(), 0),
        crowding_(Count(), 0.0) {
    for (int from_odd = 0; from_odd < (hexagonal_ ? 2 : 1); ++from_odd) {
      for (int dy = 0; dy < size; ++dy) {
        for (int dx = 0; dx < size; ++dx) weight_.push_back(Weight(from_odd, dx, dy));
      }
    }
  }

  bool Taken(std::size_t at) const { return taken_[at] != 0; }

  void Toggle(std::size_t at) {
    const double sign = Taken(at) ? -1 : 1;
    taken_[at] = Taken(at) ? 0 : 1;
    const auto size = static_cast<std::size_t>(size_);
    const std::size_t x = at % size, y = at / size;
    const double* weights = weight_.data() + (hexagonal_ && y % 2 == 1 ? Count() : 0);
    for (std::size_t row = 0; row < size; ++row) {
      const double* from = weights + (row + size - y) % size * size;
      double* to = crowding_.data() + row * size;
      for (std::size_t column = 0; column < size; ++column) {
        to[column] += sign * from[(column + size - x) % size];
      }
    }
  }

  std::size_t TightestCluster() const { return Extreme(true); }
  std::size_t LargestVoid() const { return Extreme(false); }

 private:
  std::size_t Count() const { return static_cast<std::size_t>(size_) * std::size_t(size_); }

  // At dx columns and dy rows from a point, the nearest way round the torus.
  double Weight(int from_odd, int dx, int dy) const {
    // An odd row lies further right: seen from it even rows are half a column to the left.
    const double shift = hexagonal_ && dy % 2 != 0 ? (from_odd == 1 ? -0.5 : 0.5) : 0.0;
    const double x = std::remainder(dx + shift, size_);
    const double y = std::remainder(dy, size_) * (hexagonal_ ? std::numbers::sqrt3 / 2 : 1.0);
    return std::exp(-(x * x + y * y) / (2 * kSigma * kSigma));
  }

  // The most crowded taken place, or the least crowded free one. Sums that differ by rounding are
  // ties, so that compilers agree.
  std::size_t Extreme(bool cluster) const {
    constexpr double kTie = 1e-9;
    std::size_t best = Count();
    for (std::size_t at = 0; at < Count(); ++at) {
      if (Taken(at) != cluster) continue;
      const double gain = best == Count() ? 1.0 : crowding_[at] - crowding_[best];
      if (best == Count() || (cluster ? gain : -gain) > kTie) best = at;
    }
    return best;
  }

  int size_;
  bool hexagonal_;
  std::vector<std::uint8_t> taken_;
  std::vector<double> crowding_, weight_;
};

// A tenth of the places, first at random, then moved from clusters to voids until they rest.
std::vector<std::size_t> FirstPoints(Crowd& crowd, std::size_t count) {
  std::uint64_t state = 1;
  for (std::size_t placed = 0; placed < count / 10;) {
    state = state * 6364136223846793005U + 1442695040888963407U;  // Knuth's MMIX generator
    const std::size_t at = (state >> 33U) % count;
    if (crowd.Taken(at)) continue;
    crowd.Toggle(at);
    ++placed;
  }
  for (std::size_t moves = 0; moves < count; ++moves) {
    const std::size_t cluster = crowd.TightestCluster();
    crowd.Toggle(cluster);
    const std::size_t empty = crowd.LargestVoid();
    crowd.Toggle(empty);
    if (empty == cluster) break;
  }
  std::vector<std::size_t> points;
  for (std::size_t at = 0; at < count; ++at) {
    if (crowd.Taken(at)) points.push_back(at);
  }
  return points;
}

}  // namespace

Image<int> MakeBlueNoise(int size, LensletArray::Lattice lattice) {
  Image<int> ranks(size, size);
  const std::size_t count = ranks.size();
  Crowd crowd(size, lattice);
  const std::vector<std::size_t> first = FirstPoints(crowd, count);
  // The first points by taking the most crowded away, last rank first; then voids are filled.
  for (std::size_t rank = first.size(); rank-- > 0;) {
    const std::size_t at = crowd.TightestCluster();
    crowd.Toggle(at);
    ranks.data()[at] = static_cast<int>(rank);
  }
  for (const std::size_t at : first) crowd.Toggle(at);
  for (std::size_t rank = first.size(); rank < count; ++rank) {
    const std::size_t at = crowd.LargestVoid();
    crowd.Toggle(at);
    ranks.data()[at] = static_cast<int>(rank);
  }
  return ranks;
}

const Image<float>& BlueNoise(LensletArray::Lattice lattice) {
  const auto make = [](LensletArray::Lattice of) {
    const Image<int> ranks = MakeBlueNoise(kBlueNoiseSize, of);
    Image<float> noise(kBlueNoiseSize, kBlueNoiseSize);
    std::transform(ranks.data(), ranks.data() + ranks.size(), noise.data(), [&](int rank) {
      return (static_cast<float>(rank) + 0.5F) / static_cast<float>(ranks.size());
    });
    return noise;
  };
  static const Image<float> square = make(LensletArray::Lattice::kSquare);
  static const Image<float> hexagonal = make(LensletArray::Lattice::kHexagonal);
  return lattice == LensletArray::Lattice::kSquare ? square : hexagonal;
}

}  // namespace lamella
