// Meshes in scenes, against all triangles one by one in long double.
#include "datasets_synthetic/mesh.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/photograph.h"
#include "datasets_synthetic/scene.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector3d;
using Vector3l = Eigen::Matrix<long double, 3, 1>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Surface Of(Mesh mesh) { return {.shape = std::make_shared<const Mesh>(std::move(mesh))}; }
Surface Of(const Sphere& sphere) { return {.shape = sphere}; }
Surface Of(const Parallelogram& p) { return {.shape = p}; }

Scene SceneOf(std::vector<Surface> surfaces) { return {std::move(surfaces), {}, {}}; }

struct Nearest {
  std::optional<double> t;
  double rim = kInfinity;  // the least distance in weights to an edge of any triangle that is met
};

// Cramer's rule for o + t d = a + b (B - A) + c (C - A).
Nearest BruteForce(const Mesh& mesh, const Ray& ray, double t_min) {
  Nearest nearest;
  const Vector3l o = ray.origin.cast<long double>(), d = ray.direction.cast<long double>();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int i) -> Vector3l {
      return mesh.vertices[static_cast<std::size_t>(t(i))].cast<long double>();
    };
    const Vector3l a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a;
    const long double det = e1.cross(e2).dot(-d);
    if (det == 0) continue;
    const long double at = e1.cross(e2).dot(o - a) / det;
    const Vector3l within = o + at * d - a, normal = e1.cross(e2);
    const long double b = within.cross(e2).dot(normal) / normal.squaredNorm();
    const long double c = e1.cross(within).dot(normal) / normal.squaredNorm();
    const long double least = std::min(std::min(b, c), 1 - b - c);
    if (!(at > static_cast<long double>(t_min)) || least < -1e-3L) continue;
    nearest.rim = std::min(nearest.rim, std::abs(static_cast<double>(least)));
    if (least < 0) continue;
    if (!nearest.t || static_cast<double>(at) < *nearest.t) nearest.t = static_cast<double>(at);
  }
  return nearest;
}

Vector3d Random(std::mt19937* random) {
  std::uniform_real_distribution<double> spread(-1, 1);
  const double x = spread(*random), y = spread(*random);
  return {x, y, spread(*random)};
}

class MeshAt : public testing::TestWithParam<double> {};

TEST_P(MeshAt, IsHitWhereItsTrianglesAre) {
  const Vector3d middle = GetParam() * Vector3d(1, -1, 2);
  const Mesh mesh = MeshOfTorus(middle + Vector3d(0.1, 0.2, -0.3), 1, 0.4, 12);
  const SceneSource scene(SceneOf({Of(mesh)}));
  std::mt19937 random(3);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d from = middle + 4 * Random(&random), to = middle + Random(&random);
    const Ray ray{from, (to - from) * (i % 3 == 0 ? 1e-3 : 1)};
    const Nearest expected = BruteForce(mesh, ray, 0);
    if (expected.rim < 1e-5) continue;  // may be seen or not
    const std::optional<SurfaceHit> hit = scene.FirstHit(ray);
    ASSERT_EQ(hit.has_value(), expected.t.has_value()) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->t, *expected.t, 1e-7 * *expected.t) << i;
  }
  EXPECT_GT(hits, 1000);
}

TEST_P(MeshAt, IsQueriedWhereItsTrianglesAre) {
  const Vector3d middle = GetParam() * Vector3d(1, -1, 2);
  const Mesh mesh = MeshOfTorus(middle + Vector3d(0.1, 0.2, -0.3), 1, 0.4, 12);
  const Sphere ball{middle + Vector3d(1.2, 0.3, 0.4), 0.35};
  const SceneSource alone(SceneOf({Of(mesh)})), both(SceneOf({Of(mesh), Of(ball)}));
  std::vector<RayBundle> bundles(2);
  bundles[0] = {.centre = {middle.x() - 1, middle.y() + 2, middle.z() + 4, 1},
                .origin = middle + Vector3d(-3, 2, 1),
                .dx = {0.1, 0, 0.013},
                .dy = {0, -0.1, 0.007},
                .width = 50,
                .height = 37};
  bundles[1] = bundles[0];
  bundles[1].centre = {0.2, -0.3, 0.9, 0};
  for (const RayBundle& bundle : bundles) {
    const double t_min = bundle.centre.w() != 0 ? 0 : -kInfinity;
    const Rect all{0, 0, bundle.width, bundle.height};
    Image<float> t(all.width, all.height), t_both(all.width, all.height);
    alone.QueryDepth(bundle, all, t.span());
    both.QueryDepth(bundle, all, t_both.span());
    int hits = 0, on_ball = 0;
    for (int y = 0; y < all.height; ++y) {
      for (int x = 0; x < all.width; ++x) {
        const Ray ray = bundle.RayAt(x + 0.5, y + 0.5);
        const Nearest expected = BruteForce(mesh, ray, t_min);
        if (expected.rim < 1e-5) continue;
        ASSERT_EQ(std::isfinite(t(x, y)), expected.t.has_value()) << x << " " << y;
        const double near = expected.t.value_or(kInfinity);
        if (expected.t) {
          EXPECT_NEAR(static_cast<double>(t(x, y)), near, 1e-6 * (2 + std::abs(near)));
        }
        hits += expected.t ? 1 : 0;
        const auto ball_t = Intersect(ball, ray, t_min, kInfinity);  // proved in scene_test
        const double nearest = std::min(near, ball_t.value_or(kInfinity));
        on_ball += nearest < near ? 1 : 0;
        if (std::isfinite(nearest)) {
          EXPECT_NEAR(static_cast<double>(t_both(x, y)), nearest, 1e-6 * (2 + std::abs(nearest)));
        } else {
          EXPECT_TRUE(std::isinf(t_both(x, y)));
        }
      }
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(on_ball, 10);
  }
}
INSTANTIATE_TEST_SUITE_P(Offsets, MeshAt, testing::Values(0.0, 1e4, 1e7));

TEST(Mesh, DepthsFromAMillionthToInfinityFitIntoOneScene) {
  // Panels across the view, each larger than the one before and partly behind it; the last one as
  // a mesh of two triangles as wide as all depths together.
  std::vector<Surface> surfaces;
  std::vector<double> depths;
  for (double z = 1e-6; z < 2e6; z *= 10) {
    depths.push_back(z);
    const int n = static_cast<int>(depths.size());
    const double left = -0.07 * n * z;  // each one begins farther to the left
    Mesh mesh =
        MeshOfHeightField({left, -z, 2 * z, 2 * z, 3, 5}, [z](double, double) { return z; });
    surfaces.push_back(n % 2 == 0 ? Of(Parallelogram{{left, -z, z}, {2 * z, 0, 0}, {0, 2 * z, 0}})
                                  : Of(std::move(mesh)));
  }
  std::reverse(surfaces.begin(), surfaces.end());  // the order of the list does not matter
  const SceneSource scene(SceneOf(std::move(surfaces)));
  for (std::size_t n = 1; n <= depths.size() + 1; ++n) {  // between the left edges of n and n - 1
    const double x = -0.07 * static_cast<double>(n) + 0.035;
    const auto hit = scene.FirstHit({{0, 0, 0}, {x, 0.013, 1}});
    ASSERT_EQ(hit.has_value(), n <= depths.size());
    if (hit) {
      EXPECT_NEAR(hit->t, depths[n - 1], 1e-5 * depths[n - 1]);
    }
  }
  for (std::size_t n = 0; n < depths.size(); ++n) {  // from just behind each panel the next is seen
    const double z = 1.5 * depths[n];
    const auto hit = scene.FirstHit({{0.7 * z, 0, z}, {0, 0, 1}});
    ASSERT_EQ(hit.has_value(), n + 1 < depths.size());
    if (hit) {
      EXPECT_NEAR(hit->t, depths[n + 1] - z, 1e-5 * depths[n + 1]);
    }
  }
}

TEST(Mesh, OneMeshMayBeginAMillionthBeforeTheCamera) {
  const Mesh ground{
      {{-1e3, -1e-6, -1e3}, {1e3, -1e-6, -1e3}, {1e3, -1e-6, 1e3}, {-1e3, -1e-6, 1e3}},
      {{0, 1, 2}, {0, 2, 3}},
      {},
      {}};
  const SceneSource scene(SceneOf({Of(ground)}));
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    Vector3d d = Random(&random);
    const auto hit = scene.FirstHit({{0, 0, 0}, d});
    const double t = -1e-6 / d.y();
    ASSERT_EQ(hit.has_value(), t > 0 && t < 900) << d.transpose();
    if (hit) {
      EXPECT_NEAR(hit->t, t, 1e-5 * t);
    }
  }
}

TEST(Mesh, WithoutTrianglesOrAreaIsNeverSeen) {
  const Mesh empty, points{{{0, 0, 5}, {1, 0, 5}}, {}, {}, {}};
  // No area, exactly or to rounding; one that repeats a corner.
  const Mesh flat{{{-1, 0, 5}, {1, 0.1, 5}, {3, 0.2, 5}, {0.1, 0.05 + 0.005, 5}},
                  {{0, 1, 2}, {0, 0, 0}, {0, 1, 1}, {0, 3, 1}, {2, 2, 0}},
                  {},
                  {}};
  const SceneSource scene(SceneOf({Of(empty), Of(points), Of(flat)}));
  const SceneSource only_empty(SceneOf({Of(empty)}));
  const RayBundle bundle{.centre = {0, 0, 0, 1},
                         .origin = {-1, -1, 5},
                         .dx = {0.05, 0, 0},
                         .dy = {0, 0.05, 0},
                         .width = 40,
                         .height = 40};
  for (const SceneSource* source : {&scene, &only_empty}) {
    Image<RaySample> samples(40, 40);
    source->Query(bundle, {0, 0, 40, 40}, samples.span());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_TRUE(std::isinf(samples.data()[i].z)) << i;
      EXPECT_EQ(samples.data()[i].color, Rgb{});
    }
    EXPECT_FALSE(source->FirstHit({{0, 0, 0}, {0.02, 0.002, 0.1}}));
    EXPECT_FALSE(source->FirstHit({{0, 0, 0}, {0, 0, 0}}));
  }
}

TEST(Mesh, IsRefusedWhereItDoesNotFitTogether) {
  const auto refused = [](const Mesh& mesh) {
    EXPECT_THROW(SceneSource(SceneOf({Of(mesh)})), Error);
  };
  const std::vector<Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  refused({corners, {{0, 1, 3}}, {}, {}});
  refused({corners, {{0, -1, 2}}, {}, {}});
  refused({{{0, 0, 0}, {std::nan(""), 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}});
  refused({corners, {{0, 1, 2}}, {{0, 0}}, {}});
}

TEST(Mesh, OfTwoAtOnePlaceTheFirstIsSeen) {
  const Mesh wall = MeshOfHeightField({-1, -1, 2, 2, 7, 9},
                                      [](double x, double y) { return 5 + 0.1 * x + 0.23 * y; });
  Mesh turned = wall;  // other triangles first, other corners first
  std::reverse(turned.triangles.begin(), turned.triangles.end());
  for (Eigen::Vector3i& t : turned.triangles) t = {t.y(), t.z(), t.x()};
  const Parallelogram exact{{-1, -1, 5 - 0.1 - 0.23}, {2, 0, 0.2}, {0, 2, 0.46}};
  for (const auto& order : std::vector<std::vector<Surface>>{
           {Of(wall), Of(turned), Of(exact)}, {Of(exact), Of(wall)}, {Of(turned), Of(exact)}}) {
    const SceneSource scene(SceneOf(order));
    std::mt19937 random(5);
    for (int i = 0; i < 300; ++i) {
      const Vector3d d = Random(&random);
      const auto hit = scene.FirstHit({{0, 0, 0}, {0.18 * d.x(), 0.18 * d.y(), 1}});
      ASSERT_TRUE(hit);
      EXPECT_EQ(hit->surface, 0);
    }
  }
}

TEST(Mesh, IsSeenFromInside) {
  const Vector3d centre(1, 2, 3);
  const Mesh mesh = MeshOfSphere(centre, 2, 40);
  const SceneSource inside(SceneOf({Of(mesh)})), ball(SceneOf({Of(Sphere{centre, 2})}));
  std::mt19937 random(6);
  for (int i = 0; i < 500; ++i) {
    const Ray ray{centre + Random(&random), Random(&random).normalized()};
    const auto hit = inside.FirstHit(ray), on_ball = ball.FirstHit(ray);
    ASSERT_TRUE(hit && on_ball);
    EXPECT_NEAR(hit->t, on_ball->t, 0.02);  // the facets are that far within the sphere
    const Nearest expected = BruteForce(mesh, ray, 0);
    if (i < 50 && expected.rim > 1e-5) {
      EXPECT_NEAR(hit->t, *expected.t, 1e-9 * *expected.t);
    }
  }
}

// Mirrors nothing, repeats itself with any threads and rectangles.
TEST(Mesh, IsPhotographedTheSameWithAnyThreadsAndRectangles) {
  const auto photograph = [](int threads) {
    const ThreadLimit limit(threads);
    Scene scene =
        SceneOf({Of(MeshOfTorus({0, 0, 5}, 1, 0.4, 60)), Of(MeshOfSphere({0, 0, 5}, 0.4, 50)),
                 Of(Parallelogram{{-9, -9, 7}, {18, 0, 0}, {0, 18, 0}})});
    scene.lighting.lamp = {3, -5, -2};
    Camera camera;
    camera.width = 101;
    camera.height = 77;
    camera.fx = camera.fy = 150;
    camera.cx = 50.5;
    camera.cy = 38.5;
    return TakePhotograph(SceneSource(std::move(scene)), camera, Rigid{}, 3);
  };
  const Photograph one = photograph(1), two = photograph(2);
  EXPECT_EQ(std::memcmp(one.color.data(), two.color.data(), one.color.size() * sizeof(Rgb)), 0);
  EXPECT_EQ(std::memcmp(one.depth.data(), two.depth.data(), one.depth.size() * sizeof(float)), 0);

  const SceneSource scene(SceneOf({Of(MeshOfTorus({0, 0, 5}, 1, 0.4, 60))}));
  const RayBundle bundle{.centre = {0, 0, 0, 1},
                         .origin = {-1.5, -1.5, 5},
                         .dx = {0.03, 0, 0},
                         .dy = {0, 0.03, 0},
                         .width = 100,
                         .height = 100};
  Image<RaySample> whole(100, 100), part(31, 17);
  scene.Query(bundle, {0, 0, 100, 100}, whole.span());
  scene.Query(bundle, {23, 42, 31, 17}, part.span());
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 31; ++x) {
      EXPECT_EQ(part(x, y).color, whole(23 + x, 42 + y).color);
      EXPECT_EQ(part(x, y).z, whole(23 + x, 42 + y).z);
    }
  }
}

TEST(Mesh, FocalLengthsFromOnePixelToAMillion) {
  const Mesh wall = MeshOfHeightField({-1e5, -1e5, 2e5, 2e5, 20, 20},
                                      [](double x, double) { return 100 + 1e-4 * x; });
  const SceneSource scene(SceneOf({Of(wall)}));
  for (const double focal : {1.0, 1e6}) {
    Camera camera;
    camera.width = camera.height = 64;
    camera.fx = camera.fy = focal;
    camera.cx = camera.cy = 32;
    Image<float> depth(64, 64);
    scene.QueryDepth(BundleOfCamera(camera, Rigid{}), {0, 0, 64, 64}, depth.span());
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double expected = 100 / (1 - 1e-4 * (x + 0.5 - 32) / focal);
        EXPECT_NEAR(static_cast<double>(depth(x, y)), expected, 1e-6 * expected);
      }
    }
  }
}

TEST(Mesh, OfTenMillionTrianglesIsTraced) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__OPTIMIZE__)
  GTEST_SKIP() << "too slow under sanitizers and unoptimised";
#endif
  const auto height = [](double x, double y) { return 6 + 0.5 * x - 0.25 * y; };
  Mesh mesh = MeshOfHeightField({-2, -2, 4, 4, 2500, 2000}, height);
  ASSERT_EQ(mesh.triangles.size(), 10'000'000U);
  const SceneSource scene(SceneOf({Of(std::move(mesh))}));
  const RayBundle bundle{.centre = {0, 0, 0, 1},
                         .origin = {-0.16, -0.16, 1},
                         .dx = {0.001, 0, 0},
                         .dy = {0, 0.001, 0},
                         .width = 320,
                         .height = 320};
  Image<float> depth(320, 320);
  scene.QueryDepth(bundle, {0, 0, 320, 320}, depth.span());
  for (int y = 0; y < 320; ++y) {
    for (int x = 0; x < 320; ++x) {
      const Vector3d d = bundle.RayAt(x + 0.5, y + 0.5).direction;
      const double expected = 6 / (1 - 0.5 * d.x() + 0.25 * d.y());
      ASSERT_NEAR(static_cast<double>(depth(x, y)), expected, 1e-5 * expected) << x << " " << y;
    }
  }
}

TEST(Mesh, GeneratorsMakeWhatTheySay) {
  const Mesh sphere = MeshOfSphere({1, 2, 3}, 2, 8);
  EXPECT_EQ(sphere.triangles.size(), 2U * 16 * 8 - 2 * 16);
  for (std::size_t i = 0; i < sphere.vertices.size(); ++i) {
    EXPECT_NEAR((sphere.vertices[i] - Vector3d(1, 2, 3)).norm(), 2, 1e-12);
    EXPECT_NEAR((sphere.vertices[i] - Vector3d(1, 2, 3)).dot(sphere.normals[i]), 2, 1e-12);
  }
  const Mesh torus = MeshOfTorus({0, 0, 0}, 3, 1, 8);
  for (const Vector3d& v : torus.vertices) {
    EXPECT_NEAR(std::hypot(std::hypot(v.x(), v.z()) - 3, v.y()), 1, 1e-12);
  }
  const Eigen::Affine3d map = Eigen::Translation3d(1, 0, 0) * Eigen::Scaling(1.0, 2.0, 1.0);
  const Mesh moved = Transformed(sphere, map);  // normals stay across the surface
  const Vector3d v = moved.vertices[20] - Vector3d(2, 4, 3);
  const Vector3d across = Vector3d(v.x(), v.y() / 4, v.z()).normalized();
  EXPECT_NEAR(moved.normals[20].dot(across), 1, 1e-12);
}

}  // namespace
}  // namespace lamella
