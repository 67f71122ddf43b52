// Lattices estimated from the photographs of sheet_scene.h. The accuracy that is promised is
// checked at 6 dB: an amplitude of the sinusoid of 10^(6/20) = 2 standard deviations of a
// photograph's noise, so that one pixel alone is 0.64 panel px wrong and its period unknown.
#include "calibration/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
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
#include "tests/calibration/sheet_scene.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using Type = LensLattice::Type;

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
  const auto seen = PhotographSheet(sheet_, TwoEyes(), 3000, {}, 1);
  const LatticeReport report = EstimateLattice(seen, WrongDesign(sheet_, 1), SheetViewers());
  EXPECT_LT(DriftOf(report.layer, sheet_), 1e-4);
  EXPECT_NEAR(report.layer.gap_mm, sheet_.gap, 1e-5);
}

TEST_P(LatticeOf, IsKnownToFiftiethsOfAPixelAtSixDecibels) {
  SheetNoise noise;
  noise.intensity = std::pow(10, -6 / 20.0);
  for (const int sign : {-1, 1}) {
    const auto seen =
        PhotographSheet(sheet_, TwoEyes(), 25000, noise, 5 + static_cast<unsigned>(sign));
    const LatticeReport report = EstimateLattice(seen, WrongDesign(sheet_, sign), SheetViewers());
    EXPECT_TRUE(report.accepted()) << report.failures[0].lost;
    EXPECT_LT(DriftOf(report.layer, sheet_), 0.02);
    EXPECT_LT(std::abs(report.layer.lattice->rotation_rad - sheet_.rotation), 0.001 * kDegree);
    EXPECT_LT(PhaseErrorPx(report.layer, sheet_), 0.02);
    EXPECT_NEAR(report.noise_px, 0.64, 0.05);
  }
}

TEST_P(LatticeOf, DoesNotMindMixedLightAtBordersAndStrayPixels) {
  SheetNoise noise{0.1, 0, 0.25, 0.1, 0};
  const auto seen = PhotographSheet(sheet_, TwoEyes(), 10000, noise, 3);
  const LatticeReport report = EstimateLattice(seen, WrongDesign(sheet_, -1), SheetViewers());
  EXPECT_TRUE(report.accepted()) << report.failures[0].lost;
  EXPECT_LT(DriftOf(report.layer, sheet_), 0.012);
}

// The estimate's error in units of what it says of itself, squared, per parameter.
double NormalisedError(const LatticeReport& report, const Sheet& truth) {
  const bool line = truth.type == Type::kLine;
  Eigen::Matrix<double, 5, 1> error;
  Vector2d phase = report.layer.lattice->phase - truth.phase;
  phase -= Vector2d(std::round(phase.x()), std::round(phase.y()));
  error << report.layer.lattice->pitch_mm - truth.pitch,
      report.layer.lattice->rotation_rad - truth.rotation, phase, report.layer.gap_mm - truth.gap;
  if (line) error(kLatticePhase1) = 0;
  Matrix5d covariance = report.covariance;
  if (line) covariance(kLatticePhase1, kLatticePhase1) = 1;
  return error.dot(covariance.inverse() * error) / (line ? 4 : 5);
}

TEST_P(LatticeOf, KnowsHowWellItIsKnown) {
  LatticeOptions exact = SheetViewers();
  exact.eye_sd_mm = 0;
  double noise = 0, eyes = 0;
  constexpr int kTrials = 12;
  for (unsigned seed = 0; seed < kTrials; ++seed) {
    const auto noisy = PhotographSheet(sheet_, TwoEyes(), 1500, {0.5}, seed);
    noise += NormalisedError(EstimateLattice(noisy, DesignOf(sheet_), exact), sheet_) / kTrials;
    const auto elsewhere =
        PhotographSheet(sheet_, TwoEyes(), 1500, {0.05, 0, 0, 0, 0.3}, 50 + seed);
    eyes += NormalisedError(EstimateLattice(elsewhere, DesignOf(sheet_), SheetViewers()), sheet_) /
            kTrials;
  }
  // The mean of 48 or 60 squares: 1 within 4.5 times its standard deviation; of 600 it is 1.0
  // to 1.1.
  EXPECT_NEAR(noise, 1, 0.85);
  EXPECT_NEAR(eyes, 1, 0.85);
}

std::string Lost(const LatticeReport& report) {
  return report.failures.empty() ? "nothing" : report.failures[0].lost;
}

TEST_P(LatticeOf, IsRefusedFromOnePositionOrFromPositionsTooNear) {
  const auto one = PhotographSheet(sheet_, {{90, 60, 500}}, 8000, {0.5}, 1);
  const LatticeReport from_one = EstimateLattice(one, WrongDesign(sheet_, 1), SheetViewers());
  EXPECT_THAT(Lost(from_one), HasSubstr("pitch and phase cannot be told from their gap: there is "
                                        "one camera position only"));
  EXPECT_THAT(from_one.failures.at(0).cure, HasSubstr("100 mm and more away across the lenses"));
  EXPECT_GT(from_one.drift_max_px, 0.1);
  EXPECT_TRUE(from_one.next_eye);
  const auto near = PhotographSheet(sheet_, {{90, 60, 500}, {92, 60, 500}}, 8000, {0.5}, 1);
  const LatticeReport from_near = EstimateLattice(near, WrongDesign(sheet_, 1), SheetViewers());
  EXPECT_THAT(Lost(from_near), HasSubstr("camera positions are 2 mm apart across the lenses"));
  // The photograph that it asks for settles it.
  const std::string& cure = from_near.failures.at(0).cure;
  double x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(cure.substr(cure.find('(')).c_str(), "(%lf, %lf, %lf)", &x, &y, &z), 3);
  const auto cured = PhotographSheet(sheet_, {{90, 60, 500}, {x, y, z}}, 8000, {0.5}, 1);
  EXPECT_EQ(Lost(EstimateLattice(cured, WrongDesign(sheet_, 1), SheetViewers())), "nothing");
}

TEST_P(LatticeOf, SaysWhereItIsKnownAndWhereItWasSeen) {
  auto seen = PhotographSheet(sheet_, TwoEyes(), 12000, {0.3}, 1);
  const LatticeReport whole = EstimateLattice(seen, DesignOf(sheet_), SheetViewers());
  EXPECT_EQ(whole.residuals.CellsSeen(), 40U);
  EXPECT_TRUE(whole.warnings.empty());
  EXPECT_FALSE(whole.next_eye);
  double squares = 0, most = 0;
  for (const LensDrift& place : whole.drift) {
    squares += place.rms_px * place.rms_px / 9;
    most = std::max(most, place.max_px);
  }
  EXPECT_NEAR(std::sqrt(squares), whole.drift_rms_px, 1e-9);
  EXPECT_EQ(most, whole.drift_max_px);
  int used = 0;
  for (const FitOf& view : whole.views_fit) {
    EXPECT_EQ(view.num_points, 12000);
    EXPECT_NEAR(view.rms_px, 0.3, 0.03);
    used += view.num_used;
  }
  EXPECT_EQ(used, whole.num_used);
  // The left quarter alone.
  std::erase_if(seen.samples, [](const LatticeSample& sample) {
    return sample.sheet_mm.x() > -kSheetWidth * kSheetPixel / 4;
  });
  const LatticeReport part = EstimateLattice(seen, DesignOf(sheet_), SheetViewers());
  EXPECT_EQ(part.residuals.CellsSeen(), 10U);
  EXPECT_GT(part.residuals.At(0, 4).num_points, 0);
  EXPECT_EQ(part.residuals.At(7, 4).num_points, 0);
  ASSERT_FALSE(part.warnings.empty());
  EXPECT_THAT(part.warnings.back().lost,
              HasSubstr("the sheet was seen in 25 % of its area: its lenses are extrapolated"));
}

// Lenses of the panel's top right part are shifted along their rows.
TEST_P(LatticeOf, MapsWhereLensesAreOffIt) {
  auto seen = PhotographSheet(sheet_, TwoEyes(), 12000, {0.1}, 1);
  const Vector2d across(std::cos(sheet_.rotation), std::sin(sheet_.rotation));
  for (LatticeSample& sample : seen.samples) {
    const Vector2d at =
        sample.sheet_mm.cwiseQuotient(kSheetPixel / 2 * Vector2d(kSheetWidth, kSheetHeight));
    if (at.x() < 0.75 || at.y() < 0.6) continue;
    sample.panel_px += 0.3 * Vector2d(across.x(), -across.y());
  }
  const LatticeReport report = EstimateLattice(seen, DesignOf(sheet_), SheetViewers());
  EXPECT_THAT(Lost(report), HasSubstr("are off the lattice by"));
  const Vector2d corner = report.residuals.At(7, 0).mean_px;
  EXPECT_GT(corner.norm(), report.largest_mean_px);
  EXPECT_NEAR(corner.dot(Vector2d(across.x(), -across.y())), 0.3, 0.08);
  EXPECT_LT(report.residuals.At(0, 4).mean_px.norm(), report.largest_mean_px);
}

TEST(Lattice, OfALineIsNotToldByCamerasAlongTheLenses) {
  Sheet sheet;
  const Vector2d along(-std::sin(sheet.rotation), std::cos(sheet.rotation));
  const std::vector<Vector3d> eyes = {{120 * along.x(), 120 * along.y(), 500},
                                      {-120 * along.x(), -120 * along.y(), 500}};
  const auto refused = EstimateLattice(PhotographSheet(sheet, eyes, 6000, {0.3}, 1),
                                       DesignOf(sheet), SheetViewers());
  EXPECT_THAT(Lost(refused), HasSubstr("are 0 mm apart across the lenses"));
  sheet.type = Type::kSquare;
  EXPECT_TRUE(
      EstimateLattice(PhotographSheet(sheet, eyes, 6000, {0.3}, 1), DesignOf(sheet), SheetViewers())
          .accepted());
}

TEST(Lattice, IsRefusedWhereThePhotographsAreTooNoisyOrShowSomethingElse) {
  const Sheet sheet;
  EXPECT_THAT(Lost(EstimateLattice(PhotographSheet(sheet, TwoEyes(), 300, {0.6}, 1),
                                   DesignOf(sheet), SheetViewers())),
              HasSubstr("of 600 samples with a noise of 0.6"));
  EXPECT_THAT(Lost(EstimateLattice(PhotographSheet(sheet, TwoEyes(), 5000, {0.1, 0, 0, 0.5, 0}, 1),
                                   DesignOf(sheet), SheetViewers())),
              HasSubstr("% of the samples are off the lattice"));
}

std::string Refusal(const LatticeObservations& seen, const LayerCalibration& design) {
  try {
    EstimateLattice(seen, design, SheetViewers());
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Lattice, OfAnotherSheetIsNotFound) {
  const Sheet sheet;
  const auto seen = PhotographSheet(sheet, TwoEyes(), 2000, {0.3}, 1);
  LayerCalibration design = DesignOf(sheet);
  design.lattice->pitch_mm *= 1.05;
  EXPECT_THAT(Refusal(seen, design), HasSubstr("no lattice like the design's is seen"));
  design = DesignOf(sheet);
  design.lattice->rotation_rad += 5 * kDegree;
  EXPECT_THAT(Refusal(seen, design),
              HasSubstr("check that the display's file has the sheet's type"));
  design.lattice.reset();
  EXPECT_THAT(Refusal(seen, design), HasSubstr("the layer has no lenses"));
}

TEST(Lattice, RefusesSamplesThatMakeNoSense) {
  const Sheet sheet;
  const auto refusal = [&](auto change) {
    LatticeObservations seen = PhotographSheet(sheet, TwoEyes(), 100, {}, 1);
    change(seen);
    return Refusal(seen, DesignOf(sheet));
  };
  EXPECT_THAT(refusal([](auto& seen) { seen.samples[7].view = 2; }), HasSubstr("sample 7"));
  EXPECT_THAT(refusal([](auto& seen) { seen.samples[3].sigma_px.x() = 0; }), HasSubstr("sample 3"));
  EXPECT_THAT(refusal([](auto& seen) { seen.samples[0].panel_px.y() = std::nan(""); }),
              HasSubstr("sample 0"));
  EXPECT_THAT(refusal([](auto& seen) { seen.eyes_mm[1].z() = -1; }),
              HasSubstr("a camera does not stand before it"));
  EXPECT_THAT(refusal([](auto& seen) { seen.samples.clear(); }), HasSubstr("no pixel"));
}

// A panel of 4K behind lenses of 4.5 sub-pixels: 2500 of them side by side, 1 % is 25 lenses.
TEST(Lattice, OfFineSlantedLensesIsFound) {
  Sheet sheet;
  sheet.pitch = 1.5 * kSheetPixel;
  sheet.rotation = -std::atan(1 / 6.0);
  sheet.gap = 0.25;
  LatticeObservations seen;
  seen.eyes_mm = {{-140, 20, 620}, {130, -30, 600}};
  std::mt19937 random(4);
  std::uniform_real_distribution<double> side(-0.5, 0.5);
  std::normal_distribution<double> normal(0, 0.15);
  for (int i = 0; i < 40000; ++i) {
    const int view = i % 2;
    const Vector2d q(side(random) * 3840 * kSheetPixel, side(random) * 2160 * kSheetPixel);
    const Vector2d mm = sheet.Seen(q, seen.eyes_mm[static_cast<std::size_t>(view)]);
    seen.samples.push_back({view,
                            q,
                            {mm.x() / kSheetPixel + 1920 + normal(random),
                             1080 - mm.y() / kSheetPixel + normal(random)},
                            {1, 1}});
  }
  for (const int sign : {-1, 1}) {
    LayerCalibration design = WrongDesign(sheet, sign);
    design.emitter.width_px = 3840;
    design.emitter.height_px = 2160;
    const LatticeReport report = EstimateLattice(seen, design, SheetViewers());
    EXPECT_LT(DriftOf(report.layer, sheet), 0.01);
    EXPECT_LT(std::abs(report.layer.lattice->rotation_rad - sheet.rotation), 0.001 * kDegree);
    EXPECT_NEAR(report.layer.gap_mm, sheet.gap, 0.002);
  }
}

// Lines of sight of lightfield/panel_rays.h through a sheet of glass, before a mirrored emitter
// that is moved and turned.
LayerCalibration ThickSheet(const Sheet& sheet, double focal_mm) {
  LayerCalibration layer = DesignOf(sheet);
  layer.lattice = LensLattice{sheet.type, sheet.pitch, sheet.rotation, sheet.phase, focal_mm};
  layer.display_from_stack.translation = {3, -2, 10};
  layer.index = 1.5;
  layer.gap_mm = 1.5 * sheet.gap;
  layer.offset_mm = {0.4, -0.3};
  layer.rotation_rad = {0, 0, 0.01};
  layer.emitter.mirror_x = true;
  return layer;
}

LatticeObservations LinesOfSight(const LayerCalibration& layer, int samples) {
  const LayerSights sights(layer);
  LatticeObservations seen;
  seen.eyes_mm = TwoEyes();
  std::mt19937 random(8);
  std::uniform_real_distribution<double> side(-0.5, 0.5);
  for (int i = 0; i < samples; ++i) {
    const int view = i % 2;
    const Vector2d q(side(random) * kSheetWidth * kSheetPixel,
                     side(random) * kSheetHeight * kSheetPixel);
    const Vector3d origin = layer.display_from_stack * seen.eyes_mm[static_cast<std::size_t>(view)];
    const Vector3d at = layer.display_from_stack * Vector3d(q.x(), q.y(), 0);
    const auto hit = sights.Seen(origin, at - origin);
    if (hit) seen.samples.push_back({view, q, hit->emitter, {0.5, 0.5}});
  }
  EXPECT_EQ(static_cast<int>(seen.samples.size()), samples);
  return seen;
}

LatticeReport EstimatedFrom(const LayerCalibration& truth, const Sheet& sheet, int samples) {
  LayerCalibration design = truth;
  design.lattice = LensLattice{
      sheet.type, 1.01 * sheet.pitch, sheet.rotation + kDegree, {0, 0}, truth.lattice->focal_mm};
  design.gap_mm *= 0.93;
  return EstimateLattice(LinesOfSight(truth, samples), design, SheetViewers());
}

TEST_P(LatticeOf, IsExactBehindThickGlassAndOfLensesThatFocusBeyondThePanel) {
  for (const double focal : {0.0, 1.3}) {
    const LayerCalibration truth = ThickSheet(sheet_, focal);
    const LatticeReport report = EstimatedFrom(truth, sheet_, 3000);
    EXPECT_NEAR(report.layer.lattice->pitch_mm, sheet_.pitch, 1e-8);
    EXPECT_NEAR(report.layer.lattice->rotation_rad, sheet_.rotation, 1e-8);
    EXPECT_LT(PhaseErrorPx(report.layer, sheet_), 1e-4);
    EXPECT_NEAR(report.layer.gap_mm, truth.gap_mm, 1e-5);
    EXPECT_EQ(report.layer.lattice->focal_mm, focal);
  }
}

// An emitter that is designed to stand askew is out of the lenses' focus at its sides.
TEST_P(LatticeOf, IsFoundBeforeAPanelThatStandsAskew) {
  LayerCalibration truth = ThickSheet(sheet_, 0);
  truth.rotation_rad = {0.002, -0.001, 0.01};
  const LatticeReport report = EstimatedFrom(truth, sheet_, 10000);
  EXPECT_LT(DriftOf(report.layer, sheet_), 0.01);
}

// The same, but nobody knows.
TEST_P(LatticeOf, IsRefusedWhereThePanelStandsAskew) {
  LayerCalibration truth = ThickSheet(sheet_, 0), design = truth;
  truth.rotation_rad.y() = 0.003;
  const LatticeReport report = EstimateLattice(LinesOfSight(truth, 20000), design, SheetViewers());
  EXPECT_THAT(Lost(report), HasSubstr("the sheet or the panel is bent or stands askew"));
}

TEST(LatticeModel, SlopesAreThoseOfItsResiduals) {
  for (const Type type : {Type::kLine, Type::kSquare, Type::kHexagonal}) {
    for (const double focal : {0.0, 1.1}) {
      LensLattice lattice{type, 0.45, 0.2, {0, 0}, focal};
      Eigen::Matrix<double, 5, 1> at;
      at << 0.45, 0.2, 0.3, 0.6, 0.9;
      const SheetRay ray{0, {12, -31}, {12.1, -30.9}, {0.2, -0.15}, {0.01, 0.01}};
      const LatticeModel model(lattice, at);
      for (int a = 0; a < model.num_families(); ++a) {
        const auto residual = model.ResidualOf(ray, model.CentreOf(ray), a);
        for (int i = 0; i < 5; ++i) {
          Eigen::Matrix<double, 5, 1> low = at, high = at;
          low(i) -= 1e-6;
          high(i) += 1e-6;
          const LatticeModel below = model.At(low), above = model.At(high);
          const double slope = (above.ResidualOf(ray, above.CentreOf(ray), a).mm -
                                below.ResidualOf(ray, below.CentreOf(ray), a).mm) /
                               2e-6;
          EXPECT_NEAR(residual.slopes(i), slope, 1e-6) << a << " " << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace lamella
