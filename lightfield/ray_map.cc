#include "lightfield/ray_map.h"

#include <cmath>

namespace lamella {

int ShearShiftPx(double x_mm, double d0_mm, double distance_mm, double pitch_mm) {
  return static_cast<int>(std::floor(x_mm * d0_mm / (distance_mm * pitch_mm) + 0.5));
}

RayMap::RayMap(const Display& display, int layer_index) {
  const Layer& layer = display.layers.at(static_cast<std::size_t>(layer_index));
  columns_ = display.emitter_columns();
  rows_ = display.emitter_rows();
  pitch_mm_ = display.emitter_pitch_mm(layer);
  position_mm_ = layer.position_mm;
  d0_mm_ = layer.seen_d0_mm();
  shear_distance_mm_ = display.shear ? display.distance_mm(layer) : 0.0;
  viewer_mm_ = display.distance_mm(layer);
  if (const BarePanel* bare = std::get_if<BarePanel>(&layer.optics)) {
    eye_box_mm_ = bare->eye_box_mm;
    barrier_ = OpeningsOf(layer);
  } else {
    barrier_ = BarrierOf(display, static_cast<std::size_t>(layer_index));
  }
  x_ = MakeAxis(columns_, 1);
  y_ = MakeAxis(rows_, -1);
}

RayMap::Axis RayMap::MakeAxis(int count, double sign) const {
  Axis axis{count, sign, std::vector<std::uint32_t>(static_cast<std::size_t>(count), 0U)};
  for (int slot = 0; slot < barrier_.slots; ++slot) {
    for (int opening = 0; Whole(axis, opening, slot); ++opening) {
      const int first = barrier_.period_px * opening + barrier_.stride_px() * slot;
      for (int i = first; i < first + barrier_.aperture_px; ++i) {
        axis.open_slots[static_cast<std::size_t>(i)] |= 1U << slot;
      }
    }
  }
  return axis;
}

double RayMap::Centre(const Axis& axis, int index) const {
  return axis.sign * (index + 0.5 - axis.count / 2.0) * pitch_mm_;
}

bool RayMap::Whole(const Axis& axis, int opening, int slot) const {
  const int first = barrier_.period_px * opening + barrier_.stride_px() * slot;
  return opening >= 0 && first + barrier_.aperture_px <= axis.count;
}

// In emitters from the middle, in the direction of rising indices.
double RayMap::OpeningCentrePx(const Axis& axis, int opening, int slot) const {
  const double first = barrier_.period_px * opening + barrier_.stride_px() * slot;
  return first + barrier_.aperture_px / 2.0 - axis.count / 2.0;
}

// In the direction of rising indices, which for rows is downwards.
int RayMap::ShearShift(const Axis& axis, int opening, int slot) const {
  if (shear_distance_mm_ == 0) return 0;
  const double centre_mm = axis.sign * OpeningCentrePx(axis, opening, slot) * pitch_mm_;
  const int shift = ShearShiftPx(centre_mm, d0_mm_, shear_distance_mm_, pitch_mm_);
  return axis.sign > 0 ? shift : -shift;
}

bool RayMap::Open(const Axis& axis, int slot, int index) const {
  return (axis.open_slots[static_cast<std::size_t>(index)] >> slot & 1U) != 0;
}

// The opening to whose fan an emitter belongs.
std::optional<int> RayMap::OpeningOf(const Axis& axis, int slot, int index) const {
  const double from_middle = index + 0.5 - axis.count / 2.0;
  // A window's centre is (1 + d0/D) times its opening's, up to half an emitter of rounding.
  const double shear = shear_distance_mm_ > 0 ? d0_mm_ / shear_distance_mm_ : 0.0;
  const double place =
      (from_middle / (1 + shear) - OpeningCentrePx(axis, 0, slot)) / barrier_.period_px;
  constexpr double kTie = 1e-9;  // the lower index where equally near
  const int nearest = static_cast<int>(std::ceil(place - 0.5 - kTie));
  std::optional<int> claiming;
  double distance = 0;
  bool just_before = false, just_after = false;  // a window
  for (int opening = nearest - 1; opening <= nearest + 1; ++opening) {
    if (!Whole(axis, opening, slot)) continue;
    const int first = barrier_.period_px * opening + barrier_.stride_px() * slot +
                      (barrier_.aperture_px - barrier_.period_px) / 2 +
                      ShearShift(axis, opening, slot);
    just_before |= index == first - 1;
    just_after |= index == first + barrier_.period_px;
    if (index < first || index >= first + barrier_.period_px) continue;
    const double from_opening = std::abs(from_middle - OpeningCentrePx(axis, opening, slot));
    if (claiming && from_opening >= distance) continue;
    distance = from_opening;
    claiming = opening;
  }
  const bool missed = !claiming && just_before && just_after;
  return missed && Whole(axis, nearest, slot) ? nearest : claiming;
}

std::optional<AxisBeam> RayMap::Beam(const Axis& axis, int slot, int index) const {
  if (index < 0 || index >= axis.count) return std::nullopt;
  if (eye_box_mm_ > 0) {
    return AxisBeam{index, Centre(axis, index), pitch_mm_, 0, eye_box_mm_, -viewer_mm_};
  }
  const std::optional<int> opening = OpeningOf(axis, slot, index);
  if (!opening) return std::nullopt;
  return AxisBeam{*opening,
                  axis.sign * OpeningCentrePx(axis, *opening, slot) * pitch_mm_,
                  barrier_.aperture_px * pitch_mm_,
                  Centre(axis, index),
                  pitch_mm_,
                  d0_mm_};
}

std::optional<AxisHit> RayMap::Met(const Axis& axis, double position, double slope) const {
  const double middle = axis.count / 2.0;
  const double element = std::floor(axis.sign * position / pitch_mm_ + middle);
  const double emitter = std::floor(axis.sign * (position - d0_mm_ * slope) / pitch_mm_ + middle);
  const double last = axis.count - 1;
  // Written so that a NaN is nothing.
  if (!(element >= 0 && element <= last && emitter >= 0 && emitter <= last)) return std::nullopt;
  AxisHit hit;
  hit.element = static_cast<int>(element);
  hit.emitter = static_cast<int>(emitter);
  hit.open_slots = axis.open_slots[static_cast<std::size_t>(hit.element)];
  return hit;
}

std::optional<AxisHit> RayMap::Seen(const Axis& axis, double position, double slope) const {
  std::optional<AxisHit> hit = Met(axis, position, slope);
  if (!hit || hit->open_slots == 0) return std::nullopt;
  while ((hit->open_slots >> hit->slot & 1U) == 0) ++hit->slot;
  return hit;
}

std::optional<LayerHit> RayMap::See(double x_mm, double y_mm, double slope_x,
                                    double slope_y) const {
  const std::optional<AxisHit> x = SeenColumn(x_mm, slope_x), y = SeenRow(y_mm, slope_y);
  if (!x || !y) return std::nullopt;
  LayerHit hit;
  hit.element_column = x->element;
  hit.element_row = y->element;
  hit.column = (x_mm - d0_mm_ * slope_x) / pitch_mm_ + columns_ / 2.0;
  hit.row = rows_ / 2.0 - (y_mm - d0_mm_ * slope_y) / pitch_mm_;
  hit.slots_x = x->open_slots;
  hit.slots_y = y->open_slots;
  return hit;
}

}  // namespace lamella
