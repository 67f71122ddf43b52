#include "calibration/next_plane_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "calibration/imagined_view.h"
#include "lightfield/median.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPlaneColumns = 9, kPlaneRows = 6;  // points of a plane
constexpr double kWithoutLensesDeg = 30;

Vector3d MiddleOfPlanes(const VarifocalState& state) {
  Vector3d sum = Vector3d::Zero();
  for (const PlaneState& plane : state.planes) sum += plane.frame_from_plane.translation;
  return sum / static_cast<double>(state.planes.size());
}

double MedianDistanceOfPlanes(const VarifocalFit& fit, const VarifocalTask& task) {
  const Vector3d middle = MiddleOfPlanes(fit.state);
  std::set<int> views;  // some show the sheet alone
  for (const PlanePhoto& photo : task.observations.photos) views.insert(photo.view);
  std::vector<double> distances;
  for (const int view : views) {
    const Rigid& pose = fit.state.camera_from_frame[static_cast<std::size_t>(view)];
    distances.push_back((Centre(pose) - middle).norm());
  }
  return Median(std::move(distances));
}

// Within which every lens shows the emitters behind it.
double LensAngleDeg(const Calibration& design) {
  double angle = kWithoutLensesDeg;
  for (const LayerCalibration& layer : design.layers) {
    if (!layer.lattice) continue;
    const double slope = layer.lattice->pitch_mm / 2 / (layer.gap_mm / layer.index);
    angle = std::min(angle, std::atan(slope) * 180 / std::numbers::pi);
  }
  return angle;
}

// The variance of a coordinate of so many points as are imagined, as if they were those of a
// photograph so far.
double VarianceOfPoints(const VarifocalFit& fit, const VarifocalTask& task) {
  std::vector<double> variances, counts;
  for (const PlanePhoto& photo : task.observations.photos) {
    if (photo.points.empty()) continue;
    counts.push_back(static_cast<double>(photo.points.size()));
    variances.push_back(photo.points.front().covariance_px2.trace() / 2);
  }
  return std::max(1.0, fit.variance) * Median(std::move(variances)) * kPlaneColumns * kPlaneRows /
         Median(std::move(counts));
}

// A view of all planes and of the sheet as the first view that shows most of it.
struct ImaginedPlanes {
  VarifocalState state;
  VarifocalObservations observations;
};

ImaginedPlanes ViewOfPlanes(const VarifocalFit& fit, const VarifocalTask& task, const Rigid& pose) {
  const auto& views = task.observations.views;
  const auto most = std::max_element(views.begin(), views.end(),
                                     [](const VarifocalView& a, const VarifocalView& b) {
                                       return a.marks.size() < b.marks.size();
                                     });
  ImaginedPlanes imagined{fit.state, {task.observations.cameras, {*most}, {}}};
  VarifocalView& view = imagined.observations.views.front();
  view.camera = 0;
  if (view.camera_from_frame) view.camera_from_frame = pose;
  for (std::size_t i = 0; i < task.planes.size(); ++i) {
    PlanePhoto photo{static_cast<int>(i), 0, "", {}};
    const Vector2d size(task.planes[i].width_px, task.planes[i].height_px);
    for (int k = 0; k < kPlaneColumns * kPlaneRows; ++k) {
      const int column = k % kPlaneColumns, row = k / kPlaneColumns;
      const Vector2d share((column + 0.5) / kPlaneColumns, (row + 0.5) / kPlaneRows);
      photo.points.push_back(
          {share.cwiseProduct(size), Vector2d::Zero(), Eigen::Matrix2d::Identity()});
    }
    imagined.observations.photos.push_back(std::move(photo));
  }
  imagined.state.camera_from_frame = {pose};
  imagined.state.slips_px.assign(task.planes.size() + 1, Vector2d::Zero());
  return imagined;
}

// Points where they would be seen; false where planes would lie outside of the picture. Marks that
// would are left out.
bool PlacePoints(const std::vector<PanelCalibration>& planes, double variance_px2, double chi2,
                 ImaginedPlanes& imagined) {
  VarifocalView& view = imagined.observations.views.front();
  std::vector<double> mark_variances;
  for (MarkSighting& mark : view.marks) {
    mark_variances.push_back(std::max(1.0, chi2) * mark.covariance_px2.trace() / 2);
    mark.image_px.setZero();
    mark.covariance_px2.setIdentity();
  }
  // Against a point at (0, 0) of unit covariance a residual is what is predicted.
  const auto predicted = WhitenedResiduals(imagined.state, planes, imagined.observations);
  const VarifocalCamera& camera = imagined.observations.cameras.front();
  const auto is_inside = [&](const Vector2d& at) {
    return at.x() >= 0 && at.y() >= 0 && at.x() <= camera.width && at.y() <= camera.height;
  };
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (Eigen::Index k = 0; k < predicted[i].cols(); ++k) {
      Observation& point = imagined.observations.photos[i].points[static_cast<std::size_t>(k)];
      point.image_px = predicted[i].col(k);
      point.covariance_px2 *= variance_px2;
      if (!is_inside(point.image_px)) return false;
    }
  }
  std::vector<MarkSighting> seen;
  for (std::size_t k = 0; k < view.marks.size(); ++k) {
    const Vector2d at = predicted.back().col(static_cast<Eigen::Index>(k));
    if (!is_inside(at)) continue;
    seen.push_back({view.marks[k].frame_mm, at, mark_variances[k] * Eigen::Matrix2d::Identity()});
  }
  view.marks = std::move(seen);
  return true;
}

MatrixXd InformationOfPlanes(const ImaginedPlanes& imagined, const VarifocalFit& fit,
                             const VarifocalTask& task) {
  const VarifocalColumns columns = ColumnsOf(imagined.observations, task.planes.size(), fit.free);
  Weighting weighting;
  weighting.slip_sd_px = fit.weighting.slip_sd_px;
  return InformationOfView(
      Linearise(imagined.state, task.planes, columns, imagined.observations, weighting),
      columns.common);
}

// The plane that is farthest off what is asked for.
struct WorstKnown {
  double times_limit = 0, depth_sd_mm = 0, magnification_sd = 0;
};
WorstKnown WorstOf(const MatrixXd& covariance, const VarifocalColumns& columns,
                   const Vector3d& normal, const PlaneLimits& limits) {
  WorstKnown worst;
  for (const int first : columns.plane) {
    const Eigen::Matrix3d position = covariance.block<3, 3>(first + 3, first + 3);
    const double depth = std::sqrt(normal.dot(position * normal));
    const double magnification = std::sqrt(covariance(first + 6, first + 6));
    const double times =
        std::max(depth / limits.depth_sd_mm, magnification / limits.magnification_sd);
    if (times > worst.times_limit) worst = {times, depth, magnification};
  }
  return worst;
}

}  // namespace

std::optional<NextPlaneView> BestNextPlaneView(const VarifocalFit& fit, const VarifocalTask& task,
                                               const Rigid& display_from_frame,
                                               const PlaneLimits& limits) {
  const MatrixXd so_far = InformationSoFar(fit.equations, fit.columns.common, fit.variance);
  const Vector3d normal = Inverse(display_from_frame).rotation * Vector3d::UnitZ();
  const Vector3d middle = display_from_frame * MiddleOfPlanes(fit.state);
  const Rigid middle_from_display{Eigen::Quaterniond::Identity(), -middle};
  const double now =
      WorstOf(CovarianceOfInformation(so_far), fit.columns, normal, limits).times_limit;
  const double distance = MedianDistanceOfPlanes(fit, task), reach_deg = LensAngleDeg(task.design);
  const double variance = VarianceOfPoints(fit, task);
  const double step_deg = std::max(1.0, std::floor(reach_deg / 3));
  std::optional<NextPlaneView> best;
  for (const int up : {0, 1, -1, 2, -2, 3, -3}) {
    for (const int right : {0, 1, -1, 2, -2, 3, -3}) {
      const double right_deg = right * step_deg, up_deg = up * step_deg;
      if (std::hypot(right_deg, up_deg) > reach_deg) continue;
      const Rigid pose = LookingFrom(PlaceAt(right_deg, up_deg, distance)) * middle_from_display *
                         display_from_frame;
      ImaginedPlanes imagined = ViewOfPlanes(fit, task, pose);
      if (!PlacePoints(task.planes, variance, fit.variance, imagined)) continue;
      const MatrixXd then = so_far + InformationOfPlanes(imagined, fit, task);
      const WorstKnown next = WorstOf(CovarianceOfInformation(then), fit.columns, normal, limits);
      if (best && !(next.times_limit < best->next_times_limit)) continue;
      best = NextPlaneView{right_deg,
                           up_deg,
                           distance,
                           now,
                           next.times_limit,
                           next.depth_sd_mm,
                           next.magnification_sd};
    }
  }
  return best;
}

}  // namespace lamella
