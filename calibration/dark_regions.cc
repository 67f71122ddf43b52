#include "calibration/dark_regions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kTile = 16;

struct Range {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
  void Add(const Range& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};

Image<Range> TileRanges(ImageSpan<const float> grey) {
  Image<Range> tiles((grey.width + kTile - 1) / kTile, (grey.height + kTile - 1) / kTile);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      tiles(x / kTile, y / kTile).Add({grey(x, y), grey(x, y)});
    }
  }
  Image<Range> around(tiles.width(), tiles.height());
  for (int y = 0; y < tiles.height(); ++y) {
    for (int x = 0; x < tiles.width(); ++x) {
      for (int j = std::max(0, y - 1); j <= std::min(tiles.height() - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(tiles.width() - 1, x + 1); ++i) {
          around(x, y).Add(tiles(i, j));
        }
      }
    }
  }
  return around;
}

// Union-find over the regions' provisional labels.
class Labels {
 public:
  int New() {
    parents_.push_back(static_cast<int>(parents_.size()));
    return parents_.back();
  }
  int Root(int label) {
    while (Parent(label) != label) label = Parent(label) = Parent(Parent(label));
    return label;
  }
  void Join(int a, int b) {
    a = Root(a);
    b = Root(b);
    Parent(std::max(a, b)) = std::min(a, b);
  }
  std::size_t size() const { return parents_.size(); }

 private:
  int& Parent(int label) { return parents_[static_cast<std::size_t>(label)]; }
  std::vector<int> parents_;
};

// The root label of every dark pixel, -1 elsewhere.
Image<int> Label(const Image<std::uint8_t>& dark, Labels& labels) {
  Image<int> label(dark.width(), dark.height(), -1);
  for (int y = 0; y < dark.height(); ++y) {
    for (int x = 0; x < dark.width(); ++x) {
      if (dark(x, y) == 0) continue;
      const int left = x > 0 ? label(x - 1, y) : -1, up = y > 0 ? label(x, y - 1) : -1;
      if (left < 0 && up < 0) {
        label(x, y) = labels.New();
      } else {
        label(x, y) = left < 0 ? up : left;
        if (left >= 0 && up >= 0) labels.Join(left, up);
      }
    }
  }
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (label.data()[i] >= 0) label.data()[i] = labels.Root(label.data()[i]);
  }
  return label;
}

std::vector<Region> Bounds(const Image<int>& label, std::size_t num_labels) {
  std::vector<Region> regions(num_labels);
  for (int y = 0; y < label.height(); ++y) {
    for (int x = 0; x < label.width(); ++x) {
      if (label(x, y) < 0) continue;
      Region& r = regions[static_cast<std::size_t>(label(x, y))];
      if (r.area++ == 0) {
        r = {x, y, 1, 1, 1, {}};
        continue;
      }
      const int right = std::max(r.x + r.width, x + 1);
      r.x = std::min(r.x, x);
      r.width = right - r.x;
      r.height = y + 1 - r.y;
    }
  }
  return regions;
}

std::vector<Vector2d> OutlineOf(const Region& region, const Image<int>& label, int wanted) {
  std::vector<Vector2d> outline;
  const int right = region.x + region.width, bottom = region.y + region.height;
  for (int y = region.y; y < bottom; ++y) {
    int first = region.x, last = right - 1;
    while (first < last && label(first, y) != wanted) ++first;
    while (last > first && label(last, y) != wanted) --last;
    outline.emplace_back(first, y + 0.5);
    outline.emplace_back(last + 1, y + 0.5);
  }
  for (int x = region.x; x < right; ++x) {
    int first = region.y, last = bottom - 1;
    while (first < last && label(x, first) != wanted) ++first;
    while (last > first && label(x, last) != wanted) --last;
    outline.emplace_back(x + 0.5, first);
    outline.emplace_back(x + 0.5, last + 1);
  }
  return outline;
}

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

template <class Measure>
Vector2d Farthest(const std::vector<Vector2d>& points, Measure measure) {
  return *std::max_element(points.begin(), points.end(), [&](const Vector2d& a, const Vector2d& b) {
    return measure(a) < measure(b);
  });
}

// Two opposite corners are the farthest point from the middle and the farthest from that one; the
// others lie farthest to either side of their line.
Quad RoughCorners(const std::vector<Vector2d>& outline) {
  const Vector2d middle = std::accumulate(outline.begin(), outline.end(), Vector2d(0, 0)) /
                          static_cast<double>(outline.size());
  const Vector2d a = Farthest(outline, [&](const auto& p) { return (p - middle).squaredNorm(); });
  const Vector2d c = Farthest(outline, [&](const auto& p) { return (p - a).squaredNorm(); });
  // The picture's v runs down: a positive cross product is clockwise.
  const Vector2d d = Farthest(outline, [&](const auto& p) { return Cross(c - a, p - a); });
  const Vector2d b = Farthest(outline, [&](const auto& p) { return -Cross(c - a, p - a); });
  return {a, b, c, d};
}

struct Line {
  Vector2d point, direction;
  double rms = 0;
};

std::optional<Line> FitLine(const std::vector<Vector2d>& points) {
  if (points.size() < 3) return std::nullopt;
  const auto n = static_cast<double>(points.size());
  const Vector2d mean = std::accumulate(points.begin(), points.end(), Vector2d(0, 0)) / n;
  Matrix2d spread = Matrix2d::Zero();
  for (const Vector2d& p : points) spread += (p - mean) * (p - mean).transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Matrix2d> solver(spread);
  return Line{mean, solver.eigenvectors().col(1),
              std::sqrt(std::max(0.0, solver.eigenvalues()[0]))};
}

std::optional<Vector2d> Intersection(const Line& a, const Line& b) {
  const double cross = Cross(a.direction, b.direction);
  if (std::abs(cross) < 0.05) return std::nullopt;
  return a.point + a.direction * (Cross(b.point - a.point, b.direction) / cross);
}

// The outline's points nearest to each side, without those near its ends.
std::array<std::vector<Vector2d>, 4> PointsOfSides(const std::vector<Vector2d>& outline,
                                                   const Quad& corners) {
  constexpr double kEnd = 0.12;
  std::array<std::vector<Vector2d>, 4> sides;
  for (const Vector2d& p : outline) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity(), place = 0;
    for (std::size_t s = 0; s < 4; ++s) {
      const Vector2d along = corners[(s + 1) % 4] - corners[s];
      const double distance = std::abs(Cross(along, p - corners[s])) / along.norm();
      if (distance >= least) continue;
      least = distance;
      nearest = s;
      place = along.dot(p - corners[s]) / along.squaredNorm();
    }
    if (place > kEnd && place < 1 - kEnd) sides[nearest].push_back(p);
  }
  return sides;
}

bool IsConvex(const Quad& q) {
  for (std::size_t i = 0; i < 4; ++i) {
    if (Cross(q[(i + 1) % 4] - q[i], q[(i + 2) % 4] - q[(i + 1) % 4]) <= 0) return false;
  }
  return true;
}

}  // namespace

Image<std::uint8_t> DarkPixels(ImageSpan<const float> grey, float least_contrast) {
  Image<std::uint8_t> dark(grey.width, grey.height);
  const Image<Range> ranges = TileRanges(grey);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      const Range& range = ranges(x / kTile, y / kTile);
      dark(x, y) =
          range.high - range.low >= least_contrast && grey(x, y) < (range.low + range.high) / 2 ? 1
                                                                                                : 0;
    }
  }
  return dark;
}

std::vector<Region> ConnectedRegions(const Image<std::uint8_t>& dark, int least_side_px) {
  Labels labels;
  const Image<int> label = Label(dark, labels);
  std::vector<Region> regions = Bounds(label, labels.size()), kept;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (regions[i].width < least_side_px || regions[i].height < least_side_px) continue;
    kept.push_back(std::move(regions[i]));
    kept.back().outline = OutlineOf(kept.back(), label, static_cast<int>(i));
  }
  return kept;
}

std::optional<Quad> FitQuad(const Region& region) {
  constexpr double kMostRms = 0.8, kMostRmsOfSide = 0.03, kMostMoved = 0.15;
  const Quad rough = RoughCorners(region.outline);
  for (std::size_t s = 0; s < 4; ++s) {
    if ((rough[(s + 1) % 4] - rough[s]).norm() < 3) return std::nullopt;
  }
  const auto sides = PointsOfSides(region.outline, rough);
  std::array<Line, 4> lines;
  for (std::size_t s = 0; s < 4; ++s) {
    const auto line = FitLine(sides[s]);
    const double length = (rough[(s + 1) % 4] - rough[s]).norm();
    if (!line || line->rms > std::max(kMostRms, kMostRmsOfSide * length)) return std::nullopt;
    lines[s] = *line;
  }
  Quad quad;
  for (std::size_t s = 0; s < 4; ++s) {
    const auto corner = Intersection(lines[(s + 3) % 4], lines[s]);
    const double length =
        std::max((rough[(s + 1) % 4] - rough[s]).norm(), (rough[(s + 3) % 4] - rough[s]).norm());
    if (!corner || (*corner - rough[s]).norm() > 2 + kMostMoved * length) return std::nullopt;
    quad[s] = *corner;
  }
  return IsConvex(quad) ? std::optional(quad) : std::nullopt;
}

}  // namespace lamella
