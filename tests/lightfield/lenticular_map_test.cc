// Slanted lenticular lenses against geometry that is written out: cylinders whose vertex lines are
// straight, which bend a ray across them by its distance from that line over f.
#include "lightfield/lenticular_map.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/looking_glass.h"

namespace lamella {
namespace {

constexpr double kPitch = 0.3, kGap = 1.5;

Display Under(const Lenticular& lenses, bool shear, bool mirror = false) {
  Display display{"lenticular", 200, 120, kPitch, 1, 500, shear, 0, 0, {}};
  display.layers = {{5, kGap, lenses, mirror}};
  Check(display, "test");
  return display;
}

TEST(VanBerkelView, GivesTheClassicNineViewPattern) {
  // 4.5 sub-pixels per lens and slant 1/6: each row starts half a sub-pixel, one view, earlier.
  const Lenticular lenses{4.5, 1.0 / 6, 9, 0};
  constexpr double kRounding = 1e-9;
  for (int row = 0; row < 12; ++row) {
    for (int k = 0; k < 30; ++k) {
      const int expected = ((2 * k - row) % 9 + 9) % 9;
      const double view = VanBerkelView(lenses, k, row);
      EXPECT_NEAR(std::remainder(view - expected, 9), 0, kRounding) << k << " " << row;
      EXPECT_GE(view, 0);
      EXPECT_LT(view, 9);
    }
  }
}

TEST(VanBerkelView, IsTheLookingGlasssViewTurnedRound) {
  LookingGlass calibration;
  calibration.pitch_per_in = 52.3;
  calibration.slope = -7.1;
  calibration.center = 0.37;
  calibration.dpi = 324;
  calibration.width_px = 1536;
  calibration.height_px = 2048;
  const double lenses_per_width = WeaveOf(calibration).lenses;
  Lenticular lenses;
  lenses.subpixels_per_lens = 3 * 1536 / lenses_per_width;
  lenses.slant = 1 / calibration.slope;
  lenses.views = 1;
  lenses.offset_subpx = 1.5 + 3 * (2048 - 0.5) * lenses.slant - 0.37 * lenses.subpixels_per_lens;
  for (int row = 0; row < 2048; row += 119) {
    for (int column = 0; column < 1536; column += 67) {
      for (int c = 0; c < 3; ++c) {
        const double view = LookingGlassView(calibration, column, row, c);
        EXPECT_NEAR(std::remainder(view + VanBerkelView(lenses, 3 * column + c, row), 1), 0, 1e-9);
      }
    }
  }
}

TEST(LenticularMap, SeesAlongEveryBeamTheEmitterThatMadeIt) {
  for (const double slant : {0.0, 1.0 / 6, -0.3, 40.0}) {
    for (const bool shear : {false, true}) {
      for (const bool mirror : {false, true}) {
        const LenticularMap map(Under({4.5, slant, 9, 1.3}, shear, mirror), 0);
        int beams = 0;
        for (int row = 0; row < 120; row += 7) {
          for (int column = 0; column < 200; ++column) {
            for (int channel = 0; channel < 3; ++channel) {
              const std::optional<Beam> beam = map.BeamOf(channel, column, row);
              ASSERT_TRUE(beam);
              const std::optional<Sight> sight =
                  map.See(beam->x.element_mm, beam->y.element_mm, beam->x.slope(), beam->y.slope());
              if (!sight) continue;  // beyond the panel's edge
              ++beams;
              EXPECT_NEAR(sight->column, column + ((mirror ? 2 - channel : channel) + 0.5) / 3,
                          1e-9);
              EXPECT_NEAR(sight->row, row + 0.5, 1e-9);
              EXPECT_EQ(sight->channel, channel);
              EXPECT_EQ(sight->element_column, beam->x.opening);
              if (shear) {
                EXPECT_NEAR(beam->y.At(495), 0, 1e-9);
              }
            }
          }
        }
        EXPECT_GT(beams, 9000);
      }
    }
  }
}

TEST(LenticularMap, BendsRaysAcrossItsCylindersOnly) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double focal : {0.0, 1.1, 2.5}) {
    for (const double slant : {0.0, 1.0 / 6, -0.4}) {
      const LenticularMap map(Under({6, slant, 6, 0, focal}, false), 0);
      const double f = focal == 0 ? kGap : focal;
      // Vertex lines: phase 3, 9, ... of k - 3 l tan alpha, with k and l of the sub-pixels'
      // centres.
      const auto phase = [&](double x, double y) {
        return (3 * (x / kPitch + 100) - 0.5) - 3 * slant * (60 - y / kPitch - 0.5);
      };
      const double cosine = std::cos(std::atan(slant)), sine = std::sin(std::atan(slant));
      for (int i = 0; i < 500; ++i) {
        const double x = 15 * unit(random), y = 10 * unit(random);        // on the lenses
        const double ex = x + 1.5 * unit(random), ey = y + unit(random);  // on the emitters
        const double turns = phase(x, y) / 6;
        const double along_row_mm = (turns - std::floor(turns) - 0.5) * 6 * kPitch / 3;
        const double across_mm = along_row_mm * cosine;
        const double slope_x = (x - ex) / kGap - cosine * across_mm / f;
        const double slope_y = (y - ey) / kGap - sine * across_mm / f;
        const std::optional<Sight> sight = map.See(x, y, slope_x, slope_y);
        ASSERT_TRUE(sight);
        EXPECT_NEAR((sight->column - 100) * kPitch, ex, 1e-9);
        EXPECT_NEAR((60 - sight->row) * kPitch, ey, 1e-9);
        EXPECT_EQ(sight->element_column, std::floor(turns));
        // Along the vertex line nothing changes but the height.
        const double step = 0.7;
        const auto above = map.See(x - step * sine, y + step * cosine, slope_x, slope_y);
        ASSERT_TRUE(above);
        EXPECT_EQ(above->element_column, sight->element_column);
        EXPECT_NEAR((above->column - sight->column) * kPitch, -step * sine, 1e-9);
        EXPECT_NEAR((above->row - sight->row) * kPitch, -step * cosine, 1e-9);
      }
    }
  }
}

TEST(LenticularMap, ShowsTheFirstViewToTheRight) {
  const LenticularMap map(Under({6, 0, 6, 0.5}, false), 0);
  EXPECT_NEAR(map.View(0, 50, 0), 0.5, 1e-9);
  EXPECT_NEAR(map.BeamOf(0, 50, 0)->x.slope(), 2.5 * kPitch / 3 / kGap, 1e-12);
  EXPECT_NEAR(map.View(2, 51, 0), 5.5, 1e-9);
  EXPECT_NEAR(map.BeamOf(2, 51, 0)->x.slope(), -2.5 * kPitch / 3 / kGap, 1e-12);
}

TEST(LenticularMap, HasNoVerticalParallax) {
  const LenticularMap map(Under({4.5, 1.0 / 6, 9}, false), 0);
  const std::optional<Beam> beam = map.BeamOf(1, 77, 40);
  ASSERT_TRUE(beam);
  for (const double offset : {-20.0, 0.0, 30.0}) {
    EXPECT_NEAR(beam->y.OpeningBlurMm(offset), kPitch, 1e-12);
    EXPECT_EQ(beam->y.EmitterBlurMm(offset), 0);
    EXPECT_NEAR(beam->x.OpeningBlurMm(offset), 4.5 * kPitch / 3, 1e-12);
    EXPECT_NEAR(beam->x.EmitterBlurMm(offset), kPitch / 3 * std::abs(offset) / kGap, 1e-12);
  }
}

TEST(LenticularMap, SeesNothingBesideThePanel) {
  const LenticularMap map(Under({4.5, 1.0 / 6, 9}, false), 0);
  EXPECT_TRUE(map.See(29.9, 0, 0, 0));
  EXPECT_FALSE(map.See(30.01, 0, 0, 0));
  EXPECT_FALSE(map.See(0, -18.01, 0, 0));
  EXPECT_FALSE(map.See(0, 0, 0, 100));
  EXPECT_FALSE(map.See(std::nan(""), 0, 0, 0));
  EXPECT_FALSE(map.See(0, 0, std::nan(""), 0));
  EXPECT_FALSE(map.BeamOf(0, 200, 0));
  EXPECT_FALSE(map.BeamOf(0, 0, -1));
}

}  // namespace
}  // namespace lamella
