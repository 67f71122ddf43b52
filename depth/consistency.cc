#include "depth/consistency.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "depth/consistency_kernels.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr float kUnknown = InverseDepthMap::kUnknown;

// Union-find over the pixels of a map; a root is its component's first pixel.
class Components {
 public:
  explicit Components(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t Root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t ra = Root(a), rb = Root(b);
    parent_[std::max(ra, rb)] = std::min(ra, rb);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

void RemoveSmallComponents(InverseDepthMap& map, double jump, int min_pixels) {
  const int width = map.w.width(), height = map.w.height();
  Components components(map.w.size());
  const auto index = [&](int x, int y) { return static_cast<std::uint32_t>(y * width + x); };
  const auto connected = [&](float a, float b) {
    return a >= 0 && b >= 0 && static_cast<double>(std::abs(a - b)) <= jump;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float here = map.w(x, y);
      if (x > 0 && connected(map.w(x - 1, y), here)) components.Join(index(x - 1, y), index(x, y));
      if (y > 0 && connected(map.w(x, y - 1), here)) components.Join(index(x, y - 1), index(x, y));
    }
  }
  std::vector<int> pixels(map.w.size(), 0);
  for (std::uint32_t i = 0; i < pixels.size(); ++i) ++pixels[components.Root(i)];
  for (std::uint32_t i = 0; i < pixels.size(); ++i) {
    if (pixels[components.Root(i)] >= min_pixels) continue;
    map.w.data()[i] = kUnknown;
    map.confidence.data()[i] = 0;
  }
}

InverseDepthMap MakeConsistent(const InverseDepthMap& own,
                               const std::vector<NeighbourMap>& neighbours,
                               const ConsistencyOptions& options) {
  const int width = own.w.width(), height = own.w.height();
  std::vector<InverseDepthMap> warped(neighbours.size());
  ParallelForEach(0, static_cast<std::int64_t>(neighbours.size()), [&](std::int64_t i) {
    InverseDepthMap& map = warped[static_cast<std::size_t>(i)];
    map = {Image<float>(width, height, kUnknown), Image<float>(width, height)};
    WarpMap(neighbours[static_cast<std::size_t>(i)], map);
  });
  InverseDepthMap result{Image<float>(width, height, kUnknown), Image<float>(width, height)};
  const ConsistencyVote vote{own, neighbours, warped, options};
  ParallelFor(0, height, 8, [&](std::int64_t first, std::int64_t last) {
    DecideRows(vote, static_cast<int>(first), static_cast<int>(last), result);
  });
  RemoveSmallComponents(result, 2 * options.step, options.min_component);
  return result;
}

}  // namespace lamella
