#include "depth/neighbours.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lamella {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kBestAngleDeg = 10, kNarrowSigmaDeg = 5, kWideSigmaDeg = 15;
constexpr double kLeastAngleDeg = 0.3;
constexpr int kLeastCommonPoints = 20;

struct Candidate {
  int view = 0;
  double score = 0, angle_deg = 0;
  Eigen::Vector2d side;  // direction of the baseline in the view's image plane
};

double AngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * kDegrees;
}

bool Sees(const View& view, const Eigen::Vector3d& point) {
  const auto pixel = Project(view.camera, view.camera_from_world * point);
  return pixel && pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() <= view.camera.width &&
         pixel->y() <= view.camera.height;
}

// World points on the view's rays, 5 x 5 pixels at the middle of the range.
std::vector<Eigen::Vector3d> StandIns(const View& view, const InverseDepthRange& range) {
  const Rigid world_from_camera = Inverse(view.camera_from_world);
  const double depth = 2 / (range.w0 + range.w1);
  std::vector<Eigen::Vector3d> points;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) * view.camera.width / 5,
                                  (j + 0.5) * view.camera.height / 5);
      if (const auto ray = Unproject(view.camera, pixel))
        points.push_back(world_from_camera * (depth * *ray));
    }
  }
  return points;
}

// The points that each view shares with `reference`.
std::vector<std::vector<Eigen::Vector3d>> CommonPoints(const ViewSet& set, int reference,
                                                       const InverseDepthRange& range) {
  std::vector<std::vector<Eigen::Vector3d>> common(set.views.size());
  for (const SparsePoint& point : set.points) {
    if (std::find(point.views.begin(), point.views.end(), reference) == point.views.end()) continue;
    for (const int view : point.views)
      common[static_cast<std::size_t>(view)].push_back(point.position);
  }
  const auto enough = [&](const std::vector<Eigen::Vector3d>& points) {
    return points.size() >= kLeastCommonPoints;
  };
  if (std::count_if(common.begin(), common.end(), enough) >= 2)
    return common;  // one is the view itself
  const auto stand_ins = StandIns(set.views[static_cast<std::size_t>(reference)], range);
  for (std::size_t v = 0; v < common.size(); ++v) {
    common[v].clear();
    for (const Eigen::Vector3d& point : stand_ins) {
      if (Sees(set.views[v], point)) common[v].push_back(point);
    }
    if (common[v].size() * 10 < stand_ins.size() * 3) common[v].clear();  // under 30 % in common
  }
  return common;
}

std::optional<Candidate> Rate(const ViewSet& set, int reference, int other,
                              const std::vector<Eigen::Vector3d>& common) {
  const View& a = set.views[static_cast<std::size_t>(reference)];
  const View& b = set.views[static_cast<std::size_t>(other)];
  if (common.empty()) return std::nullopt;
  const Eigen::Vector3d from_a = Centre(a.camera_from_world), from_b = Centre(b.camera_from_world);
  std::vector<double> angles;
  double score = 0, scale = 0;
  for (const Eigen::Vector3d& point : common) {
    const double angle = AngleDeg(point - from_a, point - from_b);
    const double t =
        (angle - kBestAngleDeg) / (angle < kBestAngleDeg ? kNarrowSigmaDeg : kWideSigmaDeg);
    score += std::exp(-0.5 * t * t);
    angles.push_back(angle);
    // Pixels of b for a pixel of a.
    scale += b.camera.fx / (point - from_b).norm() * (point - from_a).norm() / a.camera.fx;
  }
  scale /= static_cast<double>(common.size());
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  if (!(*middle >= kLeastAngleDeg)) return std::nullopt;
  const Eigen::Vector3d baseline = a.camera_from_world * from_b;
  return Candidate{other, score * std::min(1.0, scale * scale), *middle, baseline.head<2>()};
}

// By score; those wider than the largest angle come last, by angle.
void Rank(std::vector<Candidate>& candidates, double max_angle_deg) {
  std::sort(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
    const bool a_wide = a.angle_deg > max_angle_deg, b_wide = b.angle_deg > max_angle_deg;
    if (a_wide != b_wide) return b_wide;
    if (a_wide && a.angle_deg != b.angle_deg) return a.angle_deg < b.angle_deg;
    if (a.score != b.score) return a.score > b.score;
    return a.view < b.view;
  });
}

}  // namespace

std::vector<int> ChooseSources(const ViewSet& set, int view, const InverseDepthRange& range,
                               const NeighbourOptions& options) {
  const auto common = CommonPoints(set, view, range);
  std::vector<Candidate> candidates;
  for (int other = 0; other < static_cast<int>(set.views.size()); ++other) {
    if (other == view) continue;
    if (auto c = Rate(set, view, other, common[static_cast<std::size_t>(other)]))
      candidates.push_back(*c);
  }
  Rank(candidates, options.max_angle_deg);
  const auto narrow = std::count_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return c.angle_deg <= options.max_angle_deg;
  });
  candidates.resize(
      std::min(candidates.size(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(narrow, 2))));
  std::vector<int> sources;
  while (!candidates.empty() && static_cast<int>(sources.size()) < options.max_sources) {
    // The best of all, then the best of the other side of it.
    const Eigen::Vector2d side = candidates.front().side;
    sources.push_back(candidates.front().view);
    candidates.erase(candidates.begin());
    const auto opposite = std::find_if(candidates.begin(), candidates.end(),
                                       [&](const Candidate& c) { return c.side.dot(side) < 0; });
    if (opposite == candidates.end() || static_cast<int>(sources.size()) >= options.max_sources)
      continue;
    sources.push_back(opposite->view);
    candidates.erase(opposite);
  }
  return sources;
}

std::optional<InverseDepthRange> RangeOfPoints(const ViewSet& set, int view, int labels) {
  const View& reference = set.views[static_cast<std::size_t>(view)];
  std::vector<double> depths;
  for (const SparsePoint& point : set.points) {
    if (std::find(point.views.begin(), point.views.end(), view) == point.views.end()) continue;
    const double depth = (reference.camera_from_world * point.position).z();
    if (depth > 0 && std::isfinite(depth)) depths.push_back(depth);
  }
  if (depths.size() < 8) return std::nullopt;
  std::sort(depths.begin(), depths.end());
  const auto quantile = [&](double q) {
    return depths[static_cast<std::size_t>(q * static_cast<double>(depths.size() - 1))];
  };
  return InverseDepthRange{0.2 / quantile(0.99), 1 / (0.88 * quantile(0.01)), labels};
}

}  // namespace lamella
