#include "depth/render.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "tests/allocated.h"
#include "tests/depth/analytic_scene.h"

namespace lamella {
namespace {

using testing_scene::PinholeOf;
using testing_scene::PlaneScene;
using testing_scene::PoseAt;
using testing_scene::TwoPlanes;

constexpr int kRenderWidth = 160, kRenderHeight = 120;
constexpr double kFocal = 150;

Eigen::Vector3d CentreOf(int i) {
  const int column = i % 3, row = i / 3;
  return {0.4 * (column - 1), 0.4 * (row - 1), 0.02 * i};
}

// Nine views on a square of side 0.8, each slightly turned.
std::vector<DepthView> NineViews(const PlaneScene& scene,
                                 const Eigen::Vector3d& offset = {0, 0, 0}) {
  std::vector<DepthView> views;
  for (int i = 0; i < 9; ++i) {
    const Rigid pose = PoseAt(CentreOf(i), -0.01 * (i % 3 - 1));
    DepthView view = scene.Capture(PinholeOf(kRenderWidth, kRenderHeight, kFocal), pose);
    view.view.name = "view" + std::to_string(i);
    view.view.camera_from_world.translation -= pose.rotation * offset;
    views.push_back(std::move(view));
  }
  return views;
}

Image<RaySample> QueryWhole(const RaySource& source, const RayBundle& bundle) {
  Image<RaySample> samples(bundle.width, bundle.height);
  source.Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
  return samples;
}

struct Errors {
  double color_psnr = 0, worst_z = 0, mean_coverage = 0;
};

// The largest step of the truth's z around a ray.
float DepthJump(const Image<RaySample>& truth, int x, int y) {
  float low = truth(x, y).z, high = low;
  for (int v = std::max(y - 2, 0); v <= std::min(y + 2, truth.height() - 1); ++v) {
    for (int u = std::max(x - 2, 0); u <= std::min(x + 2, truth.width() - 1); ++u) {
      low = std::min(low, truth(u, v).z);
      high = std::max(high, truth(u, v).z);
    }
  }
  return high - low;
}

// Away from edges of depth and from the sides, where a pixel is one surface.
Errors Compare(const Image<RaySample>& a, const Image<RaySample>& truth) {
  constexpr int kBorder = 8;
  double squares = 0, coverage = 0, worst = 0;
  int count = 0;
  for (int y = kBorder; y < a.height() - kBorder; ++y) {
    for (int x = kBorder; x < a.width() - kBorder; ++x) {
      if (DepthJump(truth, x, y) > 1) continue;
      const Rgb d = a(x, y).color - truth(x, y).color;
      squares += static_cast<double>(d.r * d.r + d.g * d.g + d.b * d.b) / 3;
      coverage += static_cast<double>(a(x, y).coverage);
      worst = std::max(worst, std::abs(static_cast<double>(a(x, y).z - truth(x, y).z)));
      ++count;
    }
  }
  EXPECT_GT(count, 0.8 * (a.width() - 2 * kBorder) * (a.height() - 2 * kBorder));
  return {-10 * std::log10(squares / count), worst, coverage / count};
}

bool SameBytes(const RaySample& a, const RaySample& b) {
  return a.color == b.color && a.z == b.z && a.confidence == b.confidence &&
         a.coverage == b.coverage;
}

RayBundle NewView() {
  return BundleOfCamera(PinholeOf(kRenderWidth, kRenderHeight, kFocal),
                        PoseAt({0.17, -0.12, 0.1}, 0.02));
}

TEST(CaptureSource, RendersANewViewOfTwoPlanesLikeTheTruth) {
  const PlaneScene scene = TwoPlanes();
  const auto source = CaptureSource(NineViews(scene), {});
  const Errors e = Compare(QueryWhole(*source, NewView()), QueryWhole(scene, NewView()));
  EXPECT_GT(e.color_psnr, 55);
  EXPECT_LT(e.worst_z, 0.01);
  EXPECT_GT(e.mean_coverage, 0.999);
}

// What is in front hides little: parallel rays look past it where cameras do.
PlaneScene ShallowScene() {
  testing_scene::TexturedRectangle wall, front;
  wall.centre = {0, 0, 9};
  wall.u = Eigen::Vector3d(1, 0, 0.2).normalized();
  front.centre = {0.2, -0.1, 7.6};
  front.half_u = front.half_v = 0.4;
  front.phase = 1;
  return PlaneScene({wall, front});
}

bool SeenBySome(const PlaneScene& scene, const Eigen::Vector3d& point) {
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector3d centre = CentreOf(i);
    if (std::abs(scene.Trace({centre, point - centre}).t - 1) < 1e-6) return true;
  }
  return false;
}

TEST(CaptureSource, RendersADirectionBundleLikeTheTruth) {
  const PlaneScene scene = ShallowScene();
  const auto source = CaptureSource(NineViews(scene), {});
  RayBundle bundle;
  bundle.centre << 0.02, -0.03, -1, 0;
  bundle.origin = {-1.6, -1.2, 6};
  bundle.dx = {0.04, 0, 0};
  bundle.dy = {0, 0.04, 0};
  bundle.width = 80;
  bundle.height = 60;
  Image<RaySample> samples = QueryWhole(*source, bundle), truth = QueryWhole(scene, bundle);
  int hidden = 0;
  for (int y = 0; y < bundle.height; ++y) {
    for (int x = 0; x < bundle.width; ++x) {
      const Ray ray = bundle.RayAt(x + 0.5, y + 0.5);
      if (SeenBySome(scene, ray.origin + scene.Trace(ray, -1e9).t * ray.direction)) continue;
      samples(x, y) = truth(x, y);
      ++hidden;
    }
  }
  EXPECT_LT(hidden, 0.2 * static_cast<double>(samples.size()));
  const Errors e = Compare(samples, truth);
  EXPECT_GT(e.color_psnr, 45);
  EXPECT_LT(e.worst_z, 0.02);
}

TEST(CaptureSource, DirectionBundlesEqualBundlesOfAFarPoint) {
  const auto source = CaptureSource(NineViews(ShallowScene()), {});
  RayBundle direction;
  direction.centre << 0.1, 0.05, -1, 0;
  direction.origin = {-1.2, -0.9, 7};
  direction.dx = {0.02, 0, 0};
  direction.dy = {0, 0.02, 0};
  direction.width = 120;
  direction.height = 90;
  RayBundle point = direction;
  point.centre.head<3>() = point.PlanePoint(60, 45) + 1e7 * direction.centre.head<3>();
  point.centre.w() = 1;
  const Image<RaySample> a = QueryWhole(*source, direction), b = QueryWhole(*source, point);
  double color = 0;
  int far_off = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Rgb d = a.data()[i].color - b.data()[i].color;
    color += static_cast<double>(std::abs(d.r) + std::abs(d.g) + std::abs(d.b));
    if (std::abs(a.data()[i].z - b.data()[i].z) > 0.05F) ++far_off;
  }
  EXPECT_LT(color / static_cast<double>(a.size()), 1e-3);
  EXPECT_LT(far_off, 20);  // edge pixels
}

TEST(CaptureSource, FinerRaysThanPixelsLeaveNoCracks) {
  const PlaneScene scene = TwoPlanes();
  const auto source = CaptureSource(NineViews(scene), {});
  RayBundle bundle = BundleOfCamera(PinholeOf(8 * kRenderWidth, 8 * kRenderHeight, 8 * kFocal),
                                    PoseAt({0.17, -0.12, 0.1}));
  bundle.origin = bundle.PlanePoint(3 * kRenderWidth, 3 * kRenderHeight);
  bundle.width = 2 * kRenderWidth;
  bundle.height = 2 * kRenderHeight;
  const Errors e = Compare(QueryWhole(*source, bundle), QueryWhole(scene, bundle));
  EXPECT_GT(e.color_psnr, 50);
  EXPECT_LT(e.worst_z, 0.01);
}

// The mean colour of the truth over a ray's cell.
Image<RaySample> AreaTruth(const PlaneScene& scene, const RayBundle& bundle, int samples) {
  RayBundle fine = bundle;
  fine.dx /= samples;
  fine.dy /= samples;
  fine.width *= samples;
  fine.height *= samples;
  const Image<RaySample> all = QueryWhole(scene, fine);
  Image<RaySample> mean = QueryWhole(scene, bundle);
  for (int y = 0; y < bundle.height; ++y) {
    for (int x = 0; x < bundle.width; ++x) {
      Rgb sum;
      for (int i = 0; i < samples * samples; ++i) {
        sum += all(x * samples + i % samples, y * samples + i / samples).color;
      }
      mean(x, y).color = 1.0F / static_cast<float>(samples * samples) * sum;
    }
  }
  return mean;
}

TEST(CaptureSource, CoarserRaysThanPixelsAverageTheirFootprint) {
  for (const double wavelength : {1.2, 0.1}) {  // 20 pixels; under 2, so that coarse rays see grey
    testing_scene::TexturedRectangle wall;
    wall.centre = {0, 0, 9};
    wall.u = Eigen::Vector3d(1, 0, 0.2).normalized();
    wall.wavelength = wavelength;
    const PlaneScene scene({wall});
    const auto source = CaptureSource(NineViews(scene), {});
    for (const int factor : {2, 3, 4}) {
      RayBundle coarse = NewView();
      coarse.dx *= factor;
      coarse.dy *= factor;
      coarse.width /= factor;
      coarse.height /= factor;
      const Errors e = Compare(QueryWhole(*source, coarse), AreaTruth(scene, coarse, 2 * factor));
      EXPECT_GT(e.color_psnr, wavelength > 1 ? 40 : 20) << wavelength << " " << factor;
      EXPECT_LT(e.worst_z, 0.05) << factor;
    }
  }
}

TEST(CaptureSource, ARectangleNeverChangesAValue) {
  const auto source = CaptureSource(NineViews(TwoPlanes()), {});
  const RayBundle bundle = NewView();
  const Image<RaySample> whole = QueryWhole(*source, bundle);
  for (const int side : {1, 7, 45}) {
    for (int y = 0; y < bundle.height; y += 3 * side) {
      for (int x = side / 2; x < bundle.width; x += 5 * side) {
        const Rect part{x, y, std::min(side, bundle.width - x), std::min(side, bundle.height - y)};
        if (side == 1 && (x * y) % 31 != 0) continue;
        Image<RaySample> samples(part.width, part.height);
        source->Query(bundle, part, samples.span());
        for (int v = 0; v < part.height; ++v) {
          for (int u = 0; u < part.width; ++u) {
            ASSERT_TRUE(SameBytes(samples(u, v), whole(x + u, y + v))) << x + u << "," << y + v;
          }
        }
      }
    }
  }
}

// Rows far down a large bundle, whose coordinates have fewer digits left.
TEST(CaptureSource, NoValueDependsOnWhereRowsBegin) {
  const auto source = CaptureSource(NineViews(TwoPlanes()), {});
  const RayBundle bundle = BundleOfCamera(
      PinholeOf(9 * kRenderWidth, 9 * kRenderHeight, 9 * kFocal), PoseAt({0.02, -0.01, 0}));
  const Image<RaySample> whole = QueryWhole(*source, bundle);
  constexpr int kRows = 30;
  for (int y = 100; y + kRows < bundle.height; y += 70) {
    Image<RaySample> rows(bundle.width, kRows);
    source->Query(bundle, {0, y, bundle.width, kRows}, rows.span());
    for (int v = 0; v < kRows; ++v) {
      for (int x = 0; x < bundle.width; ++x) {
        ASSERT_TRUE(SameBytes(rows(x, v), whole(x, y + v))) << x << "," << y + v;
      }
    }
  }
}

TEST(CaptureSource, ResultsDoNotDependOnTheNumberOfThreads) {
  const RayBundle bundle = NewView();
  const Image<RaySample> many = QueryWhole(*CaptureSource(NineViews(TwoPlanes()), {}), bundle);
  const ThreadLimit one(1);
  const Image<RaySample> single = QueryWhole(*CaptureSource(NineViews(TwoPlanes()), {}), bundle);
  for (std::size_t i = 0; i < many.size(); ++i) {
    ASSERT_TRUE(SameBytes(many.data()[i], single.data()[i]));
  }
}

TEST(CaptureSource, WorldCoordinatesFarFromTheOriginChangeNothing) {
  const Eigen::Vector3d far(1e7, -1e7, 3e6);
  RayBundle bundle = NewView();
  const Image<RaySample> here = QueryWhole(*CaptureSource(NineViews(TwoPlanes()), {}), bundle);
  bundle.centre.head<3>() += far;
  bundle.origin += far;
  const Image<RaySample> there =
      QueryWhole(*CaptureSource(NineViews(TwoPlanes(), far), {}), bundle);
  const Errors e = Compare(there, here);
  EXPECT_GT(e.color_psnr, 90);
  EXPECT_LT(e.worst_z, 1e-3);
}

TEST(CaptureSource, RaysThatNoViewSawAreMarkedAndKeepAPlausibleColour) {
  // One view: what the front rectangle hides from it is unknown from the side.
  const PlaneScene scene = TwoPlanes();
  std::vector<DepthView> one;
  one.push_back(scene.Capture(PinholeOf(kRenderWidth, kRenderHeight, kFocal), PoseAt({0, 0, 0})));
  const auto source = CaptureSource(std::move(one), {});
  const RayBundle bundle =
      BundleOfCamera(PinholeOf(kRenderWidth, kRenderHeight, kFocal), PoseAt({0.8, 0, 0}));
  const Image<RaySample> samples = QueryWhole(*source, bundle);
  // Seen by the view at the origin: in its picture, and nothing before it.
  Image<int> seen(kRenderWidth, kRenderHeight);
  for (int y = 0; y < kRenderHeight; ++y) {
    for (int x = 0; x < kRenderWidth; ++x) {
      const Ray ray = bundle.RayAt(x + 0.5, y + 0.5);
      const Eigen::Vector3d point = ray.origin + scene.Trace(ray).t * ray.direction;
      const bool inside = std::abs(kFocal * point.x() / point.z()) < 0.5 * kRenderWidth;
      seen(x, y) = inside && std::abs(scene.Trace({{0, 0, 0}, point}).t - 1) < 1e-6 ? 1 : 0;
    }
  }
  int seen_count = 0, unseen_count = 0, wrong = 0;
  for (int y = 2; y < kRenderHeight - 2; ++y) {
    for (int x = 2; x < kRenderWidth - 2; ++x) {
      EXPECT_GT(samples(x, y).color.g, 0.01F);
      int around = 0;
      for (int i = 0; i < 25; ++i) around += seen(x + i % 5 - 2, y + i / 5 - 2);
      if (around != 0 && around != 25) continue;  // on the border of what is seen
      (around > 0 ? seen_count : unseen_count) += 1;
      if ((around > 0) != (samples(x, y).coverage >= 0.5F)) ++wrong;
    }
  }
  EXPECT_GT(unseen_count, 500);
  EXPECT_GT(seen_count, 10000);
  EXPECT_LT(wrong, 60);  // beside edges of depth
}

TEST(CaptureSource, LeavesOutWhatNoViewSawWhereItIsNotGuessed) {
  const PlaneScene scene = TwoPlanes();
  RenderOptions seen_only;
  seen_only.guess_unseen = false;
  const auto views = [&] {
    std::vector<DepthView> made = NineViews(scene);
    for (DepthView& v : made) {
      for (int y = 30; y < 60; ++y) {
        for (int x = 40; x < 80; ++x) v.depth.depth(x, y) = v.depth.confidence(x, y) = 0;
      }
    }
    return made;
  };
  // Looks past the pictures, too.
  const RayBundle bundle =
      BundleOfCamera(PinholeOf(kRenderWidth, kRenderHeight, kFocal), PoseAt({1.1, 0, 0}));
  const Image<RaySample> all = QueryWhole(*CaptureSource(views(), {}), bundle);
  const Image<RaySample> some = QueryWhole(*CaptureSource(views(), seen_only), bundle);
  int seen = 0, unseen = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const RaySample &a = all.data()[i], &b = some.data()[i];
    ASSERT_NEAR(a.coverage, b.coverage, 1e-6F);
    if (a.coverage == 0) {
      ++unseen;
      ASSERT_EQ(b.color, Rgb());
      ASSERT_EQ(b.confidence, 0);
    } else if (a.coverage > 0.5F) {
      ++seen;
      ASSERT_NEAR(a.color.g, b.color.g, 2e-3F);
      ASSERT_EQ(a.z, b.z);
    }
  }
  EXPECT_GT(seen, 3000);
  EXPECT_GT(unseen, 1500);
}

TEST(CaptureSource, KeepsColoursNoFinerThanTheRaysNeed) {
  const PlaneScene scene = TwoPlanes();
  RayBundle coarse = NewView();
  coarse.dx *= 4;
  coarse.dy *= 4;
  coarse.width /= 4;
  coarse.height /= 4;
  RenderOptions known;
  known.rays = coarse;
  std::vector<DepthView> with = NineViews(scene), without = NineViews(scene);
  const Image<RaySample> a = QueryWhole(*CaptureSource(std::move(with), known), coarse);
  const Image<RaySample> b = QueryWhole(*CaptureSource(std::move(without), {}), coarse);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_NEAR(a.data()[i].color.g, b.data()[i].color.g, 4e-3F);
    ASSERT_EQ(a.data()[i].coverage, b.data()[i].coverage);
  }
}

TEST(CaptureSource, AllocatesNoMoreForAQueryThanItSays) {
  RenderOptions seen_only;
  seen_only.guess_unseen = false;
  const auto source = CaptureSource(NineViews(TwoPlanes()), seen_only);
  RayBundle fine = NewView();
  fine.dx /= 6;
  fine.dy /= 6;
  fine.width *= 6;
  fine.height *= 6;
  for (const int rows : {720, 160}) {
    Image<RaySample> samples(fine.width, rows);
    const Rect part{0, (fine.height - rows) / 2, fine.width, rows};
    source->Query(fine, part, samples.span());
    const Allocated allocated;
    source->Query(fine, part, samples.span());
    const double said = source->QueryBytes(fine.width, rows);
    EXPECT_LE(allocated.PeakBytes(), said) << rows;
    EXPECT_GE(allocated.PeakBytes(), 0.3 * said) << rows;
  }
}

TEST(CaptureSource, AnUnknownDepthIsNoSurface) {
  const PlaneScene scene = TwoPlanes();
  std::vector<DepthView> views = NineViews(scene);
  for (DepthView& v : views) {
    for (int y = 30; y < 60; ++y) {
      for (int x = 40; x < 80; ++x) v.depth.depth(x, y) = v.depth.confidence(x, y) = 0;
    }
  }
  const auto source = CaptureSource(std::move(views), {});
  const Errors e = Compare(QueryWhole(*source, NewView()), QueryWhole(scene, NewView()));
  EXPECT_GT(e.color_psnr, 30);
}

TEST(CaptureSource, EqualisesExposures) {
  const PlaneScene scene = TwoPlanes();
  std::vector<DepthView> views = NineViews(scene);
  for (std::size_t k = 0; k < views.size(); ++k) {
    const float gain = 1.0F + 0.05F * (static_cast<float>(k) - 4);
    for (std::size_t i = 0; i < views[k].color.size(); ++i) {
      Rgb& c = views[k].color.data()[i];
      c = {gain * c.r, c.g, c.b / gain};
    }
  }
  const auto source = CaptureSource(std::move(views), {});
  const Errors e = Compare(QueryWhole(*source, NewView()), QueryWhole(scene, NewView()));
  EXPECT_GT(e.color_psnr, 40);
}

TEST(CaptureSource, RefusesNoViewAndPicturesOfAnotherSize) {
  EXPECT_THROW(CaptureSource({}, {}), Error);
  std::vector<DepthView> views = NineViews(TwoPlanes());
  views[3].color = Image<Rgb>(3, 3);
  EXPECT_THROW(CaptureSource(std::move(views), {}), Error);
}

}  // namespace
}  // namespace lamella
