#include "pipeline/report/calibration_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "pipeline/report/svg_drawing.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr double kFigureWidth = 448;
constexpr std::size_t kProbed = 35;  // places of RaysToProbe and RaysThroughPlanes

double Degrees(double slope) { return std::atan(slope) * 180 / std::numbers::pi; }

// A cell's mean residual as an arrow from its middle.
void DrawMean(const ResidualCell& cell, double x, double y, double limit_px, SvgDrawing& drawing) {
  if (cell.num_points == 0) return;
  const double length = cell.mean_px.norm();
  const bool beyond = length > std::hypot(limit_px, cell.ChancePx());
  const char* colour = beyond ? kSvgBeyond : "var(--ink)";
  constexpr double kUnitsAtLimit = 20;  // an arrow that is allowed fits its cell
  const double longest = 1.3 * limit_px;
  const Vector2d arrow =
      kUnitsAtLimit / limit_px * cell.mean_px * (length > longest ? longest / length : 1);
  drawing.Circle(x, y, 2.2, fmt::format("fill=\"{}\"", colour));
  drawing.Line(x, y, x + arrow.x(), y + arrow.y(),
               fmt::format("stroke=\"{}\" stroke-width=\"2.5\"", colour));
}

// Where degrees fall in a square figure.
struct Dial {
  double reach_deg, size;
  double X(double degrees) const { return size / 2 * (1 + degrees / reach_deg); }
  double Y(double degrees) const { return size / 2 * (1 - degrees / reach_deg); }
};

void DrawDial(const Dial& dial, SvgDrawing& drawing) {
  drawing.Rectangle(0, 0, dial.size, dial.size, "fill=\"var(--ground)\" stroke=\"var(--line)\"");
  for (double degrees = 10; degrees < dial.reach_deg; degrees += 10) {
    drawing.Circle(dial.size / 2, dial.size / 2, dial.X(degrees) - dial.size / 2,
                   "fill=\"none\" stroke=\"var(--line)\"");
    drawing.Text(dial.X(0) + 3, dial.Y(degrees) - 3, "start", fmt::format("{:.0f}°", degrees));
  }
}

void DrawEyes(const Dial& dial, const EyeBox& box, SvgDrawing& drawing) {
  const double middle = (box.near_mm + box.far_mm) / 2;
  const double right = std::min(dial.reach_deg, Degrees(box.half_width_mm / middle));
  const double up = std::min(dial.reach_deg, Degrees(box.half_height_mm / middle));
  drawing.Rectangle(dial.X(-right), dial.Y(up), dial.X(right) - dial.X(-right),
                    dial.Y(-up) - dial.Y(up),
                    "fill=\"var(--accent)\" fill-opacity=\"0.12\" stroke=\"var(--accent)\" "
                    "stroke-dasharray=\"5 4\"");
}

}  // namespace

std::vector<PlaceDeviation> DeviationsOf(const std::vector<ProbedRay>& probed,
                                         const RayUncertainty& rays,
                                         const std::optional<PanelId>& panel) {
  std::vector<PlaceDeviation> places(kProbed);
  std::vector<double> counts(kProbed);
  std::size_t next = 0;
  for (std::size_t i = 0; i < probed.size(); ++i) {
    if (panel && probed[i].panel != *panel) continue;
    const std::size_t place = next;
    next = (next + 1) % kProbed;  // places run fastest
    const double sd = rays.sd_px[i];
    if (std::isnan(sd)) continue;
    places[place].rms_px += sd * sd;
    places[place].max_px = std::max(places[place].max_px, sd);
    counts[place] += 1;
  }
  for (std::size_t i = 0; i < kProbed; ++i) {
    places[i].rms_px = std::sqrt(places[i].rms_px / counts[i]);
  }
  return places;
}

std::string DeviationFigure(const std::string& label, int columns,
                            const std::vector<PlaceDeviation>& places, double limit_px) {
  constexpr double kCellHeight = 40;
  const double width = kFigureWidth / columns;
  const auto per_row = static_cast<std::size_t>(columns);
  const std::size_t num_rows = places.size() / per_row;
  SvgDrawing drawing(kFigureWidth, kCellHeight * static_cast<double>(num_rows), label);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t column = i % per_row, row = i / per_row;
    const double x = width * static_cast<double>(column);
    const double y = kCellHeight * static_cast<double>(row);
    const double rms = places[i].rms_px;
    if (std::isnan(rms)) {
      drawing.Cell(x, y, width, kCellHeight, 0, "no ray through here meets the panel");
      continue;
    }
    drawing.Cell(
        x, y, width, kCellHeight, rms / limit_px,
        fmt::format("{:.4f} px RMS over the eyes, {:.4f} px at worst", rms, places[i].max_px));
    drawing.Text(x + width / 2, y + kCellHeight / 2 + 5, "middle",
                 std::isfinite(rms) ? fmt::format("{:.4f}", rms) : "unknown");
  }
  return drawing.Done();
}

std::string ResidualFigure(const std::string& label, const ResidualMap& map, double limit_px) {
  constexpr double kWidth = kFigureWidth / ResidualMap::kColumns, kHeight = 48;
  SvgDrawing drawing(kFigureWidth, kHeight * ResidualMap::kRows, label);
  int most = 1;
  for (const ResidualCell& cell : map.cells) most = std::max(most, cell.num_points);
  for (int row = 0; row < ResidualMap::kRows; ++row) {
    for (int column = 0; column < ResidualMap::kColumns; ++column) {
      const ResidualCell& cell = map.At(column, row);
      const double x = kWidth * column, y = kHeight * row;
      drawing.Cell(x, y, kWidth, kHeight, 0.5 * cell.num_points / most,
                   fmt::format("{} points, mean ({:.4f}, {:.4f}) px, RMS {:.3f} px",
                               cell.num_points, cell.mean_px.x(), cell.mean_px.y(), cell.rms_px));
      drawing.Text(x + kWidth - 4, y + kHeight - 4, "end", fmt::format("{}", cell.num_points));
      DrawMean(cell, x + kWidth / 2, y + kHeight / 2, limit_px, drawing);
    }
  }
  return drawing.Done();
}

Vector2d DirectionTo(const Eigen::Vector3d& point_mm) {
  return {Degrees(point_mm.x() / point_mm.z()), Degrees(point_mm.y() / point_mm.z())};
}

std::string DirectionFigure(const std::vector<CameraDirection>& cameras, const EyeBox& eyes,
                            const std::optional<Vector2d>& next_degrees) {
  double reach = 35;
  for (const CameraDirection& camera : cameras) {
    reach = std::max(reach, camera.degrees.cwiseAbs().maxCoeff() + 5);
  }
  if (next_degrees) reach = std::max(reach, next_degrees->cwiseAbs().maxCoeff() + 5);
  const Dial dial{std::min(reach, 90.0), kFigureWidth};
  SvgDrawing drawing(kFigureWidth, kFigureWidth, "Directions of the cameras");
  DrawDial(dial, drawing);
  DrawEyes(dial, eyes, drawing);
  for (const CameraDirection& camera : cameras) {
    const double x = dial.X(camera.degrees.x()), y = dial.Y(camera.degrees.y());
    drawing.Circle(x, y, 5,
                   camera.of_board_alone
                       ? "fill=\"var(--ground)\" stroke=\"var(--ink)\" stroke-width=\"2\""
                       : "fill=\"var(--ink)\"",
                   fmt::format("position {}: {:.1f}° to the right, {:.1f}° up", camera.position,
                               camera.degrees.x(), camera.degrees.y()));
    drawing.Text(x + 8, y + 5, "start", camera.position);
  }
  if (next_degrees) {
    drawing.Circle(dial.X(next_degrees->x()), dial.Y(next_degrees->y()), 11,
                   fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"3\"", kSvgBeyond));
  }
  return drawing.Done();
}

std::vector<FitOf> InTheMean(std::vector<FitOf> fits, const std::vector<FitOf>& all) {
  double chi2 = 0, used = 0;
  for (const FitOf& fit : all) {
    chi2 += fit.chi2 * fit.num_used;
    used += fit.num_used;
  }
  constexpr double kRoundingChi2 = 1e-4;  // of photographs without noise
  if (!(chi2 > kRoundingChi2 * used)) return fits;
  for (FitOf& fit : fits) fit.chi2 *= used / chi2;
  return fits;
}

std::string Chi2Figure(const std::vector<FitOf>& fits) {
  constexpr double kLeft = 150, kRight = 54, kRow = 26;
  double most = 1.2 * kMostChi2Drawn;
  for (const FitOf& fit : fits) most = std::max(most, fit.chi2);
  const double scale = (kFigureWidth - kLeft - kRight) / most;
  const double height = kRow * static_cast<double>(fits.size());
  SvgDrawing drawing(kFigureWidth, height, "Chi squared in the mean of all");
  drawing.Rectangle(kLeft + scale * kLeastChi2Drawn, 0, scale * (kMostChi2Drawn - kLeastChi2Drawn),
                    height, "fill=\"var(--line)\" fill-opacity=\"0.5\"");
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const FitOf& fit = fits[i];
    const double y = kRow * static_cast<double>(i);
    const bool inside = fit.chi2 >= kLeastChi2Drawn && fit.chi2 <= kMostChi2Drawn;
    drawing.Text(kLeft - 8, y + 18, "end", fit.name);
    drawing.Rectangle(
        kLeft, y + 5, scale * fit.chi2, kRow - 10,
        fmt::format("fill=\"{}\"", inside ? "var(--accent)" : kSvgBeyond),
        fmt::format("{} of {} points, RMS {:.4f} px", fit.num_used, fit.num_points, fit.rms_px));
    drawing.Text(kLeft + scale * fit.chi2 + 6, y + 18, "start", fmt::format("{:.2f}", fit.chi2));
  }
  return drawing.Done();
}

}  // namespace lamella
