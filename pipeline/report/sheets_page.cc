#include "pipeline/report/sheets_page.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pipeline/report/calibration_figures.h"
#include "pipeline/report/page_parts.h"

namespace lamella {
namespace {

std::string NameOfSheet(const SolvedSheet& sheet) { return fmt::format("layer {}", sheet.layer); }

std::string SheetsApart(const LatticeReport& report) {
  std::string text;
  for (const double apart : report.apart_mm) {
    text += fmt::format("{}{:.0f} mm", text.empty() ? "" : " and ", apart);
  }
  return report.num_views < 2 ? "one position only" : text + " apart";
}

std::string SheetsVerdict(const SolvedSheets& solved) {
  std::vector<std::pair<std::string, std::string>> facts;
  for (const SolvedSheet& sheet : solved.sheets) {
    const LatticeReport& report = sheet.report;
    const std::string name = NameOfSheet(sheet);
    facts.emplace_back(
        fmt::format("Lenses of {} are known to", name),
        fmt::format("{:.4f} px at worst ({} asked for), {:.4f} px RMS: what eyes "
                    "see through them at the panel's edges",
                    report.drift_max_px, report.largest_drift_px, report.drift_rms_px));
    facts.emplace_back("Cameras across its lenses", SheetsApart(report));
    facts.emplace_back(
        "Samples",
        fmt::format("{} of {} used, each {:.2f} px off the lattice{}", report.num_used,
                    report.num_samples, report.noise_px,
                    sheet.faint ? "; by the finest sinusoid alone, since it is faint" : ""));
  }
  if (solved.board) {
    const BoardCameras& cameras = solved.board->cameras;
    facts.emplace_back("The camera, by the printed board",
                       fmt::format("{} of {} corners in {} photographs, {:.3f} px RMS; focal "
                                   "length {:.1f} ± {:.1f} px",
                                   cameras.num_used, cameras.num_corners, cameras.views.size(),
                                   cameras.rms_px, cameras.found.camera.fx, cameras.focal_sd_px));
  }
  return PageVerdict(solved.failures().empty(), facts);
}

// As the first sheet sees them.
std::vector<CameraDirection> SheetsCameras(const SolvedSheets& solved) {
  const SolvedSheet& sheet = solved.sheets.front();
  std::vector<CameraDirection> cameras;
  for (std::size_t i = 0; i < sheet.positions.size(); ++i) {
    cameras.push_back(
        {DirectionTo(sheet.eyes_mm[i]), fmt::format("{}", sheet.positions[i] + 1), false});
  }
  if (!solved.board) return cameras;
  const BoardCameras& board = solved.board->cameras;
  const Rigid stack_from_board =
      Inverse(sheet.report.layer.display_from_stack) * solved.board->display_from_board;
  for (std::size_t i = 0; i < board.views.size(); ++i) {
    const int position = board.views[i];
    if (std::count(sheet.positions.begin(), sheet.positions.end(), position) > 0) continue;
    cameras.push_back({DirectionTo(stack_from_board * Centre(board.found.camera_from_board[i])),
                       fmt::format("{}", position + 1), true});
  }
  return cameras;
}

std::optional<Eigen::Vector3d> NextEyeOf(const SolvedSheets& solved) {
  for (const SolvedSheet& sheet : solved.sheets) {
    if (sheet.report.next_eye) return sheet.report.next_eye;
  }
  return std::nullopt;
}

std::string SheetsPositions(const SolvedSheets& solved) {
  std::vector<std::vector<std::string>> rows;
  for (const SolvedSheet& sheet : solved.sheets) {
    for (std::size_t i = 0; i < sheet.positions.size(); ++i) {
      const FitOf& fit = sheet.report.views_fit[i];
      const Eigen::Vector3d& eye = sheet.eyes_mm[i];
      rows.push_back({fmt::format("{}, {}", sheet.positions[i] + 1, NameOfSheet(sheet)),
                      fmt::format("({:.1f}, {:.1f}, {:.1f})", eye.x(), eye.y(), eye.z()),
                      fmt::format("{}", fit.num_used), fmt::format("{}", fit.num_points),
                      fmt::format("{:.3f}", fit.rms_px)});
    }
  }
  return HtmlTable({"position", "camera, mm before the sheet", "samples used", "of", "RMS px"},
                   rows);
}

std::string SheetsViews(const SolvedSheets& solved) {
  std::optional<Eigen::Vector2d> next_degrees;
  std::string ring = "no place is asked for, positions are apart enough across the lenses";
  if (const auto next = NextEyeOf(solved)) {
    next_degrees =
        DirectionTo(Inverse(solved.sheets.front().report.layer.display_from_stack) * *next);
    ring = fmt::format(
        "orange ring: where a further position would tell the lenses' pitch and phase from their "
        "gap, ({:.0f}, {:.0f}, {:.0f}) mm",
        next->x(), next->y(), next->z());
  }
  const std::string hollow = solved.board ? " (hollow: of the printed board alone)" : "";
  return PageSection(
      "Camera positions",
      PageNote(fmt::format("Cameras by their number{}, in degrees from the normal of layer {}; "
                           "dashed: where eyes are; {}.",
                           hollow, solved.sheets.front().layer, ring)) +
          PageDrawings({{"Directions",
                         DirectionFigure(SheetsCameras(solved), solved.eye_box, next_degrees)}}) +
          SheetsPositions(solved));
}

std::string SheetsMaps(const SolvedSheets& solved) {
  std::vector<CaptionedDrawing> drawings;
  for (const SolvedSheet& sheet : solved.sheets) {
    const LatticeReport& report = sheet.report;
    const std::string name = NameOfSheet(sheet);
    std::vector<PlaceDeviation> places;
    for (const LensDrift& at : report.drift) places.push_back({at.rms_px, at.max_px});
    drawings.push_back({"Standard deviation of lenses, px, " + name,
                        DeviationFigure("Standard deviation of lenses of " + name, 3, places,
                                        report.largest_drift_px)});
    drawings.push_back(
        {fmt::format("Lenses off the lattice, {}; {:.3f} px are allowed", name,
                     report.largest_mean_px),
         ResidualFigure("Residuals of " + name, report.residuals, report.largest_mean_px)});
  }
  const EyeBox& box = solved.eye_box;
  return PageSection(
      "Where on the sheet",
      PageNote(fmt::format(
          "The sheet before the panel, as seen from the front. Standard deviation: of the panel's "
          "point that an eye sees through the lens at nine places from edge to edge; RMS over eyes "
          "within {:.0f} x {:.0f} mm, {:.0f} to {:.0f} mm away; orange: more than is asked for at "
          "worst.",
          2 * box.half_width_mm, 2 * box.half_height_mm, box.near_mm, box.far_mm)) +
          PageNote("Off the lattice: numbers, and darker cells: samples; lines: the mean of lens "
                   "centres as decoded less those of the lattice, in the panel's pixels (of "
                   "straight lenses across them). What is allowed, 0.03 px and what chance does, "
                   "would reach nearly to the cell's edge, and more is orange. Means that follow a "
                   "pattern are a sheet or panel that is bent or askew, or a camera that is "
                   "elsewhere.") +
          PageDrawings(drawings));
}

// A row of a number, its deviation and what was designed.
std::vector<std::string> NumberRow(const std::string& name, const std::string& unit, int digits,
                                   double value, double sd, const std::string& designed) {
  return {name, fmt::format("{:.{}f} {}", value, digits, unit),
          std::isfinite(sd) ? fmt::format("{:.2g} {}", sd, unit) : "unknown", designed};
}

std::string SheetsNumbers(const SolvedSheets& solved) {
  constexpr double kDegreesOfRadian = 180 / std::numbers::pi;
  const Calibration design = DesignCalibration(solved.display);
  std::vector<std::vector<std::string>> rows;
  for (const SolvedSheet& sheet : solved.sheets) {
    const LatticeReport& report = sheet.report;
    const LayerCalibration& is = report.layer;
    const LayerCalibration& was = design.layers[static_cast<std::size_t>(sheet.layer)];
    const LensLattice lattice = is.lattice.value_or(LensLattice{});
    const LensLattice designed = was.lattice.value_or(LensLattice{});
    const auto sd = [&](LatticeParameter i) {
      return report.covariance.allFinite() ? std::sqrt(std::max(0.0, report.covariance(i, i)))
                                           : std::numeric_limits<double>::infinity();
    };
    const auto add = [&](const char* name, const char* unit, int digits, double value, double of,
                         const std::string& by_design) {
      rows.push_back(
          NumberRow(NameOfSheet(sheet) + " " + name, unit, digits, value, of, by_design));
    };
    add("lens pitch", "mm", 6, lattice.pitch_mm, sd(kLatticePitch),
        fmt::format("{:.6f} mm", designed.pitch_mm));
    add("lens rotation", "degrees", 5, lattice.rotation_rad * kDegreesOfRadian,
        sd(kLatticeRotation) * kDegreesOfRadian,
        fmt::format("{:.5f} degrees", designed.rotation_rad * kDegreesOfRadian));
    add("lens phase", "lenses", 5, lattice.phase.x(), sd(kLatticePhase0), "");
    if (lattice.type != LensLattice::Type::kLine) {
      add("lens phase 2", "lenses", 5, lattice.phase.y(), sd(kLatticePhase1), "");
    }
    add("gap", "mm", 4, is.gap_mm, sd(kLatticeGap) * is.index,
        fmt::format("{:.4f} mm", was.gap_mm));
    rows.push_back({NameOfSheet(sheet) + " panel behind its lenses",
                    fmt::format("{:.2f} mm right, {:.2f} mm up, {:.3f} degrees", is.offset_mm.x(),
                                is.offset_mm.y(), is.rotation_rad.z() * kDegreesOfRadian),
                    "a fraction of a lens", "0"});
  }
  return PageSection("Parameters",
                     HtmlTable({"parameter", "measured", "standard deviation", "designed"}, rows));
}

}  // namespace

std::string SheetsPage(const SolvedSheets& solved) {
  return CalibrationHtml(
      solved.display.name, solved.photos.size(),
      SheetsVerdict(solved) + PageWeaknesses("What the photographs leave open", solved.failures()) +
          PageWeaknesses("What is weak", solved.warnings()) + SheetsViews(solved) +
          SheetsMaps(solved) + PageLines("Left out", solved.left_out) + SheetsNumbers(solved));
}

}  // namespace lamella
