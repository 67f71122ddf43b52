#include "calibration/varifocal_rays.h"

#include <cmath>
#include <optional>
#include <vector>

#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPlaneColumns = 7, kPlaneRows = 5,
              kPlaneNumbers = 9;  // of a plane: pose, magnification, bends

// A plane in the frame.
struct Plane {
  Plane(const PanelCalibration& design, const PlaneState& state)
      : panel(WithShape(design, state.shape)), frame_from_plane(state.frame_from_plane) {}

  Vector3d PointOf(const Vector2d& pixel) const {
    return frame_from_plane * PanelPoint(panel, pixel);
  }
  std::optional<Vector2d> Seen(const Vector3d& eye, const Vector3d& through) const {
    const Rigid plane_from_frame = Inverse(frame_from_plane);
    const Vector3d from = plane_from_frame * eye;
    const auto point = MeetPanel(panel, from, plane_from_frame * through - from);
    return point ? PanelPixel(panel, point->head<2>()) : std::nullopt;
  }

  PanelCalibration panel;
  Rigid frame_from_plane;
};

Vector2d PixelOf(const PanelCalibration& panel, int number) {
  const int row = number / kPlaneColumns, column = number % kPlaneColumns;
  return {column / (kPlaneColumns - 1.0) * panel.width_px,
          row / (kPlaneRows - 1.0) * panel.height_px};
}

// A plane's columns: 7, then bow and pincushion, -1 where they are held.
std::vector<int> ColumnsOf(const VarifocalColumns& columns, std::size_t plane) {
  std::vector<int> all;
  for (int i = 0; i < 7; ++i) all.push_back(columns.plane[plane] + i);
  for (const int bent : columns.bent[plane]) all.push_back(bent);
  return all;
}

PlaneState Moved(PlaneState plane, int number, double step) {
  if (number < 3) {
    const Eigen::AngleAxisd turn(step, Vector3d::Unit(number));
    plane.frame_from_plane.rotation = turn * plane.frame_from_plane.rotation;
  } else if (number < 6) {
    plane.frame_from_plane.translation(number - 3) += step;
  } else {
    plane.shape(number == 6 ? 0 : number - 4) += step;
  }
  return plane;
}

// How the pixels that lines meet move with the plane's numbers, by central differences.
class PlaneSlopes {
 public:
  PlaneSlopes(const PanelCalibration& design, const PlaneState& state,
              const std::vector<int>& columns, const Eigen::MatrixXd& covariance) {
    for (int k = 0; k < kPlaneNumbers; ++k) {
      const int column = columns[static_cast<std::size_t>(k)];
      if (column < 0) continue;
      numbers_.push_back(column);
      steps_.push_back(0.05 * std::sqrt(covariance(column, column)));
      ahead_.emplace_back(design, Moved(state, k, steps_.back()));
      behind_.emplace_back(design, Moved(state, k, -steps_.back()));
    }
    covariance_ = covariance(numbers_, numbers_);
  }

  // Of the pixel's two coordinates together; nothing where a line passes by.
  std::optional<double> VarianceOf(const Vector3d& eye, const Vector3d& through) const {
    Eigen::MatrixXd slopes(2, static_cast<Eigen::Index>(numbers_.size()));
    for (std::size_t n = 0; n < numbers_.size(); ++n) {
      const auto a = ahead_[n].Seen(eye, through), b = behind_[n].Seen(eye, through);
      if (!a || !b) return std::nullopt;
      slopes.col(static_cast<Eigen::Index>(n)) = (*a - *b) / (2 * steps_[n]);
    }
    return (slopes * covariance_ * slopes.transpose()).trace();
  }

 private:
  std::vector<int> numbers_;  // columns that are free
  std::vector<double> steps_;
  std::vector<Plane> ahead_, behind_;
  Eigen::MatrixXd covariance_;
};

}  // namespace

std::vector<ProbedRay> RaysThroughPlanes(const std::vector<PanelCalibration>& planes,
                                         const EyeBox& box) {
  std::vector<ProbedRay> rays;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const PanelId id{static_cast<int>(i), PanelId::kEmitter};
    for (const Vector3d& eye : box.Eyes()) {
      for (int k = 0; k < kPlaneColumns * kPlaneRows; ++k) {
        rays.push_back({id, PixelOf(planes[i], k), eye});
      }
    }
  }
  return rays;
}

double ChangeOfRays(const VarifocalState& a, const VarifocalState& b, const VarifocalTask& task,
                    const EyeBox& box) {
  const Rigid frame_from_display = Inverse(DisplayFromFrame(a, task));
  double sum = 0, num = 0;
  for (std::size_t i = 0; i < task.planes.size(); ++i) {
    const Plane through(task.planes[i], a.planes[i]), met(task.planes[i], b.planes[i]);
    for (const Vector3d& eye : box.Eyes()) {
      for (int k = 0; k < kPlaneColumns * kPlaneRows; ++k) {
        const Vector2d pixel = PixelOf(through.panel, k);
        const auto seen = met.Seen(frame_from_display * eye, through.PointOf(pixel));
        if (!seen) continue;
        sum += (*seen - pixel).squaredNorm();
        num += 1;
      }
    }
  }
  return num > 0 ? std::sqrt(sum / num) : 0;
}

RayUncertainty UncertaintyOfRays(const VarifocalFit& fit, const VarifocalTask& task,
                                 const Rigid& display_from_frame, const Eigen::MatrixXd& covariance,
                                 const EyeBox& box) {
  const Rigid frame_from_display = Inverse(display_from_frame);
  std::vector<Plane> planes;
  std::vector<PlaneSlopes> slopes;
  for (std::size_t i = 0; i < task.planes.size(); ++i) {
    const PlaneState& state = fit.state.planes[i];
    planes.emplace_back(task.planes[i], state);
    slopes.emplace_back(task.planes[i], state, ColumnsOf(fit.columns, i), covariance);
  }
  RayUncertainty uncertainty;
  double sum = 0, num = 0;
  for (const ProbedRay& ray : RaysThroughPlanes(task.planes, box)) {
    const auto plane = static_cast<std::size_t>(ray.panel.layer);
    const auto variance = slopes[plane].VarianceOf(frame_from_display * ray.eye_mm,
                                                   planes[plane].PointOf(ray.reference_px));
    uncertainty.sd_px.push_back(variance ? std::sqrt(*variance) : std::nan(""));
    if (!variance) continue;
    sum += *variance;
    num += 1;
    if (!(uncertainty.sd_px.back() > uncertainty.max_sd_px)) continue;
    uncertainty.max_sd_px = uncertainty.sd_px.back();
    uncertainty.worst = ray;
  }
  uncertainty.rms_sd_px = num > 0 ? std::sqrt(sum / num) : 0;
  return uncertainty;
}

}  // namespace lamella
