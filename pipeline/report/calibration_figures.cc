#include "pipeline/report/calibration_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr double kFigureWidth = 448, kCellRows = 5;
constexpr const char* kInk = "var(--accent)";
constexpr const char* kBeyond = "#e08a1e";
constexpr double kLargestMeanPx = 0.03;            // calibration.md section 7
constexpr double kLowChi2 = 0.7, kHighChi2 = 1.5;  // likewise

template <class... Args>
void Add(std::string& svg, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(svg), format, std::forward<Args>(args)...);
  svg += '\n';
}

std::string Open(double width, double height, const std::string& label) {
  return fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n", width, height,
                     EscapedHtml(label));
}

void Text(std::string& svg, double x, double y, const char* anchor, const std::string& text) {
  Add(svg, "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>", x, y, anchor,
      EscapedHtml(text));
}

// A cell as dark as its share of what is allowed, in another colour beyond that.
void Cell(std::string& svg, double x, double y, double width, double height, double share,
          const std::string& title) {
  const bool beyond = share > 1;
  Add(svg,
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" "
      "fill-opacity=\"{:.2f}\" stroke=\"var(--line)\"><title>{}</title></rect>",
      x, y, width, height, beyond ? kBeyond : kInk, beyond ? 0.5 : 0.05 + 0.55 * share,
      EscapedHtml(title));
}

double Degrees(double slope) { return std::atan(slope) * 180 / std::numbers::pi; }

// Cameras as they stand to the reference stack.
std::vector<Vector2d> Directions(const CalibrationReport& report) {
  const auto layer = static_cast<std::size_t>(report.reference.layer);
  const Rigid stack_from_display = Inverse(report.calibration.layers[layer].display_from_stack);
  std::vector<Vector2d> directions;
  for (const Rigid& camera_from_display : report.camera_from_display) {
    const Eigen::Vector3d at = stack_from_display * Centre(camera_from_display);
    directions.emplace_back(Degrees(at.x() / at.z()), Degrees(at.y() / at.z()));
  }
  return directions;
}

constexpr int kProbedColumns = 7, kProbedRows = 5;  // of RaysToProbe
constexpr std::size_t kProbed = 35;

// RMS over eyes and largest deviation at the reference panel's places.
struct Deviations {
  double sum = 0, largest = 0, num = 0;
  double Rms() const { return num > 0 ? std::sqrt(sum / num) : std::nan(""); }
};
std::vector<Deviations> DeviationsOf(const CalibrationReport& report, const PanelId& panel) {
  std::vector<Deviations> places(kProbed);
  std::size_t place = 0;
  for (std::size_t i = 0; i < report.probed.size(); ++i) {
    if (report.probed[i].panel != panel) continue;
    Deviations& at = places[place];
    place = (place + 1) % places.size();  // places run fastest
    const double sd = report.rays.sd_px[i];
    if (std::isnan(sd)) continue;
    at.sum += sd * sd;
    at.largest = std::max(at.largest, sd);
    at.num += 1;
  }
  return places;
}

// Where degrees fall in a square figure.
struct Dial {
  double reach_deg, size;
  double X(double degrees) const { return size / 2 * (1 + degrees / reach_deg); }
  double Y(double degrees) const { return size / 2 * (1 - degrees / reach_deg); }
};

void DrawDial(std::string& svg, const Dial& dial) {
  Add(svg, "<rect width=\"{0}\" height=\"{0}\" fill=\"var(--ground)\" stroke=\"var(--line)\"/>",
      dial.size);
  for (double degrees = 10; degrees < dial.reach_deg; degrees += 10) {
    Add(svg, "<circle cx=\"{0}\" cy=\"{0}\" r=\"{1:.1f}\" fill=\"none\" stroke=\"var(--line)\"/>",
        dial.size / 2, dial.X(degrees) - dial.size / 2);
    Text(svg, dial.X(0) + 3, dial.Y(degrees) - 3, "start", fmt::format("{:.0f}°", degrees));
  }
}

void DrawEyes(std::string& svg, const Dial& dial, const EyeBox& box) {
  const double middle = (box.near_mm + box.far_mm) / 2;
  const double right = std::min(dial.reach_deg, Degrees(box.half_width_mm / middle));
  const double up = std::min(dial.reach_deg, Degrees(box.half_height_mm / middle));
  Add(svg,
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"var(--accent)\" "
      "fill-opacity=\"0.12\" stroke=\"var(--accent)\" stroke-dasharray=\"5 4\"/>",
      dial.X(-right), dial.Y(up), dial.X(right) - dial.X(-right), dial.Y(-up) - dial.Y(up));
}

}  // namespace

std::string EscapedHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string RayFigure(const CalibrationReport& report, const PanelId& panel, double limit_px) {
  constexpr double kCellWidth = kFigureWidth / kProbedColumns, kCellHeight = 40;
  std::string svg = Open(kFigureWidth, kCellHeight * kProbedRows,
                         "Standard deviation of rays that meet " + NameOf(panel) + ", px");
  const std::vector<Deviations> places = DeviationsOf(report, panel);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t column = i % kProbedColumns, row = i / kProbedColumns;
    const double x = kCellWidth * static_cast<double>(column);
    const double y = kCellHeight * static_cast<double>(row);
    const double rms = places[i].Rms();
    if (std::isnan(rms)) {
      Cell(svg, x, y, kCellWidth, kCellHeight, 0, "no ray through here meets the panel");
      continue;
    }
    Cell(svg, x, y, kCellWidth, kCellHeight, rms / limit_px,
         fmt::format("{:.4f} px RMS over the eyes, {:.4f} px at worst", rms, places[i].largest));
    Text(svg, x + kCellWidth / 2, y + kCellHeight / 2 + 5, "middle", fmt::format("{:.4f}", rms));
  }
  return svg + "</svg>\n";
}

std::string ResidualFigure(const ResidualMap& map) {
  constexpr double kCellWidth = kFigureWidth / ResidualMap::kColumns, kCellHeight = 48;
  constexpr double kUnitsPerPx = 20 / kLargestMeanPx;  // an arrow that is allowed fits its cell
  std::string svg =
      Open(kFigureWidth, kCellHeight * kCellRows, "Residuals of " + NameOf(map.panel));
  int most = 1;
  for (const ResidualCell& cell : map.cells) most = std::max(most, cell.num_points);
  for (int row = 0; row < ResidualMap::kRows; ++row) {
    for (int column = 0; column < ResidualMap::kColumns; ++column) {
      const ResidualCell& cell = map.At(column, row);
      const double x = kCellWidth * column, y = kCellHeight * row;
      Cell(svg, x, y, kCellWidth, kCellHeight, 0.5 * cell.num_points / most,
           fmt::format("{} points, mean ({:.4f}, {:.4f}) px, RMS {:.3f} px", cell.num_points,
                       cell.mean_px.x(), cell.mean_px.y(), cell.rms_px));
      Text(svg, x + kCellWidth - 4, y + kCellHeight - 4, "end", fmt::format("{}", cell.num_points));
      if (cell.num_points == 0) continue;
      const bool beyond = cell.mean_px.norm() > kLargestMeanPx;
      const Vector2d arrow =
          kUnitsPerPx * cell.mean_px * std::min(1.0, 1.3 * kLargestMeanPx / cell.mean_px.norm());
      const double from_x = x + kCellWidth / 2, from_y = y + kCellHeight / 2;
      Add(svg,
          "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"2.2\" fill=\"{4}\"/><line x1=\"{0:.1f}\" "
          "y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{3:.1f}\" stroke=\"{4}\" stroke-width=\"2.5\"/>",
          from_x, from_y, from_x + arrow.x(), from_y + arrow.y(), beyond ? kBeyond : "var(--ink)");
    }
  }
  return svg + "</svg>\n";
}

std::string DirectionFigure(const CalibrationReport& report) {
  const std::vector<Vector2d> directions = Directions(report);
  double reach = 35;
  for (const Vector2d& at : directions) reach = std::max(reach, at.cwiseAbs().maxCoeff() + 5);
  const Dial dial{std::min(reach, 90.0), kFigureWidth};
  std::string svg = Open(kFigureWidth, kFigureWidth, "Directions of the cameras");
  DrawDial(svg, dial);
  DrawEyes(svg, dial, report.limits.eye_box);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double x = dial.X(directions[i].x()), y = dial.Y(directions[i].y());
    Add(svg, "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"var(--ink)\"/>", x, y);
    Text(svg, x + 8, y + 5, "start", fmt::format("{}", report.views[i] + 1));
  }
  if (report.next_view) {
    Add(svg,
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"11\" fill=\"none\" stroke=\"{}\" "
        "stroke-width=\"3\"/>",
        dial.X(report.next_view->right_deg), dial.Y(report.next_view->up_deg), kBeyond);
  }
  return svg + "</svg>\n";
}

std::string Chi2Figure(const std::vector<FitOf>& fits) {
  constexpr double kLeft = 150, kRight = 54, kRow = 26;
  double most = 1.2 * kHighChi2;
  for (const FitOf& fit : fits) most = std::max(most, fit.chi2);
  const double scale = (kFigureWidth - kLeft - kRight) / most;
  const double height = kRow * static_cast<double>(fits.size());
  std::string svg = Open(kFigureWidth, height, "Chi squared per degree of freedom");
  Add(svg,
      "<rect x=\"{:.1f}\" y=\"0\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"var(--line)\" "
      "fill-opacity=\"0.5\"/>",
      kLeft + scale * kLowChi2, scale * (kHighChi2 - kLowChi2), height);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const FitOf& fit = fits[i];
    const double y = kRow * static_cast<double>(i);
    const bool inside = fit.chi2 >= kLowChi2 && fit.chi2 <= kHighChi2;
    Text(svg, kLeft - 8, y + 18, "end", fit.name);
    Add(svg,
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"><title>{} "
        "of "
        "{} points, RMS {:.4f} px</title></rect>",
        kLeft, y + 5, scale * fit.chi2, kRow - 10, inside ? kInk : kBeyond, fit.num_used,
        fit.num_points, fit.rms_px);
    Text(svg, kLeft + scale * fit.chi2 + 6, y + 18, "start", fmt::format("{:.2f}", fit.chi2));
  }
  return svg + "</svg>\n";
}

}  // namespace lamella
