#include "tests/calibration/sheet_scene.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Type = LensLattice::Type;

Vector2d PixelOf(const Vector2d& mm) {
  return {mm.x() / kSheetPixel + kSheetWidth / 2.0, kSheetHeight / 2.0 - mm.y() / kSheetPixel};
}

// Eight steps of a period of 16 px, as a camera's pixel has them: the phase in px.
double Decode(double u, double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise(0, sigma);
  double sine = 0, cosine = 0;
  for (int k = 0; k < 8; ++k) {
    const double light = std::cos(2 * std::numbers::pi * (u / 16 - k / 8.0)) + noise(random);
    cosine += light * std::cos(2 * std::numbers::pi * k / 8);
    sine += light * std::sin(2 * std::numbers::pi * k / 8);
  }
  return 16 * std::atan2(sine, cosine) / (2 * std::numbers::pi);
}

}  // namespace

Vector2d Sheet::NearestCentre(const Vector2d& q) const {
  const double turn = type == Type::kHexagonal ? -std::numbers::pi / 6 : 0;
  Eigen::Matrix2d basis;
  basis.col(0) = pitch * Vector2d(std::cos(rotation + turn), std::sin(rotation + turn));
  basis.col(1) = pitch * Vector2d(-std::sin(rotation), std::cos(rotation));
  const Vector2d at = basis.inverse() * q - phase;
  if (type == Type::kLine) return basis * (Vector2d(std::round(at.x()), at.y()) + phase);
  Vector2d best(1e9, 1e9);
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const Vector2d index(std::round(at.x()) + i, std::round(at.y()) + j);
      const Vector2d centre = basis * (index + phase);
      if ((centre - q).norm() < (best - q).norm()) best = centre;
    }
  }
  return best;
}

Vector2d Sheet::Seen(const Vector2d& q, const Vector3d& eye) const {
  return NearestCentre(q) + gap * (q - eye.head<2>()) / eye.z();
}

std::vector<Vector3d> TwoEyes() { return {{-110, 20, 520}, {120, -80, 480}}; }

LayerCalibration DesignOf(const Sheet& sheet) {
  LayerCalibration layer;
  layer.emitter.width_px = kSheetWidth;
  layer.emitter.height_px = kSheetHeight;
  layer.emitter.pitch_mm = kSheetPixel;
  layer.gap_mm = sheet.gap;
  layer.lattice = LensLattice{sheet.type, sheet.pitch, sheet.rotation, {0, 0}, 0};
  return layer;
}

LatticeObservations PhotographSheet(const Sheet& sheet, const std::vector<Vector3d>& eyes,
                                    int samples, const SheetNoise& noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0, 1), side(-0.5, 0.5);
  std::normal_distribution<double> normal(0, 1);
  LatticeObservations seen;
  if (noise.intensity > 0) seen.period_px = 16;
  for (std::size_t view = 0; view < eyes.size(); ++view) {
    const Vector3d& eye = eyes[view];
    seen.eyes_mm.emplace_back(eye + noise.eye_mm *
                                        Vector3d(normal(random), normal(random), normal(random)));
    for (int i = 0; i < samples; ++i) {
      const Vector2d q(side(random) * kSheetWidth * kSheetPixel,
                       side(random) * kSheetHeight * kSheetPixel);
      Vector2d px = PixelOf(sheet.Seen(q, eye));
      const Vector2d step = noise.borders * sheet.pitch * Vector2d(side(random), side(random));
      px = (px + PixelOf(sheet.Seen(q + step, eye))) / 2;  // mixes at rims only
      for (double& u : px) {
        u += noise.decode_px * normal(random);
        if (noise.intensity > 0) u = Decode(u, noise.intensity, random);
      }
      if (share(random) < noise.stray)
        px = {share(random) * kSheetWidth, share(random) * kSheetHeight};
      seen.samples.push_back({static_cast<int>(view), q, px, {0.5, 0.5}});
    }
  }
  return seen;
}

double DriftOf(const LayerCalibration& layer, const Sheet& truth) {
  Sheet sheet = truth;
  sheet.pitch = layer.lattice->pitch_mm;
  sheet.rotation = layer.lattice->rotation_rad;
  sheet.phase = layer.lattice->phase;
  sheet.gap = layer.gap_mm / layer.index;
  const Vector2d across(std::cos(truth.rotation), std::sin(truth.rotation));
  double most = 0;
  for (int place = 0; place < 9; ++place) {
    const int column = place % 3 - 1, row = place / 3 - 1;
    const Vector2d corner(kSheetWidth * kSheetPixel / 2 * column,
                          kSheetHeight * kSheetPixel / 2 * row);
    const Vector2d lens = truth.NearestCentre(corner);
    for (const double x : {-120.0, 0.0, 120.0}) {
      for (const double y : {-120.0, 0.0, 120.0}) {
        const Vector3d eye(x, y, 500);
        const Vector2d off = sheet.Seen(lens, eye) - truth.Seen(lens, eye);
        const double px = (truth.type == Type::kLine ? std::abs(across.dot(off)) : off.norm());
        most = std::max(most, px / kSheetPixel);
      }
    }
  }
  return most;
}

double PhaseErrorPx(const LayerCalibration& layer, const Sheet& truth) {
  Vector2d off = layer.lattice->phase - truth.phase;
  off -= Vector2d(std::round(off.x()), std::round(off.y()));
  if (truth.type == Type::kLine) off.y() = 0;
  return off.cwiseAbs().maxCoeff() * truth.pitch / kSheetPixel;
}

LatticeOptions SheetViewers() {
  LatticeOptions options;
  options.eye_box = {120, 120, 450, 550};
  return options;
}

LayerCalibration WrongDesign(const Sheet& sheet, int sign) {
  LayerCalibration design = DesignOf(sheet);
  design.lattice->pitch_mm *= 1 + 0.01 * sign;
  design.lattice->rotation_rad -= kDegree * sign;
  design.gap_mm *= 1 + 0.1 * sign;
  return design;
}

}  // namespace lamella
