#include "depth/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

struct Candidate {
  Sight sight;
  double distance = 0;  // from the view to the point
};

// Direction and picture; nothing where no point lies in front of the view and before the viewer.
bool Assess(const BundleGeometry& geometry, const SourceView& view, double u, double v,
            const std::vector<double>& nearness, double neighbour, Candidate* candidate) {
  const Eigen::Matrix4d view_from_bundle = view.view_from_world * geometry.world_from_bundle();
  Eigen::Vector3d on_ray, toward;
  geometry.Line(u, v, &on_ray, &toward);
  double outside = std::numeric_limits<double>::infinity();
  for (const double n : nearness) {
    const Eigen::Vector4d out = view_from_bundle * Eigen::Vector4d(u, v, 1, n);
    if (!(out.z() > 0)) continue;
    const Eigen::Vector4d point = geometry.world_from_bundle() * Eigen::Vector4d(u, v, 1, n);
    // Towards the view and towards the viewer from one side of the surface.
    if (!((view.centre * point.w() - point.head<3>()).dot(toward) > 0)) continue;
    const double x = out.x() / out.z(), y = out.y() / out.z();
    const double here = Outside(view, x, y) / std::max(view.width, view.height);
    if (!(here < outside)) continue;
    outside = here;
    candidate->distance = point.w() != 0 ? (point.head<3>() / point.w() - view.centre).norm()
                                         : std::numeric_limits<double>::infinity();
    const Eigen::Vector2d du =
        (view_from_bundle.block<2, 1>(0, 0) - Eigen::Vector2d(x, y) * view_from_bundle(2, 0)) /
        out.z();
    const Eigen::Vector2d dv =
        (view_from_bundle.block<2, 1>(0, 1) - Eigen::Vector2d(x, y) * view_from_bundle(2, 1)) /
        out.z();
    candidate->sight.spacing = std::sqrt(std::abs(du.x() * dv.y() - du.y() * dv.x()));
  }
  if (!std::isfinite(outside)) return false;
  candidate->sight.penalty = std::sqrt(geometry.DistanceSquared(u, v, view.centre)) / neighbour +
                             kOutsidePenalty * outside;
  return true;
}

}  // namespace

const ColorLevel& ColorLevelForSpacing(const SourceView& view, double spacing) {
  if (!(spacing > 1)) return view.color[0];
  const double level = std::min(2 * std::log2(spacing), 1e3);
  return view.color[std::min(static_cast<std::size_t>(std::lround(level)), view.color.size() - 1)];
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

std::vector<Sight> RankViews(const BundleGeometry& geometry, const std::vector<SourceView>& views,
                             double u, double v, const std::vector<double>& nearness,
                             double neighbour, int count) {
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < views.size(); ++k) {
    Candidate candidate;
    candidate.sight.view = static_cast<int>(k);
    if (Assess(geometry, views[k], u, v, nearness, neighbour, &candidate)) {
      candidates.push_back(candidate);
    }
  }
  double finest = 0;
  for (const Candidate& c : candidates) finest = std::max(finest, c.sight.spacing);
  for (Candidate& c : candidates) {
    if (!(finest > 0) || !std::isfinite(c.distance)) continue;
    c.sight.resolution =
        kResolutionPenalty * (1 - c.sight.spacing / finest) * c.distance / neighbour;
    c.sight.penalty += c.sight.resolution;
  }
  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.sight.penalty != b.sight.penalty ? a.sight.penalty < b.sight.penalty
                                              : a.sight.view < b.sight.view;
  };
  const auto kept = std::min(candidates.size(), static_cast<std::size_t>(count));
  std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(kept),
                    candidates.end(), better);
  std::vector<Sight> sights;
  for (std::size_t i = 0; i < kept; ++i) sights.push_back(candidates[i].sight);
  return sights;
}

}  // namespace lamella
