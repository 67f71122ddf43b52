// The closed loop of a calibration: layers made for where a misaligned prototype's panels stand,
// shown on it and looked at from new positions, against the scene itself. Beside it: what it shows
// without, and with the usual remedy, a layer's finished pictures warped by one homography. Where
// the panels stand is known exactly, or from photographs. At the size of the paper's panels, 20 mm
// and 5 degrees off, in minutes:
//   LAMELLA_FULL_SIZE=1 build/release/tests/pipeline_test --gtest_filter='CalibratedDisplay.*'
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/SVD>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/panel_rays.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/solve_photos.h"
#include "pipeline/synth_photos.h"
#include "tests/pipeline/prototype_view.h"
#include "tests/reference/analytic_scene.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kViewerMm = 600;

// Of paper-two-layer's panel to each side: all of it where LAMELLA_FULL_SIZE is set, for a run of
// its own; else a part that is small and quick.
int Size(int small_size, int full_size) {
  return std::getenv("LAMELLA_FULL_SIZE") != nullptr ? full_size : small_size;
}

// paper-two-layer with fewer pixels: the back layer seen in a mirror.
Display TwoLayers(int width_px, int height_px) {
  Display display;
  display.name = "small";
  display.width_px = width_px;
  display.height_px = height_px;
  display.pitch_mm = 0.3113158871666749;
  display.viewing_distance_mm = kViewerMm;
  display.border_mm = 4;
  display.layers.resize(2);
  display.layers[0].position_mm = -10;
  display.layers[0].mirror_x = true;
  display.layers[1].position_mm = 10;
  return display;
}

// Each layer up to `size` mm and degrees from its place, gaps from 3 to 10 mm, sizes half a percent
// off, panels of a layer askew and bowed.
Calibration Misaligned(const Display& display, std::uint32_t seed, double size_mm,
                       double size_deg) {
  Calibration calibration = DesignCalibration(display);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  for (LayerCalibration& layer : calibration.layers) {
    const auto degrees = [&](double most) { return most * M_PI / 180 * number(random); };
    // One number after the other: of arguments, compilers choose the order.
    Vector3d turn, shift;
    for (const int axis : {2, 1, 0}) turn(axis) = degrees(axis == 2 ? size_deg : size_deg / 2);
    for (const int axis : {2, 1, 0}) shift(axis) = (axis == 2 ? 0.4 : 1) * number(random);
    layer.display_from_stack.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    layer.display_from_stack.translation += size_mm * shift;
    layer.index = 1.49;
    layer.gap_mm = 6.5 + 3.5 * number(random);
    layer.offset_mm = {3 * number(random), 3 * number(random)};
    layer.rotation_rad = {degrees(0.3), degrees(0.3), degrees(size_deg)};
    for (PanelCalibration* panel : {&layer.emitter, &*layer.modulator}) {
      panel->scale = 0.005 * number(random);
      panel->bow_mm = 0.1 * number(random);
    }
  }
  return calibration;
}

// Smooth light at one depth, off the layers so that it moves from eye to eye: without silhouettes,
// whose halo is the display's own and not its misalignment's.
AnalyticScene SceneAt(double z) {
  const auto waves = [](double x, double y) {
    const double a = std::cos(2 * M_PI * 0.05 * (0.8 * x + 0.6 * y) + 1);
    const double b = std::cos(2 * M_PI * 0.05 * (0.3 * x - 0.7 * y) + 2);
    return Rgb{static_cast<float>(0.5 + 0.22 * (a + b)), static_cast<float>(0.5 + 0.45 * a),
               static_cast<float>(0.5 + 0.45 * b)};
  };
  AnalyticScene scene;
  scene.rectangles = {{z, -1e6, 1e6, -1e6, 1e6, waves}};
  return scene;
}

std::vector<Eye> NewPositions() {
  std::vector<Eye> eyes;
  for (const auto& [x, y] :
       {std::pair(0.0, 0.0), {-31.0, 12.0}, {27.0, -19.0}, {13.0, 33.0}, {-22.0, -28.0}}) {
    Eye eye;
    eye.position = {x, y, kViewerMm};
    eye.pixel_mm = 0.9;
    eye.width = Size(26, 312);
    eye.height = Size(18, 162);
    eye.left_mm = -eye.width * eye.pixel_mm / 2;
    eye.top_mm = eye.height * eye.pixel_mm / 2;
    eyes.push_back(eye);
  }
  return eyes;
}

Image<Rgb> SceneSeen(const AnalyticScene& scene, const Eye& eye) {
  constexpr int kSplit = 4;
  const RayBundle bundle = BundleOfEye(eye, kSplit);
  Image<RaySample> samples(bundle.width, bundle.height);
  scene.Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
  Image<Rgb> seen(eye.width, eye.height);
  for (int y = 0; y < bundle.height; ++y) {
    for (int x = 0; x < bundle.width; ++x) {
      seen(x / kSplit, y / kSplit) += (1.0F / (kSplit * kSplit)) * samples(x, y).color;
    }
  }
  return seen;
}

// Root of the mean square of what the eyes see beside the scene, linear, white 1.
double ViewError(const Prototype& prototype, const AnalyticScene& scene, double brightness) {
  double sum = 0, count = 0;
  for (const Eye& eye : NewPositions()) {
    const Image<Rgb> truth = SceneSeen(scene, eye);
    const Image<Rgb> shown = PhotographPrototype(prototype, CameraOf(eye), 32, SilentProgress());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Rgb difference = static_cast<float>(1 / brightness) * shown.data()[i] - truth.data()[i];
      sum += static_cast<double>(difference.r * difference.r + difference.g * difference.g +
                                 difference.b * difference.b);
      count += 3;
    }
  }
  return std::sqrt(sum / count);
}

// The homography that sends `from` to `to` with the least algebraic error, of coordinates about the
// panel's size.
Matrix3d FitHomography(const std::vector<Vector2d>& from, const std::vector<Vector2d>& to,
                       double size) {
  Eigen::MatrixXd equations(2 * static_cast<Eigen::Index>(from.size()), 9);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vector3d p = (from[i] / size).homogeneous();
    const Vector2d q = to[i] / size;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    equations.row(row) << p.transpose(), 0, 0, 0, -q.x() * p.transpose();
    equations.row(row + 1) << 0, 0, 0, p.transpose(), -q.y() * p.transpose();
  }
  const Eigen::VectorXd h =
      Eigen::JacobiSVD<Eigen::MatrixXd>(equations, Eigen::ComputeThinV).matrixV().col(8);
  Matrix3d fitted;
  fitted << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  const Matrix3d scale = Vector3d(size, size, 1).asDiagonal();
  return scale * fitted * scale.inverse();
}

// Each pixel shows what the picture has where the homography sends it, interpolated.
template <class Pixel>
std::shared_ptr<const Image<Pixel>> Warped(const Image<Pixel>& picture,
                                           const Matrix3d& homography) {
  auto warped = std::make_shared<Image<Pixel>>(picture.width(), picture.height());
  const auto at = [&](int x, int y) {
    return x < 0 || y < 0 || x >= picture.width() || y >= picture.height() ? Pixel()
                                                                           : picture(x, y);
  };
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Vector2d p = (homography * Vector3d(x + 0.5, y + 0.5, 1)).hnormalized();
      const int left = static_cast<int>(std::floor(p.x() - 0.5));
      const int top = static_cast<int>(std::floor(p.y() - 0.5));
      const auto s = static_cast<float>(p.x() - 0.5 - left);
      const auto t = static_cast<float>(p.y() - 0.5 - top);
      (*warped)(x, y) = (1 - t) * ((1 - s) * at(left, top) + s * at(left + 1, top)) +
                        t * ((1 - s) * at(left, top + 1) + s * at(left + 1, top + 1));
    }
  }
  return warped;
}

// Warps a layer's finished pictures so that from the middle of the eye box its modulator's pixels
// are seen where the design has them; with `each_panel` its emitter's by a homography of their own.
Prototype WarpedByHomographies(Prototype prototype, const Display& display, bool each_panel) {
  const Calibration design = DesignCalibration(display);
  const Vector3d viewer(0, 0, kViewerMm);
  for (std::size_t l = 0; l < prototype.shown.size(); ++l) {
    const LayerSights real(prototype.calibration.layers[l]), ideal(design.layers[l]);
    std::array<std::vector<Vector2d>, 4> pixels;  // emitter, its ideal, modulator, its ideal
    for (int i = -8; i <= 8; ++i) {
      for (int j = -8; j <= 8; ++j) {
        const Vector3d direction = Vector3d(Size(2, 24) * i, Size(3, 27) * j / 2.0, 0) - viewer;
        const auto at = real.Seen(viewer, direction), should = ideal.Seen(viewer, direction);
        pixels[0].push_back(at->emitter);
        pixels[1].push_back(should->emitter);
        pixels[2].push_back(at->modulator);
        pixels[3].push_back(should->modulator);
      }
    }
    const Matrix3d modulator = FitHomography(pixels[2], pixels[3], display.width_px);
    const Matrix3d emitter =
        each_panel ? FitHomography(pixels[0], pixels[1], display.width_px) : modulator;
    for (auto& image : prototype.shown[l].emitter) image = Warped(*image, emitter);
    for (auto& image : prototype.shown[l].modulator) image = Warped(*image, modulator);
  }
  return prototype;
}

struct Errors {
  double corrected = 0, uncorrected = 0, per_layer = 0, per_panel = 0;
};

// Of a prototype that is `real`, as far as it is `known`.
Errors ErrorsOf(const Display& display, const Calibration& real, const Calibration& known) {
  const double brightness = Brightness(display, display.layers[0]);
  Errors errors;
  for (const double z : {-17.0, 17.0}) {
    const AnalyticScene scene = SceneAt(z);
    const LayerImages as_designed = Distribute(scene, display, LayersOptions(), SilentProgress());
    const LayerImages corrected =
        Distribute(scene, display, LayersOptions(), SilentProgress(), &known);
    errors.corrected += ViewError(Showing(display, real, corrected), scene, brightness) / 2;
    const Prototype uncorrected = Showing(display, real, as_designed);
    errors.uncorrected += ViewError(uncorrected, scene, brightness) / 2;
    const auto warped = [&](bool each_panel) {
      return ViewError(WarpedByHomographies(uncorrected, display, each_panel), scene, brightness);
    };
    errors.per_layer += warped(false) / 2;
    errors.per_panel += warped(true) / 2;
  }
  return errors;
}

void ExpectMuchSmaller(const Errors& errors) {
  const std::string figures = fmt::format(
      "corrected {:.5f} uncorrected {:.5f} a homography per layer {:.5f} per panel {:.5f}",
      errors.corrected, errors.uncorrected, errors.per_layer, errors.per_panel);
  testing::Test::RecordProperty("view_error", figures);
  fmt::print("view error: {}\n", figures);
  EXPECT_LT(10 * errors.corrected, errors.uncorrected) << figures;
  EXPECT_LT(3 * errors.corrected, errors.per_layer) << figures;
}

TEST(CalibratedDisplay, ShowsTheSceneFromNewPositionsThoughItsPanelsStandAskew) {
  const Display display = TwoLayers(Size(160, 1920), Size(120, 1080));
  const Calibration real = Misaligned(display, 1, Size(6, 20), Size(3, 5));
  ExpectMuchSmaller(ErrorsOf(display, real, real));
}

// The calibration that photographs of boards on the panels give, from 12 positions.
Calibration FromPhotographs(const Display& display, const Calibration& real) {
  const std::filesystem::path folder = ScratchFolder();
  const Calibration design = DesignCalibration(display);
  WritePatterns(folder / "patterns", PlanShots(design, CalibrationMode::kQuick), SilentProgress());
  WriteTextAtomically(folder / "patterns" / kPatternsDisplay, ToToml(display));
  SaveCalibration(folder / "truth.json", real);
  SynthPhotosOptions photos;
  photos.misalignment = (folder / "truth.json").string();
  photos.shots = (folder / "patterns/shots.json").string();
  photos.views = 12;
  photos.distance_mm = 1.75 * display.width_mm();
  photos.width_px = Size(960, 2736);
  photos.k1 = -0.08;
  photos.blur_px = 1;
  photos.samples = Size(8, 64);
  photos.full_well_e = 3500;
  photos.read_noise_e = 2;
  SynthPhotos(photos, folder / "taken", SilentProgress());
  const SolvedPhotos solved =
      SolvePhotos({folder / "patterns", folder / "taken/images", {}}, SilentProgress());
  EXPECT_TRUE(solved.report.accepted());
  return solved.report.calibration;
}

// The world of a calibration is that of its reference panel: it stands where it is designed to.
TEST(CalibratedDisplay, ShowsTheSceneByAsMuchAsPhotographsTell) {
  Display display = TwoLayers(Size(480, 1920), Size(270, 1080));
  for (Layer& layer : display.layers) layer.index = 1.49;
  Calibration real = Misaligned(display, 1, 20, 5);
  real.layers[1].display_from_stack = DesignCalibration(display).layers[1].display_from_stack;
  real.layers[1].modulator->scale = 0;
  ExpectMuchSmaller(ErrorsOf(display, real, FromPhotographs(display, real)));
}

}  // namespace
}  // namespace lamella
