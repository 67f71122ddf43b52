#include "calibration/lattice_place.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "calibration/lattice_model.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewest = 100;
constexpr int kRounds = 8;

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
    std::vector<double> lengths;
    lengths.reserve(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) lengths.push_back(left(i).norm());
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    const double most = 3 * std::max(*middle, 1e-9);
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

}  // namespace

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
