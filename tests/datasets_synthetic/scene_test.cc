// Generated scenes against closed forms that are worked out here, in long double where it matters.
#include "datasets_synthetic/scene.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "datasets_synthetic/cameras.h"
#include "datasets_synthetic/photograph.h"
#include "datasets_synthetic/room.h"
#include "lightfield/parallel.h"
#include "tests/depth/synthetic.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

Surface Plain(Shape shape) {
  Surface surface;
  surface.shape = std::move(shape);
  return surface;
}

// |o + t d - c|^2 = r^2, the smaller root in front.
std::optional<double> SphereHit(const Sphere& sphere, const Ray& ray) {
  const auto radius = static_cast<long double>(sphere.radius);
  long double a = 0, b = 0, c = -radius * radius;
  for (int i = 0; i < 3; ++i) {
    const auto o =
        static_cast<long double>(ray.origin[i]) - static_cast<long double>(sphere.centre[i]);
    const auto d = static_cast<long double>(ray.direction[i]);
    a += d * d;
    b += o * d;
    c += o * o;
  }
  const long double root = b * b - a * c;
  if (root < 0) return std::nullopt;
  for (const long double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) {
    if (t > 0) return static_cast<double>(t);
  }
  return std::nullopt;
}

class SphereAt : public testing::TestWithParam<double> {};

// Single precision alone would be off by 1e-7 of the distance to the origin: far scenes show it.
TEST_P(SphereAt, IsHitWhereTheEquationSays) {
  const double offset = GetParam();
  const Vector3d middle(offset, -offset, 2 * offset);
  const Sphere sphere{middle + Vector3d(0.1, -0.2, 5), 1.3};
  const SceneSource scene({{Plain(sphere)}, {}, {}});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> spread(-0.3, 0.3);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Ray ray{middle, {spread(random), spread(random), 1}};
    const std::optional<double> expected = SphereHit(sphere, ray);
    const std::optional<SurfaceHit> hit = scene.FirstHit(ray);
    if (expected) {
      // A ray that only grazes the rim may miss it: 1e-6 of the radius.
      const Vector3d from_centre = ray.origin + *expected * ray.direction - sphere.centre;
      const double graze = from_centre.dot(ray.direction.normalized()) / sphere.radius;
      if (std::abs(graze) < 2e-3) continue;
    }
    ASSERT_EQ(hit.has_value(), expected.has_value()) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->t, *expected, 1e-8 * *expected * std::max(1.0, offset * 1e-4)) << i;
  }
  EXPECT_GT(hits, 500);
}
INSTANTIATE_TEST_SUITE_P(Offsets, SphereAt, testing::Values(0.0, 10.0, 1e4));

TEST(Scene, PhotographsHaveExactDepthAndStandUpright) {
  // A slanted wall z = 6 + 0.5 x - 0.25 y (y down here: the camera sits at the origin, axes as
  // the world's), with a ball in its upper right quarter.
  const Vector3d corner(-20, -20, 6 - 10 + 5), u(40, 0, 20), v(0, 40, -10);
  const Sphere ball{{1.2, -1.1, 4}, 0.5};
  const SceneSource scene({{Plain(Parallelogram{corner, u, v}), Plain(ball)}, {}, {}});
  const Camera camera = synthetic::Pinhole(120, 90, 120);
  const Photograph photograph = TakePhotograph(scene, camera, Rigid{}, 2);
  int on_ball = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d d((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1);
      double expected = 6 / (1 - 0.5 * d.x() + 0.25 * d.y());
      if (const auto hit = SphereHit(ball, {Vector3d::Zero(), d}); hit && *hit < expected) {
        expected = *hit;
        ++on_ball;
        EXPECT_GT(x, camera.width / 2);
        EXPECT_LT(y, camera.height / 2);
      }
      EXPECT_NEAR(static_cast<double>(photograph.depth(x, y)), expected, 1e-5 * expected)
          << x << " " << y;
    }
  }
  EXPECT_GT(on_ball, 100);
}

TEST(Scene, NothingIsBackgroundAtInfinity) {
  const SceneSource scene({{Plain(Sphere{{0, 0, -5}, 1})}, {}, {0.1F, 0.2F, 0.3F}});
  const Photograph photograph = TakePhotograph(scene, synthetic::Pinhole(8, 6, 8), Rigid{}, 2);
  EXPECT_TRUE(std::isinf(photograph.depth(3, 2)));
  EXPECT_FLOAT_EQ(photograph.color(3, 2).g, 0.2F);
}

// What one photograph sees at a place, the next one sees there too, or something nearer.
TEST(Room, TwoPhotographsAgreeOnTheWorld) {
  const SceneSource scene(Room(1));
  const std::vector<Rigid> poses = CamerasOnArc(ArcBeforeRoom(), 14, 1);
  const Camera camera = synthetic::Pinhole(160, 120, 160);
  const Photograph a = TakePhotograph(scene, camera, poses[6], 1);
  const Rigid b_from_a = poses[8] * Inverse(poses[6]);
  int same = 0, hidden = 0, deeper = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double z = static_cast<double>(a.depth(x, y));
      ASSERT_TRUE(std::isfinite(z) && z > 0.5 && z < 10);
      const Vector3d point = b_from_a * Vector3d((x + 0.5 - camera.cx) / camera.fx * z,
                                                 (y + 0.5 - camera.cy) / camera.fy * z, z);
      const Vector3d world = Inverse(poses[8]) * point;
      EXPECT_GT(world.y(), -1 - 1e-4);  // nothing below the floor, nothing behind the wall
      EXPECT_GT(world.z(), -2.4 - 1e-4);
      const Ray ray{Inverse(poses[8]).translation,
                    (world - Inverse(poses[8]).translation).normalized()};
      const double distance = point.norm();
      const std::optional<SurfaceHit> hit = scene.FirstHit(ray);
      ASSERT_TRUE(hit);
      same += std::abs(hit->t - distance) < 1e-5 * distance ? 1 : 0;
      hidden += hit->t < distance * (1 - 1e-5) ? 1 : 0;
      deeper += hit->t > distance * (1 + 1e-5) ? 1 : 0;
    }
  }
  EXPECT_EQ(deeper, 0);
  EXPECT_GT(same, 10 * hidden);
  EXPECT_GT(hidden, 0);
}

TEST(Room, IsTheSameForASeedWhateverTheThreads) {
  const Camera camera = synthetic::Pinhole(64, 48, 64);
  const auto photograph = [&](std::uint32_t seed, int threads) {
    const ThreadLimit limit(threads);
    return TakePhotograph(SceneSource(Room(seed)), camera,
                          CamerasOnArc(ArcBeforeRoom(), 14, seed)[3], 4);
  };
  const auto equal = [](const Photograph& a, const Photograph& b) {
    return std::memcmp(a.color.data(), b.color.data(), a.color.size() * sizeof(Rgb)) == 0 &&
           std::memcmp(a.depth.data(), b.depth.data(), a.depth.size() * sizeof(float)) == 0;
  };
  const Photograph one = photograph(1, 1);
  EXPECT_TRUE(equal(one, photograph(1, 2)));
  EXPECT_FALSE(equal(one, photograph(2, 1)));
}

}  // namespace
}  // namespace lamella
