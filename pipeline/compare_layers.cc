#include "pipeline/compare_layers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/layers_record.h"

namespace lamella {
namespace {

constexpr double kSameLength = 1e-6;  // relative
constexpr double kWithinBox = 0.96;   // the box's very border is a matter of rounding

bool Same(double a, double b) { return std::abs(a - b) <= kSameLength * std::abs(a); }

void CheckComparable(const Workspace& b, const LayersRecord& of_a, const LayersRecord& of_b) {
  const Placement &p = of_a.placement, &q = of_b.placement;
  if (Same(p.viewing_distance_mm, q.viewing_distance_mm) &&
      Same(p.picture_width_mm, q.picture_width_mm) &&
      Same(p.picture_height_mm, q.picture_height_mm)) {
    return;
  }
  throw InputError((b.Stage("layers") / "layers.json").string(),
                   fmt::format("shows {:.3f} x {:.3f} mm to eyes at {:g} mm, the other one {:.3f} "
                               "x {:.3f} mm at {:g} mm",
                               q.picture_width_mm, q.picture_height_mm, q.viewing_distance_mm,
                               p.picture_width_mm, p.picture_height_mm, p.viewing_distance_mm),
                   "place both alike (lamella synth layers --like)");
}

// Of the placed picture's part on both panels, in the first one's pixels.
Eye MiddleEye(const LayersRecord& of_a, const LayersRecord& of_b) {
  Eye eye;
  const double width =
      std::min({of_a.placement.picture_width_mm, of_a.display.width_mm(), of_b.display.width_mm()});
  const double height = std::min(
      {of_a.placement.picture_height_mm, of_a.display.height_mm(), of_b.display.height_mm()});
  eye.pixel_mm = of_a.display.pitch_mm;
  eye.width = std::max(1, static_cast<int>(width / eye.pixel_mm + kSameLength));
  eye.height = std::max(1, static_cast<int>(height / eye.pixel_mm + kSameLength));
  eye.left_mm = -0.5 * eye.width * eye.pixel_mm;
  eye.top_mm = 0.5 * eye.height * eye.pixel_mm;
  eye.position = {0, 0, of_a.placement.viewing_distance_mm};
  return eye;
}

}  // namespace

LayersComparison CompareLayers(const Workspace& a, const Workspace& b, int border_px,
                               Progress& progress) {
  const LayersRecord of_a = LoadLayersRecord(a), of_b = LoadLayersRecord(b);
  CheckComparable(b, of_a, of_b);
  for (const auto& [workspace, of] : {std::pair(&a, &of_a), {&b, &of_b}}) {
    if (!of->calibration) continue;
    throw InputError(workspace->root().string(),
                     "has layers for a calibrated display, which can't be compared yet",
                     "compare layers of the display as designed");
  }
  const LayerImages layers_a = LoadLayerImages(a, of_a), layers_b = LoadLayerImages(b, of_b);
  const double box = kWithinBox * std::min(CleanEyeBox(of_a.display), CleanEyeBox(of_b.display));
  LayersComparison comparison;
  Eye eye = MiddleEye(of_a, of_b);
  comparison.width = eye.width;
  comparison.height = eye.height;
  // In shares of the box, which is as high as it is wide.
  constexpr std::array<std::array<double, 2>, 9> kPlaces = {
      {{-1, 0}, {-0.5, 0}, {0, 0}, {0.5, 0}, {1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}}};
  progress.Start("eyes", kPlaces.size(), "eyes");
  for (const auto& [x, y] : kPlaces) {
    eye.position.x() = x * box;
    eye.position.y() = y * box;
    comparison.eyes.push_back(
        {eye.position.x(), eye.position.y(),
         Compare(PictureOf(SimulateEye(layers_a, of_a.display, eye)),
                 PictureOf(SimulateEye(layers_b, of_b.display, eye)), border_px)});
    progress.Advance();
  }
  return comparison;
}

}  // namespace lamella
