// Every effect of the virtual prototype in closed form, one at a time.
#include "datasets_synthetic/prototype.h"

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

using Light = std::function<Rgb(int u, int v)>;

std::shared_ptr<const Image<Rgb>> Emitting(const PanelCalibration& panel, const Light& light) {
  auto image = std::make_shared<Image<Rgb>>(panel.width_px, panel.height_px);
  for (int v = 0; v < panel.height_px; ++v) {
    for (int u = 0; u < panel.width_px; ++u) (*image)(u, v) = light(u, v);
  }
  return image;
}

std::shared_ptr<const Image<float>> Passing(const PanelCalibration& panel,
                                            const std::function<float(int, int)>& share) {
  auto image = std::make_shared<Image<float>>(panel.width_px, panel.height_px);
  for (int v = 0; v < panel.height_px; ++v) {
    for (int u = 0; u < panel.width_px; ++u) (*image)(u, v) = share(u, v);
  }
  return image;
}

Rgb White(int, int) { return {1, 1, 1}; }

// One bare panel of 40 x 30 pixels of 0.5 mm, in z = 0.
Prototype Bare(const Light& light) {
  Prototype prototype;
  LayerCalibration layer;
  layer.emitter.width_px = 40;
  layer.emitter.height_px = 30;
  layer.emitter.pitch_mm = 0.5;
  prototype.calibration.layers = {layer};
  prototype.shown = {{{Emitting(layer.emitter, light)}, {}}};
  return prototype;
}

// Looks straight at the panel from (0, 0, 100): 2 px per panel pixel, 80 x 60 of them.
PrototypeCamera Straight(double z_mm = 100) {
  PrototypeCamera camera;
  camera.camera = {CameraModel::kPinhole, 80, 60, 400, 400, 40, 30, {}};
  camera.camera_from_display.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  camera.camera_from_display.translation = {0, 0, z_mm};
  return camera;
}

Image<Rgb> Photo(const Prototype& prototype, const PrototypeCamera& camera, int samples = 16) {
  return PhotographPrototype(prototype, camera, samples, SilentProgress());
}

// The camera's pixel that sees panel pixel (u, v): its first of 2 x 2.
Rgb At(const Image<Rgb>& photo, int u, int v) { return photo(2 * u, 2 * v); }

TEST(Prototype, ShowsAPanelUpright) {
  const Light light = [](int u, int v) {
    return Rgb{u == 3 ? 1.0F : 0, v == 2 ? 1.0F : 0, u == 39 && v == 29 ? 1.0F : 0};
  };
  const Image<Rgb> photo = Photo(Bare(light), Straight());
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) EXPECT_EQ(At(photo, u, v), light(u, v)) << u << " " << v;
  }
}

TEST(Prototype, FlipsAMirroredPanel) {
  const Light light = [](int u, int v) {
    return Rgb{static_cast<float>(u) / 40, static_cast<float>(v) / 30, 0};
  };
  Prototype prototype = Bare(light);
  prototype.calibration.layers[0].emitter.mirror_x = true;
  const Image<Rgb> photo = Photo(prototype, Straight());
  for (int u = 0; u < 40; ++u) EXPECT_EQ(At(photo, u, 7), light(39 - u, 7));
}

TEST(Prototype, AveragesTimeSlotsAndSumsLayersByTheirGain) {
  Prototype prototype = Bare(White);
  LayerCalibration layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  layer.gain = 0.25;
  layer.display_from_stack.translation.z() = -20;
  prototype.calibration.layers.insert(prototype.calibration.layers.begin(), layer);
  const auto level = [&](float value) {
    return Emitting(layer.emitter, [value](int, int) { return Rgb{value, 0, 0}; });
  };
  const auto open = [&](float value) {
    return Passing(layer.emitter, [value](int, int) { return value; });
  };
  prototype.shown.insert(prototype.shown.begin(),
                         {{level(1), level(0.5F), level(0.25F)}, {open(1), open(0.5F), open(0)}});
  prototype.calibration.layers[1].gain = 0.5;
  const Rgb seen = LightAlong(prototype, {0.1, 0.1, 50}, {0, 0, -1});
  EXPECT_NEAR(seen.r, 0.5 + 0.25 * (1 + 0.25 + 0) / 3, 1e-6);
  EXPECT_NEAR(seen.g, 0.5, 1e-6);
}

// A closed barrier leaks its black level: seen = L ((a/P)^2 + c (1 - (a/P)^2)) of white emitters.
TEST(Prototype, LeaksThroughAClosedModulator) {
  Prototype prototype = Bare(White);
  LayerCalibration& layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  layer.modulator->photometry.black = 1e-3;
  Image<Rgb8> codes(40, 30);
  codes(20, 15) = {255, 255, 255};
  prototype.shown[0].modulator = {
      std::make_shared<Image<float>>(TransmittanceOfModulator(*layer.modulator, codes.span()))};
  const Image<Rgb> photo = Photo(prototype, Straight());
  EXPECT_NEAR(At(photo, 20, 15).g, 1, 1e-6);
  EXPECT_NEAR(At(photo, 3, 5).g, 1e-3, 1e-8);
}

TEST(LightOfEmitter, AppliesCurveBlackAndPrimaries) {
  PanelCalibration panel;
  panel.width_px = 3;
  panel.height_px = 1;
  panel.pitch_mm = 1;
  panel.photometry.curve = {ToneCurve::Kind::kGamma, 2.0, {}};
  panel.photometry.black = 0.01;
  panel.photometry.primaries << 0.8, 0.2, 0, 0.1, 0.9, 0, 0, 0, 0.7;
  Image<Rgb8> codes(3, 1);
  codes(1, 0) = {51, 0, 255};
  codes(2, 0) = {255, 255, 255};
  const Image<Rgb> light = LightOfEmitter(panel, codes.span());
  const auto level = [](double code) { return 0.01 + 0.99 * code * code; };
  EXPECT_NEAR(light(0, 0).r, 0.01, 1e-7);
  EXPECT_NEAR(light(1, 0).r, 0.8 * level(0.2) + 0.2 * level(0), 1e-6);
  EXPECT_NEAR(light(1, 0).g, 0.1 * level(0.2) + 0.9 * level(0), 1e-6);
  EXPECT_NEAR(light(1, 0).b, 0.7, 1e-6);
  EXPECT_NEAR(light(2, 0).r, 1, 1e-6);
  EXPECT_THROW(LightOfEmitter(panel, Image<Rgb8>(2, 1).span()), Error);
}

TEST(LightOfEmitter, IsAsUnevenAsThePanel) {
  PanelCalibration panel;
  panel.width_px = 8;
  panel.height_px = 4;
  panel.pitch_mm = 1;
  panel.photometry.evenness = {2, 2, {1, 0.5, 0.8, 0.6}};
  const Image<Rgb> light = LightOfEmitter(panel, Image<Rgb8>(8, 4, {255, 255, 255}).span());
  EXPECT_NEAR(light(0, 0).r, 1, 1e-6);
  EXPECT_NEAR(light(7, 0).g, 0.5, 1e-6);
  EXPECT_NEAR(light(0, 3).b, 0.8, 1e-6);
  EXPECT_NEAR(light(7, 3).b, 0.6, 1e-6);
  EXPECT_NEAR(light(3, 0).r, 1 - 0.5 * 3 / 8, 1e-6);  // 3/8 of the way between the middles
}

TEST(LightOfEmitter, HandsLightToNeighboursByTheKernel) {
  PanelCalibration panel;
  panel.width_px = 20;
  panel.height_px = 10;
  panel.pitch_mm = 1;
  panel.photometry.crosstalk = {3, {0.01, 0.02, 0.03, 0.04, 0.75, 0.05, 0.03, 0.04, 0.03}};
  Image<Rgb8> codes(20, 10);
  codes(7, 4) = {255, 255, 255};
  const Image<Rgb> light = LightOfEmitter(panel, codes.span());
  float sum = 0;
  for (std::size_t i = 0; i < light.size(); ++i) sum += light.data()[i].r;
  EXPECT_NEAR(sum, 1, 1e-6);
  EXPECT_NEAR(light(7, 4).r, 0.75, 1e-6);
  EXPECT_NEAR(light(8, 4).r, 0.05, 1e-6);  // to the right
  EXPECT_NEAR(light(7, 3).r, 0.02, 1e-6);  // upwards
  EXPECT_NEAR(light(6, 5).r, 0.03, 1e-6);
}

TEST(Prototype, FallsOffWithTheAngle) {
  Prototype prototype = Bare(White);
  prototype.calibration.layers[0].emitter.photometry.falloff = 1.5;
  for (const double slope : {0.0, 0.3, 2.0}) {
    const Rgb seen = LightAlong(prototype, {slope * 50, 0.1, 50}, {-slope, 0, -1});
    EXPECT_NEAR(seen.g, std::pow(1 / std::hypot(1, slope), 1.5), 1e-6);
  }
}

TEST(Prototype, MixesStripesOfAPixel) {
  Prototype prototype = Bare([](int, int) { return Rgb{0.5F, 0.25F, 1}; });
  prototype.calibration.layers[0].emitter.rgb_stripes = true;
  const auto seen = [&](double u) {
    return LightAlong(prototype, {(u - 20) * 0.5, 0.1, 50}, {0, 0, -1});
  };
  EXPECT_EQ(seen(7.1), (Rgb{1.5F, 0, 0}));
  EXPECT_EQ(seen(7.5), (Rgb{0, 0.75F, 0}));
  EXPECT_EQ(seen(7.9), (Rgb{0, 0, 3}));
  // The mean over a pixel is its colour: 2 camera pixels.
  const Image<Rgb> photo = Photo(prototype, Straight(), 1024);
  EXPECT_NEAR((photo(14, 9).r + photo(15, 9).r) / 2, 0.5F, 2e-3F);
}

// The modulator's pixel in front and the emitter behind a spacer, both through the camera.
TEST(Prototype, ShiftsTheEmitterBehindASpacer) {
  Prototype prototype = Bare([](int u, int) { return Rgb{static_cast<float>(u), 0, 0}; });
  LayerCalibration& layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  prototype.shown[0].modulator = {Passing(layer.emitter, [](int, int) { return 1.0F; })};
  layer.gap_mm = 4;
  layer.index = 1.5;
  const double slope = 0.5, sine = slope / std::hypot(1, slope) / 1.5;
  const double x_e = 1.3 - 4 * sine / std::sqrt(1 - sine * sine);
  const Rgb seen = LightAlong(prototype, {1.3 + slope * 80, 0.1, 80}, {-slope, 0, -1});
  EXPECT_EQ(seen.r, std::floor(x_e / 0.5 + 20));
}

TEST(Prototype, DarkensTheCornersBySquareOfTheRadius) {
  PrototypeCamera camera = Straight();
  camera.vignetting = 0.4;
  const Image<Rgb> photo = Photo(Bare(White), camera);
  for (const int x : {1, 39, 70}) {
    for (const int y : {2, 30, 58}) {
      const double r2 = (std::pow(x + 0.5 - 40, 2) + std::pow(y + 0.5 - 30, 2)) / 2500;
      EXPECT_NEAR(photo(x, y).g, 1 - 0.4 * r2, 1e-6);
    }
  }
}

// A lens out of focus spreads a point over a disc of diameter c = A f |1/z_f - 1/z| px, and an edge
// over the disc's integral: nothing beyond c/2, variance of its derivative c^2/16 (and 1/12 of the
// pixel).
TEST(Prototype, BlursAnEdgeByTheDiscOfConfusion) {
  PrototypeCamera camera = Straight();
  camera.aperture_mm = 6;
  camera.focus_mm = 150;
  const double c = 6 * 400 * std::abs(1 / 150.0 - 1 / 100.0);
  const Image<Rgb> photo = Photo(Bare([](int u, int) {
                                   return u >= 20 ? Rgb{1, 1, 1} : Rgb();
                                 }),
                                 camera, 1024);
  double mean = 0, variance = 0;
  for (int x = 25; x < 55; ++x) {
    const double step =
        static_cast<double>(photo(x, 30).g) - static_cast<double>(photo(x - 1, 30).g);
    mean += step * x;  // the step between pixel centres x - 1/2 and x + 1/2 is at x
    variance += step * (x - 40) * (x - 40);
    if (x + 1 < 40 - c / 2) {
      EXPECT_EQ(photo(x, 30).g, 0);
    }
  }
  EXPECT_NEAR(mean, 40, 0.05);
  EXPECT_NEAR(variance, c * c / 16 + 2.0 / 12, 0.02 * c * c / 16);
  camera.focus_mm = 100;
  const Image<Rgb> sharp = Photo(Bare([](int u, int) {
                                   return u >= 20 ? Rgb{1, 1, 1} : Rgb();
                                 }),
                                 camera, 64);
  EXPECT_NEAR(sharp(39, 30).g, 0, 1e-6);
  EXPECT_NEAR(sharp(40, 30).g, 1, 1e-6);
}

// A lens that spreads light: an edge stays where it is, its derivative has the variance of the
// Gaussian, of a pixel and of a difference of pixels, and no light is lost. Of an edge between
// pixels, two half pixels are 1/16 px^2 (of others 1/12).
TEST(Prototype, SpreadsAnEdgeByAGaussian) {
  PrototypeCamera camera = Straight();
  camera.blur_px = 1.3;
  const Image<Rgb> photo = Photo(Bare([](int u, int) {
                                   return u >= 20 ? Rgb{1, 1, 1} : Rgb();
                                 }),
                                 camera, 1);
  double mean = 0, variance = 0;
  for (int x = 30; x < 50; ++x) {
    const double step =
        static_cast<double>(photo(x, 30).g) - static_cast<double>(photo(x - 1, 30).g);
    mean += step * x;  // the step between pixel centres x - 1/2 and x + 1/2 is at x
    variance += step * (x - 40) * (x - 40);
  }
  EXPECT_NEAR(mean, 40, 1e-4);
  EXPECT_NEAR(variance, 1.3 * 1.3 + 2.0 / 16, 0.005);
  double sum = 0;
  camera.blur_px = 4;
  const Image<Rgb> point = Photo(Bare([](int u, int v) {
                                   return u == 20 && v == 15 ? Rgb{1, 1, 1} : Rgb();
                                 }),
                                 camera, 1);
  for (std::size_t i = 0; i < point.size(); ++i) sum += static_cast<double>(point.data()[i].g);
  EXPECT_NEAR(sum, 4, 1e-4);  // of 2 x 2 camera pixels
}

// What follows from a pixel's corners against lines of sight, each traced: a stack that is tilted,
// bowed, refracting and behind a distorting lens.
TEST(Prototype, SeesBetweenAPixelsCornersWhatLinesOfSightSee) {
  Prototype prototype = Bare([](int u, int v) { return Rgb{(u + v) % 2 ? 1.0F : 0.2F, 0.1F, 0}; });
  LayerCalibration& layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  layer.emitter.bow_mm = 0.4;
  layer.gap_mm = 2;
  layer.index = 1.5;
  layer.rotation_rad = {0.01, -0.02, 0.05};
  layer.display_from_stack.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0.2).normalized()));
  prototype.shown[0].modulator = {
      Passing(layer.emitter, [](int u, int v) { return (u / 3 + v / 2) % 2 ? 1.0F : 0.25F; })};
  PrototypeCamera camera = Straight();
  camera.camera.model = CameraModel::kBrown;
  camera.camera.distortion = {-0.3, 0.2, 0.002, -0.001, 0, 0, 0, 0};
  constexpr int kSide = 24;
  const Image<Rgb> photo = Photo(prototype, camera, 1024);
  const Rigid display_from_camera = Inverse(camera.camera_from_display);
  for (const auto& [x, y] : {std::pair(22, 18), {31, 40}, {40, 30}, {55, 21}, {3, 3}}) {
    double sum = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int column = i % kSide, row = i / kSide;
      const auto direction =
          Unproject(camera.camera, {x + (column + 0.5) / kSide, y + (row + 0.5) / kSide});
      const Rgb light = LightAlong(prototype, display_from_camera.translation,
                                   display_from_camera.rotation * *direction);
      sum += static_cast<double>(light.r) / (kSide * kSide);
    }
    EXPECT_NEAR(photo(x, y).r, sum, 0.01) << x << ", " << y;
  }
}

// One lit panel pixel, its centroid where the camera's model projects it.
TEST(Prototype, BendsLinesAsTheLensDoes) {
  PrototypeCamera camera = Straight();
  camera.camera.model = CameraModel::kBrown;
  camera.camera.distortion = {-0.8, 2, 0.01, -0.02, 0, 0, 0, 0};
  for (const int u : {5, 20, 34}) {
    const Image<Rgb> photo = Photo(Bare([u](int i, int j) {
                                     return i == u && j == 4 ? Rgb{1, 1, 1} : Rgb();
                                   }),
                                   camera, 256);
    Vector2d sum(0, 0);
    double total = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 80; ++x) {
        const double g = static_cast<double>(photo(x, y).g);
        sum += g * Vector2d(x + 0.5, y + 0.5);
        total += g;
      }
    }
    // The mean of the pixel's area, since the model is not linear over it.
    Vector2d expected(0, 0);
    double weight = 0;
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        const Vector3d point((u + (i + 0.5) / 8 - 20) * 0.5, (15 - 4 - (j + 0.5) / 8) * 0.5, 0);
        PixelJacobian jacobian;
        const auto pixel = Project(camera.camera, camera.camera_from_display * point, &jacobian);
        const double area = jacobian.point.leftCols<2>().determinant();
        expected += area * *pixel;
        weight += area;
      }
    }
    EXPECT_LT((sum / total - expected / weight).norm(), 0.01) << u;
  }
}

// Planes of a relay: a point of plane k at its own distance, magnified by its own M.
TEST(Prototype, PutsVarifocalPlanesAtTheirDistanceAndSize) {
  Display display;
  display.name = "planes";
  display.width_px = 40;
  display.height_px = 30;
  display.pitch_mm = 0.5;
  display.viewing_distance_mm = 400;
  Layer layer;
  layer.d0_mm = 2;
  layer.optics = LensletArray{LensletArray::Lattice::kSquare, 5, 3, 0, 0, true, 0};
  for (const double z : {-30.0, 0.0, 60.0}) {
    layer.position_mm = z;
    layer.magnification = 1.1 + z / 300;
    display.layers.push_back(layer);
  }
  Prototype prototype;
  prototype.calibration = DesignCalibration(display);
  for (std::size_t k = 0; k < 3; ++k) {
    const PanelCalibration& panel = prototype.calibration.layers[k].emitter;
    prototype.shown.push_back({{Emitting(panel, [](int, int) { return Rgb(); })}, {}});
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const Layer& plane = display.layers[k];
    const double M = plane.magnification;
    // Along the axis of the lens with its centre at column 27.5, row 12.5, in the plane k.
    const Vector3d lens(M * 3.75, M * 1.25, plane.position_mm), eye(20, -10, 400);
    const Vector3d sight = lens - eye;
    const Vector2d slope(sight.x() / sight.z(), sight.y() / sight.z());
    // The emitter: unmagnified gap d0 and slope M s.
    const int u = static_cast<int>(std::floor((3.75 - 2 * M * slope.x()) / 0.5 + 20));
    const int v = static_cast<int>(std::floor(15 - (1.25 - 2 * M * slope.y()) / 0.5));
    Prototype lit = prototype;
    lit.shown[k].emitter = {Emitting(prototype.calibration.layers[k].emitter, [&](int i, int j) {
      return i == u && j == v ? Rgb{1, 1, 1} : Rgb();
    })};
    EXPECT_NEAR(LightAlong(lit, eye, sight).g, 1.0 / 3, 1e-6) << k;
  }
}

// By samples and by areas, of several bands where the lens spreads light.
TEST(Prototype, DoesNotDependOnTheNumberOfThreads) {
  Prototype prototype = Bare([](int u, int v) {
    return Rgb{static_cast<float>(u * v % 7), static_cast<float>(u % 3), static_cast<float>(v % 5)};
  });
  LayerCalibration& layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  layer.gap_mm = 2;
  prototype.shown[0].modulator = {
      Passing(layer.emitter, [](int u, int v) { return static_cast<float>((u + v / 2) % 3) / 2; })};
  for (const double aperture_mm : {0.0, 3.0}) {
    for (const double blur_px : {0.0, 1.5}) {
      PrototypeCamera camera = Straight(101.3);
      camera.camera.height = 300;
      camera.camera.cy = 150;
      camera.aperture_mm = aperture_mm;
      camera.focus_mm = 120;
      camera.blur_px = blur_px;
      std::vector<Image<Rgb>> photos;
      for (const int threads : {1, 2}) {
        const ThreadLimit limit(threads);
        photos.push_back(Photo(prototype, camera));
      }
      for (std::size_t i = 0; i < photos[0].size(); ++i) {
        ASSERT_EQ(photos[0].data()[i], photos[1].data()[i]);
      }
    }
  }
}

// Two panels whose pixels are half of the camera's: areas, not samples.
TEST(Prototype, SumsManyPanelPixelsByAreas) {
  Prototype prototype = Bare([](int u, int v) {
    return Rgb{static_cast<float>(u % 2), static_cast<float>(v % 3) / 2, 1};
  });
  LayerCalibration& layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  layer.gap_mm = 2;
  prototype.shown[0].modulator = {
      Passing(layer.emitter, [](int u, int v) { return static_cast<float>((u + v) % 2); })};
  PrototypeCamera camera = Straight();
  camera.camera = {CameraModel::kPinhole, 20, 15, 97, 97, 10.2, 7.4, {}};
  const Image<Rgb> one = Photo(prototype, camera, 1), many = Photo(prototype, camera, 1024);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one.data()[i], many.data()[i]) << i;
}

TEST(Prototype, StandsExtremes) {
  // From straight to grazing, everything on: there is light, and it is finite.
  Prototype prototype = Bare(White);
  LayerCalibration& layer = prototype.calibration.layers[0];
  layer.modulator = layer.emitter;
  prototype.shown[0].modulator = {Passing(layer.emitter, [](int, int) { return 1.0F; })};
  layer.index = 1.49;
  layer.emitter.bow_mm = 0.5;
  layer.emitter.photometry.falloff = 2;
  layer.plate = Plate{3, 1.5, {0, 0, 1}};
  for (const double gap : {0.0, 5.0}) {
    for (const double degrees : {0.0, 60.0, 80.0, 89.9}) {
      layer.gap_mm = gap;
      const double angle = degrees * std::numbers::pi / 180;
      const Vector3d away(std::sin(angle), 0, std::cos(angle));
      PrototypeCamera camera = Straight();
      camera.camera_from_display.rotation =
          Eigen::Quaterniond::FromTwoVectors(-away, Vector3d::UnitZ());
      camera.camera_from_display.translation =
          -(camera.camera_from_display.rotation * (1000 * away));
      camera.camera.fx = camera.camera.fy = 4000;
      const Image<Rgb> photo = Photo(prototype, camera);
      float most = 0;
      for (std::size_t i = 0; i < photo.size(); ++i) {
        ASSERT_TRUE(std::isfinite(photo.data()[i].g));
        most = std::max(most, photo.data()[i].g);
      }
      // At 89.9 degrees the bow may hide the panel.
      if (degrees < 89) {
        EXPECT_GT(most, 0) << gap << " " << degrees;
      }
    }
  }
  // A panel of one pixel, seen through a gap of nothing.
  Prototype one = Bare(White);
  one.calibration.layers[0].emitter.width_px = one.calibration.layers[0].emitter.height_px = 1;
  one.shown[0].emitter = {Emitting(one.calibration.layers[0].emitter, White)};
  const Image<Rgb> photo = Photo(one, Straight());
  EXPECT_EQ(photo(40, 30).g, 1);
  EXPECT_EQ(photo(42, 30).g, 0);
}

// A barrier's layer behind one with lenses: shows of the one alone, of both and of neither, with
// slots and a sheet of paper, photographed together and one by one.
TEST(Prototype, PhotographsShowsTogetherAsOneByOne) {
  const Light light = [](int u, int v) {
    return Rgb{u % 3 == 0 ? 1.0F : 0.1F, v % 4 == 0 ? 0.7F : 0, static_cast<float>(u + v) / 70};
  };
  Prototype prototype = Bare(light);
  LayerCalibration lenses = prototype.calibration.layers[0];
  lenses.gap_mm = 3;
  lenses.lattice = LensLattice{};
  lenses.lattice->type = LensLattice::Type::kSquare;
  lenses.lattice->pitch_mm = 2.6;
  lenses.lattice->focal_mm = 3;
  LayerCalibration barrier = prototype.calibration.layers[0];
  barrier.modulator = barrier.emitter;
  barrier.gap_mm = 4;
  barrier.display_from_stack.translation = {0.3, -0.2, -10};
  prototype.calibration.layers = {barrier, lenses};
  const ShownLayer dark_barrier{{Emitting(barrier.emitter, [](int, int) { return Rgb(); })},
                                {Passing(barrier.emitter, [](int, int) { return 1.0F; })}};
  const ShownLayer lit_barrier{
      {Emitting(barrier.emitter, light), Emitting(barrier.emitter, White)},
      {Passing(barrier.emitter, [](int u, int) { return u % 6 < 2 ? 1.0F : 0; }),
       Passing(barrier.emitter, [](int u, int) { return u % 6 < 2 ? 0 : 1.0F; })}};
  const ShownLayer dark{{dark_barrier.emitter}, {}}, lit{{Emitting(lenses.emitter, light)}, {}};
  auto paper = std::make_shared<Image<Rgb>>(4, 4);
  (*paper)(1, 2) = {0.5F, 1, 0.2F};
  PrintedSheet sheet{{}, 0.7, paper};
  sheet.display_from_sheet.translation = {5, 2, 3};
  const std::vector<Show> shows = {{{dark_barrier, dark}},
                                   {{lit_barrier, dark}},
                                   {{dark_barrier, lit}, sheet},
                                   {{lit_barrier, lit}},
                                   {{lit_barrier, dark}, sheet}};
  PrototypeCamera camera = Straight();
  camera.camera_from_display.translation = {2, 1, 100};
  for (const double blur_px : {0.0, 0.8}) {
    camera.blur_px = blur_px;
    const std::vector<Image<Rgb>> together =
        PhotographShows(prototype.calibration, shows, camera, 16, SilentProgress());
    ASSERT_EQ(together.size(), shows.size());
    for (std::size_t i = 0; i < shows.size(); ++i) {
      prototype.shown = shows[i].layers;
      prototype.sheet = shows[i].sheet;
      const Image<Rgb> alone = Photo(prototype, camera);
      EXPECT_TRUE(std::equal(alone.data(), alone.data() + alone.size(), together[i].data())) << i;
      const bool any = std::any_of(alone.data(), alone.data() + alone.size(),
                                   [](const Rgb& pixel) { return !(pixel == Rgb()); });
      EXPECT_EQ(any, i > 0) << i;
    }
  }
}

TEST(Prototype, RefusesWithOneLine) {
  const auto refusal = [](const Prototype& prototype, const PrototypeCamera& camera) {
    try {
      Photo(prototype, camera);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal(Bare(White), Straight()), "accepted");
  EXPECT_THAT(refusal(Bare(White), Straight(-100)), HasSubstr("is not in front of layer 0"));
  EXPECT_THAT(refusal(Bare(White), Straight(0)), HasSubstr("is not in front of layer 0"));
  PrototypeCamera camera = Straight();
  camera.aperture_mm = 1;
  EXPECT_THAT(refusal(Bare(White), camera), HasSubstr("no focus distance"));
  Prototype prototype = Bare(White);
  prototype.shown[0].emitter.clear();
  EXPECT_THAT(refusal(prototype, Straight()), HasSubstr("0 emitter"));
  prototype = Bare(White);
  prototype.calibration.layers[0].emitter.width_px = 41;
  EXPECT_THAT(refusal(prototype, Straight()), HasSubstr("not its panel's size"));
  prototype.shown.clear();
  EXPECT_THAT(refusal(prototype, Straight()), HasSubstr("0 layers are shown"));
}

}  // namespace
}  // namespace lamella
