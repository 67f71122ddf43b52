#include "pipeline/solve_sheets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "calibration/lattice_place.h"
#include "lightfield/error.h"
#include "pipeline/calibration_set_up.h"
#include "pipeline/check_photos.h"
#include "pipeline/phase_photos.h"
#include "pipeline/position_cameras.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostSamples = 100000;  // of a position
// A lens magnifies the panel's pixels, within which there is one phase.
constexpr double kPixelSigma = 0.2887;  // px: 1/sqrt(12)
// Of the pixels that see a faint sinusoid, those to be unwrapped one by one; else none are.
constexpr double kLeastUnwrapped = 0.2;
constexpr int kFinePeriod = 16, kMiddlePeriod = 128;  // px
constexpr double kDegrees = 180 / std::numbers::pi;

void CheckLayers(const Calibration& design) {
  for (std::size_t i = 0; i < design.layers.size(); ++i) {
    if (design.layers[i].lattice) continue;
    throw UsageError(design.display, fmt::format("layer {} has no lenses, others have", i),
                     "calibrate displays of one kind of layers");
  }
}

// Every so many-th known pixel as a sample of the sheet.
void AddSamples(const ScreenMap& map, const View& camera, const Rigid& stack_from_display,
                LatticeObservations& seen) {
  const Rigid stack_from_camera = stack_from_display * Inverse(camera.camera_from_world);
  const Vector3d eye = stack_from_camera.translation;
  const int view = static_cast<int>(seen.eyes_mm.size());
  seen.eyes_mm.push_back(eye);
  std::vector<std::pair<int, int>> known;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.valid(x, y) != 0) known.emplace_back(x, y);
    }
  }
  const std::size_t count = std::min(kMostSamples, known.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto [x, y] = known[i * known.size() / count];
    const std::optional<Vector3d> ray = Unproject(camera.camera, {x + 0.5, y + 0.5});
    if (!ray) continue;
    const Vector3d direction = stack_from_camera.rotation * *ray;
    if (!(direction.z() < 0)) continue;
    LatticeSample sample;
    sample.view = view;
    sample.sheet_mm = (eye - eye.z() / direction.z() * direction).head<2>();
    sample.panel_px = {static_cast<double>(map.u_px(x, y)), static_cast<double>(map.v_px(x, y))};
    sample.sigma_px = {std::hypot(static_cast<double>(map.sigma_u(x, y)), kPixelSigma),
                       std::hypot(static_cast<double>(map.sigma_v(x, y)), kPixelSigma)};
    seen.samples.push_back(sample);
  }
}

// What all positions show of one sheet: pixel by pixel, and by single periods.
struct SheetSamples {
  LatticeObservations whole, fine, middle;
  int num_views = 0;
  bool IsFaint() const {
    return static_cast<double>(whole.samples.size()) <
           kLeastUnwrapped * static_cast<double>(fine.samples.size());
  }
};

void AddView(const PhaseCapture& capture, const View& camera, const Rigid& stack_from_display,
             SheetSamples& seen) {
  AddSamples(DecodePhase(capture), camera, stack_from_display, seen.whole);
  AddSamples(DecodePeriod(capture, kFinePeriod), camera, stack_from_display, seen.fine);
  AddSamples(DecodePeriod(capture, kMiddlePeriod), camera, stack_from_display, seen.middle);
  ++seen.num_views;
}

SheetSamples SamplesOf(const CalibratedPanel& panel, const LayerCalibration& design,
                       const CheckedPhotos& checked, const std::map<int, View>& cameras,
                       const SolveSheetsOptions& options, std::set<std::string>& names,
                       Progress& progress) {
  const fs::path folder =
      fs::is_directory(options.photos) ? options.photos : options.photos.parent_path();
  SheetSamples seen;
  seen.fine.period_px = kFinePeriod;
  seen.middle.period_px = kMiddlePeriod;
  for (int view = 0; view < checked.num_views; ++view) {
    const auto photos = IsComplete(checked, view)
                            ? ReadPhasePhotos(checked, folder, view, panel, ReadMeanLight)
                            : std::nullopt;
    progress.Advance();
    if (!photos) {
      continue;
    }
    AddView(photos->capture, CameraOfPosition(cameras, view, checked, options.cameras),
            Inverse(design.display_from_stack), seen);
    names.insert(photos->names.begin(), photos->names.end());
  }
  if (seen.num_views > 0) return seen;
  throw InputError(options.photos.string(), "no position has all shots",
                   "`lamella calibrate check` says which are missing");
}

SolvedSheet SolveSheet(int layer, const SheetSamples& seen, const LayerCalibration& design,
                       const LatticeOptions& options) {
  const bool faint = seen.IsFaint();
  const LayerCalibration placed = WithPanelInPlace(faint ? seen.middle : seen.whole, design);
  return {layer, seen.num_views, faint,
          EstimateLattice(faint ? seen.fine : seen.whole, placed, options)};
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
      sd(kLatticePitch), lattice.rotation_rad * kDegrees, sd(kLatticeRotation) * kDegrees,
      lattice.phase.x(), sd(kLatticePhase0));
  if (lattice.type != LensLattice::Type::kLine) {
    text += fmt::format(" and {:.5f} +- {:.5f}", lattice.phase.y(), sd(kLatticePhase1));
  }
  return text + fmt::format(
                    "\n  gap {:.4f} +- {:.4f} mm; panel {:.2f} mm to the right and {:.2f} mm up, "
                    "turned by {:.3f} degrees\n",
                    layer.gap_mm, sd(kLatticeGap) * layer.index, layer.offset_mm.x(),
                    layer.offset_mm.y(), layer.rotation_rad.z() * kDegrees);
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
  for (const SolvedSheet& sheet : sheets) {
    for (const Weakness& weakness : sheet.report.failures) {
      all.push_back({fmt::format("layer {}: {}", sheet.layer, weakness.lost), weakness.cure});
    }
  }
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
  const std::map<int, View> cameras = CamerasOfPositions(checked, options.cameras);
  LatticeOptions lattice;
  lattice.eye_box = solved.eye_box;
  lattice.eye_sd_mm = options.camera_sd_mm;
  progress.Start("sinusoids",
                 static_cast<std::int64_t>(checked.list.panels.size()) * checked.num_views,
                 "panels");
  for (int view = 0; view < checked.num_views; ++view) {
    if (IsComplete(checked, view)) continue;
    solved.left_out.push_back(IncompletePosition(view));
  }
  std::set<std::string> names;
  for (const CalibratedPanel& panel : checked.list.panels) {
    LayerCalibration& layer = solved.calibration.layers[static_cast<std::size_t>(panel.id.layer)];
    const SheetSamples seen = SamplesOf(panel, layer, checked, cameras, options, names, progress);
    solved.sheets.push_back(SolveSheet(panel.id.layer, seen, layer, lattice));
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
  if (!failures.empty()) text += "\nwhat the photographs leave open\n";
  for (const Weakness& weakness : failures) {
    text += fmt::format("  {}\n    cure: {}\n", weakness.lost, weakness.cure);
  }
  if (!solved.left_out.empty()) text += "\nleft out\n";
  for (const std::string& line : solved.left_out) text += "  " + line + "\n";
  return text;
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
