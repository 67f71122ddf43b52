#include "lightfield/lenticular_map.h"

#include <algorithm>
#include <cmath>

#include "lightfield/error.h"

namespace lamella {
namespace {

// k + k_off - 3 l tan alpha: rises by X from lens to lens.
double Phase(const Lenticular& lenses, double subpixel, double row) {
  return subpixel + lenses.offset_subpx - 3 * row * lenses.slant;
}

// Its rest in [0, X), without rounding: in many designs whole views fall on sub-pixels.
double InLens(double phase, double width) {
  const double rest = std::fmod(phase, width);
  if (rest >= 0) return rest;
  return rest + width < width ? rest + width : 0.0;
}

}  // namespace

double VanBerkelView(const Lenticular& lenses, double subpixel, double row) {
  const double width = lenses.subpixels_per_lens;
  return InLens(Phase(lenses, subpixel, row), width) / width * lenses.views;
}

LenticularMap::LenticularMap(const Display& display, int layer_index) {
  const Layer& layer = display.layers.at(static_cast<std::size_t>(layer_index));
  const Lenticular* lenses = std::get_if<Lenticular>(&layer.optics);
  if (lenses == nullptr) {
    throw UsageError(display.name, "a layer has " + NameOf(layer.optics),
                     "ask for the map of a layer with lenticular lenses");
  }
  lenses_ = *lenses;
  columns_ = display.emitter_columns();
  rows_ = display.emitter_rows();
  pitch_mm_ = display.emitter_pitch_mm(layer);
  d0_mm_ = layer.seen_d0_mm();
  power_per_mm_ = LensPowerPerMm(layer, lenses_.focal_mm);
  viewer_mm_ = display.shear ? display.distance_mm(layer) + d0_mm_ : 0.0;
  mirrored_ = layer.mirror_x;
}

LenticularMap::Place LenticularMap::PlaceOf(double subpixel, double row) const {
  const double width = lenses_.subpixels_per_lens, phase = Phase(lenses_, subpixel, row);
  const double in_lens = InLens(phase, width);
  return {static_cast<int>(std::lround((phase - in_lens) / width)), in_lens - width / 2};
}

double LenticularMap::View(int channel, int column, int row) const {
  return VanBerkelView(lenses_, 3.0 * column + Stripe(channel), row);
}

std::optional<Beam> LenticularMap::BeamOf(int channel, int column, int row) const {
  if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return std::nullopt;
  const double width = pitch_mm_ / 3, subpixel = 3.0 * column + Stripe(channel);
  const Place place = PlaceOf(subpixel, row);
  const double x = (subpixel + 0.5 - 1.5 * columns_) * width;
  const double y = (rows_ / 2.0 - row - 0.5) * pitch_mm_;
  const double slope_y = viewer_mm_ > 0 ? -y / viewer_mm_ : 0.0;
  const double slope_x = -place.offset_subpx * width / d0_mm_ - slope_y * lenses_.slant;
  return Beam{{place.lens, x + d0_mm_ * slope_x, lenses_.subpixels_per_lens * width, x, width,
               d0_mm_, power_per_mm_},
              {row, y + d0_mm_ * slope_y, pitch_mm_, y, 0, d0_mm_, 1 / d0_mm_}};
}

std::optional<Sight> LenticularMap::See(double x_mm, double y_mm, double slope_x,
                                        double slope_y) const {
  const double x = x_mm / pitch_mm_ + columns_ / 2.0, y = rows_ / 2.0 - y_mm / pitch_mm_;
  // Written so that a NaN is nothing.
  if (!(x >= 0 && x < columns_ && y >= 0 && y < rows_)) return std::nullopt;
  const Place place = PlaceOf(3 * x - 0.5, y - 0.5);
  // Bent by the power times the distance from the vertex line, across it: of an offset along the
  // row the part cos(alpha) is across, and of that cos(alpha) is along x and sin(alpha) along y.
  const double cosine = 1 / std::hypot(1.0, lenses_.slant), sine = lenses_.slant * cosine;
  const double bent = d0_mm_ * power_per_mm_ * (place.offset_subpx / 3) * cosine;
  const double reach = d0_mm_ / pitch_mm_;
  Sight sight;
  sight.element_column = place.lens;
  sight.column = x - bent * cosine - reach * slope_x;
  sight.row = y + bent * sine + reach * slope_y;
  if (!(sight.column >= 0 && sight.column < columns_ && sight.row >= 0 && sight.row < rows_)) {
    return std::nullopt;
  }
  const double in_pixel = sight.column - std::floor(sight.column);
  sight.channel = Stripe(std::min(2, static_cast<int>(3 * in_pixel)));
  return sight;
}

}  // namespace lamella
