#include "depth/plane_sweep.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/parallel.h"
#include "tests/reference/plane_sweep_reference.h"

namespace lamella {
namespace {

Image<std::uint8_t> Noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<std::uint8_t> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<std::uint8_t>(random());
  return image;
}

Camera Pinhole(int width, int height, double f) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = f;
  camera.fy = 1.01 * f;
  camera.cx = 0.5 * width + 0.3;
  camera.cy = 0.5 * height - 0.7;
  return camera;
}

struct SweepInput {
  Image<std::uint8_t> reference;
  Camera camera;
  std::vector<Image<std::uint8_t>> images;
  std::vector<SweepSource> sources;
  InverseDepthRange range;
};

SweepInput RandomInput(int width, int height, int sources, int labels) {
  SweepInput s;
  s.reference = Noise(width, height, 1);
  s.camera = Pinhole(width, height, width);
  for (int i = 0; i < sources; ++i)
    s.images.push_back(Noise(width + 2 * i + 1, height + i + 1, 7U + static_cast<unsigned>(i)));
  for (int i = 0; i < sources; ++i) {
    SweepSource source;
    source.grey = s.images[static_cast<std::size_t>(i)].span();
    source.camera = Pinhole(width + 2 * i + 1, height + i + 1, 0.9 * width);
    source.source_from_reference.rotation =
        Eigen::Quaterniond(1, 0.02 * i, -0.03, 0.05).normalized();
    source.source_from_reference.translation = {0.2 * (i % 2 ? 1 : -1), 0.03 * i, 0.02};
    s.sources.push_back(source);
  }
  s.range = {0.0, 1.0, labels};
  return s;
}

void ExpectEqual(const CostVolume& a, const CostVolume& b) {
  ASSERT_EQ(a.Bytes(), b.Bytes());
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.Bytes(); ++i) different += a.costs[i] != b.costs[i];
  EXPECT_EQ(different, 0U);
}

TEST(SweepPlanes, EqualsTheReferenceForOneToSixSources) {
  for (int sources = 1; sources <= 6; ++sources) {
    const SweepInput s = RandomInput(37, 53, sources, 19);
    ExpectEqual(SweepPlanes(s.reference.span(), s.camera, s.sources, s.range),
                SweepPlanesReference(s.reference.span(), s.camera, s.sources, s.range));
  }
}

TEST(SweepPlanes, EqualsTheReferenceAtEverySmallWidth) {
  for (int width = 1; width <= 34; ++width) {
    const SweepInput s = RandomInput(width, 5, 2, 3);
    ExpectEqual(SweepPlanes(s.reference.span(), s.camera, s.sources, s.range),
                SweepPlanesReference(s.reference.span(), s.camera, s.sources, s.range));
  }
}

TEST(SweepPlanes, DoesNotDependOnTheNumberOfThreads) {
  const SweepInput s = RandomInput(61, 90, 3, 17);
  const CostVolume two = SweepPlanes(s.reference.span(), s.camera, s.sources, s.range);
  const ThreadLimit limit(1);
  const CostVolume one = SweepPlanes(s.reference.span(), s.camera, s.sources, s.range);
  EXPECT_EQ(std::memcmp(one.costs.get(), two.costs.get(), one.Bytes()), 0);
}

// A textured plane at inverse depth 0.5 seen by two cameras, drawn from a formula in the plane's
// own coordinates: the cheapest label must be the plane's.
TEST(SweepPlanes, IsCheapestAtTheTrueDepth) {
  const Camera camera = Pinhole(96, 64, 90);
  const double truth = 0.5;
  const auto texture = [](double x, double y) {
    return 128 + 50 * std::sin(35 * x + 4 * std::sin(25 * y)) + 40 * std::cos(41 * y + 17 * x * y);
  };
  const auto draw = [&](const Eigen::Vector3d& centre) {
    Image<std::uint8_t> image(96, 64);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        const double depth = 1 / truth - centre.z();
        image(x, y) = static_cast<std::uint8_t>(
            texture(centre.x() + depth * (x + 0.5 - camera.cx) / camera.fx,
                    centre.y() + depth * (y + 0.5 - camera.cy) / camera.fy));
      }
    }
    return image;
  };
  const Image<std::uint8_t> reference = draw({0, 0, 0}), left = draw({-0.3, 0, 0}),
                            right = draw({0.3, 0.05, 0.1});
  std::vector<SweepSource> sources(2);
  sources[0] = {left.span(), camera, {}};
  sources[0].source_from_reference.translation = {0.3, 0, 0};
  sources[1] = {right.span(), camera, {}};
  sources[1].source_from_reference.translation = {-0.3, -0.05, -0.1};
  const CostVolume volume = SweepPlanes(reference.span(), camera, sources, {0.1, 0.9, 17});
  int right_label = 0, pixels = 0;
  for (int y = 4; y < 60; ++y) {
    for (int x = 20; x < 76; ++x, ++pixels) {
      const std::uint8_t* cost = volume.At(x, y);
      right_label += std::abs(std::min_element(cost, cost + 17) - cost - 8) == 0;
    }
  }
  EXPECT_GT(right_label, 0.95 * pixels);
}

TEST(SweepPlanes, CostsTheSameEverywhereWhereNoSourceSees) {
  SweepInput s = RandomInput(20, 12, 2, 5);
  for (SweepSource& source : s.sources) {
    source.source_from_reference.rotation = Eigen::Quaterniond(0, 0, 1, 0);  // looks back
    source.source_from_reference.translation.setZero();
  }
  const CostVolume volume = SweepPlanes(s.reference.span(), s.camera, s.sources, s.range);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(volume.At(9, 6)[k], 14 * 8 - 1);  // rounded down
}

}  // namespace
}  // namespace lamella
