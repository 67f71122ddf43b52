// The kernels of rendering against plain references, on every instruction set.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "depth/blend_kernels.h"
#include "depth/bundle_map.h"
#include "depth/draw_quads.h"
#include "depth/forward_warp.h"
#include "depth/resize_area.h"
#include "depth/source_view.h"
#include "tests/depth/every_target.h"
#include "tests/reference/blend_reference.h"

namespace lamella {
namespace {

constexpr float kNothing = kNoSurface;

struct RandomQuads {
  std::vector<float> u[4], v[4], n[4];
  std::vector<std::uint8_t> drawn;

  RandomQuads(int count, float size, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto number = [&](float low, float high) {
      return low + (high - low) * static_cast<float>(random()) / 4294967296.0F;
    };
    for (int i = 0; i < count + kQuadPadding; ++i) {
      const float x = number(-3, 40), y = number(-3, 30);
      for (int k = 0; k < 4; ++k) {
        const int right = k % 2, below = k / 2;
        u[k].push_back(x + size * (static_cast<float>(right) + number(-0.3F, 0.3F)));
        v[k].push_back(y + size * (static_cast<float>(below) + number(-0.3F, 0.3F)));
        n[k].push_back(number(0, 1));
      }
      drawn.push_back(random() % 8 != 0);
    }
  }
  Quads View(int count) const {
    Quads quads;
    for (std::size_t k = 0; k < 4; ++k) {
      quads.u[k] = u[k].data();
      quads.v[k] = v[k].data();
      quads.n[k] = n[k].data();
    }
    quads.drawn = drawn.data();
    quads.count = count;
    return quads;
  }
};

// The largest value of the triangles that cover a point for sure, and of those that might.
struct Bounds {
  double sure = -std::numeric_limits<double>::infinity(), possible = sure;
};

void Consider(const RandomQuads& q, std::size_t i, int a, int b, int c, double x, double y,
              Bounds& bounds) {
  const auto u = [&](int k) { return static_cast<double>(q.u[k][i]); };
  const auto v = [&](int k) { return static_cast<double>(q.v[k][i]); };
  const double area = (u(b) - u(a)) * (v(c) - v(a)) - (u(c) - u(a)) * (v(b) - v(a));
  if (!(area > 0)) return;
  const double beta = ((x - u(a)) * (v(c) - v(a)) - (u(c) - u(a)) * (y - v(a))) / area;
  const double gamma = ((u(b) - u(a)) * (y - v(a)) - (x - u(a)) * (v(b) - v(a))) / area;
  const double least = std::min({beta, gamma, 1 - beta - gamma});
  const double n = static_cast<double>(q.n[a][i]) +
                   beta * static_cast<double>(q.n[b][i] - q.n[a][i]) +
                   gamma * static_cast<double>(q.n[c][i] - q.n[a][i]);
  if (least > 1e-4) bounds.sure = std::max(bounds.sure, n);
  if (least > -2e-3) bounds.possible = std::max(bounds.possible, n);
}

Bounds Expected(const RandomQuads& quads, int count, int x, int y) {
  Bounds bounds;
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (quads.drawn[k] == 0) continue;
    Consider(quads, k, 0, 1, 2, x + 0.5, y + 0.5, bounds);
    Consider(quads, k, 3, 2, 1, x + 0.5, y + 0.5, bounds);
  }
  return bounds;
}

TEST(DrawQuads, EqualsEveryTriangleAtEveryPointOnEveryTarget) {
  for (const float size : {0.4F, 1.0F, 1.7F, 12.0F}) {
    const int count = size > 10 ? 9 : 301;
    const RandomQuads quads(count, size, 7);
    Image<float> first;
    ForEveryTarget([&] {
      Image<float> raster(37, 27, kNothing);
      DrawQuads(quads.View(count), raster.span());
      for (int y = 0; y < raster.height(); ++y) {
        for (int x = 0; x < raster.width(); ++x) {
          const Bounds bounds = Expected(quads, count, x, y);
          ASSERT_GE(static_cast<double>(raster(x, y)), bounds.sure - 1e-3)
              << size << " " << x << "," << y;
          ASSERT_LE(static_cast<double>(raster(x, y)), bounds.possible + 1e-3)
              << size << " " << x << "," << y;
        }
      }
      if (first.empty()) first = raster.Clone();
      EXPECT_EQ(std::memcmp(first.data(), raster.data(), raster.size() * sizeof(float)), 0);
    });
  }
}

TEST(DrawQuads, DrawsNothingOfWhatIsNotFinite) {
  ForEveryTarget([] {
    RandomQuads quads(16, 1.0F, 3);
    for (std::size_t i = 0; i < 16; ++i) {
      quads.u[i % 4][i] = i % 3 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                     : std::numeric_limits<float>::infinity();
      quads.n[0][i] = quads.n[3][i] = std::numeric_limits<float>::infinity();
    }
    Image<float> raster(20, 20, kNothing);
    DrawQuads(quads.View(16), raster.span());
    for (std::size_t i = 0; i < raster.size(); ++i) ASSERT_EQ(raster.data()[i], kNothing);
  });
}

TEST(MapVertices, EqualsTheMapAndMarksWhatIsBehind) {
  Eigen::Matrix4d map;
  map << 1.1, 0.02, 3, 40, -0.03, 0.95, 1, 5, 0.001, -0.002, 1, 0.3, 0, 0, 0.1, 1.2;
  const LocalMap local(map, 20, 10, 0.5);
  std::vector<float> da(64), w(64), u(64), v(64), n(64);
  for (std::size_t i = 0; i < 64; ++i) {
    da[i] = static_cast<float>(i) - 16;
    w[i] = i == 20 ? -40.0F : 0.02F * static_cast<float>(i);  // 20: behind
  }
  ForEveryTarget([&] {
    MapVertices(local, 0.5F, da.data(), 3.0F, w.data(), 33, u.data(), v.data(), n.data());
    for (std::size_t i = 0; i < 33; ++i) {
      const Eigen::Vector4d out =
          map * Eigen::Vector4d(20 + static_cast<double>(da[i]), 13, 1, static_cast<double>(w[i]));
      if (i == 20) {
        ASSERT_LT(out.z(), 0);
        ASSERT_TRUE(std::isnan(u[i]));
        continue;
      }
      ASSERT_NEAR(static_cast<double>(u[i]), out.x() / out.z(), 1e-4);
      ASSERT_NEAR(static_cast<double>(v[i]), out.y() / out.z(), 1e-4);
      ASSERT_NEAR(static_cast<double>(n[i]), out.w() / out.z(), 1e-6);
    }
  });
}

// A small view with a slanted surface, an edge and an unknown patch.
struct SmallView {
  std::vector<DepthLevel> depth;
  ColorPyramid color;
  TileView view;

  SmallView() : view{LocalMap(Map(), 48, 48, 0.2)} {
    DepthMap map{Image<float>(40, 36), Image<float>(40, 36)};
    Image<Rgb> picture(80, 72);
    for (int y = 0; y < 36; ++y) {
      for (int x = 0; x < 40; ++x) {
        const float w = (x < 20 ? 0.2F : 0.3F) + 0.0005F * static_cast<float>(y);
        map.depth(x, y) = x > 30 && y > 20 ? 0.0F : 1.0F / w;
        map.confidence(x, y) = static_cast<float>((x * 7 + y * 3) % 10) / 10.0F;
      }
    }
    for (int y = 0; y < 72; ++y) {
      for (int x = 0; x < 80; ++x) {
        const auto wave = [&](int a, int b) {
          return 0.5F + 0.5F * std::sin(static_cast<float>(a * x + b * y));
        };
        picture(x, y) = {wave(1, 2), wave(2, 1), 0.2F * wave(1, 1)};
      }
    }
    depth = DepthPyramid(map, 80, 72, {0.02, 0});
    color = ColorPyramid(picture, {1, 1, 0.5F}, 4);
    view.at_nearness = 0.2F;
    view.penalty = {0.1F, 0.4F, 0.2F, 1.5F};
    view.width = 80;
    view.height = 72;
    view.per_fade = 0.3F;
    view.softness_absolute = 0.01F;
    view.softness_relative = 0.02F;
    view.depth = &depth[0];
    view.color = &color[0];
  }
  // Rays (u, v) of the tile at (32, 32) to pixels; part of the tile looks past the picture.
  static Eigen::Matrix4d Map() {
    Eigen::Matrix4d map;
    map << 2.6, 0.1, -90, 60, 0.05, 2.4, -80, 0, 0, 0.001, 1, 0.1, 0, 0, 0, 1.1;
    return map;
  }
};

void FillTile(int count, TileRays& rays) {
  rays.count = count;
  for (std::size_t i = 0; i < kTileRays; ++i) {
    const std::size_t column = i % kTile, row = i / kTile;
    rays.du[i] = static_cast<float>(column) + 0.5F - 16;
    rays.dv[i] = static_cast<float>(row) + 0.5F - 16;
    rays.nearness[i] = 0.16F + 0.0001F * static_cast<float>((i * 37) % 1400);
    rays.weight[i] = i % 5 == 0 ? 3.0F : 0.0F;
    rays.seen[i] = i % 3 == 0 ? 0.6F : 0.2F;
    rays.most_seen[i] = 0.1F;
    rays.confidence[i] = 0;
    rays.color[i] = {};
  }
}

TEST(SeeTile, EqualsTheFormulasRayByRayOnEveryTarget) {
  const SmallView small;
  for (const int count : {1, 13, 1024}) {
    for (const bool unseen_only : {false, true}) {
      ForEveryTarget([&] {
        TileRays rays, before;
        FillTile(count, before);
        FillTile(count, rays);
        ActiveRays active;
        SeeTile(small.view, unseen_only, rays, active);
        int next = 0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
          const bool left_out = unseen_only && before.seen[i] > 0.5F;
          const reference::Added added =
              left_out ? reference::Added()
                       : reference::Add(small.view, static_cast<double>(rays.du[i]),
                                        static_cast<double>(rays.dv[i]),
                                        static_cast<double>(rays.nearness[i]));
          ASSERT_NEAR(static_cast<double>(rays.seen[i] - before.seen[i]), added.visible, 2e-3) << i;
          ASSERT_NEAR(static_cast<double>(rays.confidence[i]), added.confidence, 2e-2) << i;
          const bool active_here =
              next < active.count &&
              active.ray[static_cast<std::size_t>(next)] == static_cast<std::int32_t>(i);
          const double least = 1e-3 * static_cast<double>(before.weight[i]);
          if (added.weight > 1.1 * least && added.weight > 0) {
            ASSERT_TRUE(active_here) << i;
            const auto at = static_cast<std::size_t>(next);
            ASSERT_NEAR(static_cast<double>(active.x[at]), added.x, 1e-3);
            ASSERT_NEAR(static_cast<double>(active.y[at]), added.y, 1e-3);
            ASSERT_NEAR(static_cast<double>(active.weight[at]), added.weight,
                        2e-3 + 2e-3 * added.weight);
          } else if (added.weight < 0.9 * least || left_out) {
            ASSERT_FALSE(active_here) << i;
          }
          next += active_here;
        }
        ASSERT_EQ(next, active.count);
      });
    }
  }
}

TEST(AddColors, EqualsTheFilterByItsDefinitionOnEveryTarget) {
  const SmallView small;
  for (const bool cubic : {true, false}) {
    for (const std::size_t l : {std::size_t{0}, std::size_t{3}}) {
      const ColorLevel& level = small.color[l];
      std::vector<float> first;
      ForEveryTarget([&] {
        TileRays rays;
        FillTile(1024, rays);
        ActiveRays active;
        for (int i = 0; i < 200; ++i) {
          const auto k = static_cast<std::size_t>(active.count++);
          active.ray[k] = 3 * i;
          active.x[k] = std::min(80.0F, 0.41F * static_cast<float>(i));
          active.y[k] = std::max(0.0F, 72.0F - 0.37F * static_cast<float>(i));
          active.weight[k] = 0.5F;
        }
        AddColors(level, cubic, active, rays);
        std::vector<float> sums;
        for (std::size_t k = 0; k < 200; ++k) {
          const float* sum = rays.color[3 * k].channels;
          sums.insert(sums.end(), sum, sum + 3);
          for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(static_cast<double>(sum[c]),
                        0.5 * reference::ColorAt(level, cubic, static_cast<double>(active.x[k]),
                                                 static_cast<double>(active.y[k]), c),
                        1e-4)
                << k;
          }
        }
        if (first.empty()) first = sums;
        EXPECT_EQ(first, sums);  // the same bytes on every target
      });
    }
  }
}

TEST(ColorPyramid, KeepsColoursAsHalfFloatsToThreeDigits) {
  Image<Rgb> picture(3, 1);
  picture(0, 0) = {1e-6F, 0.3333F, 1};
  picture(1, 0) = {0, -2, 60000};
  picture(2, 0) = {2e-8F, 0.00002F, 1e9F};
  const ColorPyramid levels(picture, {1, 1, 1}, 0);
  const auto at = [&](int x) { return levels[0].pixels(x + ColorLevel::kPad, ColorLevel::kPad); };
  EXPECT_NEAR(reference::FromHalf(at(0).r), 1e-6, 3e-8);
  EXPECT_NEAR(reference::FromHalf(at(0).g), 0.3333, 1e-4);
  EXPECT_EQ(reference::FromHalf(at(0).b), 1);
  EXPECT_EQ(reference::FromHalf(at(1).r), 0);
  EXPECT_EQ(reference::FromHalf(at(1).g), 0);
  EXPECT_NEAR(reference::FromHalf(at(1).b), 60000, 16);
  EXPECT_EQ(reference::FromHalf(at(2).r), 0);
  EXPECT_NEAR(reference::FromHalf(at(2).g), 0.00002, 3e-8);
  EXPECT_EQ(reference::FromHalf(at(2).b), 65504);  // the largest
}

TEST(ColorPyramid, ChoosesAnExponentThatFits) {
  for (const float largest : {1e-30F, 1e-8F, 0.5F, 1.0F, 3.0F, 1e8F, 1e30F}) {
    const double scaled = std::ldexp(static_cast<double>(largest), ColorExponent(largest));
    EXPECT_LT(scaled, 32768.001);
    EXPECT_GE(scaled, 16383.9);
  }
  EXPECT_EQ(ColorExponent(0), 0);
}

TEST(DepthPyramid, KeepsSurfacesApartAndUnknownPixelsUnknown) {
  DepthMap map{Image<float>(5, 4, 2.0F), Image<float>(5, 4, 1.0F)};
  map.depth(0, 0) = map.depth(1, 0) = map.depth(0, 1) = 4.0F;   // three of the first square
  for (int i = 0; i < 4; ++i) map.depth(2 + i % 2, i / 2) = 0;  // all of the second one
  const std::vector<DepthLevel> levels = DepthPyramid(map, 10, 8, {0.05, 0});
  ASSERT_EQ(levels.size(), 4U);  // 5x4, 3x2, 2x1, 1x1
  EXPECT_FLOAT_EQ(levels[1].Known(0, 0), 0.25F);
  EXPECT_LT(levels[1].Known(1, 0), 0);
  EXPECT_FLOAT_EQ(levels[1].Known(2, 1), 0.5F);
  EXPECT_DOUBLE_EQ(levels[1].per_color_x, 0.25);
  EXPECT_DOUBLE_EQ(levels[1].extent_x, 2.5);
  EXPECT_EQ(levels[0].smooth(1, 1), 0);  // the edge inside of the first square
  EXPECT_EQ(levels[0].smooth(2, 3), 1);
}

TEST(SurfaceRule, TakesASlantForOneSurfaceAndAStepForTwo) {
  const SurfaceRule rule{0.1, 0};
  EXPECT_TRUE(rule.Joined(1.00F, 1.09F, 1.18F, 1.27F));   // a slant
  EXPECT_FALSE(rule.Joined(1.00F, 1.00F, 1.09F, 1.09F));  // a step of the same size
  EXPECT_TRUE(rule.Joined(1.00F, 1.00F, 1.04F, 1.04F));   // noise
  EXPECT_FALSE(rule.Joined(1.00F, 1.20F, 1.40F, 1.60F));  // too steep
  EXPECT_FALSE(rule.Joined(1.00F, -1.0F, 1.00F, 1.00F));  // unknown
}

TEST(FillFromFartherSide, TakesTheBackgroundAndLeavesNoHole) {
  Image<float> nearness(7, 3, kNothing);
  nearness(0, 1) = 5;
  nearness(6, 1) = 2;
  FillFromFartherSide(9, nearness.height(), nearness.span());
  EXPECT_EQ(nearness(0, 1), 5);
  for (int x = 1; x < 7; ++x) EXPECT_EQ(nearness(x, 1), 2);
  EXPECT_EQ(nearness(0, 0), 5);  // only its column knows something
  EXPECT_EQ(nearness(6, 2), 2);
  EXPECT_EQ(nearness(3, 0), 9);  // nothing along its row and column
}

TEST(FillFromFartherSide, LooksSoFarAlongColumnsOnly) {
  Image<float> nearness(3, 9, kNothing);
  nearness(1, 0) = 4;
  nearness(1, 8) = 3;
  FillFromFartherSide(9, 3, nearness.span());
  const float expected[] = {4, 4, 4, 4, 9, 3, 3, 3, 3};
  for (int y = 0; y < 9; ++y) EXPECT_EQ(nearness(1, y), expected[y]) << y;
  EXPECT_EQ(nearness(0, 0), 4);
  EXPECT_EQ(nearness(0, 2), 9);
}

TEST(LandingBlocks, HoldAllThatTheirBlocksDraw) {
  DepthMap map{Image<float>(150, 110), Image<float>(150, 110, 1.0F)};
  for (int y = 0; y < 110; ++y) {
    for (int x = 0; x < 150; ++x) {
      if (x > 64 && x < 100 && y > 30 && y < 66) continue;  // a block of nothing
      map.depth(x, y) = 1 / (0.2F + 0.001F * static_cast<float>(x % 50) + (y > 70 ? 0.2F : 0.0F));
    }
  }
  const DepthLevel level = std::move(DepthPyramid(map, 150, 110, {0.02, 0}).front());
  Eigen::Matrix4d to_bundle;
  to_bundle << 1.3, 0.1, -40, 20, -0.1, 1.2, -10, 5, 0, 0.001, 1, 0.1, 0, 0, 0, 1;
  Image<float> whole(130, 90, kNothing);
  const std::vector<LandingBlock> blocks = LandingBlocks(level, to_bundle, 130, 90);
  EXPECT_LT(blocks.size(), level.blocks.size());
  DrawBlocks(level, to_bundle, blocks, whole.span());
  int drawn = 0;
  Image<float> together(130, 90, kNothing);
  for (const LandingBlock& block : blocks) {
    Image<float> alone(130, 90, kNothing);
    DrawBlocks(level, to_bundle, {&block, 1}, alone.span());
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 130; ++x) {
        if (alone(x, y) == kNothing) continue;
        ++drawn;
        const float u = static_cast<float>(x) + 0.5F, v = static_cast<float>(y) + 0.5F;
        ASSERT_TRUE(u >= block.u0 && u <= block.u1 && v >= block.v0 && v <= block.v1);
        together(x, y) = std::max(together(x, y), alone(x, y));
      }
    }
  }
  EXPECT_GT(drawn, 5000);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    ASSERT_EQ(whole.data()[i], together.data()[i]);
  }
}

TEST(ColorPyramid, KeepsNoFinerLevelThanTheFinestAndTheOthersAsTheyWere) {
  Image<Rgb> picture(80, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      const auto wave = [&](int a, int b) {
        return 0.5F + 0.5F * std::sin(0.3F * static_cast<float>(a * x + b * y));
      };
      picture(x, y) = {wave(1, 2), wave(2, 1), wave(1, 1)};
    }
  }
  const ColorPyramid all(picture, {1, 0.8F, 1}, 4), coarse(picture, {1, 0.8F, 1}, 4, 2);
  ASSERT_EQ(all.size(), coarse.size());
  EXPECT_EQ(&coarse[0], &coarse[2]);
  EXPECT_EQ(&coarse[1], &coarse[2]);
  for (std::size_t l = 2; l < all.size(); ++l) {
    ASSERT_EQ(all[l].width, coarse[l].width);
    ASSERT_EQ(all[l].height, coarse[l].height);
    EXPECT_EQ(all[l].scale_x, coarse[l].scale_x);
    double worst = 0;
    for (std::size_t i = 0; i < all[l].pixels.size(); ++i) {
      const double a = reference::FromHalf(all[l].pixels.data()[i].g);
      const double b = reference::FromHalf(coarse[l].pixels.data()[i].g);
      worst = std::max(worst, std::abs(a - b) / 16);
    }
    // Much coarser ones are means of means.
    EXPECT_LT(worst, l < 5 ? 1e-3 : 0.05) << l;
  }
}

TEST(ResizeArea, KeepsTheMeanAndAveragesWhatAPixelCovers) {
  Image<Rgb> picture(6, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) picture(x, y).r = static_cast<float>(x + 10 * y);
  }
  const Image<Rgb> half = ResizeArea(picture.span(), 3, 2);
  EXPECT_FLOAT_EQ(half(1, 1).r, 27.5F);  // of 22 23 32 33
  const Image<Rgb> odd = ResizeArea(picture.span(), 4, 3);
  EXPECT_NEAR(odd(0, 0).r, (2.0F / 3 * 0 + 1.0F / 3 * 1) + 10 * 0.25F, 1e-5F);
  double sum = 0;
  for (std::size_t i = 0; i < odd.size(); ++i) sum += static_cast<double>(odd.data()[i].r);
  EXPECT_NEAR(sum / 12, 17.5, 1e-5);
  const Image<Rgb> same = ResizeArea(picture.span(), 6, 4);
  EXPECT_EQ(same(5, 3).r, 35);
  const Image<Rgb> large = ResizeArea(picture.span(), 12, 8);
  EXPECT_FLOAT_EQ(large(3, 3).r, 11);
}

TEST(LocalMap, KeepsItsDigitsFarFromTheOrigin) {
  Eigen::Matrix4d map = Eigen::Matrix4d::Identity();
  map(0, 3) = 1e5;  // px of parallax, most of it common to all
  map(2, 3) = 1;
  const LocalMap local(map, 3e5, 20, 0.75);
  const Eigen::Vector4d exact = map * Eigen::Vector4d(3e5 + 2.25, 21, 1, 0.7500001);
  const LocalMap::Out out = local(2.25F, 1.0F, 1e-7F, 0.7500001F);
  const double at = (map * Eigen::Vector4d(3e5, 20, 1, 0.75)).x() / 1.75;
  EXPECT_NEAR(static_cast<double>(out.x - local.x0), exact.x() / exact.z() - at, 0.02);
  EXPECT_NEAR(static_cast<double>(out.y), exact.y() / exact.z(), 1e-5);
}

}  // namespace
}  // namespace lamella
