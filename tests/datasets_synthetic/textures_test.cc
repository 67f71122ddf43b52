// Textures, pictures on surfaces and highlights, against sums and closed forms worked out here.
#include "datasets_synthetic/textures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "datasets_synthetic/image_texture.h"
#include "datasets_synthetic/scene.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

Texture BlackAndWhite(Texture::Pattern pattern) {
  Texture texture;
  texture.pattern = pattern;
  texture.dark = {0, 0, 0};
  texture.light = {1, 1, 1};
  return texture;
}

// The mean of `pattern` (a function of x, y) over a square about (x, y) of side w, by midpoints.
template <class Pattern>
double MeanOver(const Pattern& pattern, double x, double y, double w) {
  constexpr int kSteps = 400;
  double sum = 0;
  for (int j = 0; j < kSteps; ++j) {
    for (int i = 0; i < kSteps; ++i) {
      sum += pattern(x + w * ((i + 0.5) / kSteps - 0.5), y + w * ((j + 0.5) / kSteps - 0.5));
    }
  }
  return sum / (kSteps * kSteps);
}

TEST(Textures, GratingsAndCheckersAreMeansOverTheFootprint) {
  Texture grating = BlackAndWhite(Texture::Pattern::kGrating);
  grating.direction = {0, 5, 0};
  grating.frequency = 3;
  Texture checker = BlackAndWhite(Texture::Pattern::kChecker);
  checker.scale = 0.2;
  const auto sinusoid = [](double, double y) { return 0.5 + 0.5 * std::sin(2 * kPi * 3 * y); };
  const auto squares = [](double x, double y) {  // light about the origin
    const auto i = static_cast<int>(std::floor(x / 0.2 + 0.5)),
               j = static_cast<int>(std::floor(y / 0.2 + 0.5));
    return (i + j) % 2 == 0 ? 1.0 : 0.0;
  };
  for (const double w : {0.001, 0.07, 0.25, 0.41, 1.3}) {
    for (const Vector3d& p :
         {Vector3d(0, 0, 0), Vector3d(0.13, 0.22, 0), Vector3d(-0.71, 3.31, 0)}) {
      const auto at = [&](const Texture& texture) {
        return static_cast<double>(ColorAt(texture, p, w, Vector3d::UnitZ()).g);
      };
      EXPECT_NEAR(at(grating), MeanOver(sinusoid, p.x(), p.y(), w), 1e-4) << w;
      EXPECT_NEAR(at(checker), MeanOver(squares, p.x(), p.y(), w), 0.006) << w;
    }
  }
  EXPECT_EQ(ColorAt(BlackAndWhite(Texture::Pattern::kPlain), {1, 2, 3}, 0.1).g, 1.0F);
}

// Whole scenes of one flat surface, lit evenly, seen straight on: pixel (i, j) of a square of 2
// x 2.
Scene Flat(Shape shape, std::variant<Texture, ImageTexture> texture) {
  Scene scene;
  scene.surfaces.push_back({std::move(shape), std::move(texture)});
  scene.lighting.ambient = 1;
  scene.lighting.lamp_strength = 0;
  return scene;
}

// n x n pixels that cover x, y in [-1, 1] at z = 0, seen from z = +10 with y up.
Image<RaySample> LookAtSquare(const Scene& scene, int n) {
  const SceneSource source(scene);
  RayBundle bundle;
  bundle.centre = {0, 0, 10, 1};
  bundle.origin = {-1, 1, 0};
  bundle.dx = {2.0 / n, 0, 0};
  bundle.dy = {0, -2.0 / n, 0};
  bundle.width = bundle.height = n;
  Image<RaySample> samples(n, n);
  source.Query(bundle, {0, 0, n, n}, samples.span());
  return samples;
}

TEST(Textures, CheckersOfFlatSurfacesBeginAtTheCorner) {
  Texture checker = BlackAndWhite(Texture::Pattern::kChecker);
  checker.scale = 0.5;
  const Parallelogram square{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}};
  const Image<RaySample> samples = LookAtSquare(Flat(square, checker), 16);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const bool light = (x / 4 + (15 - y) / 4) % 2 == 0;
      EXPECT_NEAR(samples(x, y).color.g, light ? 1.0F : 0.0F, 0.02F) << x << " " << y;
    }
  }
}

// Red at the upper left, green at the upper right, blue at the lower left.
Image<Rgb> Corners(int size) {
  Image<Rgb> picture(size, size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const bool left = x < size / 2, top = y < size / 2;
      picture(x, y) = {top && left ? 1.0F : 0.0F, top && !left ? 1.0F : 0.0F,
                       !top && left ? 1.0F : 0.0F};
    }
  }
  return picture;
}

void ExpectUpright(const Image<RaySample>& seen) {
  const int n = seen.width(), low = n / 4, high = n - 1 - n / 4;
  EXPECT_EQ(seen(low, low).color, (Rgb{1, 0, 0}));
  EXPECT_EQ(seen(high, low).color, (Rgb{0, 1, 0}));
  EXPECT_EQ(seen(low, high).color, (Rgb{0, 0, 1}));
  EXPECT_EQ(seen(high, high).color, (Rgb{0, 0, 0}));
}

TEST(ImageTexture, StandsUprightOnEveryShape) {
  const ImageTexture picture = MakeImageTexture(Corners(64));
  ExpectUpright(LookAtSquare(Flat(Parallelogram{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}}, picture), 32));
  const Mesh wall =
      MeshOfHeightField({-1, -1, 2, 2, 3, 5}, [](double x, double) { return 0.01 * x; });
  ExpectUpright(LookAtSquare(Flat(std::make_shared<const Mesh>(wall), picture), 32));
  // Of a ball the quarter of longitudes before the viewer is seen: two pictures side by side.
  const Image<RaySample> on_ball = LookAtSquare(Flat(Sphere{{0, 0, 0}, 1.2}, picture), 32);
  ExpectUpright(on_ball);
  const Image<RaySample> on_mesh = LookAtSquare(
      Flat(std::make_shared<const Mesh>(MeshOfSphere({0, 0, 0}, 1.2, 64)), picture), 32);
  ExpectUpright(on_mesh);
}

TEST(ImageTexture, IsInterpolatedAndRepeats) {
  Image<Rgb> ramp(4, 2);
  for (int x = 0; x < 4; ++x) ramp(x, 0) = ramp(x, 1) = {static_cast<float>(x), 0, 0};
  const ImageTexture once = MakeImageTexture(ramp.Clone(), false);
  const ImageTexture repeated = MakeImageTexture(ramp.Clone(), true);
  const auto at = [](const ImageTexture& texture, double u) {
    return ColorAt(texture, {u, 0.5}, {0, 0}).r;
  };
  EXPECT_FLOAT_EQ(at(once, 0.5), 1.5F);
  EXPECT_FLOAT_EQ(at(once, 0.375), 1);
  EXPECT_FLOAT_EQ(at(once, -7), 0);
  EXPECT_FLOAT_EQ(at(once, 1e9), 3);
  EXPECT_FLOAT_EQ(at(repeated, 3.5), 1.5F);
  EXPECT_FLOAT_EQ(at(repeated, -0.625), 1);
  EXPECT_FLOAT_EQ(at(repeated, 0), 1.5F);  // between the last texel and the first
  EXPECT_FLOAT_EQ(ColorAt(repeated, {0.3, 0.3}, {100, 100}).r, 1.5F);
}

TEST(ImageTexture, LevelsKeepTheMeanWhateverTheSize) {
  for (const auto& [width, height] : {std::pair(37, 22), std::pair(1, 9), std::pair(64, 3)}) {
    Image<Rgb> picture(width, height);
    double mean = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      picture.data()[i].g = static_cast<float>((i * 2654435761U) % 1000) / 1000;
      mean += static_cast<double>(picture.data()[i].g) / static_cast<double>(picture.size());
    }
    const ImageTexture texture = MakeImageTexture(std::move(picture));
    EXPECT_EQ(texture.pyramid->levels.back().size(), 1U);
    EXPECT_NEAR(static_cast<double>(texture.pyramid->levels.back()(0, 0).g), mean, 1e-6);
  }
}

// The finest checker there is, and stripes, seen with fewer pixels than texels: grey, no beat.
TEST(ImageTexture, DoesNotAlias) {
  Image<Rgb> fine(512, 512);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 512; ++x) {
      fine(x, y) = {static_cast<float>((x + y) % 2), static_cast<float>(x % 2),
                    static_cast<float>(y / 2 % 2)};
    }
  }
  const Scene scene =
      Flat(Parallelogram{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}}, MakeImageTexture(std::move(fine)));
  for (const int n : {37, 100, 190, 256}) {
    const Image<RaySample> seen = LookAtSquare(scene, n);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_NEAR(seen.data()[i].color.r, 0.5F, 0.01F);
      EXPECT_NEAR(seen.data()[i].color.g, 0.5F, 0.01F);
      if (n <= 128) {
        EXPECT_NEAR(seen.data()[i].color.b, 0.5F, 0.01F);
      }
    }
  }
}

TEST(ImageTexture, IsReadFromAFileAsLinearLight) {
  const std::filesystem::path path = ScratchFolder() / "a.png";
  Image<Rgb> picture(2, 1);
  picture(0, 0) = {1, 0, 0};
  picture(1, 0) = {0, 0.21586F, 1};  // code 128
  WriteSrgb8(path, picture.span());
  const ImageTexture texture = ReadImageTexture(path);
  ASSERT_EQ(texture.pyramid->levels[0].width(), 2);
  EXPECT_NEAR(texture.pyramid->levels[0](1, 0).g, 0.21586F, 1e-3F);
  EXPECT_THROW(ReadImageTexture(path.parent_path() / "none.png"), Error);
}

// Phong: ambient + lamp (n . l) + lamp strength (r . v)^exponent.
TEST(Gloss, IsWhereTheFormulaPutsItAndMovesWithTheView) {
  Scene scene = Flat(Parallelogram{{-5, -5, 0}, {10, 0, 0}, {0, 10, 0}},
                     BlackAndWhite(Texture::Pattern::kPlain));
  scene.surfaces[0].gloss = {.strength = 0.4, .exponent = 25};
  scene.lighting = {.lamp = {1, 2, 4}, .lamp_strength = 0.5F, .ambient = 0.2F};
  const SceneSource source(std::move(scene));
  double brightest[2] = {};
  Vector2d place[2];
  for (int view = 0; view < 2; ++view) {
    const Vector3d eye(view == 0 ? -1 : 2, 0.5, 3);
    RayBundle bundle;
    bundle.centre << eye, 1;
    bundle.origin = {-3, 3, 0};
    bundle.dx = {0.05, 0, 0};
    bundle.dy = {0, -0.05, 0};
    bundle.width = bundle.height = 120;
    Image<RaySample> samples(120, 120);
    source.Query(bundle, {0, 0, 120, 120}, samples.span());
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 120; ++x) {
        const Vector3d p = bundle.PlanePoint(x + 0.5, y + 0.5);
        const Vector3d l = (Vector3d(1, 2, 4) - p).normalized(), v = (eye - p).normalized();
        const Vector3d r(-l.x(), -l.y(), l.z());
        const double expected =
            0.2 + 0.5 * l.z() + 0.5 * 0.4 * std::pow(std::max(0.0, r.dot(v)), 25);
        EXPECT_NEAR(static_cast<double>(samples(x, y).color.g), expected, 1e-5);
        const double highlight = static_cast<double>(samples(x, y).color.g) - 0.5 * l.z();
        if (highlight <= brightest[view]) continue;
        brightest[view] = highlight;
        place[view] = p.head<2>();
      }
    }
    // Mirrored at the plane the lamp lies at z = -4: the line to the eye meets the plane at 4/7.
    const Vector2d mirror = Vector2d(1, 2) + 4.0 / 7 * (eye.head<2>() - Vector2d(1, 2));
    EXPECT_LT((place[view] - mirror).norm(), 0.06);
  }
  EXPECT_GT((place[0] - place[1]).norm(), 1);
}

TEST(Lighting, RadianceOfNothingAndOfAHundredMillion) {
  for (const float strength : {0.0F, 1e8F}) {
    Scene scene = Flat(std::make_shared<const Mesh>(MeshOfSphere({0, 0, 0}, 0.5, 20)),
                       BlackAndWhite(Texture::Pattern::kPlain));
    scene.lighting = {.lamp = {0, 0, 1e6}, .lamp_strength = strength, .ambient = 0};
    scene.background = {strength, strength, strength};
    const Image<RaySample> seen = LookAtSquare(scene, 33);
    EXPECT_EQ(seen(0, 0).color.g, strength);
    EXPECT_NEAR(seen(16, 16).color.g, strength, 0.01F * strength);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_TRUE(seen.data()[i].color.g >= 0 && seen.data()[i].color.g <= strength);
    }
  }
}

// A ball of triangles between the lamp and a wall; the ball itself is lit where it faces the lamp.
TEST(Lighting, MeshesThrowShadowsButNotOnThemselves) {
  for (const double offset : {0.0, 1e7}) {
    const Vector3d middle(offset, -offset, offset);
    Scene scene;
    Surface wall{Parallelogram{middle + Vector3d(-6, -6, -2), {12, 0, 0}, {0, 12, 0}},
                 BlackAndWhite(Texture::Pattern::kPlain),
                 {}};
    Surface ball{std::make_shared<const Mesh>(MeshOfSphere(middle, 0.5, 40)),
                 BlackAndWhite(Texture::Pattern::kPlain),
                 {}};
    scene.surfaces = {wall, ball};
    scene.lighting = {.lamp = middle + Vector3d(0, 0, 6), .lamp_strength = 1, .ambient = 0};
    const SceneSource source(std::move(scene));
    RayBundle bundle;  // parallel, so that the shadow is seen beside the ball
    bundle.centre = {-1, 0, 1, 0};
    bundle.origin = middle + Vector3d(-2, 2, 0);
    bundle.dx = {0.04, 0, 0};
    bundle.dy = {0, -0.04, 0};
    bundle.width = bundle.height = 100;
    Image<RaySample> samples(100, 100);
    source.Query(bundle, {0, 0, 100, 100}, samples.span());
    int in_shadow = 0, on_ball = 0;
    for (int y = 0; y < 100; ++y) {
      for (int x = 0; x < 100; ++x) {
        const Ray ray = bundle.RayAt(x + 0.5, y + 0.5);
        const auto hit = source.FirstHit(ray, -1e9);
        ASSERT_TRUE(hit);
        const Vector3d p = ray.origin + hit->t * ray.direction - middle;
        const float g = samples(x, y).color.g;
        if (hit->surface == 1) {
          ++on_ball;
          const double facing = p.normalized().dot((Vector3d(0, 0, 6) - p).normalized());
          if (facing > 0.02) {
            EXPECT_NEAR(static_cast<double>(g), facing, 0.01) << x << " " << y;
          }
        } else {
          // The cone about the ball: sin = 0.5 / 6, 8 units from the lamp to the wall.
          const double rim = 8 * std::tan(std::asin(0.5 / 6)), r = p.head<2>().norm();
          if (r < 0.97 * rim) {
            ++in_shadow;
            EXPECT_EQ(g, 0) << x << " " << y;
          } else if (r > 1.02 * rim) {
            EXPECT_GT(g, 0.5F) << x << " " << y;
          }
        }
      }
    }
    EXPECT_GT(on_ball, 200);
    EXPECT_GT(in_shadow, 200);
  }
}

}  // namespace
}  // namespace lamella
