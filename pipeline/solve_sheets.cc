#include "pipeline/solve_sheets.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "calibration/lattice_place.h"
#include "lightfield/error.h"
#include "pipeline/calibration_report.h"
#include "pipeline/calibration_set_up.h"
#include "pipeline/check_photos.h"
#include "pipeline/phase_photos.h"
#include "pipeline/photo_numbers.h"
#include "pipeline/position_cameras.h"
#include "pipeline/sheet_sights.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

void CheckLayers(const Calibration& design) {
  for (std::size_t i = 0; i < design.layers.size(); ++i) {
    if (design.layers[i].lattice) continue;
    throw UsageError(design.display, fmt::format("layer {} has no lenses, others have", i),
                     "calibrate displays of one kind of layers");
  }
}

// The cameras of the positions that are used.
struct PlacedCameras {
  std::vector<int> positions;
  std::vector<View> views;   // of each
  Rigid display_from_world;  // theirs
  const BoardCameras* board = nullptr;
  std::set<std::string> photos;  // that tell them
};

PlacedCameras CamerasOfFile(const CheckedPhotos& checked, const fs::path& file) {
  PlacedCameras cameras;
  const std::map<int, View> known = CamerasOfPositions(checked, file);
  for (int position = 0; position < checked.num_views; ++position) {
    if (!IsComplete(checked, position)) continue;
    cameras.positions.push_back(position);
    cameras.views.push_back(CameraOfPosition(known, position, checked, file));
  }
  return cameras;
}

void Append(std::vector<std::string> lines, std::vector<std::string>& all) {
  all.insert(all.end(), std::make_move_iterator(lines.begin()),
             std::make_move_iterator(lines.end()));
}

PlacedCameras CamerasOfPrintedBoard(const CheckedPhotos& checked, const SolveSheetsOptions& options,
                                    SolvedSheets& solved) {
  solved.board.emplace();
  BoardCameras& board = solved.board->cameras;
  const std::vector<BoardPhoto> photos = BoardPhotosOf(checked, options.photos);
  board = CamerasOfBoard(photos, BodyOf(checked, options.focal_px),
                         BoardOf(checked, options.board_square_mm));
  PlacedCameras cameras;
  cameras.board = &board;
  for (const BoardPhoto& photo : photos) {
    const bool used = std::binary_search(board.views.begin(), board.views.end(), photo.view);
    if (used) cameras.photos.insert(photo.photo);
  }
  for (std::size_t i = 0; i < board.views.size(); ++i) {
    if (!IsComplete(checked, board.views[i])) continue;
    cameras.positions.push_back(board.views[i]);
    View view;
    view.camera = board.found.camera;
    view.camera_from_world = board.found.camera_from_board[i];
    cameras.views.push_back(view);
  }
  Append(PositionsWithoutBoard(checked, board.views), solved.left_out);
  Append(board.rejected, solved.left_out);
  return cameras;
}

PlacedCameras CamerasOf(const CheckedPhotos& checked, const SolveSheetsOptions& options,
                        SolvedSheets& solved) {
  Append(IncompletePositions(checked), solved.left_out);
  const bool by_board = options.cameras.empty() && checked.list.printed;
  PlacedCameras cameras = by_board ? CamerasOfPrintedBoard(checked, options, solved)
                                   : CamerasOfFile(checked, options.cameras);
  if (!cameras.positions.empty()) return cameras;
  throw InputError(options.photos.string(), "no position has all shots",
                   "`lamella calibrate check` says which are missing");
}

SheetSights SightsOf(const CalibratedPanel& panel, const CheckedPhotos& checked,
                     const std::vector<int>& positions, const fs::path& photos,
                     std::set<std::string>& names, Progress& progress) {
  const fs::path folder = fs::is_directory(photos) ? photos : photos.parent_path();
  SheetSights seen;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto set = ReadPhasePhotos(checked, folder, positions[i], panel, ReadMeanLight);
    progress.Advance();
    if (!set) continue;
    seen.Add(set->capture, static_cast<int>(i));
    names.insert(set->names.begin(), set->names.end());
  }
  if (seen.num_views > 0) return seen;
  throw InputError(photos.string(), "no position has all shots",
                   "`lamella calibrate check` says which are missing");
}

// Where the first panel is as designed.
Rigid DisplayFromBoard(SheetSights& seen, const std::vector<View>& views,
                       const LayerCalibration& design) {
  const auto in_frame = [&](SightedPixels& pixels) { return Through(pixels, views, Rigid{}); };
  if (!seen.IsFaint())
    return design.display_from_stack * StackFromFrame(in_frame(seen.whole), design);
  const Rigid rough = StackFromFrame(in_frame(seen.coarse), design);
  return design.display_from_stack * StackFromFrame(in_frame(seen.middle), design, rough);
}

SolvedSheet SolveSheet(int layer, SheetSights& seen, const PlacedCameras& cameras,
                       const LayerCalibration& design, LatticeOptions options) {
  const Rigid stack_from_world = Inverse(design.display_from_stack) * cameras.display_from_world;
  const bool faint = seen.IsFaint();
  SightedPixels& pixels = faint ? seen.fine : seen.whole;
  const LatticeObservations observations = Through(pixels, cameras.views, stack_from_world);
  const LayerCalibration placed = WithPanelInPlace(
      faint ? Through(seen.middle, cameras.views, stack_from_world) : observations, design);
  if (cameras.board != nullptr) {
    options.eye_sd_mm = 0;
    options.camera_errors =
        ErrorsOf(*cameras.board, pixels, cameras.positions, observations, stack_from_world);
  }
  return {layer,
          seen.num_views,
          cameras.positions,
          observations.eyes_mm,
          faint,
          EstimateLattice(observations, placed, options)};
}

std::string Describe(const SolvedSheet& sheet) {
  const LatticeReport& report = sheet.report;
  const LayerCalibration& layer = report.layer;
  const LensLattice lattice = layer.lattice.value_or(LensLattice{});
  const auto sd = [&](LatticeParameter i) {
    return std::sqrt(std::max(0.0, report.covariance(i, i)));
  };
  std::string text = fmt::format(
      "\nlayer {}: {} positions, {} of {} samples used, each {:.2f} px off the lattice (rms){}\n"
      "  lens pitch {:.6f} +- {:.6f} mm, rotation {:.5f} +- {:.5f} degrees\n"
      "  phase {:.5f} +- {:.5f} lenses",
      sheet.layer, sheet.num_views, report.num_used, report.num_samples, report.noise_px,
      sheet.faint ? ", by the finest sinusoid alone, since it is faint" : "", lattice.pitch_mm,
      sd(kLatticePitch), lattice.rotation_rad * kDegreesPerRadian,
      sd(kLatticeRotation) * kDegreesPerRadian, lattice.phase.x(), sd(kLatticePhase0));
  if (lattice.type != LensLattice::Type::kLine) {
    text += fmt::format(" and {:.5f} +- {:.5f}", lattice.phase.y(), sd(kLatticePhase1));
  }
  return text + fmt::format(
                    "\n  gap {:.4f} +- {:.4f} mm; panel {:.2f} mm to the right and {:.2f} mm up, "
                    "turned by {:.3f} degrees\n",
                    layer.gap_mm, sd(kLatticeGap) * layer.index, layer.offset_mm.x(),
                    layer.offset_mm.y(), layer.rotation_rad.z() * kDegreesPerRadian);
}

std::string Describe(const BoardOfSheets& board) {
  const BoardCameras& cameras = board.cameras;
  const Rigid& place = board.display_from_board;
  const Eigen::Vector3d normal = place.rotation * Eigen::Vector3d::UnitZ();
  return fmt::format(
      "\ncamera: by {} of {} corners of the printed board in {} photographs, {:.3f} px RMS; focal "
      "length {:.1f} +- {:.1f} px\n"
      "  the board's middle is at ({:.1f}, {:.1f}, {:.1f}) mm, it is slanted by {:.2f} degrees\n",
      cameras.num_used, cameras.num_corners, cameras.views.size(), cameras.rms_px,
      cameras.found.camera.fx, cameras.focal_sd_px, place.translation.x(), place.translation.y(),
      place.translation.z(), std::acos(std::min(1.0, normal.z())) * kDegreesPerRadian);
}

void AddOfSheet(const SolvedSheet& sheet, const std::vector<Weakness>& weaknesses,
                std::vector<Weakness>& all) {
  for (const Weakness& weakness : weaknesses) {
    all.push_back({fmt::format("layer {}: {}", sheet.layer, weakness.lost), weakness.cure});
  }
}

const SolvedSheet& WorstOf(const SolvedSheets& solved) {
  return *std::max_element(solved.sheets.begin(), solved.sheets.end(),
                           [](const SolvedSheet& a, const SolvedSheet& b) {
                             return a.report.drift_max_px < b.report.drift_max_px;
                           });
}

}  // namespace

std::vector<Weakness> SolvedSheets::failures() const {
  std::vector<Weakness> all;
  if (board) all = board->cameras.failures;
  for (const SolvedSheet& sheet : sheets) AddOfSheet(sheet, sheet.report.failures, all);
  return all;
}

std::vector<Weakness> SolvedSheets::warnings() const {
  std::vector<Weakness> all;
  for (const SolvedSheet& sheet : sheets) AddOfSheet(sheet, sheet.report.warnings, all);
  return all;
}

bool HasLensSheets(const fs::path& patterns, const std::string& display) {
  const Calibration design = LoadCalibrationSetUp(patterns, display).design;
  return std::any_of(design.layers.begin(), design.layers.end(),
                     [](const LayerCalibration& layer) { return layer.lattice.has_value(); });
}

SolvedSheets SolveSheets(const SolveSheetsOptions& options, Progress& progress) {
  const CalibrationSetUp set_up = LoadCalibrationSetUp(options.patterns, options.display);
  CheckLayers(set_up.design);
  SolvedSheets solved;
  solved.display = set_up.display;
  solved.calibration = set_up.design;
  solved.eye_box = CleanEyesOf(set_up.display);
  const CheckedPhotos checked = CheckPhotos(
      options.patterns, options.photos, [](const CheckedPhoto&, const std::string&) {}, progress);
  PlacedCameras cameras = CamerasOf(checked, options, solved);
  LatticeOptions lattice;
  lattice.eye_box = solved.eye_box;
  lattice.eye_sd_mm = options.camera_sd_mm;
  progress.Start("sinusoids",
                 static_cast<std::int64_t>(checked.list.panels.size() * cameras.positions.size()),
                 "panels");
  std::set<std::string> names = cameras.photos;
  for (const CalibratedPanel& panel : checked.list.panels) {
    LayerCalibration& layer = solved.calibration.layers[static_cast<std::size_t>(panel.id.layer)];
    SheetSights seen = SightsOf(panel, checked, cameras.positions, options.photos, names, progress);
    if (solved.board && solved.sheets.empty()) {
      cameras.display_from_world = DisplayFromBoard(seen, cameras.views, layer);
      solved.board->display_from_board = cameras.display_from_world;
    }
    solved.sheets.push_back(SolveSheet(panel.id.layer, seen, cameras, layer, lattice));
    layer = solved.sheets.back().report.layer;
  }
  solved.photos = HashPhotos(names, options.photos);
  return solved;
}

std::string DescribeSheets(const SolvedSheets& solved) {
  const std::vector<Weakness> failures = solved.failures();
  std::string text;
  for (const SolvedSheet& sheet : solved.sheets) {
    if (text.empty()) {
      text = fmt::format("{}: the calibration is {}\n", solved.display.name,
                         failures.empty() ? "certain enough" : "NOT certain");
    }
    text += fmt::format(
        "layer {}: what eyes see through lenses at the panel's edges is known to "
        "{:.4f} px RMS and {:.4f} px at worst\n",
        sheet.layer, sheet.report.drift_rms_px, sheet.report.drift_max_px);
  }
  for (const SolvedSheet& sheet : solved.sheets) text += Describe(sheet);
  if (solved.board) text += Describe(*solved.board);
  return text + DescribeWeaknesses("what the photographs leave open", failures) +
         DescribeWeaknesses("what is weak", solved.warnings()) +
         DescribeLines("left out", solved.left_out);
}

CalibrationMeasurement MeasurementOf(const SolvedSheets& solved) {
  const SolvedSheet& worst = WorstOf(solved);
  CalibrationMeasurement m;
  m.program = std::string("lamella ") + ProgramVersion();
  m.solver = "periodogram and reweighted least squares";
  m.reference = {solved.sheets.front().layer, PanelId::kEmitter};
  m.eye_box = solved.eye_box;
  m.ray_max_sd_px = worst.report.drift_max_px;
  m.worst = {{worst.layer, PanelId::kEmitter}, worst.report.worst_px, worst.report.worst_eye};
  for (const SolvedSheet& sheet : solved.sheets) {
    const LatticeReport& report = sheet.report;
    m.ray_rms_sd_px = std::max(m.ray_rms_sd_px, report.drift_rms_px);
    m.chi2 = std::max(m.chi2, report.chi2);
    const auto add = [&](const char* name, const char* unit, LatticeParameter i, double factor) {
      m.deviations.push_back({fmt::format("layer {} {}", sheet.layer, name), unit,
                              factor * std::sqrt(std::max(0.0, report.covariance(i, i)))});
    };
    add("lens pitch", "mm", kLatticePitch, 1);
    add("lens rotation", "rad", kLatticeRotation, 1);
    add("lens phase", "", kLatticePhase0, 1);
    if (report.apart_mm.size() > 1) add("lens phase 2", "", kLatticePhase1, 1);
    add("gap", "mm", kLatticeGap, report.layer.index);
  }
  m.photos = solved.photos;
  return m;
}

}  // namespace lamella
