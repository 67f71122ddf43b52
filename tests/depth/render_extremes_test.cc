// A capture asked as a RaySource at its limits: right, or plainly unknown; never a NaN.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "depth/render.h"
#include "tests/depth/analytic_scene.h"

namespace lamella {
namespace {

using testing_scene::PinholeOf;
using testing_scene::PlaneScene;
using testing_scene::PoseAt;
using testing_scene::TwoPlanes;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Image<RaySample> QueryAll(const RaySource& source, const RayBundle& bundle) {
  Image<RaySample> samples(bundle.width, bundle.height);
  source.Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
  return samples;
}

void ExpectSane(const Image<RaySample>& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const RaySample& s = samples.data()[i];
    ASSERT_TRUE(std::isfinite(s.color.r) && std::isfinite(s.color.g) && std::isfinite(s.color.b));
    ASSERT_GE(std::min({s.color.r, s.color.g, s.color.b}), 0.0F);
    ASSERT_FALSE(std::isnan(s.z));
    ASSERT_TRUE(s.coverage >= 0 && s.coverage <= 1);
    ASSERT_TRUE(s.confidence >= 0 && s.confidence <= 1);
  }
}

RayBundle BundleAt(const Eigen::Vector3d& centre, int width = 48, int height = 40) {
  return BundleOfCamera(PinholeOf(width, height, 50), PoseAt(centre));
}

RayBundle Direction() {
  RayBundle bundle;
  bundle.centre << 0.1, 0, -1, 0;
  bundle.origin = {-1, -1, 5};
  bundle.dx = {0.05, 0, 0};
  bundle.dy = {0, 0.05, 0};
  bundle.width = bundle.height = 40;
  return bundle;
}

// Views from the given centres, `change` applied to each.
template <class Change>
std::unique_ptr<RaySource> SourceOf(const std::vector<Eigen::Vector3d>& centres, Change change,
                                    int width = 48, int height = 40, double focal = 50) {
  std::vector<DepthView> views;
  const PlaneScene scene = TwoPlanes();
  for (const Eigen::Vector3d& centre : centres) {
    views.push_back(scene.Capture(PinholeOf(width, height, focal), PoseAt(centre)));
    change(views.back());
  }
  return CaptureSource(std::move(views), {});
}

const auto kUnchanged = [](DepthView&) {};
const std::vector<Eigen::Vector3d> kThree{{-0.3, 0, 0}, {0, 0, 0}, {0.3, 0, 0}};

void ExpectSaneFromEverywhere(const RaySource& source) {
  ExpectSane(QueryAll(source, BundleAt({0.1, 0.05, 0})));
  ExpectSane(QueryAll(source, BundleAt({0, 0, 4.999})));  // just before the front surface
  ExpectSane(QueryAll(source, BundleAt({0, 0, 30})));     // behind the scene, looking away
  ExpectSane(QueryAll(source, BundleAt({1e6, 0, -1e6})));
  ExpectSane(QueryAll(source, Direction()));
}

TEST(CaptureSourceExtremes, PicturesOfOnePixelAndOfOneRow) {
  ExpectSaneFromEverywhere(*SourceOf({{0, 0, 0}}, kUnchanged, 1, 1));
  ExpectSaneFromEverywhere(*SourceOf(kThree, kUnchanged, 37, 1));
  ExpectSaneFromEverywhere(*SourceOf(kThree, kUnchanged, 1, 23));
}

TEST(CaptureSourceExtremes, BundlesOfOneRayAndOfNone) {
  const auto source = SourceOf(kThree, kUnchanged);
  const Image<RaySample> one = QueryAll(*source, BundleAt({0.1, 0, 0}, 1, 1));
  ExpectSane(one);
  EXPECT_GE(one(0, 0).coverage, 0.5F);
  RayBundle none = BundleAt({0.1, 0, 0});
  none.width = 0;
  QueryAll(*source, none);
  source->Query(BundleAt({0.1, 0, 0}), {3, 4, 0, 0}, {});
}

TEST(CaptureSourceExtremes, OneView) {
  const auto source = SourceOf({{0, 0, 0}}, kUnchanged);
  ExpectSaneFromEverywhere(*source);
  // Seen from its own place, all of it is known.
  const Image<RaySample> own = QueryAll(*source, BundleAt({0, 0, 0}));
  const Image<RaySample> truth = QueryAll(TwoPlanes(), BundleAt({0, 0, 0}));
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_EQ(own.data()[i].coverage, 1);
    EXPECT_NEAR(own.data()[i].color.g, truth.data()[i].color.g, 2e-3F);
  }
}

TEST(CaptureSourceExtremes, BaselinesOfZeroAndOfAnySize) {
  ExpectSaneFromEverywhere(*SourceOf({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, kUnchanged));
  ExpectSaneFromEverywhere(*SourceOf({{0, 0, 0}, {1e-9, 0, 0}, {0, 1e-9, 0}}, kUnchanged));
  ExpectSaneFromEverywhere(*SourceOf({{0, 0, 0}, {1e6, 0, 0}, {0, 1e6, 0}}, kUnchanged));
}

TEST(CaptureSourceExtremes, DepthUnknownEverywhere) {
  const auto source = SourceOf(kThree, [](DepthView& view) {
    view.depth.depth = Image<float>(48, 40);
    view.depth.confidence = Image<float>(48, 40);
  });
  ExpectSaneFromEverywhere(*source);
  const Image<RaySample> samples = QueryAll(*source, BundleAt({0.1, 0, 0}));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples.data()[i].coverage, 0);
    EXPECT_GT(samples.data()[i].color.g, 0);  // still something plausible
  }
}

TEST(CaptureSourceExtremes, DepthAtInfinityEverywhere) {
  const auto source =
      SourceOf(kThree, [](DepthView& view) { view.depth.depth = Image<float>(48, 40, kInfinity); });
  ExpectSaneFromEverywhere(*source);
  // Parallax of nothing: the middle view's picture from all places near it.
  const Image<RaySample> samples = QueryAll(*source, BundleAt({0, 0, 0}));
  const Image<RaySample> truth = QueryAll(TwoPlanes(), BundleAt({0, 0, 0}));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples.data()[i].coverage, 1);
    EXPECT_EQ(samples.data()[i].z, -kInfinity);
    EXPECT_NEAR(samples.data()[i].color.g, truth.data()[i].color.g, 0.05F);
  }
}

TEST(CaptureSourceExtremes, DepthFromAMillionthToInfinityInOneScene) {
  const auto source = SourceOf(kThree, [](DepthView& view) {
    for (int y = 0; y < 40; ++y) {
      view.depth.depth(3, y) = 1e-6F;
      view.depth.depth(4, y) = 1e-30F;
      view.depth.depth(5, y) = kInfinity;
      view.depth.depth(6, y) = std::numeric_limits<float>::max();
      view.depth.depth(7, y) = std::numeric_limits<float>::denorm_min();
      view.depth.depth(8, y) = std::numeric_limits<float>::quiet_NaN();
      view.depth.depth(9, y) = -3;
    }
  });
  ExpectSaneFromEverywhere(*source);
}

TEST(CaptureSourceExtremes, NoiseForDepth) {
  const auto source = SourceOf(kThree, [](DepthView& view) {
    std::uint32_t state = 1;
    for (std::size_t i = 0; i < view.depth.depth.size(); ++i) {
      state = state * 1664525U + 1013904223U;
      view.depth.depth.data()[i] = std::exp(static_cast<float>(state >> 8) * 2e-6F - 10);
    }
  });
  ExpectSaneFromEverywhere(*source);
}

TEST(CaptureSourceExtremes, FocalLengthsFromOnePixelToAMillion) {
  for (const double focal : {1.0, 1e6}) {
    const auto source = SourceOf(kThree, kUnchanged, 48, 40, focal);
    ExpectSaneFromEverywhere(*source);
    const RayBundle own = BundleOfCamera(PinholeOf(48, 40, focal), PoseAt({0, 0, 0}));
    const Image<RaySample> samples = QueryAll(*source, own), truth = QueryAll(TwoPlanes(), own);
    ExpectSane(samples);
    EXPECT_NEAR(samples(24, 20).color.g, truth(24, 20).color.g, 0.02F);
    EXPECT_NEAR(samples(24, 20).z, truth(24, 20).z, 0.02F);
  }
}

TEST(CaptureSourceExtremes, RadianceKeepsItsRatiosAtEverySize) {
  const Image<RaySample> usual = QueryAll(*SourceOf(kThree, kUnchanged), BundleAt({0.1, 0.05, 0}));
  for (const float scale : {0.0F, 1e-8F, 1e8F}) {
    const auto source = SourceOf(kThree, [&](DepthView& view) {
      for (std::size_t i = 0; i < view.color.size(); ++i) {
        view.color.data()[i] = scale * view.color.data()[i];
      }
    });
    const Image<RaySample> samples = QueryAll(*source, BundleAt({0.1, 0.05, 0}));
    ExpectSane(samples);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_NEAR(samples.data()[i].color.r, scale * usual.data()[i].color.r, 2e-3F * scale);
    }
  }
}

TEST(CaptureSourceExtremes, PlanesThroughTheCentreAndWithoutArea) {
  const auto source = SourceOf(kThree, kUnchanged);
  RayBundle through = BundleAt({0.1, 0, 0});
  through.origin = through.centre.head<3>();
  RayBundle flat = BundleAt({0.1, 0, 0});
  flat.dy = flat.dx;
  RayBundle lost = BundleAt({0.1, 0, 0});
  lost.centre.x() = std::numeric_limits<double>::quiet_NaN();
  for (const RayBundle& bundle : {through, flat, lost}) {
    const Image<RaySample> samples = QueryAll(*source, bundle);
    ExpectSane(samples);
    EXPECT_EQ(samples(5, 5).coverage, 0);
  }
}

TEST(CaptureSourceExtremes, GrazingPlanes) {
  const auto source = SourceOf(kThree, kUnchanged);
  RayBundle bundle = BundleAt({0.1, 0, 0});
  const double angle = 89.9 * 3.14159265358979 / 180;  // of the plane against the line of sight
  bundle.dx = 0.02 * Eigen::Vector3d(std::cos(angle), 0, std::sin(angle));
  bundle.origin = bundle.centre.head<3>() + Eigen::Vector3d(0, -0.3, 2) - 24 * bundle.dx;
  ExpectSane(QueryAll(*source, bundle));
}

TEST(CaptureSourceExtremes, WidePictures) {
  const PlaneScene scene = TwoPlanes();
  std::vector<DepthView> views;
  views.push_back(scene.Capture(PinholeOf(30000, 2, 20000), PoseAt({0, 0, 0})));
  const auto source = CaptureSource(std::move(views), {});
  const RayBundle bundle = BundleOfCamera(PinholeOf(30000, 1, 20000), PoseAt({0.01, 0, 0}));
  const Image<RaySample> samples = QueryAll(*source, bundle), truth = QueryAll(scene, bundle);
  ExpectSane(samples);
  EXPECT_NEAR(samples(29000, 0).color.g, truth(29000, 0).color.g, 0.02F);
}

}  // namespace
}  // namespace lamella
