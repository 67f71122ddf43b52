// The vote of depth/consistency.h, pixel by pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "depth/consistency.h"

namespace lamella::reference {

constexpr float kOwnBonus = 0.5F;
constexpr float kSureConfirmations = 3;
constexpr float kSurfaceJump = 0.03F;  // between pixels of one surface, relative

// A point of one picture in another.
struct Seen {
  double x = 0, y = 0, w = 0;
  bool in_front = false;
};

inline Seen Transfer(const PictureMap& map, double x, double y, double w) {
  const double u = map.m(0, 0) * x + map.m(0, 1) * y + map.m(0, 2) + w * map.b(0);
  const double v = map.m(1, 0) * x + map.m(1, 1) * y + map.m(1, 2) + w * map.b(1);
  const double z = map.m(2, 0) * x + map.m(2, 1) * y + map.m(2, 2) + w * map.b(2);
  if (!(z > 1e-6)) return {};
  const double reciprocal = 1 / z;
  return {u * reciprocal, v * reciprocal, w * reciprocal, true};
}

inline bool Inside(const Image<float>& image, const Seen& p) {
  return p.in_front && p.x >= 0 && p.y >= 0 && p.x < image.width() && p.y < image.height();
}

// What a neighbour's map puts at each pixel of this view, and the neighbour's confidence.
inline InverseDepthMap Warp(const NeighbourMap& from, int width, int height) {
  InverseDepthMap warped{Image<float>(width, height, InverseDepthMap::kUnknown),
                         Image<float>(width, height)};
  const Image<float>& w = from.map->w;
  for (int y = 0; y < w.height(); ++y) {
    for (int x = 0; x < w.width(); ++x) {
      if (w(x, y) < 0) continue;
      const Seen p = Transfer(from.back, x + 0.5, y + 0.5, static_cast<double>(w(x, y)));
      if (!Inside(warped.w, p)) continue;
      const int u = static_cast<int>(p.x), v = static_cast<int>(p.y);
      const auto value = static_cast<float>(p.w);
      if (value <= warped.w(u, v)) continue;
      warped.w(u, v) = value;
      warped.confidence(u, v) = from.map->confidence(x, y);
    }
  }
  return warped;
}

// The map between pixel centres: bilinear where its four values lie on one surface (within `jump`,
// relative), else the nearest one. A slanted surface would otherwise seem to disagree with itself.
inline float Sample(const Image<float>& w, const Seen& p, float jump) {
  const float nearest = w(static_cast<int>(p.x), static_cast<int>(p.y));
  const double gx = std::clamp(p.x - 0.5, 0.0, w.width() - 1.0),
               gy = std::clamp(p.y - 0.5, 0.0, w.height() - 1.0);
  const int x0 = std::min(static_cast<int>(gx), std::max(0, w.width() - 2));
  const int y0 = std::min(static_cast<int>(gy), std::max(0, w.height() - 2));
  const int x1 = std::min(x0 + 1, w.width() - 1), y1 = std::min(y0 + 1, w.height() - 1);
  const float corners[4] = {w(x0, y0), w(x1, y0), w(x0, y1), w(x1, y1)};
  for (const float corner : corners) {
    if (!(std::abs(corner - nearest) <= jump * nearest)) return nearest;
  }
  const auto fx = static_cast<float>(gx - x0), fy = static_cast<float>(gy - y0);
  return (1 - fy) * ((1 - fx) * corners[0] + fx * corners[1]) +
         fy * ((1 - fx) * corners[2] + fx * corners[3]);
}

class PixelVote {
 public:
  PixelVote(const InverseDepthMap& own, const std::vector<NeighbourMap>& neighbours,
            const std::vector<InverseDepthMap>& warped, const ConsistencyOptions& options)
      : own_(own),
        neighbours_(neighbours),
        warped_(warped),
        options_(options),
        needed_(std::min(options.agreeing, std::max(1, static_cast<int>(neighbours.size()) / 2))) {}

  void Decide(int x, int y, InverseDepthMap& result) const {
    Verdict best;
    float best_score = -std::numeric_limits<float>::infinity(), confidence = 0;
    for (std::size_t i = 0; i <= warped_.size(); ++i) {
      const InverseDepthMap& map = i == 0 ? own_ : warped_[i - 1];
      const float candidate = map.w(x, y);
      // Most warped candidates repeat the best so far.
      if (candidate < 0 || (i > 0 && Same(static_cast<double>(candidate), best.w))) continue;
      const float bonus = i == 0 ? kOwnBonus : 0;
      const Verdict verdict = Judge(x, y, static_cast<double>(candidate), i, best_score - bonus);
      const float score = static_cast<float>(verdict.confirmed - verdict.contradicted) + bonus;
      if (score <= best_score) continue;
      best = verdict;
      best_score = score;
      confidence = map.confidence(x, y);
    }
    const bool known = best.confirmed >= needed_ && best_score > 0;
    result.w(x, y) = known ? static_cast<float>(best.mean) : InverseDepthMap::kUnknown;
    const float share = std::min(1.0F, static_cast<float>(best.confirmed) / kSureConfirmations);
    result.confidence(x, y) = known ? confidence * share : 0;
  }

 private:
  struct Verdict {
    double w = -1, mean = 0;              // the candidate, and its mean with what confirms it
    int confirmed = 0, contradicted = 0;  // maps other than the one that it is from
  };

  bool Same(double a, double b) const {
    return b >= 0 && std::abs(a - b) <= std::max(options_.tolerance * b, 0.5 * options_.step);
  }

  // `from`: 0 the own map's candidate, else that of neighbour from - 1. A map does not confirm
  // itself. Ends early where confirmations less contradictions can't exceed `to_beat` any more.
  Verdict Judge(int x, int y, double w, std::size_t from, float to_beat) const {
    Verdict verdict{w, 0, 0, 0};
    double sum = w;
    const auto own = static_cast<double>(own_.w(x, y));
    if (from > 0 && own >= 0 && Same(own, w)) {
      ++verdict.confirmed;
      sum += own;
    }
    for (std::size_t i = 0; i < neighbours_.size(); ++i) {
      const auto undecided = static_cast<int>(neighbours_.size() - i);
      if (static_cast<float>(verdict.confirmed - verdict.contradicted + undecided) <= to_beat)
        break;
      if (i + 1 == from) continue;
      const NeighbourMap& neighbour = neighbours_[i];
      const Seen p = Transfer(neighbour.there, x + 0.5, y + 0.5, w);
      if (!Inside(neighbour.map->w, p)) continue;
      const auto there = static_cast<double>(Sample(neighbour.map->w, p, kSurfaceJump));
      if (there < 0) continue;
      const double limit =
          std::max(options_.tolerance * p.w, 0.5 * options_.step * (w > 0 ? p.w / w : 1));
      if (there < p.w - limit) ++verdict.contradicted;
      if (std::abs(there - p.w) > limit) continue;
      const Seen back = Transfer(neighbour.back, p.x, p.y, there);
      const double dx = back.x - x - 0.5, dy = back.y - y - 0.5;
      if (!back.in_front || dx * dx + dy * dy > options_.return_px * options_.return_px) continue;
      ++verdict.confirmed;
      sum += back.w;
    }
    verdict.mean = sum / (verdict.confirmed + 1);
    return verdict;
  }

  const InverseDepthMap& own_;
  const std::vector<NeighbourMap>& neighbours_;
  const std::vector<InverseDepthMap>& warped_;
  ConsistencyOptions options_;
  int needed_;
};

// MakeConsistent with all of its components, small ones too.
inline InverseDepthMap VoteOnMap(const InverseDepthMap& own,
                                 const std::vector<NeighbourMap>& neighbours,
                                 const ConsistencyOptions& options) {
  const int width = own.w.width(), height = own.w.height();
  std::vector<InverseDepthMap> warped;
  for (const NeighbourMap& neighbour : neighbours) warped.push_back(Warp(neighbour, width, height));
  InverseDepthMap result{Image<float>(width, height), Image<float>(width, height)};
  const PixelVote vote(own, neighbours, warped, options);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) vote.Decide(x, y, result);
  }
  return result;
}

}  // namespace lamella::reference
