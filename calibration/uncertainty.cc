#include "calibration/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "calibration/covariance.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The direction in which an eye sees a pixel of the reference panel; its plate shifts the eye.
Vector3d DirectionTo(const LayerCalibration& layer, const PanelId& reference, const Vector3d& eye,
                     const Vector2d& pixel) {
  Vector3d point;
  if (reference.role == PanelId::kModulator) {
    point = PanelPoint(*layer.modulator, pixel);
  } else {
    point = StackFromEmitter(layer) * PanelPoint(layer.emitter, pixel);
  }
  point = layer.display_from_stack * point;
  Vector3d direction = point - eye;
  for (int i = 0; layer.plate && i < 4; ++i) {
    direction = point - eye - PlateShift(*layer.plate, direction);
  }
  return direction;
}

Eigen::Matrix2Xd SlopeOf(const Fit& fit, const Structure& structure,
                         const std::vector<ProbedRay>& rays, int column, double step) {
  const auto pixels = [&](double by) {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(fit.columns.size);
    delta(column) = by;
    return PixelsOfRays(CalibrationOf(Plus(fit.state, fit.columns, delta), structure),
                        structure.reference, rays);
  };
  return (pixels(step) - pixels(-step)) / (2 * step);
}

}  // namespace

std::vector<Vector3d> EyeBox::Eyes() const {
  std::vector<Vector3d> eyes;
  for (const double z : {near_mm, (near_mm + far_mm) / 2, far_mm}) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) eyes.emplace_back(x * half_width_mm, y * half_height_mm, z);
    }
  }
  return eyes;
}

std::vector<ProbedRay> RaysToProbe(const Structure& structure, const EyeBox& box) {
  const PanelCalibration& panel = structure.Panel(structure.reference);
  std::vector<ProbedRay> rays;
  for (const PanelId& other : structure.panels) {
    if (other == structure.reference) continue;
    for (const Vector3d& eye : box.Eyes()) {
      for (int row = 0; row < 5; ++row) {
        for (int column = 0; column < 7; ++column) {
          rays.push_back(
              {other, {column / 6.0 * panel.width_px, row / 4.0 * panel.height_px}, eye});
        }
      }
    }
  }
  return rays;
}

Eigen::Matrix2Xd PixelsOfRays(const Calibration& calibration, const PanelId& reference,
                              const std::vector<ProbedRay>& rays) {
  std::vector<LayerSights> sights(calibration.layers.begin(), calibration.layers.end());
  const LayerCalibration& through = calibration.layers[static_cast<std::size_t>(reference.layer)];
  Eigen::Matrix2Xd pixels(2, static_cast<Eigen::Index>(rays.size()));
  pixels.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const ProbedRay& ray = rays[i];
    const Vector3d direction = DirectionTo(through, reference, ray.eye_mm, ray.reference_px);
    const auto hit = sights[static_cast<std::size_t>(ray.panel.layer)].Seen(ray.eye_mm, direction);
    if (!hit) continue;
    pixels.col(static_cast<Eigen::Index>(i)) =
        ray.panel.role == PanelId::kEmitter ? hit->emitter : hit->modulator;
  }
  return pixels;
}

RayDifference CompareRays(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b) {
  RayDifference difference;
  double sum = 0, num = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    const double squared = (a.col(i) - b.col(i)).squaredNorm();
    if (std::isnan(squared)) continue;
    sum += squared;
    num += 1;
    difference.max_px = std::max(difference.max_px, std::sqrt(squared));
  }
  difference.rms_px = num > 0 ? std::sqrt(sum / num) : 0;
  return difference;
}

Eigen::MatrixXd SlopesOfRays(const Fit& fit, const Structure& structure,
                             const std::vector<ProbedRay>& rays, const Eigen::VectorXd& steps) {
  const int num = fit.columns.num_display;
  const auto num_rays = static_cast<Eigen::Index>(rays.size());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(2 * num_rays, num);
  for (int column = fit.columns.num_camera; column < num; ++column) {
    slopes.col(column) = SlopeOf(fit, structure, rays, column, steps(column)).reshaped();
  }
  return slopes;
}

RayUncertainty UncertaintyOfRays(const std::vector<ProbedRay>& rays, const Eigen::MatrixXd& slopes,
                                 const Eigen::MatrixXd& covariance) {
  RayUncertainty uncertainty;
  const Eigen::MatrixXd spread = slopes * covariance;
  double sum = 0, counted = 0;
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    const auto i = static_cast<Eigen::Index>(ray);
    const double variance =
        spread.row(2 * i).dot(slopes.row(2 * i)) + spread.row(2 * i + 1).dot(slopes.row(2 * i + 1));
    uncertainty.sd_px.push_back(std::sqrt(variance));
    if (std::isnan(variance)) continue;
    sum += variance;
    counted += 1;
    if (variance > uncertainty.max_sd_px * uncertainty.max_sd_px) {
      uncertainty.max_sd_px = std::sqrt(variance);
      uncertainty.worst = rays[ray];
    }
  }
  uncertainty.rms_sd_px = counted > 0 ? std::sqrt(sum / counted) : 0;
  return uncertainty;
}

RayUncertainty UncertaintyOfRays(const Fit& fit, const Structure& structure,
                                 const Eigen::MatrixXd& covariance, const EyeBox& box) {
  const std::vector<ProbedRay> rays = RaysToProbe(structure, box);
  const int num = fit.columns.num_display;
  const Eigen::VectorXd steps = 0.05 * covariance.diagonal().head(num).cwiseSqrt();
  return UncertaintyOfRays(rays, SlopesOfRays(fit, structure, rays, steps),
                           covariance.topLeftCorner(num, num));
}

Degeneracy DegeneracyOf(const NormalEquations& equations, const Columns& columns, double variance) {
  Eigen::MatrixXd scaled = WithoutSlips(equations, columns);
  const Eigen::Map<const Eigen::VectorXd> sd(columns.prior_sd.data(), scaled.rows());
  scaled = sd.asDiagonal() * scaled * sd.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  return {eigen.eigenvalues()(0) / std::max(1.0, variance), eigen.eigenvectors().col(0)};
}

Degeneracy DegeneracyOf(const Fit& fit) {
  return DegeneracyOf(fit.equations, fit.columns, fit.variance);
}

std::string NameOfDirection(const Degeneracy& degeneracy, const Columns& columns) {
  // What the display or camera loses, rather than the views that go with it.
  std::vector<int> order;
  for (int i = 0; i < columns.num_display; ++i) order.push_back(i);
  const auto size = [&](int i) { return std::abs(degeneracy.direction(i)); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return size(a) > size(b); });
  if (order.empty()) return "";
  if (size(order[0]) < 0.1) {  // the views' own
    Eigen::Index largest = 0;
    degeneracy.direction.cwiseAbs().maxCoeff(&largest);
    return columns.names[static_cast<std::size_t>(largest)];
  }
  std::string names;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, order.size()); ++k) {
    if (size(order[k]) < 0.4 * size(order[0])) break;
    names += (k > 0 ? ", " : "") + columns.names[static_cast<std::size_t>(order[k])];
  }
  return names;
}

}  // namespace lamella
