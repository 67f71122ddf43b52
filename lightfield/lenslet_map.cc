#include "lightfield/lenslet_map.h"

#include <cmath>

#include "lightfield/error.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

constexpr double kTolerancePx = 1e-6;  // of a lens that just fits the panel

// How far the lenses of a row are shifted to the right.
double RowShiftPx(const LensletArray& lenses, int row) {
  if (lenses.lattice == LensletArray::Lattice::kSquare) return 0;
  const bool odd = row % 2 != 0;
  return odd == lenses.shift_odd_rows ? lenses.pitch_px / 2 : 0;
}

// The lens of a row over whose width x_px lies.
Lens LensInRow(const LensletArray& lenses, int row, double x_px) {
  const double from_edge = x_px - lenses.offset_x_px - RowShiftPx(lenses, row);
  return LensOf(lenses, row, static_cast<int>(std::floor(from_edge / lenses.pitch_px)));
}

}  // namespace

Lens LensOf(const LensletArray& lenses, int row, int column) {
  return {row, column,
          lenses.offset_x_px + lenses.pitch_px * (column + 0.5) + RowShiftPx(lenses, row),
          lenses.offset_y_px + lenses.row_pitch_px() * (row + 0.5)};
}

Lens NearestLens(const LensletArray& lenses, double x_px, double y_px) {
  const double row = (y_px - lenses.offset_y_px) / lenses.row_pitch_px();
  if (lenses.lattice == LensletArray::Lattice::kSquare) {
    return LensInRow(lenses, static_cast<int>(std::floor(row)), x_px);
  }
  // A hexagon reaches less than a row pitch up and down: the nearest centre is in one of the two
  // rows whose centres enclose the point.
  const int above = static_cast<int>(std::floor(row - 0.5));
  const auto distance = [&](const Lens& lens) {
    return std::hypot(x_px - lens.x_px, y_px - lens.y_px);
  };
  const Lens upper = LensInRow(lenses, above, x_px), lower = LensInRow(lenses, above + 1, x_px);
  return distance(lower) < distance(upper) ? lower : upper;
}

std::optional<int> RayIndex(double offset_px, int rays) {
  const double index = std::floor(offset_px + rays / 2.0);
  if (!(index >= 0 && index < rays)) return std::nullopt;
  return static_cast<int>(index);
}

double ParaxialLensSlope(double offset_mm, double thickness_mm, double index) {
  return -offset_mm * index / thickness_mm;
}

double ExactLensSlope(double offset_mm, double thickness_mm, double index) {
  const double sine = index * std::sin(std::atan(offset_mm / thickness_mm));
  return -sine / std::sqrt(1 - sine * sine);
}

LensletMap::LensletMap(const Display& display, int layer_index) {
  const Layer& layer = display.layers.at(static_cast<std::size_t>(layer_index));
  const LensletArray* lenses = std::get_if<LensletArray>(&layer.optics);
  if (lenses == nullptr) {
    throw UsageError(display.name, "a layer has " + NameOf(layer.optics),
                     "ask for the map of a layer with lenslets");
  }
  lenses_ = *lenses;
  columns_ = display.emitter_columns();
  rows_ = display.emitter_rows();
  pitch_mm_ = display.emitter_pitch_mm(layer);
  d0_mm_ = layer.seen_d0_mm();
  power_per_mm_ = LensPowerPerMm(layer, lenses_.focal_mm);
  shear_distance_mm_ = display.shear ? display.distance_mm(layer) : 0.0;
}

bool LensletMap::Whole(const Lens& lens) const {
  const double half_width = lenses_.pitch_px / 2 - kTolerancePx;
  const double half_height = lenses_.row_pitch_px() / 2 - kTolerancePx;
  return lens.x_px >= half_width && lens.x_px <= columns_ - half_width &&
         lens.y_px >= half_height && lens.y_px <= rows_ - half_height;
}

std::optional<LensletPixel> LensletMap::Pixel(int column, int row) const {
  if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return std::nullopt;
  const double x = column + 0.5, y = row + 0.5;
  const Lens lens = NearestLens(lenses_, x, y);
  if (!Whole(lens)) return std::nullopt;
  double window_x = lens.x_px, window_y = lens.y_px;
  if (shear_distance_mm_ > 0) {
    const auto shift = [&](double mm) {
      return ShearShiftPx(mm, d0_mm_, shear_distance_mm_, pitch_mm_);
    };
    window_x += shift(XFromPx(lens.x_px));
    window_y -= shift(YFromPx(lens.y_px));
  }
  const std::optional<int> ray_column = RayIndex(x - window_x, lenses_.rays);
  const std::optional<int> ray_row = RayIndex(y - window_y, lenses_.rays);
  if (!ray_column || !ray_row) return std::nullopt;
  return LensletPixel{lens, *ray_column, *ray_row};
}

std::optional<Beam> LensletMap::BeamOf(int column, int row) const {
  const std::optional<LensletPixel> pixel = Pixel(column, row);
  if (!pixel) return std::nullopt;
  const Lens& lens = pixel->lens;
  return Beam{{lens.column, XFromPx(lens.x_px), lenses_.pitch_px * pitch_mm_, XFromPx(column + 0.5),
               pitch_mm_, d0_mm_, power_per_mm_},
              {lens.row, YFromPx(lens.y_px), lenses_.row_pitch_px() * pitch_mm_, YFromPx(row + 0.5),
               pitch_mm_, d0_mm_, power_per_mm_}};
}

std::optional<Sight> LensletMap::See(double x_mm, double y_mm, double slope_x,
                                     double slope_y) const {
  const double x = x_mm / pitch_mm_ + columns_ / 2.0, y = rows_ / 2.0 - y_mm / pitch_mm_;
  // Written so that a NaN is nothing.
  if (!(x >= 0 && x < columns_ && y >= 0 && y < rows_)) return std::nullopt;
  const Lens lens = NearestLens(lenses_, x, y);
  if (!Whole(lens)) return std::nullopt;
  // Behind the lens the line is steeper by its power times the distance from the vertex.
  const double bent = d0_mm_ * power_per_mm_, reach = d0_mm_ / pitch_mm_;
  Sight sight;
  sight.element_column = lens.column;
  sight.element_row = lens.row;
  sight.column = x - bent * (x - lens.x_px) - reach * slope_x;
  sight.row = y - bent * (y - lens.y_px) + reach * slope_y;
  if (!(sight.column >= 0 && sight.column < columns_ && sight.row >= 0 && sight.row < rows_)) {
    return std::nullopt;
  }
  sight.guard = !Pixel(static_cast<int>(sight.column), static_cast<int>(sight.row));
  return sight;
}

}  // namespace lamella
