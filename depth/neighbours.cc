#include "depth/neighbours.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "lightfield/median.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr double kBestAngleDeg = 10, kSigmaBelowDeg = 5, kSigmaAboveDeg = 15;
constexpr std::size_t kEnoughPoints = 20;
constexpr double kEnoughShare = 0.3;
constexpr double kLeastParallax = 1;     // px, of the whole range up to infinity
constexpr double kOtherSideShare = 0.1;  // of the best score, for a turn of the other side
constexpr int kRaysPerAxis = 4;          // of the stand-in points of a view
constexpr double kSpacingsAway = 10;     // depth of stand-in points where views don't converge

Vector3d Forward(const View& view) {
  return view.camera_from_world.rotation.conjugate() * Vector3d(0, 0, 1);
}

bool Sees(const View& view, const Vector3d& point) {
  const std::optional<Eigen::Vector2d> pixel = Project(view.camera, view.camera_from_world * point);
  return pixel && pixel->x() >= 0 && pixel->y() >= 0 && pixel->x() <= view.camera.width &&
         pixel->y() <= view.camera.height;
}

// The point nearest to all optical axes (least squares), where it is in front of every view.
std::optional<Vector3d> Convergence(const std::vector<View>& views) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const View& view : views) {
    const Vector3d axis = Forward(view);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right += across * Centre(view.camera_from_world);
  }
  // Nearly parallel axes meet nowhere in particular.
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  if (!(solver.rcond() > 1e-4)) return std::nullopt;
  const Vector3d point = solver.solve(right);
  for (const View& view : views) {
    if (!((view.camera_from_world * point).z() > 0)) return std::nullopt;
  }
  return point;
}

double MedianSpacing(const std::vector<View>& views) {
  std::vector<double> spacings;
  for (const View& a : views) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const View& b : views) {
      const double distance = (Centre(a.camera_from_world) - Centre(b.camera_from_world)).norm();
      if (distance > 0) nearest = std::min(nearest, distance);
    }
    if (std::isfinite(nearest)) spacings.push_back(nearest);
  }
  return Median(std::move(spacings));
}

// Depths at which stand-in points lie, by view.
std::vector<double> StandInDepths(const std::vector<View>& views) {
  const std::optional<Vector3d> meeting = Convergence(views);
  const double away = kSpacingsAway * MedianSpacing(views);
  std::vector<double> depths;
  for (const View& view : views) {
    depths.push_back(meeting ? (view.camera_from_world * *meeting).z() : away);
  }
  return depths;
}

}  // namespace

Neighbourhood::Neighbourhood(const ViewSet& set)
    : views_(set.views), seen_(set.views.size()), measured_(!set.points.empty()) {
  Vector3d middle = Vector3d::Zero();
  for (const View& view : views_) {
    middle += Centre(view.camera_from_world) / static_cast<double>(views_.size());
  }
  for (View& view : views_)
    view.camera_from_world = view.camera_from_world * Rigid{{1, 0, 0, 0}, middle};
  for (const SparsePoint& point : set.points)
    points_.push_back({point.position - middle, point.views});
  if (!measured_) {
    const std::vector<double> depths = StandInDepths(views_);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const Camera& camera = views_[v].camera;
      const Rigid world_from_camera = Inverse(views_[v].camera_from_world);
      for (int i = 0; i < kRaysPerAxis * kRaysPerAxis; ++i) {
        const int column = i % kRaysPerAxis, row = i / kRaysPerAxis;
        const Eigen::Vector2d pixel((column + 0.5) / kRaysPerAxis * camera.width,
                                    (row + 0.5) / kRaysPerAxis * camera.height);
        const std::optional<Vector3d> ray = Unproject(camera, pixel);
        if (!ray || !(depths[v] > 0)) continue;
        Point point{world_from_camera * (depths[v] * *ray), {}};
        for (std::size_t s = 0; s < views_.size(); ++s) {
          if (s == v || Sees(views_[s], point.position)) point.views.push_back(static_cast<int>(s));
        }
        points_.push_back(std::move(point));
      }
    }
  }
  for (std::size_t p = 0; p < points_.size(); ++p) {
    for (const int v : points_[p].views)
      seen_[static_cast<std::size_t>(v)].push_back(static_cast<int>(p));
  }
}

Neighbour Neighbourhood::Weigh(int view, int other, const std::vector<int>& common) const {
  const View& a = views_[static_cast<std::size_t>(view)];
  const View& b = views_[static_cast<std::size_t>(other)];
  const Vector3d centre_a = Centre(a.camera_from_world), centre_b = Centre(b.camera_from_world);
  Neighbour neighbour{other, 0, 0};
  std::vector<double> angles, depths;
  for (const int p : common) {
    const Vector3d& point = points_[static_cast<std::size_t>(p)].position;
    const double za = (a.camera_from_world * point).z(), zb = (b.camera_from_world * point).z();
    if (!(za > 0) || !(zb > 0)) continue;
    const Vector3d to_a = (centre_a - point).normalized(), to_b = (centre_b - point).normalized();
    const double angle =
        std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b)) * 180 / std::numbers::pi;
    const double sigma = angle < kBestAngleDeg ? kSigmaBelowDeg : kSigmaAboveDeg;
    const double off = (angle - kBestAngleDeg) / sigma;
    const double finer = b.camera.fx * za / (a.camera.fx * zb);
    neighbour.score += std::exp(-off * off / 2) * std::min(1.0, finer * finer);
    angles.push_back(angle);
    depths.push_back(za);
  }
  const double depth = Median(depths);
  neighbour.angle_deg = Median(std::move(angles));
  const double parallax = depth > 0 ? a.camera.fx * (centre_a - centre_b).norm() / depth : 0;
  if (!(parallax >= kLeastParallax)) neighbour.score = 0;
  return neighbour;
}

std::vector<Neighbour> Neighbourhood::Of(int view) const {
  const auto v = static_cast<std::size_t>(view);
  std::map<int, std::vector<int>> common;  // by other view
  for (const int p : seen_[v]) {
    for (const int other : points_[static_cast<std::size_t>(p)].views) {
      if (other != view) common[other].push_back(p);
    }
  }
  const double share = kEnoughShare * static_cast<double>(seen_[v].size());
  std::vector<Neighbour> ranked;
  for (const auto& [other, points] : common) {
    if (points.size() < kEnoughPoints && static_cast<double>(points.size()) < share) continue;
    const Neighbour neighbour = Weigh(view, other, points);
    if (neighbour.score > 0) ranked.push_back(neighbour);
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.score > b.score; });
  if (ranked.empty()) return ranked;

  const Rigid& camera = views_[v].camera_from_world;
  const auto direction = [&](const Neighbour& n) -> Eigen::Vector2d {
    return (camera * Centre(views_[static_cast<std::size_t>(n.view)].camera_from_world)).head<2>();
  };
  const Eigen::Vector2d first = direction(ranked.front());
  std::vector<Neighbour> sides[2], rest, ordered;
  for (const Neighbour& n : ranked) {
    const bool turn = n.score >= kOtherSideShare * ranked.front().score;
    (turn ? sides[direction(n).dot(first) < 0 ? 1 : 0] : rest).push_back(n);
  }
  for (std::size_t i = 0; i < std::max(sides[0].size(), sides[1].size()); ++i) {
    for (const std::vector<Neighbour>& side : sides) {
      if (i < side.size()) ordered.push_back(side[i]);
    }
  }
  ordered.insert(ordered.end(), rest.begin(), rest.end());
  return ordered;
}

std::optional<Neighbourhood::DepthRange> Neighbourhood::MeasuredRange(int view) const {
  const auto v = static_cast<std::size_t>(view);
  std::vector<double> depths;
  for (const int p : seen_[v]) {
    const double z =
        (views_[v].camera_from_world * points_[static_cast<std::size_t>(p)].position).z();
    if (z > 0) depths.push_back(z);
  }
  if (!measured_ || depths.size() < kEnoughPoints) return std::nullopt;
  std::sort(depths.begin(), depths.end());
  const std::size_t tail = depths.size() / 100;
  return DepthRange{depths[tail], depths[depths.size() - 1 - tail]};
}

std::vector<int> ChooseSources(const std::vector<Neighbour>& neighbours, double max_angle_deg,
                               int most) {
  std::vector<int> sources;
  const auto add = [&](bool within, std::size_t up_to) {
    for (const Neighbour& n : neighbours) {
      if (sources.size() < up_to && (n.angle_deg <= max_angle_deg) == within)
        sources.push_back(n.view);
    }
  };
  add(true, static_cast<std::size_t>(most));
  add(false, std::min<std::size_t>(2, static_cast<std::size_t>(most)));
  return sources;
}

}  // namespace lamella
