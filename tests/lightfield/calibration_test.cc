#include "lightfield/calibration.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

Display TwoLayers() {
  Display display;
  display.name = "two";
  display.width_px = 48;
  display.height_px = 36;
  display.pitch_mm = 0.5;
  display.viewing_distance_mm = 400;
  display.layers.resize(2);
  display.layers[0].position_mm = -10;
  display.layers[0].mirror_x = true;
  display.layers[1].position_mm = 10;
  return display;
}

TEST(DesignCalibration, PutsThePanelsWhereTheDisplaySays) {
  const Calibration design = DesignCalibration(TwoLayers());
  ASSERT_EQ(design.layers.size(), 2U);
  EXPECT_NO_THROW(Check(design, "design"));
  EXPECT_TRUE(design.layers[0].emitter.mirror_x && design.layers[0].modulator->mirror_x);
  EXPECT_FALSE(design.layers[1].emitter.mirror_x);
  EXPECT_EQ(design.layers[1].gain, 0.5);
  // displays.md section 1.4: x_e = x_m - d0 (e_x - x_m)/(D - z).
  const Eigen::Vector3d eye(30, 0, 400), modulator(5, 0, 10);
  const auto hit = LayerSights(design.layers[1]).Seen(eye, modulator - eye);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->modulator.x(), 24 + 5 / 0.5, 1e-12);
  EXPECT_NEAR(hit->emitter.x(), 24 + (5 - 5 * 25.0 / 390) / 0.5, 1e-12);
}

TEST(DesignCalibration, HasThePlateThatALayerIsSeenThrough) {
  Display display = TwoLayers();
  display.layers[1].plate = GlassPlate{3, 1.52, {2, 0, 2}};
  const Calibration design = DesignCalibration(display);
  EXPECT_NO_THROW(Check(design, "design"));
  EXPECT_FALSE(design.layers[0].plate);
  ASSERT_TRUE(design.layers[1].plate);
  EXPECT_EQ(design.layers[1].plate->thickness_mm, 3);
  EXPECT_EQ(design.layers[1].plate->index, 1.52);
  // An eye on the axis sees through glass at 45 degrees t sin(45) (1 - cos(45)/sqrt(n^2 - 1/2))
  // aside, towards where the glass is thicker for it.
  const double aside = 3 * std::sqrt(0.5) * (1 - std::sqrt(0.5) / std::sqrt(1.52 * 1.52 - 0.5));
  const auto hit = LayerSights(design.layers[1]).Seen({0, 0, 400}, {0, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(std::abs(hit->modulator.x() - 24), aside / 0.5, 1e-9);
}

// hex_centre of displays.md section 6, L = 13: (1, 0) is at (13, 16.88749537) px.
TEST(DesignCalibration, PutsHexagonalLensesWhereTheReferenceHasThem) {
  Display display = TwoLayers();
  display.width_px = 923 * 2;
  display.height_px = 760 * 2;
  display.layers.resize(1);
  display.layers[0].optics = LensletArray{};
  const Calibration design = DesignCalibration(display);
  ASSERT_TRUE(design.layers[0].lattice && !design.layers[0].modulator);
  const auto lens_px = [&](double u, double v) {
    const Eigen::Vector2d at((u - 923) * 0.5, (760 - v) * 0.5);
    const Eigen::Vector2d lens = NearestLens(*design.layers[0].lattice, at);
    return Eigen::Vector2d(lens.x() / 0.5 + 923, 760 - lens.y() / 0.5);
  };
  EXPECT_LT((lens_px(14, 17) - Eigen::Vector2d(13, 16.88749537)).norm(), 1e-6);
  EXPECT_LT((lens_px(7, 6) - Eigen::Vector2d(6.5, 13 * std::sqrt(3.0) / 4)).norm(), 1e-9);
  EXPECT_LT((lens_px(922, 761) - Eigen::Vector2d(923, 759.9372918)).norm(), 1e-6);  // (67, 70)
}

// van_berkel's lens edges: views 0 and N meet where (k + k_off - 3 l tan a) mod X = 0.
TEST(DesignCalibration, PutsLenticularAxesBetweenTheEdgesOfVanBerkel) {
  Display display = TwoLayers();
  display.layers.resize(1);
  const Lenticular lenses{4.5, 1.0 / 6, 9, 0.7, 0};
  display.layers[0].optics = lenses;
  const Calibration design = DesignCalibration(display);
  EXPECT_TRUE(design.layers[0].emitter.rgb_stripes);
  for (int l = 0; l < 36; ++l) {
    for (int k = 0; k < 3 * 48; ++k) {
      const double turns = (k + 0.7 - 3 * l / 6.0) / 4.5;
      const double offset_subpx = (turns - std::floor(turns) - 0.5) * 4.5;
      const Eigen::Vector2d at(((k + 0.5) / 3 - 24) * 0.5, (18 - l - 0.5) * 0.5);
      const Eigen::Vector2d axis = NearestLens(*design.layers[0].lattice, at);
      // Across the lens: the offset along the row times cos(alpha), to the right and up.
      const double cosine = 1 / std::hypot(1.0, 1.0 / 6);
      const double across = (at - axis).dot(Eigen::Vector2d(cosine, cosine / 6));
      EXPECT_NEAR(std::abs(across), std::abs(offset_subpx) * 0.5 / 3 * cosine, 1e-9);
      if (std::abs(std::abs(offset_subpx) - 2.25) > 1e-9) {
        EXPECT_NEAR(across, offset_subpx * 0.5 / 3 * cosine, 1e-9) << k << " " << l;
      }
    }
  }
}

TEST(DesignCalibration, MagnifiesWhatARelayShows) {
  Display display = TwoLayers();
  display.layers.resize(1);
  display.layers[0].optics = LensletArray{LensletArray::Lattice::kSquare, 12, 6, 0, 0, true, 0};
  display.layers[0].mirror_x = false;
  display.layers[0].position_mm = 40;
  display.layers[0].d0_mm = 3;
  display.layers[0].magnification = 1.25;
  const Calibration design = DesignCalibration(display);
  // Lens centre x_c (unmagnified 3 mm: column 30), slope s: position M x_c, emitter M x_c - M^2 d0
  // s in the world, so pixel 24 + (x_c - M d0 s)/p.
  const double s = 0.08, x = 1.25 * 3;
  const auto hit = LayerSights(design.layers[0]).Seen({x + s * 360, x, 400}, {-s, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->emitter.x(), 24 + (3 - 1.25 * 3 * s) / 0.5, 1e-9);
}

TEST(DesignCalibration, IsPossibleForEveryMagnificationOfADisplay) {
  for (const double magnification : {0.01, 0.5, 2.0, 50.0}) {
    Display display = TwoLayers();
    for (Layer& layer : display.layers) layer.magnification = magnification;
    display.viewing_distance_mm = 1e6;
    lamella::Check(display, "test");
    EXPECT_NO_THROW(lamella::Check(DesignCalibration(display), "test")) << magnification;
  }
}

TEST(LightOfCode, FollowsItsCurve) {
  EXPECT_NEAR(LightOfCode({ToneCurve::Kind::kGamma, 2.0, {}}, 0.5), 0.25, 1e-15);
  EXPECT_NEAR(LightOfCode({}, 128 / 255.0), 0.2158605, 1e-6);  // IEC 61966-2-1
  const ToneCurve table{ToneCurve::Kind::kTable, 1, {0, 0.1, 1}};
  EXPECT_NEAR(LightOfCode(table, 0.25), 0.05, 1e-15);
  EXPECT_NEAR(LightOfCode(table, 0.75), 0.55, 1e-15);
  EXPECT_EQ(LightOfCode(table, 1), 1);
  EXPECT_EQ(LightOfCode(table, -1), 0);
}

TEST(GaussianSpread, SumsToOneAndIsSymmetric) {
  const SpreadKernel kernel = GaussianSpread(0.8);
  EXPECT_EQ(kernel.size, 7);
  EXPECT_NEAR(std::accumulate(kernel.weights.begin(), kernel.weights.end(), 0.0), 1, 1e-12);
  for (std::size_t i = 0; i < 49; ++i) EXPECT_EQ(kernel.weights[i], kernel.weights[48 - i]);
  EXPECT_EQ(GaussianSpread(0), SpreadKernel());
}

TEST(CheckCalibration, NamesWhatIsWrong) {
  const auto refusal = [](const std::function<void(Calibration&)>& change) {
    Calibration calibration = DesignCalibration(TwoLayers());
    change(calibration);
    try {
      Check(calibration, "calibration.json");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal([](Calibration&) {}), "accepted");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([&](Calibration& c) { c.layers[1].emitter.bow_mm = nan; }),
              HasSubstr("calibration.json: layer 1, emitter: bow_mm = nan"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers[0].modulator->pitch_mm = 0; }),
              HasSubstr("layer 0, modulator: pitch_mm"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers[0].index = 0.9; }), HasSubstr("index = 0.9"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers[0].gap_mm = -1; }), HasSubstr("gap_mm = -1"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers[0].display_from_stack.rotation.w() = 2; }),
              HasSubstr("unit quaternion"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers[0].lattice = LensLattice{}; }),
              HasSubstr("both lenses and a modulator"));
  EXPECT_THAT(
      refusal([](Calibration& c) { c.layers[0].emitter.photometry.crosstalk.weights = {0.9}; }),
      HasSubstr("sum to 0.9"));
  EXPECT_THAT(refusal([](Calibration& c) {
                c.layers[0].emitter.photometry.evenness = {2, 2, {1}};
              }),
              HasSubstr("evenness is not of columns x rows"));
  EXPECT_THAT(refusal([](Calibration& c) {
                c.layers[0].emitter.photometry.evenness = {1, 1, {0}};
              }),
              HasSubstr("a gain of evenness"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers[0].emitter.photometry.black = 1; }),
              HasSubstr("black"));
  EXPECT_THAT(
      refusal([](Calibration& c) {
        c.layers[0].emitter.photometry.curve = {ToneCurve::Kind::kTable, 1, {0, 0.5, 0.4, 1}};
      }),
      HasSubstr("does not rise"));
  EXPECT_THAT(refusal([](Calibration& c) { c.layers.clear(); }), HasSubstr("no layer"));
}

}  // namespace
}  // namespace lamella
