#include "distribute/warp_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Of the four pixels around a place, the second of which is `fraction` before it (Catmull and Rom
// 1974).
std::array<double, 4> CatmullRom(double fraction) {
  const double t = fraction, t2 = t * t, t3 = t2 * t;
  return {(-t + 2 * t2 - t3) / 2, (2 - 5 * t2 + 3 * t3) / 2, (t + 4 * t2 - 3 * t3) / 2,
          (t3 - t2) / 2};
}

// At a place whose pixels' edges are whole numbers; the border's pixels go on beyond it.
Rgb Interpolated(const Image<Rgb>& picture, double column, double row) {
  const double x = std::floor(column - 0.5), y = std::floor(row - 0.5);
  const std::array<double, 4> across = CatmullRom(column - 0.5 - x),
                              down = CatmullRom(row - 0.5 - y);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int j = 0; j < 4; ++j) {
    const Rgb* pixels =
        picture.row(std::clamp(static_cast<int>(y) - 1 + j, 0, picture.height() - 1));
    for (int i = 0; i < 4; ++i) {
      const Rgb& pixel = pixels[std::clamp(static_cast<int>(x) - 1 + i, 0, picture.width() - 1)];
      const double weight = across[static_cast<std::size_t>(i)] * down[static_cast<std::size_t>(j)];
      sum += weight * Eigen::Vector3d(static_cast<double>(pixel.r), static_cast<double>(pixel.g),
                                      static_cast<double>(pixel.b));
    }
  }
  const auto light = [](double value) { return value > 0 ? static_cast<float>(value) : 0.0F; };
  return {light(sum.x()), light(sum.y()), light(sum.z())};
}

void CheckWarp(const Image<Rgb>& picture, const Display& display, const Layer& layer, int index,
               const Eigen::Vector3d& eye) {
  if (!std::holds_alternative<BarePanel>(layer.optics)) {
    throw UsageError(display.name,
                     fmt::format("layer {} has {}: no ready frame can be warped behind it", index,
                                 NameOf(layer.optics)),
                     "make its layers with the calibration (`lamella layers --calibration`)");
  }
  if (picture.width() != display.emitter_columns() || picture.height() != display.emitter_rows()) {
    throw InputError(
        "the picture",
        fmt::format("is {} x {} px, the panel has {} x {} emitters", picture.width(),
                    picture.height(), display.emitter_columns(), display.emitter_rows()),
        "give a picture with a pixel for every emitter");
  }
  if (!eye.allFinite() || !(eye.z() > layer.position_mm)) {
    throw UsageError("the eye",
                     fmt::format("at ({:g}, {:g}, {:g}) mm is not in front of layer {} at {:g} mm",
                                 eye.x(), eye.y(), eye.z(), index, layer.position_mm),
                     "give [right, up, to the viewer]");
  }
}

}  // namespace

EmitterImage WarpToPanel(const Image<Rgb>& picture, const Display& display,
                         const Calibration& calibration, int layer_index,
                         const Eigen::Vector3d& eye) {
  const Layer& layer = display.layers.at(static_cast<std::size_t>(layer_index));
  CheckWarp(picture, display, layer, layer_index, eye);
  CheckCalibrates(calibration, display, "calibration");
  const CalibratedMap map(display, calibration, layer_index);
  const int columns = picture.width(), rows = picture.height();
  const double pitch = display.emitter_pitch_mm(layer);
  EmitterImage shown{Image<Rgb>(columns, rows), Image<float>(columns, rows)};
  ParallelForEach(0, rows, [&](std::int64_t y) {
    const int row = static_cast<int>(y);
    for (int column = 0; column < columns; ++column) {
      const std::optional<CalibratedBeam> beam = map.BeamOf(0, 0, column, row);
      if (!beam || !(beam->z_mm < eye.z())) continue;
      const Eigen::Vector3d at(beam->beam.x.element_mm, beam->beam.y.element_mm, beam->z_mm);
      const double along = (eye.z() - layer.position_mm) / (eye.z() - at.z());
      const Eigen::Vector3d designed = eye + along * (at - eye);
      const double u = designed.x() / pitch + columns / 2.0, v = rows / 2.0 - designed.y() / pitch;
      if (!(u >= 0 && u <= columns && v >= 0 && v <= rows)) continue;
      shown.color(column, row) = Interpolated(picture, u, v);
      shown.coverage(column, row) = 1;
    }
  });
  return shown;
}

}  // namespace lamella
