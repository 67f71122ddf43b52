// Placement against its formula, written out point by point, and against camera geometry.
#include "distribute/place.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

View MakeView(const Eigen::Vector3d& centre, double cx = 256, double cy = 256) {
  View view;
  view.name = "reference";
  view.camera = {CameraModel::kPinhole, 512, 512, 700, 700, cx, cy, {}};
  view.camera_from_world.rotation = Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized();
  view.camera_from_world.translation = -(view.camera_from_world.rotation * centre);
  return view;
}

// Where a point of the reference camera's frame is shown, by the formula of DESIGN 5.1.
Eigen::Vector3d Shown(const Placement& p, const Camera& camera, const Eigen::Vector3d& point) {
  const double z = 1 / (p.a / point.z() + p.b);
  const double px = camera.fx * point.x() / point.z() + camera.cx - camera.width / 2.0;
  const double py = camera.fy * point.y() / point.z() + camera.cy - camera.height / 2.0;
  const double k = p.mm_per_view_px / p.viewing_distance_mm;
  return {k * px * z, -k * py * z, p.viewing_distance_mm - z};
}

// A world that is a plane at one depth of the reference camera, and remembers what it was asked.
class PlaneWorld final : public RaySource {
 public:
  PlaneWorld(const View& view, double depth) : view_(view), depth_(depth) {}
  void Query(const RayBundle& bundle, const Rect&, ImageSpan<RaySample> samples) const override {
    asked = bundle;
    const double plane = (view_.camera_from_world * bundle.origin).z();
    for (int y = 0; y < samples.height; ++y) {
      for (int x = 0; x < samples.width; ++x) {
        samples(x, y).z = static_cast<float>(plane - depth_);
        samples(x, y).coverage = 1;
      }
    }
  }
  mutable RayBundle asked;

 private:
  View view_;
  double depth_;
};

double DistanceToRay(const Ray& ray, const Eigen::Vector3d& point) {
  const Eigen::Vector3d along = ray.direction.normalized();
  return (point - ray.origin - along * along.dot(point - ray.origin)).norm();
}

RayBundle DisplayBundle(const Eigen::Vector4d& centre) {
  RayBundle bundle;
  bundle.centre = centre;
  bundle.origin = {-80, 60, 0};
  bundle.dx = {1, 0, 0};
  bundle.dy = {0, -1, 0};
  bundle.width = 160;
  bundle.height = 120;
  return bundle;
}

TEST(Place, PutsNearAndFarAtTheEndsOfTheBudget) {
  const Display display = FindDisplay("paper-two-layer");
  for (const double far : {1.5, 3.0, 1e6, kInfinity}) {
    std::string note;
    const Placement p = Place(MakeView({0, 0, 0}), 1.0, far, display, {}, &note);
    EXPECT_NEAR(p.near_mm, 20, 1e-9);
    EXPECT_NEAR(p.far_mm, -20, 1e-9);
    EXPECT_GE(p.b, 0);
    EXPECT_EQ(note, "");
  }
}

TEST(Place, KeepsProportionsOfAShallowSceneAndSaysSo) {
  const Display display = FindDisplay("paper-two-layer");
  std::string note;
  const Placement p = Place(MakeView({0, 0, 0}), 1.0, 1.01, display, {}, &note);
  EXPECT_EQ(p.b, 0);
  EXPECT_NEAR(p.near_mm, -p.far_mm, 1e-9);
  EXPECT_NEAR((p.near_mm - p.far_mm) / 600, 0.01 / 1.005, 1e-6);
  EXPECT_THAT(note, HasSubstr("shallower"));
  const Placement flat = Place(MakeView({0, 0, 0}), 2.0, 2.0, display, {}, &note);
  EXPECT_NEAR(flat.near_mm, 0, 1e-9);
}

TEST(Place, PutsTheFocusOnTheReferencePlane) {
  const Display display = FindDisplay("paper-two-layer");
  for (const double focus : {0.5, 1.0, 1.3, 3.0, 50.0}) {
    PlacementOptions options;
    options.focus = focus;
    const Placement p = Place(MakeView({0, 0, 0}), 1.0, 3.0, display, options, nullptr);
    EXPECT_NEAR(p.ZFromDepth(focus), 0, 1e-9) << focus;
    EXPECT_LE(p.near_mm, 20 + 1e-9);
    EXPECT_GE(p.far_mm, -20 - 1e-9);
    EXPECT_GT(p.near_mm, p.far_mm);
    EXPECT_GE(p.b, 0);
  }
}

TEST(Place, ShowsTheWholePictureInTheMiddleOfThePanel) {
  const Display display = FindDisplay("paper-two-layer");
  const Placement p = Place(MakeView({1, 2, 3}, 300, 200), 1.0, 3.0, display, {}, nullptr);
  EXPECT_NEAR(p.picture_height_mm, display.height_mm(), 1e-9);
  EXPECT_LT(p.picture_width_mm, display.width_mm());
  const Camera camera = MakeView({0, 0, 0}, 300, 200).camera;
  const Eigen::Vector3d middle(-44.0 / 700, 56.0 / 700, 1);  // of the picture
  EXPECT_NEAR(Shown(p, camera, 1.7 * middle).head<2>().norm(), 0, 1e-9);
}

TEST(Place, MapsPointsByTheFormula) {
  const View view = MakeView({10, -20, 5}, 270, 250);
  const Placement p = Place(view, 1.0, 3.0, FindDisplay("paper-two-layer"), {}, nullptr);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const double depth = 2 + 1.5 * unit(random);
    const Eigen::Vector3d in_camera(unit(random), unit(random), depth);
    const Eigen::Vector3d world = Inverse(view.camera_from_world) * in_camera;
    const Eigen::Vector4d shown =
        p.display_from_world * Eigen::Vector4d(world.x(), world.y(), world.z(), 1);
    EXPECT_LT((shown.head<3>() / shown.w() - Shown(p, view.camera, in_camera)).norm(), 1e-9);
    EXPECT_NEAR(p.ZFromDepth(depth), Shown(p, view.camera, in_camera).z(), 1e-9);
  }
}

// HCI antinous: baseline and focus as a grid of 1 world unit steps; +-20 mm as in must hold 13.
TEST(Place, MakesNeighbouringCamerasOfTheGridEyes27MillimetresApart) {
  const Display display = FindDisplay("paper-two-layer");
  const View view = MakeView({0, 0, 0});
  const double step = 0.05, focus = 4;
  const RegularGrid grid{step * view.camera.fx, 1 / focus};
  PlacementOptions options;
  options.disparity_range = "2.689,-3.131";
  options.mm_per_view_px = display.pitch_mm;
  const DepthRange range = ChooseDepthRange(options, grid, [] { return DepthRange{}; });
  const Placement p = Place(view, range.near, range.far, display, options, nullptr);
  EXPECT_NEAR(p.near_mm, 20, 1e-9);
  EXPECT_NEAR(p.far_mm, -20, 1e-9);
  View neighbour = view;  // one step to the right, two down
  const Eigen::Vector3d centre =
      Inverse(view.camera_from_world) * Eigen::Vector3d(step, 2 * step, 0);
  neighbour.camera_from_world.translation = -(neighbour.camera_from_world.rotation * centre);
  const Eigen::Vector3d eye = EyeOfCamera(p, neighbour.camera_from_world);
  EXPECT_NEAR(eye.x(), 27.15, 0.005);
  EXPECT_NEAR(eye.y(), -2 * eye.x(), 1e-9);
  EXPECT_NEAR(eye.z(), 600, 1e-9);
  options.disparity_range = "-3.131,2.689";
  EXPECT_EQ(ChooseDepthRange(options, grid, [] { return DepthRange{}; }).near, range.near);
}

TEST(Place, RefusesRangesThatAreNone) {
  const Display display = FindDisplay("paper-two-layer");
  const auto refusal = [&](PlacementOptions options, std::optional<RegularGrid> grid) {
    try {
      const DepthRange range = ChooseDepthRange(options, grid, [] { return DepthRange{1, 3}; });
      Place(MakeView({0, 0, 0}), range.near, range.far, display, options, nullptr);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const RegularGrid grid{10, 0.25};
  PlacementOptions o;
  for (const char* text : {"1", "1;2", "a,b", ",", "1,2,3", "nan,2"}) {
    o.depth_range = text;
    EXPECT_THAT(refusal(o, {}), HasSubstr("is not two numbers")) << text;
  }
  for (const char* text : {"3,1", "0,1", "-1,2", "inf,inf"}) {
    o.depth_range = text;
    EXPECT_THAT(refusal(o, {}), HasSubstr("is no range")) << text;
  }
  o.depth_range = " 1 , inf ";
  EXPECT_EQ(refusal(o, {}), "accepted");
  o.disparity_range = "1,2";
  EXPECT_THAT(refusal(o, grid), HasSubstr("beside --depth-range"));
  o.depth_range.clear();
  EXPECT_THAT(refusal(o, {}), HasSubstr("no camera grid"));
  EXPECT_EQ(refusal(o, grid), "accepted");
  o.disparity_range = "1,-3";
  EXPECT_THAT(refusal(o, grid), HasSubstr("beyond infinity"));
  o.disparity_range = "1,-2.5";  // infinity itself
  EXPECT_EQ(refusal(o, grid), "accepted");
  o = {};
  o.depth_budget_mm = 600;
  EXPECT_THAT(refusal(o, {}), HasSubstr("--depth-budget"));
  o.depth_budget_mm = -1;
  EXPECT_THAT(refusal(o, {}), HasSubstr("--depth-budget"));
  o = {};
  o.focus = -2;
  EXPECT_THAT(refusal(o, {}), HasSubstr("--focus"));
}

TEST(ReferenceView, IsTheMostCentralOneOrTheOneNamed) {
  std::vector<View> views;
  for (int i = 0; i < 5; ++i) {
    views.push_back(MakeView({static_cast<double>(i), 0, 0}));
    views.back().name = std::string(1, static_cast<char>('a' + i));
  }
  EXPECT_EQ(ReferenceView(views, "").name, "c");
  EXPECT_EQ(ReferenceView(views, "e").name, "e");
  views.pop_back();
  EXPECT_EQ(ReferenceView(views, "").name, "b");  // equally near: the first
  EXPECT_THROW(ReferenceView(views, "q"), Error);
}

TEST(DepthRangeOf, LeavesOutTheExtremeHundredths) {
  std::vector<double> inverse;
  for (int i = 0; i < 1000; ++i) inverse.push_back(0.5);
  for (int i = 0; i < 1000; ++i) inverse.push_back(0.25);
  for (int i = 0; i < 5; ++i) inverse.insert(inverse.end(), {1e9, 0.0});
  const DepthRange range = DepthRangeOf(inverse);
  EXPECT_DOUBLE_EQ(range.near, 2);
  EXPECT_DOUBLE_EQ(range.far, 4);
  EXPECT_EQ(DepthRangeOf({1, 0, 0}).far, kInfinity);
  EXPECT_EQ(DepthRangeOf({1}).far, 1);
  EXPECT_THROW(DepthRangeOf({}), Error);
  EXPECT_THROW(DepthRangeOf({0, 0}), Error);
}

class PlacedBundle : public ::testing::TestWithParam<Eigen::Vector4d> {};

TEST_P(PlacedBundle, AsksTheWorldForTheSameLines) {
  const View view = MakeView({10, -20, 5}, 270, 250);
  for (const double far : {3.0, kInfinity, 1.001}) {  // the last is a similarity
    const Placement p = Place(view, 1.0, far, FindDisplay("paper-two-layer"), {}, nullptr);
    PlaneWorld world(view, 1.5);
    const std::unique_ptr<RaySource> placed = Placed(world, p);
    const RayBundle bundle = DisplayBundle(GetParam());
    Image<RaySample> samples(1, 1);
    placed->Query(bundle, {0, 0, 1, 1}, samples.span());
    for (const double i : {0.5, 80.5, 159.5}) {
      for (const double j : {0.5, 60.0, 119.5}) {
        const Ray shown = bundle.RayAt(i, j);
        const Ray ray = world.asked.RayAt(i, j);
        for (const double depth : {0.9, 1.0, 1.2, 2.0}) {
          // The ray's world point at this depth is shown on the display's ray.
          const Ray in_camera{view.camera_from_world * ray.origin,
                              view.camera_from_world.rotation * ray.direction};
          const double t = (depth - in_camera.origin.z()) / in_camera.direction.z();
          EXPECT_GT(in_camera.direction.z(), 0);
          const Eigen::Vector3d point = in_camera.origin + t * in_camera.direction;
          EXPECT_LT(DistanceToRay(shown, Shown(p, view.camera, point)), 1e-7);
        }
      }
    }
  }
}

TEST_P(PlacedBundle, ReportsDepthInTheDisplaysFrame) {
  const View view = MakeView({10, -20, 5});
  const Placement p = Place(view, 1.0, 3.0, FindDisplay("paper-two-layer"), {}, nullptr);
  for (const double depth : {0.9, 1.0, 1.7, 3.0, 1e4, kInfinity}) {
    const PlaneWorld world(view, depth);
    RayBundle bundle = DisplayBundle(GetParam());
    bundle.origin.z() = 5;  // z is relative to the bundle's plane
    Image<RaySample> samples(2, 1);
    Placed(world, p)->Query(bundle, {0, 0, 2, 1}, samples.span());
    const double z = std::isinf(depth) ? 600 - 1 / p.b : 600 - 1 / (p.a / depth + p.b);
    EXPECT_NEAR(static_cast<double>(samples(1, 0).z), z - 5, 1e-4) << depth;
    EXPECT_EQ(samples(1, 0).coverage, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Centres, PlacedBundle,
    ::testing::Values(Eigen::Vector4d(0, 0, 600, 1), Eigen::Vector4d(70, -30, 600, 1),
                      Eigen::Vector4d(5, 5, 300, 1), Eigen::Vector4d(-20, 9, 900, 1),
                      Eigen::Vector4d(0, 0, 1, 0), Eigen::Vector4d(0.1, -0.05, 1, 0)));

TEST(Placed, ShowsTheReferenceViewToTheEyeInTheMiddle) {
  const View view = MakeView({3, 2, 1}, 300, 200);
  const Placement p = Place(view, 1.0, 3.0, FindDisplay("paper-two-layer"), {}, nullptr);
  RayBundle eye;
  eye.centre = {0, 0, 600, 1};
  eye.origin = {-p.picture_width_mm / 2, p.picture_height_mm / 2, 0};
  eye.dx = {p.mm_per_view_px, 0, 0};
  eye.dy = {0, -p.mm_per_view_px, 0};
  eye.width = eye.height = 512;
  const PlaneWorld world(view, 2);
  Image<RaySample> samples(1, 1);
  Placed(world, p)->Query(eye, {0, 0, 1, 1}, samples.span());
  const RayBundle camera = BundleOfCamera(view.camera, view.camera_from_world);
  for (const double i : {0.5, 200.0, 511.5}) {
    const Eigen::Vector3d asked = world.asked.RayAt(i, i).direction.normalized();
    EXPECT_LT((asked - camera.RayAt(i, i).direction.normalized()).norm(), 1e-9);
  }
  EXPECT_LT((world.asked.centre - camera.centre).norm(), 1e-9);
}

TEST(Placed, HandlesAReferencePlaneAtInfinity) {
  PlacementOptions options;
  options.focus = 1e300;
  const View view = MakeView({0, 0, 0});
  const Placement p = Place(view, 1.0, kInfinity, FindDisplay("paper-two-layer"), options, nullptr);
  const PlaneWorld world(view, 1.0);
  Image<RaySample> samples(1, 1);
  const RayBundle bundle = DisplayBundle({20, 0, 600, 1});
  Placed(world, p)->Query(bundle, {0, 0, 1, 1}, samples.span());
  EXPECT_NEAR(static_cast<double>(samples(0, 0).z), 20, 1e-3);
  const Ray ray = world.asked.RayAt(3, 4);
  const Eigen::Vector3d origin = view.camera_from_world * ray.origin;
  const Eigen::Vector3d direction = view.camera_from_world.rotation * ray.direction;
  const Eigen::Vector3d point = origin + direction * ((1.1 - origin.z()) / direction.z());
  EXPECT_LT(DistanceToRay(bundle.RayAt(3, 4), Shown(p, view.camera, point)), 1e-6);
}

}  // namespace
}  // namespace lamella
