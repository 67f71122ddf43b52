#include "depth/grid_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();
constexpr float kOwnBonus = 0.5F;
constexpr float kSureAgreement = 3;  // maps
constexpr std::size_t kMaxFusionViews = 8;

// What a neighbour's map puts at each pixel of the fused view; kNothing where that is nothing.
DisparityMap Warp(const GridNeighbour& from) {
  const Image<float>& disparity = from.map->disparity;
  const int width = disparity.width(), height = disparity.height();
  DisparityMap warped{Image<float>(width, height, kNothing), Image<float>(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float d = disparity(x, y);
      const auto u = std::lround(static_cast<float>(x) + d * static_cast<float>(from.columns));
      const auto v = std::lround(static_cast<float>(y) + d * static_cast<float>(from.rows));
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      const int ui = static_cast<int>(u), vi = static_cast<int>(v);
      if (d <= warped.disparity(ui, vi)) continue;
      warped.disparity(ui, vi) = d;
      warped.confidence(ui, vi) = from.map->confidence(x, y);
    }
  }
  return warped;
}

class PixelFusion {
 public:
  PixelFusion(const DisparityMap& own, const std::vector<GridNeighbour>& neighbours,
              const std::vector<DisparityMap>& warped, const FusionTolerance& tolerance)
      : own_(own),
        neighbours_(neighbours),
        warped_(warped),
        agree_(static_cast<float>(tolerance.agree_px)),
        merge_(static_cast<float>(tolerance.merge_px)) {}

  void Fuse(int x, int y, DisparityMap& fused) const {
    float best = own_.disparity(x, y), best_score = -std::numeric_limits<float>::infinity();
    int best_agreeing = 0;
    for (std::size_t i = 0; i <= warped_.size(); ++i) {
      const float candidate = Candidate(i, x, y);
      if (candidate == kNothing) continue;
      const Votes votes = VotesFor(candidate, x, y);
      const float score =
          static_cast<float>(votes.agreeing - votes.through) + (i == 0 ? kOwnBonus : 0);
      if (score > best_score) {
        best = candidate;
        best_score = score;
        best_agreeing = votes.agreeing;
      }
    }
    Average(x, y, best, best_agreeing, fused);
  }

 private:
  struct Votes {
    int agreeing = 0, through = 0;
  };

  const DisparityMap& Map(std::size_t i) const { return i == 0 ? own_ : warped_[i - 1]; }
  float Candidate(std::size_t i, int x, int y) const { return Map(i).disparity(x, y); }

  Votes VotesFor(float d, int x, int y) const {
    Votes votes;
    votes.agreeing = std::abs(own_.disparity(x, y) - d) <= agree_ ? 1 : 0;
    for (const GridNeighbour& n : neighbours_) {
      const Image<float>& map = n.map->disparity;
      const auto u = std::lround(static_cast<float>(x) - d * static_cast<float>(n.columns));
      const auto v = std::lround(static_cast<float>(y) - d * static_cast<float>(n.rows));
      if (u < 0 || v < 0 || u >= map.width() || v >= map.height()) continue;
      const float there = map(static_cast<int>(u), static_cast<int>(v));
      if (std::abs(there - d) <= agree_) ++votes.agreeing;
      if (there < d - agree_) ++votes.through;
    }
    return votes;
  }

  void Average(int x, int y, float best, int agreeing, DisparityMap& fused) const {
    float disparity = 0, confidence = 0, count = 0;
    for (std::size_t i = 0; i <= warped_.size(); ++i) {
      const float candidate = Candidate(i, x, y);
      if (!(std::abs(candidate - best) <= merge_)) continue;
      disparity += candidate - best;
      confidence += Map(i).confidence(x, y);
      count += 1;
    }
    fused.disparity(x, y) = best + disparity / count;
    fused.confidence(x, y) =
        confidence / count * std::min(1.0F, static_cast<float>(agreeing) / kSureAgreement);
  }

  const DisparityMap& own_;
  const std::vector<GridNeighbour>& neighbours_;
  const std::vector<DisparityMap>& warped_;
  float agree_, merge_;
};

}  // namespace

DisparityMap FuseGridView(const DisparityMap& own, const std::vector<GridNeighbour>& neighbours,
                          const FusionTolerance& tolerance) {
  const int width = own.disparity.width(), height = own.disparity.height();
  std::vector<DisparityMap> warped(neighbours.size());
  ParallelForEach(0, static_cast<std::int64_t>(neighbours.size()), [&](std::int64_t i) {
    warped[static_cast<std::size_t>(i)] = Warp(neighbours[static_cast<std::size_t>(i)]);
  });
  DisparityMap fused{Image<float>(width, height), Image<float>(width, height)};
  const PixelFusion fusion(own, neighbours, warped, tolerance);
  ParallelFor(0, height, 8, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      for (int x = 0; x < width; ++x) fusion.Fuse(x, y, fused);
    }
  });
  return fused;
}

std::vector<int> ChooseFusionViews(const std::vector<View>& views, int reference, int reach) {
  const GridPosition at = *views[static_cast<std::size_t>(reference)].grid;
  struct Other {
    int view, rows, columns;
    int Steps() const { return std::max(std::abs(rows), std::abs(columns)); }
    int Squared() const { return rows * rows + columns * columns; }
  };
  std::vector<Other> others;
  int nearest = std::numeric_limits<int>::max();
  for (int v = 0; v < static_cast<int>(views.size()); ++v) {
    const GridPosition p = *views[static_cast<std::size_t>(v)].grid;
    const Other other{v, p.row - at.row, p.column - at.column};
    if (other.Steps() == 0) continue;
    others.push_back(other);
    nearest = std::min(nearest, other.Steps());
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const Other& a, const Other& b) { return a.Squared() < b.Squared(); });
  // The widest spacing at which there are enough, else the one at which there are most.
  std::vector<int> best;
  for (int spacing = std::max(reach, nearest); spacing >= 1 && best.size() < kMaxFusionViews;
       --spacing) {
    std::vector<int> chosen;
    for (const Other& o : others) {
      const bool on_lattice = o.rows % spacing == 0 && o.columns % spacing == 0;
      if (on_lattice && chosen.size() < kMaxFusionViews) chosen.push_back(o.view);
    }
    if (chosen.size() > best.size()) best = std::move(chosen);
  }
  return best;
}

}  // namespace lamella
