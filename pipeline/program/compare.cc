// lamella compare: images, poses, depth, calibrations or layers against other ones or against
// truth.
#include <limits>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/calibration_record.h"
#include "pipeline/capture/known_cameras.h"
#include "pipeline/compare_calibration.h"
#include "pipeline/compare_depth.h"
#include "pipeline/compare_layers.h"
#include "pipeline/compare_poses.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

struct Pair {
  std::string a, b;
};

ExitCode ComparePosesOf(const Pair& pair, Progress&) {
  const PoseComparison result = ComparePoses(ReadKnownCameras(pair.a), ReadKnownCameras(pair.b));
  fmt::print("{:<24} {:>12} {:>14}\n", "view", "centre", "rotation deg");
  for (const PoseError& view : result.views) {
    fmt::print("{:<24} {:>12.6g} {:>14.4f}\n", view.name, view.centre, view.rotation_deg);
  }
  for (const std::string& name : result.only_estimate) fmt::print("only in {}: {}\n", pair.a, name);
  for (const std::string& name : result.only_truth) fmt::print("only in {}: {}\n", pair.b, name);
  fmt::print(
      "views {}  scale {:.6g}  centre_rmse {:.6g}  centre_mean {:.6g}  centre_max {:.6g}  "
      "rotation_mean_deg {:.4f}\n",
      result.views.size(), result.truth_from_estimate.scale, result.rmse, result.mean, result.max,
      result.mean_rotation_deg);
  return ExitCode::kDone;
}

ExitCode CompareWorldDepthOf(const Pair& pair) {
  const WorldDepthComparison result = CompareWorldDepth(pair.a, pair.b);
  for (const std::string& name : result.only_estimate) fmt::print("only in {}: {}\n", pair.a, name);
  for (const std::string& name : result.only_truth) fmt::print("only in {}: {}\n", pair.b, name);
  fmt::print(
      "maps {}  pixels {}  known {:.2f} %  error_median {:.4f} %  error_p90 {:.4f} %  "
      "within_1_percent "
      "{:.2f} % of known, {:.2f} % of all\n",
      result.maps, result.pixels,
      result.pixels > 0
          ? 100.0 * static_cast<double>(result.known) / static_cast<double>(result.pixels)
          : 0.0,
      result.median, result.p90, result.within_1, result.within_1_of_all);
  return ExitCode::kDone;
}

ExitCode CompareDepthOf(const Pair& pair, Progress&) {
  if (std::filesystem::path(pair.b).extension() != ".pfm") return CompareWorldDepthOf(pair);
  const DepthComparison result = CompareDepth(pair.a, pair.b);
  fmt::print(
      "pixels {}  unknown {}  badpix_0.07 {:.2f} %  badpix_0.03 {:.2f} %  badpix_0.01 {:.2f} %  "
      "mse_x100 {:.3f}\n",
      result.pixels, result.unknown, result.bad_07, result.bad_03, result.bad_01, result.mse_x100);
  return ExitCode::kDone;
}

std::string Decibel(const std::optional<double>& psnr) {
  return psnr ? fmt::format("{:.2f}", *psnr) : "-";
}

ExitCode CompareLayersOf(const Pair& pair, Progress& progress) {
  constexpr int kBorderPx = 24;
  const LayersComparison result =
      CompareLayers(Workspace(pair.a), Workspace(pair.b), kBorderPx, progress);
  fmt::print("{:>8} {:>8} {:>10} {:>10} {:>8}\n", "eye x mm", "y mm", "PSNR dB", "seen dB", "SSIM");
  double lowest = std::numeric_limits<double>::infinity();
  for (const EyeDifference& eye : result.eyes) {
    fmt::print("{:>8.1f} {:>8.1f} {:>10} {:>10} {:>8}\n", eye.x_mm, eye.y_mm,
               Decibel(eye.metrics.psnr_db), Decibel(eye.metrics.psnr_seen_db),
               eye.metrics.ssim ? fmt::format("{:.4f}", *eye.metrics.ssim) : "-");
    lowest = std::min(lowest, eye.metrics.psnr_db.value_or(lowest));
  }
  fmt::print("eyes {}  pictures {}x{} less {} px  lowest_psnr_db {:.2f} (sRGB)\n",
             result.eyes.size(), result.width, result.height, kBorderPx, lowest);
  return ExitCode::kDone;
}

ExitCode CompareCalibrationOf(const Pair& pair, Progress&) {
  const CalibrationComparison result =
      CompareCalibrations(LoadCalibration(pair.a), LoadCalibration(pair.b));
  fmt::print("{:<10} {:>12} {:>10} {:>13} {:>11} {:>9} {:>10} {:>13}\n", "stack", "shift mm",
             "tilt deg", "rotation deg", "offset mm", "gap mm", "tilt deg", "rotation deg");
  for (std::size_t i = 0; i < result.layers.size(); ++i) {
    const LayerDifference& layer = result.layers[i];
    fmt::print("layer {:<4} {:>12.4f} {:>10.5f} {:>13.5f} {:>11.4f} {:>9.4f} {:>10.5f} {:>13.5f}\n",
               i, layer.stack_shift_mm, layer.stack_tilt_deg, layer.stack_rotation_deg,
               layer.offset_mm, layer.gap_mm, layer.tilt_deg, layer.rotation_deg);
  }
  for (const PanelRays& panel : result.panels) {
    fmt::print("rays to {}: {:.4f} px RMS, {:.4f} px at most\n", NameOf(panel.panel),
               panel.rays.rms_px, panel.rays.max_px);
  }
  for (const LensRays& lenses : result.lenses) {
    fmt::print("layer {} through its lenses: drift_rms_px {:.5f}  drift_max_px {:.5f}\n",
               lenses.layer, lenses.rays.rms_px, lenses.rays.max_px);
  }
  fmt::print(
      "reference {}  gap_error_mm {:.5f}  tilt_error_deg {:.5f}  rotation_error_deg {:.5f}  "
      "ray_rms_px {:.5f}  ray_max_px {:.5f}\n",
      NameOf(result.reference), result.gap_mm, result.tilt_deg, result.rotation_deg,
      result.rays.rms_px, result.rays.max_px);
  return ExitCode::kDone;
}

// A pair of what to compare, and what compares it.
void AddPair(CLI::App& parent, Invocation& invocation, const char* name, const char* help,
             const char* a, const char* b, ExitCode (*compare)(const Pair&, Progress&)) {
  CLI::App& app = *parent.add_subcommand(name, help);
  auto pair = std::make_shared<Pair>();
  app.add_option("A", pair->a, a)->required();
  app.add_option("B", pair->b, b)->required();
  AddGlobalOptions(app, invocation);
  app.callback([pair, compare, &invocation] {
    invocation.action = [pair, compare](Progress& progress) { return compare(*pair, progress); };
  });
}

}  // namespace

void AddCompare(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "compare",
      "images, poses, depth, calibrations or layers, against other ones or against truth");
  app.require_subcommand(1);
  AddCompareImages(app, invocation);
  AddPair(app, invocation, "poses",
          "cameras by name, after the best similarity of the world; errors are in units of B",
          "transforms.json, a folder of .camera files or a grid's folder", "the truth, likewise",
          ComparePosesOf);
  AddPair(app, invocation, "depth",
          "a grid view's depth against true disparity by the rule of the HCI 4D light field "
          "benchmark, or any depth against true depth in the same world",
          "W/depth/NAME.exr of a finished workspace W, or the folder W/depth",
          "true disparity, px per view step (PFM), or true depth (EXR, or a folder of them)",
          CompareDepthOf);
  AddPair(app, invocation, "calibration",
          "which pixels of the panels lie on one ray, over panel and eye box, and where the panels "
          "are; in whatever frame each is",
          "calibration.json", "another one of the same display, or the truth",
          CompareCalibrationOf);
  AddPair(app, invocation, "layers",
          "what eyes in the clean eye box see of two workspaces' layers, placed alike",
          "a workspace whose layers are finished", "another one", CompareLayersOf);
}

}  // namespace lamella
