// Layers whose optics are no product of two axes: lenses.
#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>
#include <vector>

#include "distribute/seen_elements.h"
#include "distribute/seen_layer.h"
#include "lightfield/layer_map.h"

namespace lamella {
namespace {

LayerView ViewOf(const Display& display, int index, const Eye& eye) {
  const Layer& layer = display.layers[static_cast<std::size_t>(index)];
  const double pitch = display.emitter_pitch_mm(layer), d = eye.position.z() - eye.plane_mm;
  const double share = (layer.position_mm - eye.plane_mm) / d;
  const double to_px = 1 / ((1 - share) * eye.pixel_mm);
  const Eigen::Vector3d& e = eye.position;
  LayerView view;
  view.scale = pitch * to_px;
  view.offset_x = -(display.emitter_columns() / 2.0 * pitch + e.x() * share) * to_px -
                  eye.left_mm / eye.pixel_mm;
  view.offset_y =
      eye.top_mm / eye.pixel_mm - (display.emitter_rows() / 2.0 * pitch - e.y() * share) * to_px;
  view.slope_x = {(e.x() - eye.left_mm) / d, -eye.pixel_mm / d, 0};
  view.slope_y = {(e.y() - eye.top_mm) / d, 0, eye.pixel_mm / d};
  return view;
}

// Lenses: every element's polygon is cut to the pixels, and those to the emitters seen there.
class ThroughLenses final : public LayerSeen {
 public:
  ThroughLenses(const EmitterStrip& strip, const Display& display, int layer, const Eye& eye,
                const RowRange& rows)
      : emitters_(strip.images->slots[static_cast<std::size_t>(layer)][0]),
        first_row_(strip.first_row[static_cast<std::size_t>(layer)]),
        panel_rows_(display.emitter_rows()),
        map_(display, layer),
        elements_(SeenElements(display, layer, ViewOf(display, layer, eye), rows.first, rows.end)) {
    const Layer& of = display.layers[static_cast<std::size_t>(layer)];
    black_ = 1 / display.contrast;
    subpixels_ = std::holds_alternative<Lenticular>(of.optics);
    mirrored_ = of.mirror_x;
    rays_ = subpixels_ ? 0 : std::get<LensletArray>(of.optics).rays;
  }

  void Add(PictureRows& band) const override {
    for (const SeenElement& element : elements_) {
      const auto [top, bottom] = RowsOfCell(element.cell);
      const double first = std::max<double>(std::floor(top), band.first_row);
      const double end = std::min<double>(std::ceil(bottom), band.end_row);
      for (int y = static_cast<int>(first); y < end; ++y) AddRowOf(element, y, band);
    }
  }

 private:
  void AddRowOf(const SeenElement& element, int y, PictureRows& band) const {
    const ConvexPolygon part = CutBetween(element.cell, {0, 0, 1}, y, y + 1);
    if (part.size < 3) return;
    double left = part[0].x, right = left;
    for (int i = 1; i < part.size; ++i) {
      left = std::min(left, part[i].x);
      right = std::max(right, part[i].x);
    }
    const double first = std::max(std::floor(left), 0.0);
    const double end = std::min<double>(std::ceil(right), band.sums.width());
    for (int x = static_cast<int>(first); x < end; ++x) {
      AddPiece(element, CutBetween(part, {0, 1, 0}, x, x + 1), band.sums(x, y - band.first_row));
    }
  }

  // Calls add(part, index) for the parts of a piece that lie between whole values of the form.
  template <class AddPart>
  static void Split(const ConvexPolygon& piece, const AffineForm& form, const AddPart& add) {
    if (piece.size < 3) return;
    double least = form.At(piece[0]), most = least;
    for (int i = 1; i < piece.size; ++i) {
      least = std::min(least, form.At(piece[i]));
      most = std::max(most, form.At(piece[i]));
    }
    const double first = std::floor(least), last = std::ceil(most) - 1;
    if (last <= first) return add(piece, first);
    for (double at = first; at <= last; ++at) add(CutBetween(piece, form, at, at + 1), at);
  }

  void AddPiece(const SeenElement& element, const ConvexPolygon& piece, Seen& sum) const {
    Split(piece, element.column, [&](const ConvexPolygon& part, double column) {
      Split(part, element.row, [&](const ConvexPolygon& of_emitter, double row) {
        AddEmitter(element, column, row, of_emitter.Area(), sum);
      });
    });
  }

  void AddEmitter(const SeenElement& element, double column, double row, double area,
                  Seen& sum) const {
    const double per_pixel = subpixels_ ? 3 : 1;
    if (!(column >= 0 && column < per_pixel * emitters_.color.width() && row >= 0 &&
          row < panel_rows_)) {
      return;
    }
    const int x = static_cast<int>(column / per_pixel), y = static_cast<int>(row);
    const bool guard = !subpixels_ && !IsLit(element, x, y);
    if (guard && black_ == 0) return;
    const Rgb color = guard ? Rgb{} : emitters_.color(x, y - first_row_);
    const int third = static_cast<int>(column) % 3;
    const int channel = subpixels_ ? (mirrored_ ? 2 - third : third) : -1;
    const auto light = [&](float content) {
      return area * per_pixel * (black_ + (1 - black_) * static_cast<double>(content));
    };
    if (channel < 0 || channel == 0) sum.r += light(color.r);
    if (channel < 0 || channel == 1) sum.g += light(color.g);
    if (channel < 0 || channel == 2) sum.b += light(color.b);
    if (guard) return;
    sum.known += area * static_cast<double>(emitters_.coverage(x, y - first_row_));
    sum.all += area;
  }

  bool IsLit(const SeenElement& element, int x, int y) const {
    const int column = x - element.window_column, row = y - element.window_row;
    if (column >= 0 && column < rays_ && row >= 0 && row < rays_) return true;
    return map_.BeamOf(0, 0, x, y).has_value();
  }

  const EmitterImage& emitters_;
  const int first_row_, panel_rows_;
  const LayerMap map_;
  const std::vector<SeenElement> elements_;
  double black_ = 0;  // of white
  bool subpixels_ = false, mirrored_ = false;
  int rays_ = 0;
};

// The emitters' rows that an element shows between two rows of the picture. A row more on both
// sides is room for what is rounded otherwise where the parts are cut smaller.
RowRange RowsOf(const SeenElement& element, double top, double bottom, int panel_rows) {
  const ConvexPolygon part = CutBetween(element.cell, {0, 0, 1}, top, bottom);
  if (part.size == 0) return {};
  double least = element.row.At(part[0]), most = least;
  for (int i = 1; i < part.size; ++i) {
    least = std::min(least, element.row.At(part[i]));
    most = std::max(most, element.row.At(part[i]));
  }
  const double rows = panel_rows;
  return {static_cast<int>(std::clamp(std::floor(least) - 1, 0.0, rows)),
          static_cast<int>(std::clamp(std::floor(most) + 2, 0.0, rows))};
}

}  // namespace

std::unique_ptr<LayerSeen> SeeThroughLenses(const EmitterStrip& strip, const Display& display,
                                            int layer, const Eye& eye, const RowRange& rows) {
  return std::make_unique<ThroughLenses>(strip, display, layer, eye, rows);
}

std::vector<RowRange> RowsThroughLenses(const Display& display, int layer, const Eye& eye) {
  std::vector<RowRange> bands(
      static_cast<std::size_t>((eye.height + kPictureBandRows - 1) / kPictureBandRows));
  for (const SeenElement& element :
       ElementOfEveryRow(display, layer, ViewOf(display, layer, eye))) {
    const auto [top, bottom] = RowsOfCell(element.cell);
    const int first = static_cast<int>(std::max(0.0, std::floor(top / kPictureBandRows)));
    for (int b = first; b < static_cast<int>(bands.size()) && b * kPictureBandRows < bottom; ++b) {
      RowRange& band = bands[static_cast<std::size_t>(b)];
      band = band.With(RowsOf(element, b * kPictureBandRows, (b + 1) * kPictureBandRows,
                              display.emitter_rows()));
    }
  }
  return bands;
}

}  // namespace lamella
