#include "calibration/lattice_model.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/LU>
#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void CheckSample(const LatticeSample& sample, std::size_t num_views, std::size_t index) {
  const bool finite =
      sample.sheet_mm.allFinite() && sample.panel_px.allFinite() && sample.sigma_px.allFinite();
  if (finite && sample.sigma_px.minCoeff() > 0 && sample.view >= 0 &&
      static_cast<std::size_t>(sample.view) < num_views) {
    return;
  }
  throw InputError(fmt::format("lens sheet, sample {}", index),
                   "has a view that is not there, or numbers that are not possible",
                   "give finite places and deviations above 0");
}

// n tan(angle in the gap), along the line of sight away from the eye.
Vector2d SlopeBehind(const Vector3d& eye, const Vector2d& sheet, double index) {
  const Vector3d behind = Refract({sheet.x() - eye.x(), sheet.y() - eye.y(), -eye.z()}, index);
  return index * behind.head<2>() / -behind.z();
}

}  // namespace

std::vector<SheetRay> SheetRaysOf(const LatticeObservations& observations,
                                  const LayerCalibration& design) {
  const Rigid stack_from_emitter = StackFromEmitter(design);
  const Rigid emitter_from_stack = Inverse(stack_from_emitter);
  const double gap = design.gap_mm / design.index, period = observations.period_px;
  const double pixel = design.emitter.pitch_mm * (1 + design.emitter.scale);
  for (const Vector3d& eye : observations.eyes_mm) {
    if (eye.allFinite() && eye.z() > 0) continue;
    throw InputError("lens sheet", "a camera does not stand before it",
                     "give positions in the display's frame, z towards the viewer");
  }
  std::vector<SheetRay> rays;
  rays.reserve(observations.samples.size());
  for (std::size_t i = 0; i < observations.samples.size(); ++i) {
    const LatticeSample& sample = observations.samples[i];
    CheckSample(sample, observations.eyes_mm.size(), i);
    const Vector3d& eye = observations.eyes_mm[static_cast<std::size_t>(sample.view)];
    SheetRay ray{sample.view,
                 sample.sheet_mm,
                 {0, 0},
                 SlopeBehind(eye, sample.sheet_mm, design.index),
                 pixel * sample.sigma_px};
    Vector2d seen = sample.panel_px;
    if (period > 0) {
      const Vector2d straight = ray.sheet + gap * ray.slope;
      const std::optional<Vector2d> expected = PanelPixel(
          design.emitter,
          (emitter_from_stack * Vector3d(straight.x(), straight.y(), -design.gap_mm)).head<2>());
      if (!expected) continue;
      for (int axis = 0; axis < 2; ++axis) {
        seen(axis) += period * std::round(((*expected)(axis)-seen(axis)) / period);
      }
    }
    const Vector3d at = stack_from_emitter * PanelPoint(design.emitter, seen);
    // A panel that is bowed or stands askew is further behind there than its middle.
    const double further = (-at.z() - design.gap_mm) / design.index;
    ray.panel = at.head<2>() - further * ray.slope;
    rays.push_back(ray);
  }
  return rays;
}

LatticeModel::LatticeModel(const LensLattice& lattice, const Vector5d& at)
    : at_(at), focal_(lattice.focal_mm) {
  switch (lattice.type) {
    case LensLattice::Type::kLine:
      break;
    case LensLattice::Type::kSquare:
      num_families_ = 2;
      turn_ = std::numbers::pi / 2;
      break;
    case LensLattice::Type::kHexagonal:
      num_families_ = 3;
      turn_ = std::numbers::pi / 3;
      spacing_ = std::sqrt(3.0) / 2;
      break;
  }
  *this = At(at);
}

LatticeModel LatticeModel::At(const Vector5d& at) const {
  LatticeModel model = *this;
  model.at_ = at;
  if (focal_ > 0) model.magnification_ = focal_ / at(kLatticeGap);
  for (int a = 0; a < num_families_; ++a) {
    const double angle = at(kLatticeRotation) + a * turn_;
    model.normals_[Index(a)] = {std::cos(angle), std::sin(angle)};
    model.along_[Index(a)] = {-std::sin(angle), std::cos(angle)};
  }
  model.phases_ = {at(kLatticePhase0), at(kLatticePhase1), at(kLatticePhase1) - at(kLatticePhase0)};
  return model;
}

Vector2d LatticeModel::CentreOf(const SheetRay& ray) const {
  const double gap = at_(kLatticeGap);
  if (!(focal_ > 0)) return ray.panel - gap * ray.slope;
  return magnification_ * (ray.panel - gap * ray.slope - (1 - gap / focal_) * ray.sheet);
}

LatticeModel::Residual LatticeModel::ResidualOf(const SheetRay& ray, const Vector2d& centre,
                                                int family) const {
  const double P = SpacingMm(), phase = phases_[Index(family)];
  const Vector2d& n = normals_[Index(family)];
  const double s = n.dot(centre), k = std::round(s / P - phase);
  Residual residual;
  residual.mm = s - (k + phase) * P;
  residual.sigma = magnification_ * n.cwiseProduct(ray.sigma).norm();
  residual.slopes.setZero();
  residual.slopes(kLatticePitch) = -(k + phase) * spacing_;
  residual.slopes(kLatticeRotation) = along_[Index(family)].dot(centre);
  if (family != 1) residual.slopes(kLatticePhase0) = family == 2 ? P : -P;
  if (family != 0) residual.slopes(kLatticePhase1) = -P;
  // Of c = (X - f w - (1 - f/F) q) F/f.
  const double towards_sheet = focal_ > 0 ? n.dot(ray.sheet - centre) / at_(kLatticeGap) : 0;
  residual.slopes(kLatticeGap) = towards_sheet - magnification_ * n.dot(ray.slope);
  return residual;
}

Vector3d LatticeModel::SlopesOfEye(const SheetRay& ray, const Vector3d& eye, int family) const {
  const Vector2d& n = normals_[Index(family)];
  const double scale = magnification_ * at_(kLatticeGap) / eye.z();
  return {scale * n.x(), scale * n.y(), scale * n.dot(ray.sheet - eye.head<2>()) / eye.z()};
}

Eigen::Matrix<double, 2, 5> LatticeModel::SlopesOfDrift(const Vector2d& place,
                                                        const Vector3d& eye) const {
  // n_a . dc = (k + phi_a) dP + P dphi_a - (t_a . c) dth, where lens k is the one at the place.
  Eigen::Matrix2d normals = Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, 2, 5> drift = Eigen::Matrix<double, 2, 5>::Zero();
  for (int a = 0; a < num_directions(); ++a) {
    normals.row(a) = Normal(a).transpose();
    drift(a, kLatticePitch) = Normal(a).dot(place) / SpacingMm() * spacing_;
    drift(a, kLatticeRotation) = -along_[Index(a)].dot(place);
    drift(a, kLatticePhase0 + a) = SpacingMm();
  }
  // X = c + f (c - e)/D
  drift *= 1 + at_(kLatticeGap) / eye.z();
  const Vector2d slope = (place - eye.head<2>()) / eye.z();
  if (num_directions() == 1) {
    drift(0, kLatticeGap) = Normal(0).dot(slope);
    return drift;
  }
  drift = (normals.inverse() * drift).eval();
  drift.col(kLatticeGap) = slope;
  return drift;
}

}  // namespace lamella
