// Lenslets against geometry that is written out: searches over all centres, thin lenses that bend a
// ray by its distance from the vertex over f.
#include "lightfield/lenslet_map.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Lattice = LensletArray::Lattice;

Display Under(const LensletArray& lenses, int width, int height, bool shear = false) {
  Display display{"lenses", width, height, 0.163, 1, 500, shear, 0, 0, {}};
  display.layers = {{-10, 2.92, lenses, false}};
  Check(display, "test");
  return display;
}

LensletArray Array(Lattice lattice, double pitch, int rays) { return {lattice, pitch, rays}; }

TEST(NearestLens, IsTheOneThatASearchFinds) {
  std::mt19937 random(7);
  for (const Lattice lattice : {Lattice::kSquare, Lattice::kHexagonal}) {
    for (const bool odd : {true, false}) {
      LensletArray lenses = Array(lattice, 7.48, 3);
      lenses.shift_odd_rows = odd;
      lenses.offset_x_px = 2.3;
      lenses.offset_y_px = -4.1;
      const bool hexagonal = lattice == Lattice::kHexagonal;
      const double row_pitch = hexagonal ? 7.48 * std::sqrt(3.0) / 2 : 7.48;
      std::uniform_real_distribution<double> anywhere(-10, 60);
      for (int i = 0; i < 2000; ++i) {
        const double x = anywhere(random), y = anywhere(random);
        double nearest = std::numeric_limits<double>::infinity();
        for (int row = -5; row < 15; ++row) {
          for (int column = -5; column < 15; ++column) {
            const bool shifted = hexagonal && (std::abs(row) % 2 == 1) == odd;
            const double cx = 2.3 + 7.48 * (column + (shifted ? 1.0 : 0.5));
            nearest = std::min(nearest, std::hypot(x - cx, y - (row_pitch * (row + 0.5) - 4.1)));
          }
        }
        const Lens lens = NearestLens(lenses, x, y);
        EXPECT_NEAR(std::hypot(x - lens.x_px, y - lens.y_px), nearest, 1e-9);
        const Lens again = LensOf(lenses, lens.row, lens.column);
        EXPECT_EQ(again.x_px, lens.x_px);
        EXPECT_EQ(again.y_px, lens.y_px);
      }
    }
  }
}

TEST(LensletMap, HasTheLensesOfThePaper) {
  const LensletMap map(Under(Array(Lattice::kHexagonal, 13, 6), 1024, 768), 0);
  std::set<std::pair<int, int>> lenses;
  int lit = 0;
  for (int row = 0; row < 768; ++row) {
    for (int column = 0; column < 1024; ++column) {
      const auto pixel = map.Pixel(column, row);
      if (!pixel) continue;
      ++lit;
      lenses.insert({pixel->lens.row, pixel->lens.column});
      // Six pixels around the centre, which lies anywhere among them.
      EXPECT_LE(std::abs(column + 0.5 - pixel->lens.x_px), 3);
      EXPECT_LE(std::abs(row + 0.5 - pixel->lens.y_px), 3);
      EXPECT_EQ(pixel->ray_column, std::floor(column + 0.5 - pixel->lens.x_px + 3));
      EXPECT_EQ(pixel->ray_row, std::floor(row + 0.5 - pixel->lens.y_px + 3));
    }
  }
  EXPECT_EQ(lenses.size(), 78U * 68U);
  EXPECT_EQ(lit, 78 * 68 * 36);  // a window never loses a pixel to a neighbour
}

// Every lit pixel, through the vertex and other points of its lens: out of the lens goes what a
// thin lens of the focal length makes of the ray, and back along it the same place is seen.
void ExpectSeenAlongItsBeam(const Display& display, double focal_mm) {
  const LensletMap map(display, 0);
  const double d0 = display.layers[0].d0_mm;
  int lit = 0;
  for (int row = 0; row < display.height_px; ++row) {
    for (int column = 0; column < display.width_px; ++column) {
      const std::optional<Beam> beam = map.BeamOf(column, row);
      if (!beam) continue;
      ++lit;
      for (const double a : {-0.4, 0.0, 0.3}) {
        const double from_vertex_x = a * beam->x.aperture_mm;
        const double from_vertex_y = -0.5 * a * beam->y.aperture_mm;
        const double x = beam->x.element_mm + from_vertex_x;
        const double y = beam->y.element_mm + from_vertex_y;
        const double slope_x = (x - beam->x.emitter_mm) / d0 - from_vertex_x / focal_mm;
        const double slope_y = (y - beam->y.emitter_mm) / d0 - from_vertex_y / focal_mm;
        EXPECT_NEAR(slope_x, beam->x.slope() + beam->x.kappa_per_mm() * from_vertex_x, 1e-12);
        const std::optional<Sight> sight = map.See(x, y, slope_x, slope_y);
        ASSERT_TRUE(sight) << column << " " << row;
        EXPECT_NEAR(sight->column, column + 0.5, 1e-9);
        EXPECT_NEAR(sight->row, row + 0.5, 1e-9);
        EXPECT_EQ(sight->element_column, beam->x.opening);
        EXPECT_EQ(sight->element_row, beam->y.opening);
        EXPECT_FALSE(sight->guard);
        EXPECT_EQ(sight->slots_x, 1U);
        EXPECT_EQ(sight->channel, -1);
      }
    }
  }
  EXPECT_GT(lit, 1000);
}

TEST(LensletMap, SeesAlongEveryBeamTheEmitterThatMadeIt) {
  for (const Lattice lattice : {Lattice::kSquare, Lattice::kHexagonal}) {
    for (const bool shear : {false, true}) {
      LensletArray lenses = Array(lattice, 13, 6);
      ExpectSeenAlongItsBeam(Under(lenses, 150, 120, shear), 2.92);  // focal_mm = 0: f = d0
      lenses.offset_x_px = -3.7;
      lenses.offset_y_px = 5.2;
      for (const double focal : {2.0, 3.5, 100.0}) {
        lenses.focal_mm = focal;
        ExpectSeenAlongItsBeam(Under(lenses, 150, 120, shear), focal);
      }
    }
  }
}

TEST(LensletMap, SendsLightOfARightEmitterToTheLeftAndOfALowerOneUp) {
  const LensletMap map(Under(Array(Lattice::kSquare, 8, 4), 64, 64), 0);
  // The lens over pixels 32 to 39, centre 36, lights 34 to 37.
  EXPECT_FALSE(map.BeamOf(33, 36));
  EXPECT_FALSE(map.BeamOf(38, 36));
  EXPECT_GT(map.BeamOf(34, 36)->x.slope(), 0);
  EXPECT_LT(map.BeamOf(37, 36)->x.slope(), 0);
  EXPECT_LT(map.BeamOf(36, 34)->y.slope(), 0);
  EXPECT_GT(map.BeamOf(36, 37)->y.slope(), 0);
  EXPECT_LT(map.BeamOf(36, 60)->y.element_mm, 0);  // rows count from the top
}

TEST(LensletMap, KnowsGuardPixels) {
  const LensletMap map(Under(Array(Lattice::kSquare, 8, 4), 64, 64), 0);
  const double p = 0.163, x = 4 * p;  // the vertex over column 36 of 64
  // 2.5 pixels to the right lies a guard pixel.
  const std::optional<Sight> guard = map.See(x, 4 * p, -2.5 * p / 2.92, 0);
  ASSERT_TRUE(guard);
  EXPECT_TRUE(guard->guard);
  EXPECT_NEAR(guard->column, 38.5, 1e-9);
  // 8 pixels further, a neighbour's: light that crosses.
  const std::optional<Sight> crossed = map.See(x, 4 * p, -8.5 * p / 2.92, 0.5 * p / 2.92);
  ASSERT_TRUE(crossed);
  EXPECT_FALSE(crossed->guard);
  EXPECT_EQ(crossed->element_column, 4);
  EXPECT_EQ(
      map.Pixel(static_cast<int>(crossed->column), static_cast<int>(crossed->row))->lens.column, 5);
}

TEST(LensletMap, SeesNothingBesideThePanelAndWhereNoWholeLensIs) {
  const LensletMap map(Under(Array(Lattice::kSquare, 8, 4), 60, 64), 0);
  const double half = 30 * 0.163;
  EXPECT_TRUE(map.See(half - 5 * 0.163, 0.1, 0, 0));
  EXPECT_FALSE(map.See(half - 3 * 0.163, 0.1, 0, 0));  // the eighth lens is cut
  EXPECT_FALSE(map.BeamOf(58, 36));
  EXPECT_FALSE(map.See(half + 1e-9, 0, 0, 0));
  EXPECT_FALSE(map.See(0, 0, 10, 0));
  EXPECT_FALSE(map.See(std::nan(""), 0, 0, 0));
  EXPECT_FALSE(map.See(0, 0, 0, INFINITY));
  EXPECT_FALSE(map.BeamOf(-1, 0));
  EXPECT_FALSE(map.BeamOf(0, 64));
}

TEST(LensletMap, AimsTheMiddleOfEveryWindowAtTheViewer) {
  const Display display = Under(Array(Lattice::kHexagonal, 13, 6), 1024, 768, true);
  const LensletMap map(display, 0);
  const double step = ViewSpacingMm(display, display.layers[0], 510);
  int lit = 0;
  for (int row = 0; row < 768; row += 5) {
    for (int column = 0; column < 1024; ++column) {
      const std::optional<Beam> beam = map.BeamOf(column, row);
      if (!beam) continue;
      ++lit;
      // Three emitters to each side, and half a one of rounding.
      EXPECT_LE(std::abs(beam->x.At(510)), 3.5 * step + 1e-6);
      EXPECT_LE(std::abs(beam->y.At(510)), 3.5 * step + 1e-6);
    }
  }
  EXPECT_GT(lit, 0.9 * 0.246 * 1024 * 154);
}

TEST(LensletMap, HoldsWithLensesOfOnePixelAndWithOneLens) {
  const LensletMap pixels(Under(Array(Lattice::kSquare, 1, 1), 16, 9), 0);
  for (int column = 0; column < 16; ++column) {
    EXPECT_EQ(pixels.BeamOf(column, 4)->x.slope(), 0);
    EXPECT_EQ(pixels.BeamOf(column, 4)->x.opening, column);
  }
  const LensletMap hexagons(Under(Array(Lattice::kHexagonal, 1, 1), 16, 9), 0);
  EXPECT_TRUE(hexagons.BeamOf(8, 0));
  const LensletMap one(Under(Array(Lattice::kSquare, 9, 9), 9, 9), 0);
  for (int i = 0; i < 9; ++i) {
    ASSERT_TRUE(one.BeamOf(i, 8 - i));
    EXPECT_NEAR(one.BeamOf(i, 4)->x.slope(), (4 - i) * 0.163 / 2.92, 1e-12);
  }
  EXPECT_FALSE(one.BeamOf(9, 0));
}

TEST(LensletMap, IsOfLensletsOnly) {
  Display display = Under(Array(Lattice::kSquare, 8, 4), 64, 64);
  display.layers[0].optics = Barrier{};
  EXPECT_THROW(LensletMap(display, 0), Error);
}

TEST(LensSlope, FollowsSnell) {
  for (const double offset : {-1.2, 0.0, 0.3, 1.0}) {
    // Bisection for the emergent angle: n1 sin1 = sin2.
    const double inside = std::atan2(offset, 4.47);
    double low = -std::numbers::pi / 2, high = std::numbers::pi / 2;
    for (int i = 0; i < 100; ++i) {
      const double middle = (low + high) / 2;
      (std::sin(middle) < 1.49 * std::sin(inside) ? low : high) = middle;
    }
    EXPECT_NEAR(ExactLensSlope(offset, 4.47, 1.49), -std::tan(low), 1e-9);
  }
  EXPECT_NEAR(ExactLensSlope(1e-4, 4.47, 1.49), ParaxialLensSlope(1e-4, 4.47, 1.49), 1e-12);
}

}  // namespace
}  // namespace lamella
