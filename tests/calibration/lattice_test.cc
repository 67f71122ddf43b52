// Lens sheets photographed by pinhole cameras: every pixel's line of sight goes to a lens's vertex
// and on to the panel, by geometry of this file's own. The accuracy that is promised is checked at
// 6 dB: an amplitude of the sinusoid of 10^(6/20) = 2 standard deviations of a photograph's noise,
// so that one pixel alone is 0.64 panel px wrong and its period unknown.
#include "calibration/lattice.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/lattice_model.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using Type = LensLattice::Type;

constexpr double kPixel = 0.0784;  // mm; 324 per inch
constexpr int kWidth = 1536, kHeight = 2048;
constexpr double kDegree = std::numbers::pi / 180;

// Lens centres (i + phase 0) b1 + (j + phase 1) b2; a line's lenses run along b2 everywhere.
struct Sheet {
  Type type = Type::kLine;
  double pitch = 5.7 * kPixel, rotation = 0.14, gap = 0.9;
  Vector2d phase{0.31, 0.77};

  Vector2d First() const {
    const double turn = type == Type::kHexagonal ? -std::numbers::pi / 6 : 0;
    return pitch * Vector2d(std::cos(rotation + turn), std::sin(rotation + turn));
  }
  Vector2d Second() const { return pitch * Vector2d(-std::sin(rotation), std::cos(rotation)); }
  Vector2d NearestCentre(const Vector2d& q) const {
    Eigen::Matrix2d basis;
    basis << First(), Second();
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
  // What an eye sees through the lens at q, mm: s_k (1 + f/D) - e_s f/D in every direction that the
  // lens bends, the pixel's own line of sight giving the slope.
  Vector2d Seen(const Vector2d& q, const Vector3d& eye) const {
    return NearestCentre(q) + gap * (q - eye.head<2>()) / eye.z();
  }
};

Vector2d PixelOf(const Vector2d& mm) {
  return {mm.x() / kPixel + kWidth / 2.0, kHeight / 2.0 - mm.y() / kPixel};
}

LayerCalibration DesignOf(const Sheet& sheet) {
  LayerCalibration layer;
  layer.emitter.width_px = kWidth;
  layer.emitter.height_px = kHeight;
  layer.emitter.pitch_mm = kPixel;
  layer.gap_mm = sheet.gap;
  layer.lattice = LensLattice{sheet.type, sheet.pitch, sheet.rotation, {0, 0}, 0};
  return layer;
}

struct Noise {
  double decode_px = 0;  // of a decoded pixel
  double intensity = 0;  // of photographs of the sinusoid, in its amplitudes; decoded here
  double borders = 0;    // share of a lens at its rim where two lenses' light mixes
  double stray = 0;      // share of samples that are anything
  double eye_mm = 0;     // of the cameras' positions, as they are said to be
};

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

LatticeObservations Photograph(const Sheet& sheet, const std::vector<Vector3d>& eyes, int samples,
                               const Noise& noise, std::uint32_t seed) {
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
      const Vector2d q(side(random) * kWidth * kPixel, side(random) * kHeight * kPixel);
      Vector2d px = PixelOf(sheet.Seen(q, eye));
      const Vector2d step = noise.borders * sheet.pitch * Vector2d(side(random), side(random));
      px = (px + PixelOf(sheet.Seen(q + step, eye))) / 2;  // mixes at rims only
      for (double& u : px) {
        u += noise.decode_px * normal(random);
        if (noise.intensity > 0) u = Decode(u, noise.intensity, random);
      }
      if (share(random) < noise.stray) px = {share(random) * kWidth, share(random) * kHeight};
      seen.samples.push_back({static_cast<int>(view), q, px, {0.5, 0.5}});
    }
  }
  return seen;
}

const std::vector<Vector3d> kTwoEyes = {{-110, 20, 520}, {120, -80, 480}};

// What a lens at each edge of the panel shows to eyes, by the estimate and in truth, px: the
// largest difference in the directions that the lenses bend.
double Drift(const LayerCalibration& layer, const Sheet& truth) {
  Sheet sheet = truth;
  sheet.pitch = layer.lattice->pitch_mm;
  sheet.rotation = layer.lattice->rotation_rad;
  sheet.phase = layer.lattice->phase;
  sheet.gap = layer.gap_mm / layer.index;
  const Vector2d across(std::cos(truth.rotation), std::sin(truth.rotation));
  double most = 0;
  for (int place = 0; place < 9; ++place) {
    const Vector2d corner(kWidth * kPixel / 2 * (place % 3 - 1),
                          kHeight * kPixel / 2 * (place / 3 - 1));
    const Vector2d lens = truth.NearestCentre(corner);
    for (const double x : {-120.0, 0.0, 120.0}) {
      for (const double y : {-120.0, 0.0, 120.0}) {
        const Vector3d eye(x, y, 500);
        const Vector2d off = sheet.Seen(lens, eye) - truth.Seen(lens, eye);
        const double px = (truth.type == Type::kLine ? std::abs(across.dot(off)) : off.norm());
        most = std::max(most, px / kPixel);
      }
    }
  }
  return most;
}

// Phase of the lens nearest the middle, px.
double PhaseError(const LayerCalibration& layer, const Sheet& truth) {
  Vector2d off = layer.lattice->phase - truth.phase;
  off -= Vector2d(std::round(off.x()), std::round(off.y()));
  if (truth.type == Type::kLine) off.y() = 0;
  return off.cwiseAbs().maxCoeff() * truth.pitch / kPixel;
}

LatticeOptions Viewers() {
  LatticeOptions options;
  options.eye_box = {120, 120, 450, 550};
  return options;
}

// The design is wrong by 1 %, a degree and a tenth of the gap.
LayerCalibration WrongDesign(const Sheet& sheet, int sign) {
  LayerCalibration design = DesignOf(sheet);
  design.lattice->pitch_mm *= 1 + 0.01 * sign;
  design.lattice->rotation_rad -= kDegree * sign;
  design.gap_mm *= 1 + 0.1 * sign;
  return design;
}

class LatticeOf : public ::testing::TestWithParam<Type> {
 protected:
  LatticeOf() { sheet_.type = GetParam(); }
  Sheet sheet_;
};
std::string NameOfCase(const ::testing::TestParamInfo<Type>& info) {
  return info.param == Type::kLine ? "Line" : info.param == Type::kSquare ? "Square" : "Hexagonal";
}
INSTANTIATE_TEST_SUITE_P(Types, LatticeOf,
                         ::testing::Values(Type::kLine, Type::kSquare, Type::kHexagonal),
                         NameOfCase);

TEST_P(LatticeOf, IsExactWithoutNoise) {
  const auto seen = Photograph(sheet_, kTwoEyes, 3000, {}, 1);
  const LatticeReport report = EstimateLattice(seen, WrongDesign(sheet_, 1), Viewers());
  EXPECT_LT(Drift(report.layer, sheet_), 1e-4);
  EXPECT_NEAR(report.layer.gap_mm, sheet_.gap, 1e-5);
}

TEST_P(LatticeOf, IsKnownToFiftiethsOfAPixelAtSixDecibels) {
  Noise noise;
  noise.intensity = std::pow(10, -6 / 20.0);
  for (const int sign : {-1, 1}) {
    const auto seen = Photograph(sheet_, kTwoEyes, 25000, noise, 5 + static_cast<unsigned>(sign));
    const LatticeReport report = EstimateLattice(seen, WrongDesign(sheet_, sign), Viewers());
    EXPECT_TRUE(report.accepted()) << report.failures[0].lost;
    EXPECT_LT(Drift(report.layer, sheet_), 0.02);
    EXPECT_LT(std::abs(report.layer.lattice->rotation_rad - sheet_.rotation), 0.001 * kDegree);
    EXPECT_LT(PhaseError(report.layer, sheet_), 0.02);
    EXPECT_NEAR(report.noise_px, 0.64, 0.05);
    fmt::print("drift {:.4f} sd {:.4f} rotation {:.5f} phase {:.4f}\n", Drift(report.layer, sheet_),
               report.drift_max_px,
               (report.layer.lattice->rotation_rad - sheet_.rotation) / kDegree,
               PhaseError(report.layer, sheet_));
  }
}

TEST_P(LatticeOf, DoesNotMindMixedLightAtBordersAndStrayPixels) {
  Noise noise{0.1, 0, 0.25, 0.1, 0};
  const auto seen = Photograph(sheet_, kTwoEyes, 10000, noise, 3);
  const LatticeReport report = EstimateLattice(seen, WrongDesign(sheet_, -1), Viewers());
  EXPECT_TRUE(report.accepted()) << report.failures[0].lost;
  EXPECT_LT(Drift(report.layer, sheet_), 0.012);
  fmt::print("drift {:.4f} sd {:.4f} used {}\n", Drift(report.layer, sheet_), report.drift_max_px,
             report.num_used);
}

}  // namespace
}  // namespace lamella
