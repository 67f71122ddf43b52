#include "pipeline/report/plane_figures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/report/svg_drawing.h"

namespace lamella {
namespace {

constexpr double kPlanesWidth = 448, kPlanesHeight = 190;
constexpr double kPlanesLeft = 76, kPlanesRight = 8, kPlanesTop = 12, kPlanesBottom = 26;
constexpr const char* kAxis = "stroke=\"var(--line)\"";
constexpr const char* kLimit = "stroke=\"var(--muted)\" stroke-dasharray=\"5 4\"";

// Planes to the right, a number from `low` to `high` upwards.
struct PlaneAxes {
  std::size_t num_planes;
  double low, high;

  double Step() const {
    return (kPlanesWidth - kPlanesLeft - kPlanesRight) / static_cast<double>(num_planes);
  }
  double X(std::size_t plane) const {
    return kPlanesLeft + (static_cast<double>(plane) + 0.5) * Step();
  }
  double Y(double value) const {
    const double share = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return kPlanesHeight - kPlanesBottom - share * (kPlanesHeight - kPlanesTop - kPlanesBottom);
  }
};

void DrawLevel(const PlaneAxes& axes, double value, const char* style, SvgDrawing& drawing) {
  const double y = axes.Y(value);
  drawing.Line(kPlanesLeft, y, kPlanesWidth - kPlanesRight, y, style);
  drawing.Text(kPlanesLeft - 6, y + 5, "end", fmt::format("{:.3g}", value));
}

void DrawPlaneNumbers(const PlaneAxes& axes, SvgDrawing& drawing) {
  // Every plane's, or every few's.
  const std::size_t every = 1 + (axes.num_planes - 1) / 12;
  for (std::size_t plane = 0; plane < axes.num_planes; plane += every) {
    drawing.Text(axes.X(plane), kPlanesHeight - 6, "middle", fmt::format("{}", plane));
  }
}

double LargestFinite(const std::vector<double>& values, double least) {
  for (const double value : values) {
    if (std::isfinite(value)) least = std::max(least, std::abs(value));
  }
  return least;
}

std::string TextOf(const PlaneSeries& series, std::size_t plane) {
  std::string text = fmt::format("plane {}: {:.4g}", plane, series.values[plane]);
  if (!series.sds.empty()) text += fmt::format(" +- {:.2g}", series.sds[plane]);
  return series.unit.empty() ? text : text + " " + series.unit;
}

}  // namespace

std::string PlaneLineFigure(const PlaneSeries& series) {
  const std::size_t num = series.values.size();
  std::vector<double> ends = series.values;
  for (std::size_t i = 0; i < series.sds.size(); ++i) {
    ends.push_back(std::abs(series.values[i]) + series.sds[i]);
  }
  const double reach = LargestFinite(ends, 1e-12);
  const PlaneAxes axes{num, -reach, reach};
  SvgDrawing drawing(kPlanesWidth, kPlanesHeight, series.label);
  for (const double level : {-reach, 0.0, reach}) DrawLevel(axes, level, kAxis, drawing);
  for (std::size_t i = 0; i + 1 < num; ++i) {
    drawing.Line(axes.X(i), axes.Y(series.values[i]), axes.X(i + 1), axes.Y(series.values[i + 1]),
                 "stroke=\"var(--accent)\" stroke-opacity=\"0.5\"");
  }
  for (std::size_t i = 0; i < num; ++i) {
    const double x = axes.X(i), value = series.values[i];
    if (!series.sds.empty()) {
      drawing.Line(x, axes.Y(value - series.sds[i]), x, axes.Y(value + series.sds[i]),
                   "stroke=\"var(--ink)\" stroke-width=\"1.5\"");
    }
    drawing.Circle(x, axes.Y(value), 3, "fill=\"var(--accent)\"", TextOf(series, i));
  }
  DrawPlaneNumbers(axes, drawing);
  return drawing.Done();
}

std::string PlaneColumnFigure(const PlaneSeries& series, double low, double high) {
  const std::size_t num = series.values.size();
  const PlaneAxes axes{num, 0, LargestFinite(series.values, 1.25 * high)};
  SvgDrawing drawing(kPlanesWidth, kPlanesHeight, series.label);
  const double foot = axes.Y(0), width = std::min(0.7 * axes.Step(), 48.0);
  for (std::size_t i = 0; i < num; ++i) {
    const double value = series.values[i];  // NaN and infinite: of full height
    const double top = std::isfinite(value) ? axes.Y(value) : axes.Y(axes.high);
    const bool inside = value >= low && value <= high;
    drawing.Rectangle(axes.X(i) - width / 2, top, width, foot - top,
                      fmt::format("fill=\"{}\"", inside ? "var(--accent)" : kSvgBeyond),
                      TextOf(series, i));
  }
  DrawLevel(axes, axes.high, kAxis, drawing);
  if (low > 0) DrawLevel(axes, low, kLimit, drawing);
  DrawLevel(axes, high, kLimit, drawing);
  drawing.Line(kPlanesLeft, foot, kPlanesWidth - kPlanesRight, foot, kAxis);
  DrawPlaneNumbers(axes, drawing);
  return drawing.Done();
}

}  // namespace lamella
