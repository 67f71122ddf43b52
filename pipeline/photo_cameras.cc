#include "pipeline/photo_cameras.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include <fmt/format.h>

#include "datasets_synthetic/cameras.h"
#include "lightfield/error.h"
#include "pipeline/capture/transforms_json.h"

namespace lamella {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

// "A,B,C": so many finite numbers.
std::vector<double> NumbersOf(const std::string& text, std::size_t count, const char* flag,
                              const char* form) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (std::string part; std::getline(stream, part, ',');) {
    std::istringstream number(part);
    double value = 0;
    if (!(number >> value) || !(number >> std::ws).eof() || !std::isfinite(value)) {
      numbers.clear();
      break;
    }
    numbers.push_back(value);
  }
  if (numbers.size() != count) {
    throw UsageError(flag, fmt::format("\"{}\" is not {}", text, form),
                     fmt::format("give {}", form));
  }
  return numbers;
}

const PanelCalibration& PanelOf(const Calibration& calibration) {
  return calibration.layers.front().emitter;
}

// A sensor parallel to z = 0 whose pixels are a raster on that plane, as a view camera with a
// shifted lens has it: the picture is what SimulateEye calls an eye's.
View EyeView(const SynthPhotosOptions& options, const Calibration& calibration,
             const Eigen::Vector3d& eye, int number) {
  const PanelCalibration& panel = PanelOf(calibration);
  double pixel = panel.pitch_mm, left = -panel.width_px * pixel / 2;
  double top = panel.height_px * pixel / 2;
  View view;
  view.camera.width = panel.width_px;
  view.camera.height = panel.height_px;
  if (!options.raster.empty()) {
    const char* form = "LEFT,TOP,PIXEL,WIDTH,HEIGHT";
    const std::vector<double> raster = NumbersOf(options.raster, 5, "--raster", form);
    left = raster[0];
    top = raster[1];
    pixel = raster[2];
    if (!(pixel > 0 && raster[3] >= 1 && raster[4] >= 1 && raster[3] <= 65536 &&
          raster[4] <= 65536)) {
      throw UsageError("--raster", "has a size that is not above 0", fmt::format("give {}", form));
    }
    view.camera.width = static_cast<int>(raster[3]);
    view.camera.height = static_cast<int>(raster[4]);
  }
  if (!(eye.z() > 0)) {
    throw UsageError("--eyes", fmt::format("{:g} mm is not in front of z = 0", eye.z()),
                     "give a positive Z");
  }
  view.camera.fx = view.camera.fy = eye.z() / pixel;
  view.camera.cx = (eye.x() - left) / pixel;
  view.camera.cy = (top - eye.y()) / pixel;
  view.camera_from_world.rotation = Eigen::Quaterniond(0, 1, 0, 0);  // y and z change sign
  view.camera_from_world.translation = -(view.camera_from_world.rotation * eye);
  view.name = fmt::format("eye_{:03}", number);
  return view;
}

std::vector<View> EyeViews(const SynthPhotosOptions& options, const Calibration& calibration) {
  std::vector<View> views;
  std::istringstream list(options.eyes);
  for (std::string item; std::getline(list, item, ';');) {
    const std::vector<double> at = NumbersOf(item, 3, "--eyes", "X,Y,Z in mm");
    views.push_back(
        EyeView(options, calibration, {at[0], at[1], at[2]}, static_cast<int>(views.size()) + 1));
  }
  return views;
}

// Two rings, the second with a third of the tilt; distances vary by 12 %, rolls are 0, 90, 180
// degrees. The panel's width fits into the picture's height with a tenth to spare at the nearest.
std::vector<View> RingViews(const SynthPhotosOptions& options, const Calibration& calibration) {
  const PanelCalibration& panel = PanelOf(calibration);
  const double longer = panel.pitch_mm * std::max(panel.width_px, panel.height_px);
  std::vector<View> views;
  for (int i = 0; i < options.views; ++i) {
    const double distance = options.distance_mm * (1 + 0.12 * (i % 3 - 1));
    const double tilt = options.tilt_deg / (i % 2 == 0 ? 1 : 3) * kRadians;
    const int place = i / 2, places = std::max(1, (options.views + 1) / 2);  // on its ring
    const double azimuth = 2 * std::numbers::pi * place / places + (i % 2 == 0 ? 0.0 : 0.5);
    const double roll = 90.0 * (place % 3) * kRadians;
    View view;
    view.name = fmt::format("view_{:03}", i + 1);
    Camera& camera = view.camera;
    camera.width = options.width_px;
    camera.height = (2 * options.width_px + 1) / 3;
    camera.fx = camera.fy = 0.9 * camera.height * 0.88 * options.distance_mm / longer;
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
    if (options.k1 != 0) {
      camera.model = CameraModel::kBrown;
      camera.distortion[0] = options.k1;
    }
    const Eigen::Vector3d centre =
        distance * Eigen::Vector3d(std::sin(tilt) * std::cos(azimuth),
                                   std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
    view.camera_from_world = LookAt(centre, {0, 0, 0}, {std::sin(roll), std::cos(roll), 0});
    views.push_back(view);
  }
  return views;
}

}  // namespace

std::vector<View> PhotoCameras(const SynthPhotosOptions& options, const Calibration& calibration) {
  const int kinds = (options.cameras.empty() ? 0 : 1) + (options.eyes.empty() ? 0 : 1) +
                    (options.views > 0 ? 1 : 0);
  if (kinds != 1) {
    throw UsageError("", kinds == 0 ? "no camera is given" : "cameras are given in several ways",
                     "give one of --cameras, --eyes and --views");
  }
  std::vector<View> views;
  if (!options.cameras.empty()) {
    views = ReadTransformsJson(options.cameras).views;
  } else {
    views = options.views > 0 ? RingViews(options, calibration) : EyeViews(options, calibration);
  }
  if (views.empty()) throw UsageError("", "there is no camera", "give one or more");
  return views;
}

std::optional<Rigid> PlaceOfPrintedBoard(const std::string& printed_board) {
  if (printed_board.empty()) return std::nullopt;
  const bool is_turned = std::count(printed_board.begin(), printed_board.end(), ',') > 2;
  const std::vector<double> at =
      NumbersOf(printed_board, is_turned ? 6 : 3, "--printed-board",
                is_turned ? "X,Y,Z,RX,RY,RZ in mm and degrees" : "X,Y,Z in mm");
  Rigid place{Eigen::Quaterniond::Identity(), {at[0], at[1], at[2]}};
  for (int axis = 0; is_turned && axis < 3; ++axis) {
    const double angle = at[3 + static_cast<std::size_t>(axis)] * kRadians;
    place.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)) * place.rotation;
  }
  return place;
}

}  // namespace lamella
