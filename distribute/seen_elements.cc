#include "distribute/seen_elements.h"

#include <algorithm>
#include <cmath>

#include "lightfield/lenslet_map.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

template <class Depth>
ConvexPolygon Cut(const ConvexPolygon& polygon, Depth depth) {
  ConvexPolygon inside;
  for (int i = 0; i < polygon.size; ++i) {
    const PlanePoint &p = polygon[i], &q = polygon[i + 1];
    const double dp = depth(p), dq = depth(q);
    if (dp <= 0) inside.Add(p);
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      const double t = dp / (dp - dq);
      inside.Add({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
    }
  }
  return inside;
}

// From a form in emitters of the modulating plane to one in the picture's px.
AffineForm InPicture(const AffineForm& form, const LayerView& view) {
  return {form.c - (form.x * view.offset_x + form.y * view.offset_y) / view.scale,
          form.x / view.scale, form.y / view.scale};
}

ConvexPolygon CellInPicture(const ConvexPolygon& polygon, const LayerView& view) {
  ConvexPolygon in_picture;
  for (int i = 0; i < polygon.size; ++i) {
    in_picture.Add(
        {view.scale * polygon[i].x + view.offset_x, view.scale * polygon[i].y + view.offset_y});
  }
  return in_picture;
}

AffineForm PlusTimes(const AffineForm& a, double factor, const AffineForm& b) {
  return {a.c + factor * b.c, a.x + factor * b.x, a.y + factor * b.y};
}

// The Voronoi cell of a lens.
ConvexPolygon CellOf(const LensletArray& lenses, const Lens& lens) {
  ConvexPolygon cell;
  const double half = lenses.pitch_px / 2;
  const auto add = [&](double x, double y) { cell.Add({lens.x_px + x, lens.y_px + y}); };
  if (lenses.lattice == LensletArray::Lattice::kSquare) {
    add(-half, -half);
    add(half, -half);
    add(half, half);
    add(-half, half);
    return cell;
  }
  const double tip = lenses.pitch_px / std::sqrt(3.0);
  add(0, -tip);
  add(half, -tip / 2);
  add(half, tip / 2);
  add(0, tip);
  add(-half, tip / 2);
  add(-half, -tip / 2);
  return cell;
}

// What LensletMap::See says of the lines through one lens.
SeenElement ElementOf(const Display& display, const Layer& layer, const LensletArray& lenses,
                      const Lens& lens, const LayerView& view) {
  const double d0 = layer.seen_d0_mm(), pitch = display.emitter_pitch_mm(layer);
  const double bent = d0 * LensPowerPerMm(layer, lenses.focal_mm), reach = d0 / pitch;
  SeenElement element;
  element.cell = CellInPicture(CellOf(lenses, lens), view);
  element.column =
      PlusTimes(InPicture({bent * lens.x_px, 1 - bent, 0}, view), -reach, view.slope_x);
  element.row = PlusTimes(InPicture({bent * lens.y_px, 0, 1 - bent}, view), reach, view.slope_y);
  double window_x = lens.x_px, window_y = lens.y_px;
  if (display.shear) {
    const double distance = display.distance_mm(layer);
    const auto shift = [&](double mm) { return ShearShiftPx(mm, d0, distance, pitch); };
    window_x += shift((lens.x_px - display.emitter_columns() / 2.0) * pitch);
    window_y -= shift((display.emitter_rows() / 2.0 - lens.y_px) * pitch);
  }
  // RayIndex: floor(place + 1/2 - window + N/2) is in [0, N).
  element.window_column = static_cast<int>(std::ceil(window_x - 0.5 - lenses.rays / 2.0));
  element.window_row = static_cast<int>(std::ceil(window_y - 0.5 - lenses.rays / 2.0));
  return element;
}

// Rows and columns of lenses that a panel meets, the last ones included.
struct LensRange {
  int first_row = 0, last_row = 0, first_column = 0, last_column = 0;
};

LensRange LensesOf(const Display& display, const LensletArray& lenses) {
  const int rows = static_cast<int>(display.emitter_rows() / lenses.row_pitch_px()) + 2;
  const int columns = static_cast<int>(display.emitter_columns() / lenses.pitch_px) + 2;
  const int first_row = static_cast<int>(std::floor(-lenses.offset_y_px / lenses.row_pitch_px()));
  const int first_column = static_cast<int>(std::floor(-lenses.offset_x_px / lenses.pitch_px));
  return {first_row - 1, first_row + rows, first_column - 1, first_column + columns};
}

std::vector<SeenElement> SeenLenslets(const Display& display, int index, const LensletArray& lenses,
                                      const LayerView& view, int first_row, int end_row) {
  const Layer& layer = display.layers[static_cast<std::size_t>(index)];
  const LensletMap map(display, index);
  const LensRange range = LensesOf(display, lenses);
  std::vector<SeenElement> elements;
  for (int row = range.first_row; row <= range.last_row; ++row) {
    // A row's lenses lie alike in y.
    const auto [top, bottom] =
        RowsOfCell(CellInPicture(CellOf(lenses, LensOf(lenses, row, range.first_column)), view));
    if (bottom < first_row || top > end_row) continue;
    for (int column = range.first_column; column <= range.last_column; ++column) {
      const Lens lens = LensOf(lenses, row, column);
      if (map.Whole(lens)) elements.push_back(ElementOf(display, layer, lenses, lens, view));
    }
  }
  return elements;
}

// What LenticularMap::See says of the lines through one lens, columns in sub-pixels.
SeenElement StripOf(const Display& display, const Layer& layer, const Lenticular& lenses, int lens,
                    const AffineForm& phase, const LayerView& view) {
  const double d0 = layer.seen_d0_mm(), reach = d0 / display.emitter_pitch_mm(layer);
  const double columns = display.emitter_columns(), rows = display.emitter_rows();
  const double cosine = 1 / std::hypot(1.0, lenses.slant), sine = lenses.slant * cosine;
  const double bent = d0 * LensPowerPerMm(layer, lenses.focal_mm) * cosine;
  ConvexPolygon panel;
  for (const auto& [x, y] : {PlanePoint{0, 0}, {columns, 0}, {columns, rows}, {0, rows}}) {
    panel.Add({x, y});
  }
  const double width = lenses.subpixels_per_lens;
  // Right of the vertex, in pixels.
  const AffineForm offset{(phase.c - (lens + 0.5) * width) / 3, phase.x / 3, phase.y / 3};
  const AffineForm column = PlusTimes({0, 1, 0}, -bent * cosine, offset);
  const AffineForm row = PlusTimes({0, 0, 1}, bent * sine, offset);
  SeenElement element;
  element.cell = CellInPicture(CutBetween(panel, phase, lens * width, (lens + 1) * width), view);
  element.column =
      PlusTimes({0, 0, 0}, 3, PlusTimes(InPicture(column, view), -reach, view.slope_x));
  element.row = PlusTimes(InPicture(row, view), reach, view.slope_y);
  return element;
}

std::vector<SeenElement> SeenStrips(const Display& display, int index, const Lenticular& lenses,
                                    const LayerView& view) {
  const double columns = display.emitter_columns(), rows = display.emitter_rows();
  // 3x - 1/2 + offset - 3 (y - 1/2) slant, as VanBerkelView has it for real places.
  const AffineForm phase{-0.5 + lenses.offset_subpx + 1.5 * lenses.slant, 3, -3 * lenses.slant};
  double least = phase.At({0, 0}), most = least;
  for (const auto& [x, y] : {PlanePoint{columns, 0}, {columns, rows}, {0, rows}}) {
    least = std::min(least, phase.At({x, y}));
    most = std::max(most, phase.At({x, y}));
  }
  const double width = lenses.subpixels_per_lens;
  std::vector<SeenElement> elements;
  for (int lens = static_cast<int>(std::floor(least / width)); lens * width < most; ++lens) {
    elements.push_back(StripOf(display, display.layers[static_cast<std::size_t>(index)], lenses,
                               lens, phase, view));
  }
  return elements;
}

}  // namespace

double ConvexPolygon::Area() const {
  double twice = 0;
  for (int i = 1; i + 1 < size; ++i) {
    const PlanePoint &o = corners[0], &p = corners[static_cast<std::size_t>(i)],
                     &q = corners[static_cast<std::size_t>(i) + 1];
    twice += (p.x - o.x) * (q.y - o.y) - (q.x - o.x) * (p.y - o.y);
  }
  return std::abs(twice) / 2;
}

ConvexPolygon CutBetween(const ConvexPolygon& polygon, const AffineForm& form, double low,
                         double high) {
  return Cut(Cut(polygon, [&](const PlanePoint& p) { return low - form.At(p); }),
             [&](const PlanePoint& p) { return form.At(p) - high; });
}

std::array<double, 2> RowsOfCell(const ConvexPolygon& polygon) {
  std::array<double, 2> rows{polygon[0].y, polygon[0].y};
  for (int i = 1; i < polygon.size; ++i) {
    rows[0] = std::min(rows[0], polygon[i].y);
    rows[1] = std::max(rows[1], polygon[i].y);
  }
  return rows;
}

std::vector<SeenElement> SeenElements(const Display& display, int layer, const LayerView& view,
                                      int first_row, int end_row) {
  const Optics& optics = display.layers.at(static_cast<std::size_t>(layer)).optics;
  if (const Lenticular* lenses = std::get_if<Lenticular>(&optics)) {
    return SeenStrips(display, layer, *lenses, view);
  }
  return SeenLenslets(display, layer, std::get<LensletArray>(optics), view, first_row, end_row);
}

std::vector<SeenElement> ElementOfEveryRow(const Display& display, int layer,
                                           const LayerView& view) {
  const Layer& of = display.layers.at(static_cast<std::size_t>(layer));
  if (const Lenticular* lenses = std::get_if<Lenticular>(&of.optics)) {
    return SeenStrips(display, layer, *lenses, view);
  }
  const LensletArray& lenses = std::get<LensletArray>(of.optics);
  const LensRange range = LensesOf(display, lenses);
  std::vector<SeenElement> elements;
  for (int row = range.first_row; row <= range.last_row; ++row) {
    const Lens lens = LensOf(lenses, row, range.first_column);
    elements.push_back(ElementOf(display, of, lenses, lens, view));
  }
  return elements;
}

}  // namespace lamella
