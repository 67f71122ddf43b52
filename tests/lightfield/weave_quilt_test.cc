// The native image against geometry in long double: tiles of one colour show which view each
// sub-pixel took, tiles with a pattern show from where.
#include "lightfield/weave_quilt.h"

#include <numeric>

#include <gtest/gtest.h>

#include "lightfield/color.h"
#include "lightfield/parallel.h"
#include "tests/reference/weave_reference.h"

namespace lamella {
namespace {

constexpr QuiltLayout kGrid{8, 6, std::nullopt};
constexpr int kViews = 48;

// Every pixel of view i has the code i.
Image<Rgb8> NumberedQuilt(int tile_px = 3) {
  Image<Rgb8> quilt(kGrid.columns * tile_px, kGrid.rows * tile_px);
  for (int view = 0; view < kViews; ++view) {
    const auto code = static_cast<std::uint8_t>(view);
    PutQuiltView(quilt.span(), kGrid, view,
                 Image<Rgb8>(tile_px, tile_px, {code, code, code}).span());
  }
  return quilt;
}

LookingGlass Striped() {
  LookingGlass c;
  c.pitch_per_in = 52.56;
  c.slope = -7.142;
  c.center = 0.473;
  c.dpi = 324;
  c.width_px = 211;
  c.height_px = 157;
  return c;
}

LookingGlass WithCells(int pattern) {
  LookingGlass c = Striped();
  c.slope = -6.855;
  c.center = -0.265;
  c.cell_pattern = pattern;
  c.cells = {{{{-0.31, 0.25}, {0.28, 0.25}, {0, -0.25}}},
             {{{-0.3, -0.2}, {0.2, -0.25}, {0.1, 0.35}}},
             {{{0.33, -0.4}, {0.1, -0.15}, {-0.45, 0.15}}}};
  return c;
}

std::array<int, 3> Codes(const Rgb8& p) { return {p.r, p.g, p.b}; }

void ExpectViewsOfReference(const LookingGlass& c) {
  const Image<Rgb8> native =
      WeaveQuilt(NumberedQuilt().span(), kGrid, kViews, c, ViewFilter::kNearest);
  ASSERT_EQ(native.width(), c.width_px);
  ASSERT_EQ(native.height(), c.height_px);
  int wrong = 0;
  for (int row = 0; row < c.height_px; ++row) {
    for (int column = 0; column < c.width_px; ++column) {
      for (int channel = 0; channel < 3; ++channel) {
        const long double view = ReferenceView(c, column, c.height_px - 1 - row, channel);
        const int code = Codes(native(column, row))[static_cast<std::size_t>(channel)];
        wrong += IsViewOfReference(view, code, kViews) ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(WeaveQuilt, TakesTheViewsThatGeometryGivesStripes) {
  ExpectViewsOfReference(Striped());
  for (const double slope : {5.5, -4.5, 7.1}) {
    LookingGlass c = Striped();
    c.slope = slope;
    ExpectViewsOfReference(c);
  }
}

TEST(WeaveQuilt, TakesTheViewsThatGeometryGivesEveryFlipAndDirection) {
  for (int flips = 0; flips < 16; ++flips) {
    SCOPED_TRACE(flips);
    LookingGlass c = Striped();
    c.flip_x = (flips & 1) != 0;
    c.flip_y = (flips & 2) != 0;
    c.flip_subpixels = (flips & 4) != 0;
    c.invert_views = (flips & 8) == 0;
    // The lenses' equation mirrors the slope and the stripes, with the phase of the same corner.
    ExpectViewsOfReference(c);
  }
}

TEST(WeaveQuilt, TakesTheViewsThatGeometryGivesCellsOfEveryPattern) {
  for (int pattern = 0; pattern < 5; ++pattern) {
    SCOPED_TRACE(pattern);
    ExpectViewsOfReference(WithCells(pattern));
  }
}

// displays.md section 6: rows lkg_view of the Portrait and of the 16 inch display.
TEST(WeaveQuilt, ShowsThePublishedVectors) {
  LookingGlass c;
  c.pitch_per_in = 52;
  c.slope = -7;
  c.center = 0.5;
  c.dpi = 324;
  c.width_px = 1536;
  c.height_px = 2048;
  const Image<Rgb8> portrait =
      WeaveQuilt(NumberedQuilt().span(), kGrid, kViews, c, ViewFilter::kNearest);
  EXPECT_EQ(portrait(0, 0), (Rgb8{42, 40, 37}));
  EXPECT_EQ(portrait(701, 1000), (Rgb8{39, 36, 34}));
  EXPECT_EQ(portrait(1200, 33), (Rgb8{23, 20, 18}));
}

// A panel as large as a tile shows a tile's own pixels, none from its neighbours, byte for byte.
TEST(WeaveQuilt, OfTilesOfThePanelsSizeCopiesPixels) {
  for (const bool flip : {false, true}) {
    LookingGlass c = Striped();
    c.width_px = 37;
    c.height_px = 29;
    c.flip_x = c.flip_y = flip;
    const QuiltLayout layout{2, 2, 37.0 / 29};
    Image<Rgb8> quilt(74, 58);
    unsigned state = 1;
    for (std::size_t i = 0; i < quilt.size(); ++i) {
      const auto next = [&] {
        return static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
      };
      quilt.data()[i] = {next(), next(), next()};
    }
    const Image<Rgb8> native = WeaveQuilt(quilt.span(), layout, 3, c, ViewFilter::kNearest);
    for (int y = 0; y < 29; ++y) {
      for (int x = 0; x < 37; ++x) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
          const int view = ViewIndex(LookingGlassView(c, x, y, static_cast<int>(channel)), 3);
          const int column = (view % 2) * 37 + (flip ? 36 - x : x);
          const int row = (1 - view / 2) * 29 + (flip ? 28 - y : y);
          ASSERT_EQ(Codes(native(x, y))[channel], Codes(quilt(column, row))[channel]);
        }
      }
    }
  }
}

// A picture half as wide as the panel stands in its middle, one twice as wide over its whole width.
TEST(WeaveQuilt, FitsPicturesOfAnotherAspectWithBlackBars) {
  LookingGlass c = Striped();
  c.width_px = c.height_px = 40;
  for (const double aspect : {0.5, 2.0}) {
    const QuiltLayout layout{1, 1, aspect};
    const Image<Rgb8> native =
        WeaveQuilt(Image<Rgb8>(4, 4, {77, 77, 77}).span(), layout, 1, c, ViewFilter::kNearest);
    for (int i = 0; i < 40; ++i) {
      const Rgb8 across = native(i, 20), down = native(20, i);
      const int lit = i >= 10 && i < 30 ? 77 : 0;
      EXPECT_EQ(across.g, aspect < 1 ? lit : 77) << i;
      EXPECT_EQ(down.g, aspect < 1 ? 77 : lit) << i;
    }
  }
}

TEST(WeaveQuilt, StretchesInLinearLight) {
  LookingGlass c = Striped();
  c.width_px = 4;
  c.height_px = 1;
  Image<Rgb8> quilt(2, 1);
  quilt(1, 0) = {255, 255, 255};
  const QuiltLayout layout{1, 1, std::nullopt};
  const Image<Rgb8> native = WeaveQuilt(quilt.span(), layout, 1, c, ViewFilter::kNearest);
  EXPECT_EQ(native(0, 0).r, 0);
  EXPECT_EQ(native(1, 0).r, 137);  // a quarter of the light
  EXPECT_EQ(native(2, 0).r, 225);  // three quarters
  EXPECT_EQ(native(3, 0).r, 255);
}

double MeanView(const ViewTaps& taps) {
  double mean = 0;
  for (std::size_t t = 0; t < static_cast<std::size_t>(taps.count); ++t) {
    mean += static_cast<double>(taps.weights[t]) * taps.views[t];
  }
  return mean;
}

TEST(ViewFilters, WeighNeighboursAndNeverWrap) {
  for (const ViewFilter filter : {ViewFilter::kNearest, ViewFilter::kLinear, ViewFilter::kGaussian,
                                  ViewFilter::kWideGaussian}) {
    for (int i = 0; i <= 400; ++i) {
      const ViewTaps taps = TapsOf(i / 400.0, 10, filter);
      EXPECT_NEAR(std::accumulate(taps.weights.begin(), taps.weights.end(), 0.0), 1, 1e-6);
      for (const int view : taps.views) {
        EXPECT_GE(view, 0);
        EXPECT_LE(view, 9);
        const bool is_near = i < 40 ? view <= 3 : i <= 360 || view >= 6 || view == 0;
        EXPECT_TRUE(is_near) << view << " at " << i;  // views of unused taps are 0
      }
    }
  }
  EXPECT_NEAR(MeanView(TapsOf(0.325, 10, ViewFilter::kLinear)), 3.25, 1e-6);
  EXPECT_NEAR(MeanView(TapsOf(1.0, 10, ViewFilter::kLinear)), 9, 1e-6);
  EXPECT_NEAR(MeanView(TapsOf(0.35, 10, ViewFilter::kGaussian)), 3, 1e-6);  // at a centre
  EXPECT_NEAR(MeanView(TapsOf(0.35, 10, ViewFilter::kWideGaussian)), 3, 1e-6);
  // exp(-2) to one: 1 / (1 + 2 exp(-2)).
  EXPECT_NEAR(TapsOf(0.35, 10, ViewFilter::kGaussian).weights[1], 0.78698604, 1e-6);
}

TEST(WeaveQuilt, IsTheSameForAnyThreadCount) {
  const Image<Rgb8> quilt = NumberedQuilt(5);
  const auto woven = [&](int threads) {
    const ThreadLimit limit(threads);
    return WeaveQuilt(quilt.span(), kGrid, kViews, WithCells(2), ViewFilter::kGaussian);
  };
  const Image<Rgb8> one = woven(1), four = woven(4);
  EXPECT_TRUE(std::equal(one.data(), one.data() + one.size(), four.data()));
}

}  // namespace
}  // namespace lamella
