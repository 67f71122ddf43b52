#include "calibration/lattice_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>

#include "calibration/homography.h"
#include "calibration/lattice_model.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewest = 100;
constexpr int kRounds = 8;

double MedianLength(const std::vector<Vector2d>& vectors) {
  std::vector<double> lengths;
  lengths.reserve(vectors.size());
  for (const Vector2d& vector : vectors) lengths.push_back(vector.norm());
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return std::max(*middle, 1e-9);
}

// By how much (x, y in mm, angle) all samples' panel points are to be moved, robustly.
Vector3d MoveOf(const std::vector<SheetRay>& rays, double gap, const Vector2d& pivot) {
  std::vector<Vector2d> apart;
  apart.reserve(rays.size());
  for (const SheetRay& ray : rays) apart.emplace_back(ray.sheet + gap * ray.slope - ray.panel);
  Vector3d move(0, 0, 0);
  for (int round = 0; round < kRounds; ++round) {
    const auto left = [&](std::size_t i) -> Vector2d {
      const Vector2d from = rays[i].panel - pivot;
      return apart[i] - move.head<2>() - move.z() * Vector2d(-from.y(), from.x());
    };
    std::vector<Vector2d> all;
    all.reserve(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) all.push_back(left(i));
    const double most = 3 * MedianLength(all);
    Matrix3d normal = 1e-9 * Matrix3d::Identity();
    Vector3d right = Vector3d::Zero();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Vector2d off = left(i), from = rays[i].panel - pivot;
      if (off.norm() > most) continue;
      Eigen::Matrix<double, 2, 3> slopes;
      slopes << 1, 0, -from.y(), 0, 1, from.x();
      normal += slopes.transpose() * slopes;
      right += slopes.transpose() * off;
    }
    move += normal.ldlt().solve(right);
  }
  return move;
}

using Vector6d = Eigen::Matrix<double, 6, 1>;

// At most about `most`, evenly chosen.
LatticeObservations Thinned(const LatticeObservations& observations, std::size_t most) {
  LatticeObservations thinned = observations;
  thinned.samples.clear();
  const std::size_t step = std::max<std::size_t>(1, observations.samples.size() / most);
  for (std::size_t i = 0; i < observations.samples.size(); i += step) {
    thinned.samples.push_back(observations.samples[i]);
  }
  return thinned;
}

// The same lines of sight in another frame. All stay lines towards its z = 0.
LatticeObservations Moved(const LatticeObservations& observations, const Rigid& to_from) {
  LatticeObservations moved = observations;
  for (Vector3d& eye : moved.eyes_mm) eye = to_from * eye;
  for (LatticeSample& sample : moved.samples) {
    const Vector3d& eye = moved.eyes_mm[static_cast<std::size_t>(sample.view)];
    const Vector3d at = to_from * Vector3d(sample.sheet_mm.x(), sample.sheet_mm.y(), 0);
    sample.sheet_mm = (eye + eye.z() / (eye.z() - at.z()) * (at - eye)).head<2>();
  }
  return moved;
}

Rigid Stepped(const Rigid& pose, const Vector6d& by) {
  const Vector3d turn = by.head<3>();
  const double angle = turn.norm();
  Rigid step{Eigen::Quaterniond::Identity(), by.tail<3>()};
  if (angle > 0) step.rotation = Eigen::AngleAxisd(angle, turn / angle);
  return step * pose;
}

// How far each sample's panel point is from where a straight line of sight would meet the panel.
std::vector<Vector2d> ApartOf(const LatticeObservations& in_frame, const LayerCalibration& design,
                              const Rigid& stack_from_frame) {
  std::vector<Vector2d> apart;
  for (const SheetRay& ray : SheetRaysOf(Moved(in_frame, stack_from_frame), design)) {
    apart.emplace_back(ray.sheet + design.gap_mm / design.index * ray.slope - ray.panel);
  }
  return apart;
}

// From the view with most samples. The panel's picture is that of a plane at its reduced gap.
Rigid RoughStackFromFrame(const LatticeObservations& in_frame, const LayerCalibration& design) {
  std::vector<std::size_t> counts(in_frame.eyes_mm.size(), 0);
  for (const LatticeSample& sample : in_frame.samples) {
    ++counts[static_cast<std::size_t>(sample.view)];
  }
  const auto view = std::max_element(counts.begin(), counts.end()) - counts.begin();
  const Vector3d& eye = in_frame.eyes_mm[static_cast<std::size_t>(view)];
  std::vector<Vector2d> panel, image;  // of a camera that looks along -z, y down
  for (const LatticeSample& sample : in_frame.samples) {
    if (sample.view != view) continue;
    panel.emplace_back(PanelPoint(design.emitter, sample.panel_px).head<2>());
    const Vector2d across = (sample.sheet_mm - eye.head<2>()) / eye.z();
    image.emplace_back(across.x(), -across.y());
  }
  const auto columns = [](const std::vector<Vector2d>& points) {
    return Eigen::Map<const Eigen::Matrix2Xd>(points.front().data(), 2,
                                              static_cast<Eigen::Index>(points.size()));
  };
  const auto image_from_panel =
      panel.empty() ? std::nullopt : FitHomography(columns(panel), columns(image));
  if (!image_from_panel) {
    throw InputError("lens sheet", "its panel is seen too little of to tell where it stands",
                     "photograph the whole panel");
  }
  const Rigid frame_from_camera{Eigen::Quaterniond(0, 1, 0, 0), eye};
  const Rigid frame_from_panel = frame_from_camera * PoseOfHomography(*image_from_panel);
  Rigid stack_from_panel;
  stack_from_panel.translation.z() = -design.gap_mm / design.index;
  return stack_from_panel * Inverse(frame_from_panel);
}

}  // namespace

Rigid StackFromFrame(const LatticeObservations& in_frame, const LayerCalibration& design) {
  constexpr std::size_t kEnough = 1000;
  const LatticeObservations some = Thinned(in_frame, kEnough);
  return StackFromFrame(in_frame, design, RoughStackFromFrame(some, design));
}

Rigid StackFromFrame(const LatticeObservations& in_frame, const LayerCalibration& design,
                     const Rigid& near) {
  constexpr std::size_t kEnough = 20000;
  const LatticeObservations some = Thinned(in_frame, kEnough);
  const double arm = design.emitter.HalfDiagonalMm();  // turns are stepped in mm at its end
  Rigid pose = near;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Vector2d> apart = ApartOf(some, design, pose);
    std::array<std::vector<Vector2d>, 6> moved;
    constexpr double kStepMm = 1e-3;
    const auto step_of = [&](int i, double mm) -> Vector6d {
      return (i < 3 ? mm / arm : mm) * Vector6d::Unit(i);
    };
    for (int i = 0; i < 6; ++i) {
      moved[static_cast<std::size_t>(i)] =
          ApartOf(some, design, Stepped(pose, step_of(i, kStepMm)));
    }
    const double most = 3 * MedianLength(apart);
    Eigen::Matrix<double, 6, 6> normal = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    Vector6d right = Vector6d::Zero();
    for (std::size_t k = 0; k < apart.size(); ++k) {
      if (apart[k].norm() > most) continue;
      Eigen::Matrix<double, 2, 6> slopes;
      for (int i = 0; i < 6; ++i) {
        slopes.col(i) = (moved[static_cast<std::size_t>(i)][k] - apart[k]) / kStepMm;
      }
      normal += slopes.transpose() * slopes;
      right -= slopes.transpose() * apart[k];
    }
    Vector6d step = normal.ldlt().solve(right);
    step.head<3>() /= arm;
    pose = Stepped(pose, step);
  }
  return pose;
}

LayerCalibration WithPanelInPlace(const LatticeObservations& observations,
                                  const LayerCalibration& design) {
  LayerCalibration placed = design;
  if (observations.samples.size() < kFewest) return placed;
  // Turns are small but for the first one; the second finds what that left.
  for (int pass = 0; pass < 3; ++pass) {
    const std::vector<SheetRay> rays = SheetRaysOf(observations, placed);
    const Vector3d move = MoveOf(rays, placed.gap_mm / placed.index, placed.offset_mm);
    placed.offset_mm += move.head<2>();
    const Eigen::AngleAxisd turned(Eigen::AngleAxisd(move.z(), Vector3d::UnitZ()) *
                                   StackFromEmitter(placed).rotation);
    placed.rotation_rad = turned.angle() * turned.axis();
  }
  return placed;
}

}  // namespace lamella
