#include "lightfield/calibrated_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostPitch = 0.2;  // by which a panel's pitch may differ, as a share

// The first thing in which a layer differs from the display's, or "".
std::string DifferenceOf(const LayerCalibration& layer, const Display& display,
                         const Layer& design) {
  const bool barrier = std::holds_alternative<Barrier>(design.optics);
  const bool bare = std::holds_alternative<BarePanel>(design.optics);
  if (barrier && !layer.modulator) return "has no modulator, the display has barriers";
  if (bare && (layer.modulator || layer.lattice || layer.gap_mm != 0)) {
    return "has something before its emitters, the display a bare panel";
  }
  if (!barrier && !bare && !layer.lattice) {
    return fmt::format("has no lens lattice, the display has {}", NameOf(design.optics));
  }
  for (const PanelCalibration* panel :
       {&layer.emitter, layer.modulator ? &*layer.modulator : nullptr}) {
    if (panel == nullptr) continue;
    if (panel->width_px != display.width_px || panel->height_px != display.height_px) {
      return fmt::format("has a panel of {} x {} px, the display of {} x {}", panel->width_px,
                         panel->height_px, display.width_px, display.height_px);
    }
    if (std::abs(panel->pitch_mm / display.pitch_mm - 1) > kMostPitch) {
      return fmt::format("has pixels of {:g} mm, the display of {:g} mm", panel->pitch_mm,
                         display.pitch_mm);
    }
    if (panel->mirror_x != design.mirror_x) {
      return panel->mirror_x ? "is mirrored, the display's is not" : "is not mirrored as it should";
    }
  }
  return "";
}

}  // namespace

void CheckCalibrates(const Calibration& calibration, const Display& display,
                     const std::string& where) {
  const auto require = [&](bool holds, const std::string& what) {
    if (!holds) throw InputError(where, what, "give a calibration of the display");
  };
  require(
      calibration.display == display.name,
      fmt::format("is of the display \"{}\", not of \"{}\"", calibration.display, display.name));
  require(calibration.layers.size() == display.layers.size(),
          fmt::format("is of {} layers, the display has {}", calibration.layers.size(),
                      display.layers.size()));
  double behind = -std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const std::string difference = DifferenceOf(calibration.layers[l], display, display.layers[l]);
    require(difference.empty(), fmt::format("layer {} {}", l, difference));
    const double z = calibration.layers[l].display_from_stack.translation.z();
    require(z > behind, fmt::format("layer {} does not stand in front of the one before", l));
    require(z < display.viewing_distance_mm,
            fmt::format("layer {} stands behind the viewer, at z = {:g} mm", l, z));
    behind = z;
  }
}

Display AsCalibrated(const Display& display, const Calibration& calibration) {
  Display calibrated = display;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const LayerCalibration& from = calibration.layers.at(l);
    Layer& layer = calibrated.layers[l];
    layer.position_mm = from.display_from_stack.translation.z();
    layer.d0_mm = from.gap_mm / from.index / (layer.magnification * layer.magnification);
    if (l == 0) continue;
    const double spacing = layer.position_mm - calibrated.layers[l - 1].position_mm;
    calibrated.border_mm = std::min(calibrated.border_mm, spacing);
  }
  return calibrated;
}

CalibratedMap::CalibratedMap(const Display& display, const Calibration& calibration,
                             int layer_index)
    : optics_(display.layers.at(static_cast<std::size_t>(layer_index)).optics),
      layer_(calibration.layers.at(static_cast<std::size_t>(layer_index))),
      stack_from_emitter_(StackFromEmitter(layer_)),
      columns_(display.emitter_columns()),
      rows_(display.emitter_rows()),
      binning_(display.binning_px),
      slots_(SlotsPerAxis(display.layers[static_cast<std::size_t>(layer_index)])),
      towards_point_(display.shear),
      viewer_mm_(display.viewing_distance_mm) {
  const Rigid stack_from_display = Inverse(layer_.display_from_stack);
  target_ = towards_point_ ? stack_from_display * Vector3d(0, 0, display.viewing_distance_mm)
                           : stack_from_display.rotation * Vector3d::UnitZ();
}

Vector2d CalibratedMap::PanelPixelOf(const PanelCalibration& panel, double column,
                                     double row) const {
  const double u = column * binning_;
  return {panel.mirror_x ? panel.width_px - u : u, row * binning_};
}

Vector2d CalibratedMap::EmittersOf(const PanelCalibration& panel, const Vector2d& pixel) const {
  return Vector2d(panel.mirror_x ? panel.width_px - pixel.x() : pixel.x(), pixel.y()) / binning_;
}

// From a point of the stack through its plane z = 0 in air, or before a plate.
Vector3d CalibratedMap::ToTarget(const Vector3d& from) const {
  if (!towards_point_) return target_;
  Vector3d to = target_ - from;
  if (layer_.plate) {  // the line outside is beside that inside
    const Eigen::Quaterniond& turn = layer_.display_from_stack.rotation;
    to += turn.inverse() * PlateShift(*layer_.plate, turn * Vector3d(-to));
  }
  return to;
}

// Where the line from an emitter to the target crosses the stack's plane z = 0.
std::optional<Vector3d> CalibratedMap::LeavesAt(const Vector3d& emitter) const {
  const Vector3d to = ToTarget(emitter);
  if (!(emitter.z() < 0 && to.z() > 0)) return std::nullopt;
  if (!towards_point_) {
    const Vector3d inside = Refract(to, layer_.index);
    return Vector3d(emitter - emitter.z() / inside.z() * inside);
  }
  const double height = to.z() + emitter.z(), sideways = to.head<2>().norm();
  if (!(height > 0)) return std::nullopt;
  Vector3d crossing(emitter.x(), emitter.y(), 0);
  if (sideways > 0) {
    const double from_foot = RefractionCrossing(height, -emitter.z(), sideways, layer_.index);
    crossing.head<2>() += (1 - from_foot / sideways) * to.head<2>();
  }
  return crossing;
}

std::optional<CalibratedMap::Element> CalibratedMap::OpeningAt(const Vector3d& crossing,
                                                               int slot) const {
  const Barrier& barrier = std::get<Barrier>(optics_);
  const PanelCalibration& panel = *layer_.modulator;
  const std::optional<Vector3d> met = MeetPanel(panel, crossing, ToTarget(crossing));
  if (!met) return std::nullopt;
  const std::optional<Vector2d> pixel = PanelPixel(panel, met->head<2>());
  if (!pixel) return std::nullopt;
  const Vector2d place = EmittersOf(panel, *pixel);
  const std::array<int, 2> slots = {slot % slots_, slot / slots_}, count = {columns_, rows_};
  std::array<int, 2> openings{};
  Vector2d centre;
  for (int axis = 0; axis < 2; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    constexpr double kTie = 1e-9;  // the lower index where equally near
    const double first = barrier.stride_px() * slots[a] + barrier.aperture_px / 2.0;
    const double opening = std::ceil((place(axis) - first) / barrier.period_px - 0.5 - kTie);
    centre(axis) = first + barrier.period_px * opening;
    if (!(opening >= 0 && centre(axis) + barrier.aperture_px / 2.0 <= count[a])) {
      return std::nullopt;
    }
    openings[a] = static_cast<int>(opening);
  }
  const double width = barrier.aperture_px * binning_ * panel.pitch_mm * (1 + panel.scale);
  return Element{openings[0],
                 openings[1],
                 PanelPoint(panel, PanelPixelOf(panel, centre.x(), centre.y())),
                 {width * (1 + panel.aspect), width * (1 - panel.aspect)}};
}

// Whether an emitter is one of the lit ones around where the lens is seen from the target.
bool CalibratedMap::InWindow(const LensletArray& lenses, const Vector3d& centre, int column,
                             int row) const {
  const Rigid emitter_from_stack = Inverse(stack_from_emitter_);
  const auto place_along = [&](const Vector3d& direction) -> std::optional<Vector2d> {
    const auto met = MeetPanel(layer_.emitter, emitter_from_stack * centre,
                               emitter_from_stack.rotation * direction);
    const auto pixel = met ? PanelPixel(layer_.emitter, met->head<2>()) : std::nullopt;
    return pixel ? std::optional(EmittersOf(layer_.emitter, *pixel)) : std::nullopt;
  };
  const auto window = place_along(Refract(-ToTarget(centre), layer_.index));
  const auto below = place_along(-Vector3d::UnitZ());
  if (!window || !below) return false;
  constexpr double kTolerancePx = 1e-6;  // of a lens that just fits the panel
  const double half_width = lenses.pitch_px / 2 - kTolerancePx;
  const double half_height = lenses.row_pitch_px() / 2 - kTolerancePx;
  const bool whole = below->x() >= half_width && below->x() <= columns_ - half_width &&
                     below->y() >= half_height && below->y() <= rows_ - half_height;
  return whole && RayIndex(column + 0.5 - window->x(), lenses.rays) &&
         RayIndex(row + 0.5 - window->y(), lenses.rays);
}

std::optional<CalibratedMap::Element> CalibratedMap::LensAt(const Vector3d& crossing, int column,
                                                            int row) const {
  const LensLattice& lattice = *layer_.lattice;
  const Vector2d at = crossing.head<2>();
  const Vector2d nearest = NearestLens(lattice, at);
  if (lattice.type == LensLattice::Type::kLine) {
    // A line has no fan along it: the place on its axis at the target's height.
    const Vector2d normal(std::cos(lattice.rotation_rad), std::sin(lattice.rotation_rad));
    const double along_x = (nearest - at).dot(normal) / normal.x();
    const double height = binning_ * layer_.emitter.pitch_mm * (1 + layer_.emitter.scale);
    return Element{0, row, {at.x() + along_x, at.y(), 0}, {lattice.pitch_mm / normal.x(), height}};
  }
  const Vector3d centre(nearest.x(), nearest.y(), 0);
  if (!InWindow(std::get<LensletArray>(optics_), centre, column, row)) return std::nullopt;
  const bool hexagonal = lattice.type == LensLattice::Type::kHexagonal;
  return Element{
      0, 0, centre, {lattice.pitch_mm, lattice.pitch_mm * (hexagonal ? std::sqrt(3.0) / 2 : 1)}};
}

std::optional<CalibratedMap::Element> CalibratedMap::ElementAt(const Vector3d& crossing, int slot,
                                                               int column, int row) const {
  return layer_.modulator ? OpeningAt(crossing, slot) : LensAt(crossing, column, row);
}

// The direction in air of the light from an emitter through an element's centre. A bowed
// modulator's lies beside the plane z = 0 where light is refracted, by so little that going back
// and forth between the two settles.
std::optional<Vector3d> CalibratedMap::Leaving(const Vector3d& emitter,
                                               const Vector3d& element) const {
  constexpr int kMostRounds = 50;
  Vector2d crossing = element.head<2>();
  Vector3d direction;
  for (int i = 0; i < kMostRounds; ++i) {
    const Vector3d inside(crossing.x() - emitter.x(), crossing.y() - emitter.y(), -emitter.z());
    const Vector2d sideways = layer_.index * inside.head<2>() / inside.norm();
    const double rest = 1 - sideways.squaredNorm();
    if (!(rest > 0)) return std::nullopt;
    direction = {sideways.x(), sideways.y(), std::sqrt(rest)};
    const Vector2d next = element.head<2>() - element.z() / direction.z() * direction.head<2>();
    const double moved = (next - crossing).norm();
    crossing = next;
    if (!(moved > 1e-14 * (1 + crossing.norm()))) break;
  }
  return direction;
}

CalibratedBeam CalibratedMap::BeamFrom(const Element& element, double depth_mm,
                                       const Vector3d& direction) const {
  Vector3d at = layer_.display_from_stack * element.centre;
  if (layer_.plate) at -= PlateShift(*layer_.plate, -direction);
  const double d0 = depth_mm / layer_.index;
  double power = 0;
  if (layer_.lattice) {
    const double focal = layer_.lattice->focal_mm;
    power = 1 / (focal > 0 ? focal : layer_.gap_mm / layer_.index);
  }
  const Vector2d width = EmitterWidth();
  const auto axis = [&](int i, int opening) {
    const double slope = direction(i) / direction.z();
    return AxisBeam{opening, at(i), element.width(i), at(i) - d0 * slope, width(i), d0, power};
  };
  CalibratedBeam beam{{axis(0, element.column), axis(1, element.row)}, at.z()};
  if (std::holds_alternative<Lenticular>(optics_)) {
    beam.beam.x.emitter_width_mm /= 3;
    beam.beam.y.emitter_width_mm = 0;
    beam.beam.y.power_per_mm = 1 / d0;
  }
  return beam;
}

// `emitter` is in the stack.
CalibratedBeam CalibratedMap::BareBeam(const BarePanel& bare, const Vector3d& emitter, int column,
                                       int row) const {
  Vector3d at = layer_.display_from_stack * emitter;
  if (layer_.plate) at -= PlateShift(*layer_.plate, at - Vector3d(0, 0, viewer_mm_));
  const Vector2d width = EmitterWidth();
  const auto axis = [&](int i, int element) {
    return AxisBeam{element, at(i), width(i), 0, bare.eye_box_mm, at.z() - viewer_mm_};
  };
  return {{axis(0, column), axis(1, row)}, at.z()};
}

Vector2d CalibratedMap::EmitterWidth() const {
  const PanelCalibration& panel = layer_.emitter;
  const double pixel = binning_ * panel.pitch_mm * (1 + panel.scale);
  return pixel * Vector2d(1 + panel.aspect, 1 - panel.aspect);
}

std::optional<CalibratedBeam> CalibratedMap::BeamOf(int slot, int channel, int column,
                                                    int row) const {
  if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return std::nullopt;
  const PanelCalibration& panel = layer_.emitter;
  double place = column + 0.5;
  if (std::holds_alternative<Lenticular>(optics_)) {  // sub-pixels, in reverse seen in a mirror
    place = column + ((panel.mirror_x ? 2 - channel : channel) + 0.5) / 3;
  }
  const Vector3d emitter =
      stack_from_emitter_ * PanelPoint(panel, PanelPixelOf(panel, place, row + 0.5));
  if (const auto* bare = std::get_if<BarePanel>(&optics_)) {
    return BareBeam(*bare, emitter, column, row);
  }
  const std::optional<Vector3d> crossing = LeavesAt(emitter);
  if (!crossing) return std::nullopt;
  const std::optional<Element> element = ElementAt(*crossing, slot, column, row);
  if (!element) return std::nullopt;
  const std::optional<Vector3d> leaving = Leaving(emitter, element->centre);
  if (!leaving) return std::nullopt;
  const Vector3d direction = layer_.display_from_stack.rotation * *leaving;
  if (!(direction.z() > 0)) return std::nullopt;
  return BeamFrom(*element, element->centre.z() - emitter.z(), direction);
}

}  // namespace lamella
