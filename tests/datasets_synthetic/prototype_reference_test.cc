// The virtual prototype against the area-exact renderer of planes under homographies, where a
// shared sign or half a pixel could not hide, and against the same prototype looked at line by
// line.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "datasets_synthetic/prototype.h"
#include "tests/reference/homography_reference.h"
#include "tests/reference/photograph_reference.h"

namespace lamella {
namespace {

constexpr double kReferenceDegree = std::numbers::pi / 180;
constexpr int kSamples = 256;

struct ReferenceScene {
  reference::PlanarPanel panel;
  reference::PlanarCamera camera;
  double tilt_x = 0, tilt_y = 0, turn_z = 0;  // of the panel: AboutZ * AboutY * AboutX
};

// Two camera pixels per panel pixel and some, nothing on the raster.
ReferenceScene ReferenceSceneOf(const std::string& name) {
  ReferenceScene scene;
  scene.panel = {40, 30, 0.5, false, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0.313, -0.217, 3.7}};
  if (name == "mirrored") scene.panel.mirrored = true;
  if (name == "tilted") {
    scene.tilt_x = -11 * kReferenceDegree;
    scene.tilt_y = 23 * kReferenceDegree;
    scene.turn_z = 7 * kReferenceDegree;
    scene.panel.rotation = reference::Times(
        reference::AboutZ(scene.turn_z),
        reference::Times(reference::AboutY(scene.tilt_y), reference::AboutX(scene.tilt_x)));
  }
  scene.camera = {120,         96, 470, 61.3, 47.2, reference::AboutX(180 * kReferenceDegree),
                  {4, -3, 110}};
  // Looks a little aside, so that the camera's rotation is used as well.
  scene.camera.rotation = reference::Times(
      reference::AboutZ(1.3 * kReferenceDegree),
      reference::Times(reference::AboutY(-2 * kReferenceDegree), scene.camera.rotation));
  return scene;
}

Eigen::Quaterniond AboutAxes(double x, double y, double z) {
  return Eigen::AngleAxisd(z, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(y, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(x, Eigen::Vector3d::UnitX());
}

Image<Rgb> ByPrototype(const ReferenceScene& scene, const Image<float>& light, int samples) {
  Prototype prototype;
  LayerCalibration layer;
  layer.emitter.width_px = scene.panel.width;
  layer.emitter.height_px = scene.panel.height;
  layer.emitter.pitch_mm = scene.panel.pitch;
  layer.emitter.mirror_x = scene.panel.mirrored;
  layer.display_from_stack.rotation = AboutAxes(scene.tilt_x, scene.tilt_y, scene.turn_z);
  layer.display_from_stack.translation = {scene.panel.centre[0], scene.panel.centre[1],
                                          scene.panel.centre[2]};
  prototype.calibration.layers.push_back(layer);
  auto grey = std::make_shared<Image<Rgb>>(light.width(), light.height());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const float value = light.data()[i];
    grey->data()[i] = {value, value, value};
  }
  prototype.shown.push_back({{grey}, {}});
  PrototypeCamera camera;
  camera.camera = {
      CameraModel::kPinhole, scene.camera.width, scene.camera.height, scene.camera.focal,
      scene.camera.focal,    scene.camera.cx,    scene.camera.cy,     {}};
  camera.camera_from_display.rotation =
      AboutAxes(0, -2 * kReferenceDegree, 0) * AboutAxes(180 * kReferenceDegree, 0, 0);
  camera.camera_from_display.rotation =
      AboutAxes(0, 0, 1.3 * kReferenceDegree) * camera.camera_from_display.rotation;
  const auto& c = scene.camera.position;
  camera.camera_from_display.translation =
      -(camera.camera_from_display.rotation * Eigen::Vector3d(c[0], c[1], c[2]));
  return PhotographPrototype(prototype, camera, samples, SilentProgress());
}

// Random pixels: every panel pixel's border is an edge.
Image<float> Noise(int width, int height) {
  Image<float> light(width, height);
  unsigned state = 12345;
  for (std::size_t i = 0; i < light.size(); ++i) {
    state = state * 1664525U + 1013904223U;
    light.data()[i] = static_cast<float>(state >> 8) / 16777216.0F;
  }
  return light;
}

// The half u < 20 (panel px), or v < 15, dark.
Image<float> HalfLit(int width, int height, bool columns) {
  Image<float> light(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) light(u, v) = (columns ? u >= width / 2 : v >= height / 2);
  }
  return light;
}

// Where the edge crosses the middle line through each row or column, from the light summed over
// `reach` pixels to both sides of `about`: a lit share of s puts the edge at that share.
template <class PictureAt>
std::vector<double> EdgePositions(const PictureAt& at, double about, bool along_x, int first,
                                  int last) {
  constexpr int kReach = 12;
  const int from = static_cast<int>(about) - kReach;
  std::vector<double> positions;
  for (int row = first; row < last; ++row) {
    double sum = 0;
    for (int i = from; i < from + 2 * kReach; ++i) sum += along_x ? at(i, row) : at(row, i);
    positions.push_back(from + sum);
  }
  return positions;
}

// The straight line through y(i), its values at both ends.
reference::Point2 FittedEnds(const std::vector<double>& y) {
  const double n = static_cast<double>(y.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double x = static_cast<double>(i);
    sx += x;
    sy += y[i];
    sxx += x * x;
    sxy += x * y[i];
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx), start = (sy - slope * sx) / n;
  return {start, start + slope * (n - 1)};
}

class PrototypeAgainstHomography : public testing::TestWithParam<const char*> {};

TEST_P(PrototypeAgainstHomography, SeesTheSameLightWithinAThousandthOfWhite) {
  const ReferenceScene scene = ReferenceSceneOf(GetParam());
  const Image<float> light = Noise(scene.panel.width, scene.panel.height);
  const std::vector<double> exact = reference::RenderPlane(scene.panel, light, scene.camera);
  const Image<Rgb> photograph = ByPrototype(scene, light, kSamples);
  double sum = 0, largest = 0, lit = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double difference = std::abs(static_cast<double>(photograph.data()[i].g) - exact[i]);
    sum += difference;
    largest = std::max(largest, difference);
    lit += exact[i] > 0;
  }
  const double mean = sum / static_cast<double>(exact.size());
  RecordProperty("mean_absolute_difference", std::to_string(mean));
  RecordProperty("largest_difference", std::to_string(largest));
  EXPECT_LT(mean, 1e-3);
  EXPECT_LT(largest, 0.03);
  EXPECT_GT(lit, 0.35 * static_cast<double>(exact.size()));  // the panel is in the picture
}

// Areas are no samples, however few lines of sight are asked for. Within a pixel the tilted panel
// is taken as no nearer at one side, which at so short a focal length is up to 5e-4.
TEST_P(PrototypeAgainstHomography, SeesTheSameLightWhateverTheSamples) {
  const ReferenceScene scene = ReferenceSceneOf(GetParam());
  const Image<float> light = Noise(scene.panel.width, scene.panel.height);
  const std::vector<double> exact = reference::RenderPlane(scene.panel, light, scene.camera);
  const Image<Rgb> photograph = ByPrototype(scene, light, 1);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    ASSERT_NEAR(photograph.data()[i].g, exact[i], 1e-3) << i;
  }
}

TEST_P(PrototypeAgainstHomography, PutsEdgesWithinAHundredthOfAPixel) {
  const ReferenceScene scene = ReferenceSceneOf(GetParam());
  for (const bool columns : {true, false}) {
    const Image<float> light = HalfLit(scene.panel.width, scene.panel.height, columns);
    const std::vector<double> exact = reference::RenderPlane(scene.panel, light, scene.camera);
    const Image<Rgb> photograph = ByPrototype(scene, light, kSamples);
    const auto middle = reference::Mapped(reference::PixelHomography(scene.panel, scene.camera),
                                          scene.panel.width / 2.0, scene.panel.height / 2.0);
    const double about = middle[columns ? 0 : 1];
    const int across = static_cast<int>(middle[columns ? 1 : 0]);
    const auto width = static_cast<std::size_t>(scene.camera.width);
    const auto of_exact = EdgePositions(
        [&](int x, int y) {
          return exact[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
        },
        about, columns, across - 16, across + 16);
    const auto of_photograph =
        EdgePositions([&](int x, int y) { return static_cast<double>(photograph(x, y).g); }, about,
                      columns, across - 16, across + 16);
    const auto expected = FittedEnds(of_exact), actual = FittedEnds(of_photograph);
    RecordProperty(
        columns ? "column_edge_px" : "row_edge_px",
        std::to_string(actual[0] - expected[0]) + " " + std::to_string(actual[1] - expected[1]));
    EXPECT_NEAR(actual[0], expected[0], 0.01) << columns;
    EXPECT_NEAR(actual[1], expected[1], 0.01) << columns;
  }
}

INSTANTIATE_TEST_SUITE_P(Panels, PrototypeAgainstHomography,
                         testing::Values("direct", "mirrored", "tilted"),
                         [](const auto& panel) { return std::string(panel.param); });

// A stack that is tilted, bowed, refracting, behind a plate and a lens that distorts and spreads,
// with patterns on both panels whose pixels are some of the camera's, or stripes, or no pattern on
// one.
class PrototypeLineByLine : public testing::TestWithParam<const char*> {};

Prototype BentStack(const std::string& name) {
  LayerCalibration layer;
  layer.emitter.width_px = 40;
  layer.emitter.height_px = 30;
  layer.emitter.pitch_mm = 0.5;
  layer.modulator = layer.emitter;
  layer.emitter.bow_mm = name == "deep" ? 3 : 0.4;
  layer.emitter.rgb_stripes = name == "stripes";
  layer.emitter.photometry.falloff = name.ends_with("falling_off") ? 3 : 0;
  layer.modulator->bow_mm = -0.3;
  layer.gap_mm = 2;
  layer.index = 1.5;
  layer.rotation_rad = {0.01, -0.02, 0.05};
  layer.plate = Plate{2, 1.5, Eigen::Vector3d(1, 0, 1).normalized()};
  layer.display_from_stack.rotation = AboutAxes(0.1, 0.25, 0.02);
  auto light = std::make_shared<Image<Rgb>>(40, 30);
  auto passing = std::make_shared<Image<float>>(40, 30);
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) {
      (*light)(u, v) = {(u + v) % 2 ? 1.0F : 0.2F, u % 3 ? 0.1F : 0.9F, v < 15 ? 1.0F : 0.0F};
      (*passing)(u, v) = (u / 3 + v / 2) % 2 ? 1.0F : 0.25F;
    }
  }
  Prototype prototype;
  prototype.calibration.layers = {layer};
  prototype.shown = {{{light}, {passing}}};
  const auto white = std::make_shared<Image<Rgb>>(40, 30, Rgb{1, 1, 1});
  const auto open = std::make_shared<Image<float>>(40, 30, 1.0F);
  if (name == "white_falling_off") prototype.shown = {{{white}, {open}}};
  if (name == "slots") prototype.shown = {{{white, light}, {open, passing}}};
  return prototype;
}

TEST_P(PrototypeLineByLine, GathersTheSameLight) {
  const Prototype prototype = BentStack(GetParam());
  PrototypeCamera camera;
  // 20 x 14 pixels about the display's upper left corner.
  camera.camera = {
      CameraModel::kBrown, 20, 14, 290, 290, 31.3, 22.8, {-0.3, 0.2, 0.002, -0.001, 0, 0, 0, 0}};
  camera.camera_from_display.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  camera.camera_from_display.translation = {0, 0, 100};
  camera.blur_px = 0.7;
  const Rigid display_from_camera = Inverse(camera.camera_from_display);
  const Image<Rgb> expected = reference::SpreadPhotograph(
      camera.camera,
      [&](const Eigen::Vector3d& direction) {
        return LightAlong(prototype, display_from_camera.translation,
                          display_from_camera.rotation * direction);
      },
      camera.blur_px);
  const Image<Rgb> photograph = PhotographPrototype(prototype, camera, 64, SilentProgress());
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Rgb difference = photograph.data()[i] - expected.data()[i];
    for (const float d : {difference.r, difference.g, difference.b}) {
      sum += std::abs(static_cast<double>(d));
      largest = std::max(largest, std::abs(static_cast<double>(d)));
    }
  }
  const double mean = sum / (3 * static_cast<double>(expected.size()));
  RecordProperty("mean_absolute_difference", std::to_string(mean));
  RecordProperty("largest_difference", std::to_string(largest));
  // Of a striped pixel a channel is a third as wide and three times as bright: so coarser are the
  // plain way's lines of sight.
  const double coarser = std::string(GetParam()) == "stripes" ? 3 : 1;
  EXPECT_LT(mean, 1.2e-4 * coarser);
  EXPECT_LT(largest, 1.3e-3 * coarser);
}

INSTANTIATE_TEST_SUITE_P(Stacks, PrototypeLineByLine,
                         testing::Values("bowed", "deep", "falling_off", "stripes",
                                         "white_falling_off", "slots"),
                         [](const auto& stack) { return std::string(stack.param); });

}  // namespace
}  // namespace lamella
