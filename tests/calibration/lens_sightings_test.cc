// Lenses found in what a camera's pixels see of the panel behind them: lines of sight of
// lightfield/panel_rays.h, pixel by pixel, against where the camera sees the lenses' centres.
#include "calibration/lens_sightings.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lightfield/camera.h"
#include "lightfield/display.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A plane of lenses, magnified and turned a little, and its design.
struct Sheet {
  LayerCalibration design, truth;
};

Sheet SheetOf(int width_px, int height_px, bool mirrored,
              LensletArray::Lattice lattice = LensletArray::Lattice::kHexagonal) {
  Display display;
  display.width_px = width_px;
  display.height_px = height_px;
  display.pitch_mm = 0.32;
  display.viewing_distance_mm = 400;
  Layer layer;
  layer.d0_mm = 5.8;
  layer.mirror_x = mirrored;
  LensletArray lenses;
  lenses.lattice = lattice;
  layer.optics = lenses;
  display.layers = {layer};
  Sheet sheet{DesignCalibration(display).layers[0], {}};
  sheet.truth = sheet.design;
  sheet.truth.emitter.scale = 0.01;
  sheet.truth.lattice->pitch_mm *= 1.01;
  sheet.truth.gap_mm *= 1.01 * 1.01;
  sheet.truth.display_from_stack.rotation =
      Eigen::AngleAxisd(0.02, Vector3d(0.3, 0.5, 1).normalized());
  sheet.truth.display_from_stack.translation = {1, -2, 3};
  return sheet;
}

Camera CameraFor(int width, double focal) {
  Camera camera;
  camera.width = width;
  camera.height = width * 4 / 5;
  camera.fx = camera.fy = focal;
  camera.cx = width / 2.0;
  camera.cy = camera.height / 2.0;
  return camera;
}

// From 4 mm to the right, 420 mm away, looking along -z.
Rigid Pose() {
  Rigid pose;
  pose.rotation = Eigen::AngleAxisd(std::acos(-1.0), Vector3d::UnitX());
  pose.translation = -(pose.rotation * Vector3d(4, -3, 420));
  return pose;
}

constexpr double kBlurPx = 0.7;

// Along its rows, an image of `fine` samples a pixel as pixels of their area see it through a lens
// of that blur; turned, so that twice is both axes.
Image<std::complex<float>> PixelsAlongRows(const Image<std::complex<float>>& samples, int fine) {
  const int radius = static_cast<int>(4 * kBlurPx * fine) + fine / 2;
  std::vector<float> kernel;  // from half a sample right of the pixel's centre
  for (int k = -radius; k < radius; ++k) {
    const auto up_to = [&](double x) { return std::erf(x / (fine * kBlurPx * std::sqrt(2.0))); };
    kernel.push_back(static_cast<float>(up_to(k + 0.5 + 0.5 * fine) - up_to(k + 0.5 - 0.5 * fine)) /
                     (2 * static_cast<float>(fine)));
  }
  Image<std::complex<float>> pixels(samples.height(), samples.width() / fine);
  for (int y = 0; y < samples.height(); ++y) {
    for (int x = 0; x < pixels.height(); ++x) {
      int from = fine * x + fine / 2 - radius;
      for (const float weight : kernel) {
        pixels(y, x) += weight * samples(std::clamp(from++, 0, samples.width() - 1), y);
      }
    }
  }
  return pixels;
}

// The sinusoid of one axis and period; `seen` are samples, an even number a pixel.
Image<std::complex<float>> SinusoidOf(const Image<Vector2d>& seen, int fine, int axis,
                                      double period_px) {
  Image<std::complex<float>> samples(seen.width(), seen.height());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double phase = 2 * std::acos(-1.0) * seen.data()[i][axis] / period_px;
    samples.data()[i] = std::complex<float>(std::polar(0.1, phase));
  }
  return PixelsAlongRows(PixelsAlongRows(samples, fine), fine);
}

// Straight in front of the sheet, this far away.
Rigid Straight(double distance_mm) {
  Rigid pose;
  pose.rotation = Eigen::AngleAxisd(std::acos(-1.0), Vector3d::UnitX());
  pose.translation = -(pose.rotation * Vector3d(0, 0, distance_mm));
  return pose;
}

// What every pixel sees; pixels at seams between lenses, which see two, are not known.
ScreenMap MapOf(const LayerCalibration& layer, const Camera& camera, const Rigid& pose,
                int fine = 4) {
  const int width = camera.width, height = camera.height;
  ScreenMap map{
      {width, height}, {width, height}, {width, height}, {width, height}, {width, height}};
  const LayerSights sights(layer);
  const auto seen = [&](double x, double y) {
    const auto direction = Unproject(camera, {x, y});
    return sights.Seen(Centre(pose), pose.rotation.inverse() * *direction)->emitter;
  };
  const auto inside = [&](const Vector2d& at) {
    return at.minCoeff() >= 0 && at.x() < layer.emitter.width_px &&
           at.y() < layer.emitter.height_px;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vector2d middle = seen(x + 0.5, y + 0.5);
      bool whole = inside(middle);
      for (const int below : {0, 1}) {
        for (const int right : {0, 1}) {
          whole = whole && (seen(x + right, y + below) - middle).norm() < 2;
        }
      }
      map.u_px(x, y) = static_cast<float>(middle.x());
      map.v_px(x, y) = static_cast<float>(middle.y());
      map.valid(x, y) = whole ? 1 : 0;
    }
  }
  Image<Vector2d> samples(fine * width, fine * height);
  for (int y = 0; y < samples.height(); ++y) {
    for (int x = 0; x < samples.width(); ++x) {
      samples(x, y) = seen((x + 0.5) / fine, (y + 0.5) / fine);
    }
  }
  for (const int axis : {0, 1}) {
    for (const int period : {16, 128}) {
      map.sinusoids.push_back(SinusoidOf(samples, fine, axis, period));
    }
  }
  return map;
}

// Where the camera sees a lens that is at a pixel of the designed panel.
Vector2d TruePixel(const Sheet& sheet, const Vector2d& pixel, const Camera& camera,
                   const Rigid& pose) {
  const Vector3d at = PanelPoint(sheet.truth.emitter, pixel);
  return *Project(camera, pose * (sheet.truth.display_from_stack * at));
}

struct Errors {
  double rms_px = 0, normalised = 0;
};

Errors ErrorsOf(const std::vector<Observation>& points, const Sheet& sheet, const Camera& camera,
                const Rigid& pose) {
  Errors errors;
  for (const Observation& point : points) {
    const Vector2d off = point.image_px - TruePixel(sheet, point.panel_px, camera, pose);
    errors.rms_px += off.squaredNorm() / 2;
    errors.normalised += off.squaredNorm() / 2 / point.covariance_px2(0, 0);
  }
  const auto num = static_cast<double>(points.size());
  return {std::sqrt(errors.rms_px / num), errors.normalised / num};
}

TEST(LensSightings, AreWhereTheCameraSeesTheLenses) {
  for (const bool mirrored : {false, true}) {
    const Sheet sheet = SheetOf(156, 124, mirrored);
    const Camera camera = CameraFor(230, 1500);
    const ScreenMap map = MapOf(sheet.truth, camera, Pose());
    const auto points = ObserveLenses(map, sheet.design.emitter, *sheet.design.lattice);
    EXPECT_GT(points.size(), 55U);
    const Errors errors = ErrorsOf(points, sheet, camera, Pose());
    EXPECT_LT(errors.rms_px, 0.015);
    EXPECT_GT(errors.normalised, 0.7);
    EXPECT_LT(errors.normalised, 1.4);
  }
}

TEST(LensSightings, OfManyAreMeansOfThoseAround) {
  const Sheet sheet = SheetOf(468, 372, false);
  const Camera camera = CameraFor(520, 1200);
  ScreenMap map = MapOf(sheet.truth, camera, Pose());
  std::mt19937 random(2);
  std::normal_distribution<float> noise(0, 0.004F);  // of sinusoids of 0.1
  for (Image<std::complex<float>>& sinusoid : map.sinusoids) {
    for (std::size_t i = 0; i < sinusoid.size(); ++i) {
      sinusoid.data()[i] += std::complex<float>(noise(random), noise(random));
    }
  }
  const auto points = ObserveLenses(map, sheet.design.emitter, *sheet.design.lattice);
  EXPECT_GT(points.size(), 25U);
  EXPECT_LT(points.size(), 120U);
  const Errors errors = ErrorsOf(points, sheet, camera, Pose());
  EXPECT_LT(errors.rms_px, 0.015);
  EXPECT_GT(errors.normalised, 0.6);
  EXPECT_LT(errors.normalised, 1.5);
  // Wrong fringes in one pixel of a hundred do not make it another lens's.
  for (std::size_t i = 0; i < map.u_px.size(); ++i) {
    if (random() % 100 == 0) map.u_px.data()[i] += 16;
  }
  const auto robust = ObserveLenses(map, sheet.design.emitter, *sheet.design.lattice);
  EXPECT_LT(ErrorsOf(robust, sheet, camera, Pose()).rms_px, 0.015);
}

// Lenses as wide as a whole number of pixels, nearly: from one to the next their middles hardly
// move between pixels, so that what the pixels' grid does to them is not an error that averages.
TEST(LensSightings, DoNotBeatWithThePixels) {
  const Rigid pose = Straight(400);
  for (const auto& [width_px, lattice] : {std::pair{6.02, LensletArray::Lattice::kHexagonal},
                                          std::pair{6.2, LensletArray::Lattice::kHexagonal},
                                          std::pair{6.02, LensletArray::Lattice::kSquare}}) {
    const Sheet sheet = SheetOf(234, 186, false, lattice);
    const Camera camera = CameraFor(130, width_px * 400 / sheet.truth.lattice->pitch_mm);
    const ScreenMap map = MapOf(sheet.truth, camera, pose, 8);
    const auto points = ObserveLenses(map, sheet.design.emitter, *sheet.design.lattice);
    EXPECT_GT(points.size(), 150U) << width_px;
    const Errors errors = ErrorsOf(points, sheet, camera, pose);
    // At corners of square lenses four shares are not told apart by what is seen. The middles of
    // whole pixels are 0.13 and 0.25 px off.
    const double most_px = lattice == LensletArray::Lattice::kSquare ? 0.035 : 0.01;
    EXPECT_LT(errors.rms_px, most_px) << width_px;
    EXPECT_LT(errors.normalised, 2) << width_px;
  }
}

TEST(LensSightings, NeedLenses) {
  const Sheet sheet = SheetOf(156, 124, false);
  const Camera camera = CameraFor(230, 1500);
  ScreenMap map = MapOf(sheet.truth, camera, Pose());
  for (std::size_t i = 0; i < map.valid.size(); ++i) map.valid.data()[i] = 0;
  EXPECT_TRUE(ObserveLenses(map, sheet.design.emitter, *sheet.design.lattice).empty());
}

// Of a panel that is seen without lenses, coarsely: by every lens three of its pixels, none of
// which is near the median of both axes.
TEST(LensSightings, AreNoneWhereNoPixelsAgree) {
  const Sheet sheet = SheetOf(156, 124, false);
  ScreenMap map = MapOf(sheet.truth, CameraFor(230, 1500), Pose());
  for (std::size_t i = 0; i < map.valid.size(); ++i) map.valid.data()[i] = 0;
  std::set<std::pair<long, long>> lenses;
  for (int v = 8; v < 116; ++v) {
    for (int u = 8; u < 148; ++u) {
      const Vector2d at = PanelPoint(sheet.design.emitter, {u, v}).head<2>();
      const auto middle = PanelPixel(sheet.design.emitter, NearestLens(*sheet.design.lattice, at));
      if (middle) lenses.emplace(std::lround(middle->x()), std::lround(middle->y()));
    }
  }
  std::size_t next = 0;
  for (const auto& [u, v] : lenses) {
    for (const auto& [du, dv] : {std::pair{-4, 0}, {0, 4}, {4, 0}}) {
      map.u_px.data()[next] = static_cast<float>(u + du);
      map.v_px.data()[next] = static_cast<float>(v + dv);
      map.valid.data()[next++] = 1;
    }
  }
  EXPECT_GT(lenses.size(), 50U);
  EXPECT_TRUE(ObserveLenses(map, sheet.design.emitter, *sheet.design.lattice).empty());
}

}  // namespace
}  // namespace lamella
