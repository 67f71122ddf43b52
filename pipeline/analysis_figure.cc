#include "pipeline/analysis_figure.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <fmt/format.h>

namespace lamella {
namespace {

constexpr double kWidth = 640, kLeft = 74, kRight = 22;
constexpr double kPlotHeight = 250, kHistogramHeight = 110;
constexpr double kLine = 23;             // of text
constexpr std::size_t kMostCurves = 32;  // of single layers; more would be a grey area
constexpr const char* kCombined = "#0b6e75";
constexpr const char* kBeam = "#c44601";
constexpr const char* kSingle = "#9aa3ad";
constexpr const char* kScene = "#5b7fb4";

// A value's place; `from` and `to` are places of `low` and `high`.
struct Scale {
  double low = 0, high = 1, from = 0, to = 1;
  double At(double value) const { return from + (value - low) / (high - low) * (to - from); }
};

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

// A step of 1, 2 or 5 times a power of ten, with at most so many of them.
double NiceStep(double length, int most) {
  const double step = length / most, power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::vector<double> Ticks(const Scale& scale, int most) {
  const double step = NiceStep(scale.high - scale.low, most);
  std::vector<double> ticks;
  const auto last = static_cast<long>(std::floor(scale.high / step + 1e-9));
  for (auto i = static_cast<long>(std::ceil(scale.low / step - 1e-9)); i <= last; ++i) {
    ticks.push_back(static_cast<double>(i) * step);
  }
  return ticks;
}

void AddText(std::string& svg, double x, double y, const char* anchor, const std::string& text) {
  fmt::format_to(std::back_inserter(svg),
                 "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                 Escaped(text));
}

void Line(std::string& svg, double x1, double y1, double x2, double y2, const char* color,
          const char* more = "") {
  fmt::format_to(
      std::back_inserter(svg),
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"{}/>\n", x1, y1,
      x2, y2, color, more);
}

struct Frame {
  Scale x, y;
};

// Axes with ticks, grid lines and the labels of what is on them.
void DrawAxes(std::string& svg, const Frame& frame, int y_ticks, const std::string& y_label,
              const std::string& x_label) {
  const double bottom = frame.y.from, top = frame.y.to;
  for (const double tick : Ticks(frame.y, y_ticks)) {
    const double y = frame.y.At(tick);
    Line(svg, frame.x.from, y, frame.x.to, y, "#e3e6ea");
    AddText(svg, frame.x.from - 7, y + 5.5, "end", fmt::format("{:.4g}", tick + 0.0));
  }
  for (const double tick : Ticks(frame.x, 7)) {
    const double x = frame.x.At(tick);
    Line(svg, x, bottom, x, bottom + 5, "#59616d");
    if (!x_label.empty()) AddText(svg, x, bottom + 22, "middle", fmt::format("{:.6g}", tick + 0.0));
  }
  Line(svg, frame.x.from, bottom, frame.x.to, bottom, "#59616d");
  if (!x_label.empty()) {
    AddText(svg, (frame.x.from + frame.x.to) / 2, bottom + 46, "middle", x_label);
  }
  fmt::format_to(std::back_inserter(svg),
                 "<text transform=\"translate(18 {:.1f}) rotate(-90)\" "
                 "text-anchor=\"middle\">{}</text>\n",
                 (bottom + top) / 2, Escaped(y_label));
}

void DrawCurve(std::string& svg, const Frame& frame, const std::vector<double>& x,
               const std::vector<double>& y, const char* style) {
  svg += "<polyline fill=\"none\" ";
  svg += style;
  svg += " points=\"";
  for (std::size_t i = 0; i < x.size(); ++i) {
    fmt::format_to(std::back_inserter(svg), "{:.2f},{:.2f} ", frame.x.At(x[i]), frame.y.At(y[i]));
  }
  svg += "\"/>\n";
}

struct LegendEntry {
  enum class Mark { kCurve, kArea, kPosition };
  Mark mark = Mark::kCurve;
  std::string style;
  std::string text;
};

std::string Style(const char* color, double width, const char* more) {
  return fmt::format("stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{}", color, width,
                     more);
}

const std::string& SingleStyle() {
  static const std::string style = Style(kSingle, 1.5, "");
  return style;
}
const std::string& CombinedStyle() {
  static const std::string style = Style(kCombined, 3.5, "");
  return style;
}
const std::string& BeamStyle() {
  static const std::string style = Style(kBeam, 2.5, " stroke-dasharray=\"9 5\"");
  return style;
}

bool DrawsLayers(const Analysis& analysis) {
  return analysis.cutoff.size() > 1 && analysis.cutoff.size() <= kMostCurves;
}

std::vector<LegendEntry> Legend(const Display& display, const Analysis& analysis, bool scene) {
  using Mark = LegendEntry::Mark;
  std::vector<LegendEntry> legend;
  const std::string what = display.varifocal ? "plane" : "layer";
  if (DrawsLayers(analysis)) {
    legend.push_back(
        {Mark::kCurve, SingleStyle(), fmt::format("cut-off of each {} (Eq. 1)", what)});
  }
  legend.push_back({Mark::kCurve, CombinedStyle(),
                    analysis.cutoff.size() > 1 ? fmt::format("combined: the best {}'s", what)
                                               : "cut-off of the layer (Eq. 1)"});
  legend.push_back({Mark::kCurve, BeamStyle(), "with the real width of its beams"});
  legend.push_back({Mark::kPosition, "", fmt::format("where a {} stands", what)});
  if (scene) {
    legend.push_back({Mark::kArea, fmt::format("fill=\"{}\"", kScene), "depth of the scene"});
  }
  return legend;
}

void DrawPosition(std::string& svg, double x, double bottom) {
  fmt::format_to(std::back_inserter(svg),
                 "<path d=\"M{:.1f} {:.1f}l-5 -9h10z\" fill=\"#1a1f27\"/>\n", x, bottom);
}

// Returns the height that it took.
double DrawLegend(std::string& svg, const std::vector<LegendEntry>& legend, double top) {
  auto out = std::back_inserter(svg);
  for (const LegendEntry& entry : legend) {
    const double middle = top + kLine / 2;
    if (entry.mark == LegendEntry::Mark::kArea) {
      fmt::format_to(out, "<rect x=\"{}\" y=\"{:.1f}\" width=\"34\" height=\"12\" {}/>\n", kLeft,
                     middle - 6, entry.style);
    } else if (entry.mark == LegendEntry::Mark::kPosition) {
      DrawPosition(svg, kLeft + 17, middle + 5);
    } else {
      fmt::format_to(out, "<path d=\"M{} {:.1f}h34\" {}/>\n", kLeft, middle, entry.style);
    }
    AddText(svg, kLeft + 44, middle + 5.5, "start", entry.text);
    top += kLine;
  }
  return kLine * static_cast<double>(legend.size());
}

void DrawCutoffs(std::string& svg, const Frame& frame, const Analysis& analysis) {
  if (DrawsLayers(analysis)) {
    for (const std::vector<double>& layer : analysis.cutoff) {
      DrawCurve(svg, frame, analysis.depths_mm, layer, SingleStyle().c_str());
    }
  }
  DrawCurve(svg, frame, analysis.depths_mm, analysis.combined, CombinedStyle().c_str());
  DrawCurve(svg, frame, analysis.depths_mm, analysis.combined_beam, BeamStyle().c_str());
  for (const LayerFigures& layer : analysis.layers) {
    DrawPosition(svg, frame.x.At(layer.position_mm), frame.y.from);
  }
}

void DrawHistogram(std::string& svg, const Frame& frame, const SceneFigures& scene) {
  svg += fmt::format("<g fill=\"{}\">\n", kScene);
  for (std::size_t i = 0; i < scene.share.size(); ++i) {
    const double left = frame.x.At(scene.edges_mm[i]), right = frame.x.At(scene.edges_mm[i + 1]);
    const double top = frame.y.At(100 * scene.share[i]);
    if (scene.share[i] == 0) continue;
    fmt::format_to(std::back_inserter(svg),
                   "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>\n", left,
                   top, right - left, frame.y.from - top);
  }
  svg += "</g>\n";
}

std::vector<std::string> Heading(const Display& display,
                                 const std::optional<SceneAnalysis>& scene) {
  constexpr std::size_t kLongest = 48;  // of a name, in bytes
  std::vector<std::string> lines{"Cut-off over depth"};
  if (display.name.size() <= kLongest) lines[0] += ": " + display.name;
  if (!scene) return lines;
  const SceneFigures& f = scene->figures;
  std::string kept =
      fmt::format("{:.1f} % of the scene's pixels at full resolution", 100 * f.sharp_share);
  if (f.detail_kept) kept += fmt::format(", {:.1f} % of its detail kept", 100 * *f.detail_kept);
  lines.push_back(kept);
  return lines;
}

}  // namespace

std::string AnalysisFigure(const Display& display, const Analysis& analysis,
                           const std::optional<SceneAnalysis>& scene) {
  const std::vector<LegendEntry> legend = Legend(display, analysis, scene.has_value());
  const std::vector<std::string> heading = Heading(display, scene);
  std::string body;
  double y = 30;
  for (const std::string& line : heading) {
    AddText(body, 18, y, "start", line);
    y += kLine;
  }
  y += DrawLegend(body, legend, y - 10);
  const Scale across{analysis.depths_mm.front(), analysis.depths_mm.back(), kLeft, kWidth - kRight};
  double highest = 0;
  for (const double cutoff : analysis.combined) highest = std::max(highest, cutoff);
  Frame frame{across, {0, 1.08 * highest, y + kPlotHeight, y + 6}};
  const char* kDepth = "depth z, mm (viewer on the right)";
  DrawAxes(body, frame, 6, "cut-off, cycles/mm", scene ? "" : kDepth);
  DrawCutoffs(body, frame, analysis);
  y += kPlotHeight;
  if (scene) {
    double most = 1e-6;
    for (const double share : scene->figures.share) most = std::max(most, 100 * share);
    frame.y = {0, 1.05 * most, y + 20 + kHistogramHeight, y + 20};
    DrawAxes(body, frame, 3, "pixels, %", kDepth);
    DrawHistogram(body, frame, scene->figures);
    y = frame.y.from;
  }
  y += 62;
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" role=\"img\" "
             "aria-label=\"{2}\" font-family=\"system-ui, 'Liberation Sans', sans-serif\" "
             "font-size=\"16\" fill=\"#1a1f27\">\n"
             "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
             kWidth, y, "Cut-off over depth") +
         body + "</svg>\n";
}

}  // namespace lamella
