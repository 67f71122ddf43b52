#include "lightfield/panel_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// r with r (1 + c r^2) = target >= 0, the branch that starts at 0: Newton's method approaches it
// from one side, whatever the sign of c.
std::optional<double> UndoPincushion(double c, double target) {
  if (c < 0) {
    const double fold = 1 / std::sqrt(-3 * c);
    if (!(target < fold * (1 + c * fold * fold))) return std::nullopt;
  }
  double r = target;
  for (int i = 0; i < 100; ++i) {
    const double step = (r * (1 + c * r * r) - target) / (1 + 3 * c * r * r);
    r -= step;
    if (!(std::abs(step) > 1e-15 * r)) break;
  }
  return r;
}

Vector2d Normal(double angle) { return {std::cos(angle), std::sin(angle)}; }

// The lens centres' families: unit normals, spacing.
struct Families {
  Vector2d first, second;
  double spacing;
};

Families FamiliesOf(const LensLattice& lattice) {
  const bool hexagonal = lattice.type == LensLattice::Type::kHexagonal;
  const double turn = std::numbers::pi / (hexagonal ? 3 : 2);
  return {Normal(lattice.rotation_rad), Normal(lattice.rotation_rad + turn),
          lattice.pitch_mm * (hexagonal ? std::sqrt(3.0) / 2 : 1)};
}

// Where the pencil of a lens goes that enters at `at` with `chief` as its direction in the gap.
Vector3d BentByLens(const LayerCalibration& layer, const Vector2d& at, const Vector3d& chief) {
  const LensLattice& lattice = *layer.lattice;
  const double f = layer.gap_mm / layer.index;
  const double focal = lattice.focal_mm > 0 ? lattice.focal_mm : f;
  const Vector2d centre = NearestLens(lattice, at);
  const Vector2d behind_centre = centre - layer.gap_mm * chief.head<2>() / chief.z();
  const Vector2d target = behind_centre + (at - centre) * (1 - f / focal);
  return {target.x() - at.x(), target.y() - at.y(), -layer.gap_mm};
}

}  // namespace

Vector3d PanelPoint(const PanelCalibration& panel, const Vector2d& pixel) {
  const double R2 = panel.HalfDiagonalMm() * panel.HalfDiagonalMm(), p = panel.pitch_mm;
  const double y = p * (panel.height_px / 2.0 - pixel.y()) * (1 + panel.scale) * (1 - panel.aspect);
  const double x = p * (pixel.x() - panel.width_px / 2.0) * (1 + panel.scale) * (1 + panel.aspect) +
                   panel.skew * y;
  const double radial = 1 + panel.pincushion * (x * x + y * y) / R2;
  const double X = x * radial, Y = y * radial;
  return {panel.mirror_x ? -X : X, Y, panel.bow_mm * (X * X + Y * Y) / R2};
}

std::optional<Vector2d> PanelPixel(const PanelCalibration& panel, const Vector2d& point_mm) {
  double x = panel.mirror_x ? -point_mm.x() : point_mm.x(), y = point_mm.y();
  if (panel.pincushion != 0) {
    const double R = panel.HalfDiagonalMm(), target = std::hypot(x, y);
    const std::optional<double> r = UndoPincushion(panel.pincushion / (R * R), target);
    if (!r) return std::nullopt;
    if (target > 0) {
      x *= *r / target;
      y *= *r / target;
    }
  }
  const double p = panel.pitch_mm;
  x -= panel.skew * y;
  return Vector2d(x / (p * (1 + panel.scale) * (1 + panel.aspect)) + panel.width_px / 2.0,
                  panel.height_px / 2.0 - y / (p * (1 + panel.scale) * (1 - panel.aspect)));
}

std::optional<Vector3d> MeetPanel(const PanelCalibration& panel, const Vector3d& origin,
                                  const Vector3d& direction) {
  if (panel.bow_mm == 0) {
    const double t = -origin.z() / direction.z();
    if (!std::isfinite(t)) return std::nullopt;
    return origin + t * direction;
  }
  // o_z + t d_z = (b/R^2) |o_xy + t d_xy|^2 as A t^2 + B t + C = 0.
  const double R = panel.HalfDiagonalMm(), c = panel.bow_mm / (R * R);
  const double A = c * direction.head<2>().squaredNorm();
  const double B = 2 * c * origin.head<2>().dot(direction.head<2>()) - direction.z();
  const double C = c * origin.head<2>().squaredNorm() - origin.z();
  const double discriminant = B * B - 4 * A * C;
  if (!(discriminant >= 0)) return std::nullopt;
  const double denominator = B + std::copysign(std::sqrt(discriminant), B);
  const double t = -2 * C / denominator;  // tends to -C/B as the bow vanishes
  if (!std::isfinite(t)) return std::nullopt;
  return origin + t * direction;
}

Rigid StackFromEmitter(const LayerCalibration& layer) {
  Rigid pose;
  const double angle = layer.rotation_rad.norm();
  if (angle > 0) {
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, layer.rotation_rad / angle));
  }
  pose.translation = {layer.offset_mm.x(), layer.offset_mm.y(), -layer.gap_mm};
  return pose;
}

Vector3d Refract(const Vector3d& direction, double index) {
  const Vector3d unit = direction.normalized();
  const Vector2d along = unit.head<2>() / index;
  return {along.x(), along.y(),
          std::copysign(std::sqrt(std::max(0.0, 1 - along.squaredNorm())), unit.z())};
}

double RefractionCrossing(double d, double z, double L, double index) {
  // Monotone in r, so bisection guards Newton's steps.
  double low = 0, high = L, r = L * d / (d + z / index);
  if (!(L > 0)) return 0;
  if (!std::isfinite(r)) r = L / 2;
  for (int i = 0; i < 200; ++i) {
    const double w = L - r, eye = std::hypot(r, d), deep = std::hypot(w, z);
    const double f = (eye > 0 ? r / eye : 0) - index * (deep > 0 ? w / deep : 0);
    (f < 0 ? low : high) = r;
    const double slope = d * d / (eye * eye * eye) + index * z * z / (deep * deep * deep);
    double next = r - f / slope;
    if (!(next >= low && next <= high)) next = (low + high) / 2;
    if (std::abs(next - r) <= 1e-15 * L) return next;
    r = next;
  }
  return r;
}

Vector3d PlateShift(const Plate& plate, const Vector3d& direction) {
  const Vector3d d = direction.normalized();
  const double cosine = d.dot(plate.normal);
  const Vector3d m = cosine < 0 ? Vector3d(-plate.normal) : plate.normal;
  const Vector3d sideways = (d - d.dot(m) * m) / plate.index;
  const Vector3d inside = sideways + std::sqrt(std::max(0.0, 1 - sideways.squaredNorm())) * m;
  return plate.thickness_mm * (inside / inside.dot(m) - d / d.dot(m));
}

Vector2d NearestLens(const LensLattice& lattice, const Vector2d& point_mm) {
  const Families families = FamiliesOf(lattice);
  const double p = families.spacing;
  const auto nearest = [&](const Vector2d& normal, double phase) {
    return std::floor(point_mm.dot(normal) / p - phase + 0.5);
  };
  const double i = nearest(families.first, lattice.phase.x());
  const double s = (i + lattice.phase.x()) * p;
  if (lattice.type == LensLattice::Type::kLine) {
    return point_mm + (s - point_mm.dot(families.first)) * families.first;
  }
  const double j = nearest(families.second, lattice.phase.y());
  // The point whose normal coordinates are (s, t): solves the two families' equations.
  const double cosine = families.first.dot(families.second), sine2 = 1 - cosine * cosine;
  const auto centre = [&](double s1, double s2) -> Vector2d {
    return ((s1 - cosine * s2) * families.first + (s2 - cosine * s1) * families.second) / sine2;
  };
  Vector2d best = centre(s, (j + lattice.phase.y()) * p);
  if (lattice.type == LensLattice::Type::kSquare) return best;
  for (int di = -1; di <= 1; ++di) {
    for (int dj = -1; dj <= 1; ++dj) {
      const Vector2d other = centre(s + di * p, (j + dj + lattice.phase.y()) * p);
      if ((other - point_mm).squaredNorm() < (best - point_mm).squaredNorm()) best = other;
    }
  }
  return best;
}

LayerSights::LayerSights(const LayerCalibration& layer)
    : layer_(layer),
      stack_from_display_(layer.display_from_stack.rotation.toRotationMatrix().transpose()),
      stack_origin_(layer.display_from_stack.translation) {
  const Rigid stack_from_emitter = StackFromEmitter(layer);
  emitter_from_stack_ = stack_from_emitter.rotation.toRotationMatrix().transpose();
  emitter_origin_ = stack_from_emitter.translation;
}

std::optional<SightHit> LayerSights::Seen(const Vector3d& origin, const Vector3d& direction) const {
  Vector3d from = origin;
  if (layer_.plate) from += PlateShift(*layer_.plate, direction);
  from = stack_from_display_ * (from - stack_origin_);
  const Vector3d d = (stack_from_display_ * direction).normalized();
  if (!(d.z() < 0 && from.z() > 0)) return std::nullopt;
  SightHit hit;
  hit.cosine = -d.z();
  if (layer_.modulator) {
    const std::optional<Vector3d> point = MeetPanel(*layer_.modulator, from, d);
    if (!point) return std::nullopt;
    const std::optional<Vector2d> pixel = PanelPixel(*layer_.modulator, point->head<2>());
    if (!pixel) return std::nullopt;
    hit.modulator = *pixel;
  }
  Vector3d at = from - from.z() / d.z() * d;
  at.z() = 0;
  Vector3d behind = Refract(d, layer_.index);
  if (layer_.lattice) behind = BentByLens(layer_, at.head<2>(), behind);
  const std::optional<Vector3d> point = MeetPanel(
      layer_.emitter, emitter_from_stack_ * (at - emitter_origin_), emitter_from_stack_ * behind);
  if (!point) return std::nullopt;
  const std::optional<Vector2d> pixel = PanelPixel(layer_.emitter, point->head<2>());
  if (!pixel) return std::nullopt;
  hit.emitter = *pixel;
  return hit;
}

}  // namespace lamella
