#include "depth/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace lamella {
namespace {

// Outside of the picture by its whole size counts as this many neighbour spacings.
constexpr double kOutsidePenalty = 30;
// Pixels twice as large as the best view's cost half of this, in radians of direction.
constexpr double kResolutionPenalty = 0.1;

// Distance in pixels from the picture; 0 inside.
double Outside(const SourceView& view, double x, double y) {
  const double dx = std::max({-x, x - view.width, 0.0}), dy = std::max({-y, y - view.height, 0.0});
  return std::hypot(dx, dy);
}

}  // namespace

std::size_t ColorLevelForSpacing(double spacing, std::size_t levels) {
  if (!(spacing > 1)) return 0;
  const double level = std::min(2 * std::log2(spacing), 1e3);
  return std::min(static_cast<std::size_t>(std::lround(level)), levels - 1);
}

const ColorLevel& ColorLevelForSpacing(const SourceView& view, double spacing) {
  return view.color[ColorLevelForSpacing(spacing, view.color.size())];
}

const DepthLevel& DepthLevelForSpacing(const SourceView& view, double spacing) {
  const double pixels = spacing * std::sqrt(view.depth[0].per_color_x * view.depth[0].per_color_y);
  if (!(pixels >= 2)) return view.depth[0];
  const auto level = static_cast<std::size_t>(std::min(std::log2(pixels), 1e3));
  return view.depth[std::min(level, view.depth.size() - 1)];
}

BundleGeometry::BundleGeometry(const RayBundle& bundle, double zero)
    : bundle_(bundle), zero_(zero), world_from_bundle_(CountedFrom(zero, WorldFromBundle(bundle))) {
  const Eigen::Vector4d sizes = world_from_bundle_.colwise().norm();
  if (!world_from_bundle_.allFinite() || !(sizes.minCoeff() > 0)) return;
  // Judged with columns of size 1: rays of 1e-6 are no flaw.
  const Eigen::FullPivLU<Eigen::Matrix4d> lu(world_from_bundle_ *
                                             sizes.cwiseInverse().asDiagonal());
  valid_ = lu.isInvertible();
  if (valid_) bundle_from_world_ = sizes.cwiseInverse().asDiagonal() * lu.inverse();
}

void BundleGeometry::Line(double u, double v, Eigen::Vector3d* point,
                          Eigen::Vector3d* toward) const {
  *point = bundle_.PlanePoint(u, v);
  *toward = (bundle_.centre.w() != 0 ? Eigen::Vector3d(bundle_.centre.head<3>() - *point)
                                     : Eigen::Vector3d(bundle_.centre.head<3>()))
                .normalized();
}

double BundleGeometry::DistanceSquared(double u, double v, const Eigen::Vector3d& point) const {
  Eigen::Vector3d on_ray, toward;
  Line(u, v, &on_ray, &toward);
  // From the centre where there is one: the plane may be far away.
  const Eigen::Vector3d from =
      bundle_.centre.w() != 0 ? Eigen::Vector3d(bundle_.centre.head<3>()) : on_ray;
  return (point - from).cross(toward).squaredNorm();
}

ViewRanking::ViewRanking(const BundleGeometry& geometry, const std::vector<SourceView>& views,
                         double neighbour)
    : geometry_(geometry), views_(views), neighbour_(neighbour) {
  for (const SourceView& view : views) {
    view_from_bundle_.push_back(view.view_from_world * geometry.world_from_bundle());
  }
}

bool ViewRanking::Assess(std::size_t index, double u, double v,
                         const std::array<double, 3>& nearness, const Eigen::Vector3d& toward,
                         double offset, Candidate* candidate) const {
  const SourceView& view = views_[index];
  const Eigen::Matrix4d& map = view_from_bundle_[index];
  double outside = std::numeric_limits<double>::infinity();
  for (const double n : nearness) {
    const Eigen::Vector4d out = map * Eigen::Vector4d(u, v, 1, n);
    if (!(out.z() > 0)) continue;
    const Eigen::Vector4d point = geometry_.world_from_bundle() * Eigen::Vector4d(u, v, 1, n);
    // Towards the view and towards the viewer from one side of the surface.
    if (!((view.centre * point.w() - point.head<3>()).dot(toward) > 0)) continue;
    const double x = out.x() / out.z(), y = out.y() / out.z();
    const double here = Outside(view, x, y) / std::max(view.width, view.height);
    if (!(here < outside)) continue;
    outside = here;
    candidate->distance = point.w() != 0 ? (point.head<3>() / point.w() - view.centre).norm()
                                         : std::numeric_limits<double>::infinity();
    const Eigen::Vector2d du =
        (map.block<2, 1>(0, 0) - Eigen::Vector2d(x, y) * map(2, 0)) / out.z();
    const Eigen::Vector2d dv =
        (map.block<2, 1>(0, 1) - Eigen::Vector2d(x, y) * map(2, 1)) / out.z();
    candidate->sight.spacing = std::sqrt(std::abs(du.x() * dv.y() - du.y() * dv.x()));
  }
  if (!std::isfinite(outside)) return false;
  candidate->sight.view = static_cast<int>(index);
  candidate->sight.penalty = offset + kOutsidePenalty * outside;
  return true;
}

std::vector<Sight> ViewRanking::Best(double u, double v, const std::array<double, 3>& nearness,
                                     int count) const {
  Eigen::Vector3d on_ray, toward;
  geometry_.Line(u, v, &on_ray, &toward);
  std::vector<std::pair<double, std::size_t>> offsets;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    offsets.emplace_back(std::sqrt(geometry_.DistanceSquared(u, v, views_[k].centre)) / neighbour_,
                         k);
  }
  std::sort(offsets.begin(), offsets.end());
  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.sight.penalty != b.sight.penalty ? a.sight.penalty < b.sight.penalty
                                              : a.sight.view < b.sight.view;
  };
  // Offset alone is the least penalty that a view can have: once enough are better than that, the
  // rest need no look. (Of resolution only what these few differ in counts.)
  std::vector<Candidate> candidates;
  const auto enough = static_cast<std::size_t>(count);
  for (const auto& [offset, k] : offsets) {
    if (candidates.size() >= enough && candidates[enough - 1].sight.penalty < offset) break;
    Candidate candidate;
    if (!Assess(k, u, v, nearness, toward, offset, &candidate)) continue;
    candidates.insert(std::upper_bound(candidates.begin(), candidates.end(), candidate, better),
                      candidate);
  }
  double finest = 0;
  for (const Candidate& c : candidates) finest = std::max(finest, c.sight.spacing);
  for (Candidate& c : candidates) {
    if (!(finest > 0) || !std::isfinite(c.distance)) continue;
    c.sight.resolution =
        kResolutionPenalty * (1 - c.sight.spacing / finest) * c.distance / neighbour_;
    c.sight.penalty += c.sight.resolution;
  }
  std::sort(candidates.begin(), candidates.end(), better);
  std::vector<Sight> sights;
  for (std::size_t i = 0; i < std::min(candidates.size(), enough); ++i) {
    sights.push_back(candidates[i].sight);
  }
  return sights;
}

}  // namespace lamella
