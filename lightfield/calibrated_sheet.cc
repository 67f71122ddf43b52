#include "lightfield/calibrated_sheet.h"

#include <cmath>
#include <numbers>

#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

constexpr double kMmPerInch = 25.4;
constexpr double kMostSlope = 1e6;  // more is upright

}  // namespace

SheetForViewer SheetFor(const LayerCalibration& layer, double distance_mm,
                        const std::string& where) {
  const auto require = [&](bool holds, const char* what) {
    if (!holds) throw InputError(where, what, "give a display of one slanted lenticular sheet");
  };
  require(layer.lattice && layer.lattice->type == LensLattice::Type::kLine,
          "has no cylinder lenses");
  require(layer.emitter.rgb_stripes, "has no panel of red, green and blue stripes");
  require(!layer.emitter.mirror_x, "is seen in a mirror");
  const PanelCalibration& panel = layer.emitter;
  const double reduced_gap = layer.gap_mm / layer.index;
  const double pitch = layer.lattice->pitch_mm * (1 + reduced_gap / distance_mm);
  const double pixel = panel.pitch_mm * (1 + panel.scale);
  // The lenses' normal in the stack, and along the panel's own axes.
  const double angle = layer.lattice->rotation_rad;
  const Eigen::Vector3d normal(std::cos(angle), std::sin(angle), 0);
  const Rigid stack_from_emitter = StackFromEmitter(layer);
  const Eigen::Vector3d along = stack_from_emitter.rotation.inverse() * normal;
  const double slope = along.x() / along.y();
  require(std::abs(slope) < kMostSlope, "has lenses that stand upright");
  const Eigen::Vector3d corner =
      stack_from_emitter * PanelPoint(panel, Eigen::Vector2d(0, panel.height_px));
  // Red is a third of a pixel left of the middle, where the formula begins to count.
  const double third = pixel / 3 * along.x();
  const double center = layer.lattice->phase.x() + (third - corner.dot(normal)) / pitch - 0.5;
  SheetForViewer sheet;
  sheet.panel.pitch_per_in = kMmPerInch / pitch;
  sheet.panel.slope = slope;
  sheet.panel.center = center - std::floor(center);
  sheet.panel.dpi = kMmPerInch / pixel;
  sheet.panel.width_px = panel.width_px;
  sheet.panel.height_px = panel.height_px;
  sheet.view_cone_deg = 2 * std::atan(pitch / (2 * reduced_gap)) * 180 / std::numbers::pi;
  return sheet;
}

}  // namespace lamella
