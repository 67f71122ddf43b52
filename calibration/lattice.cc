#include "calibration/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "calibration/lattice_fit.h"
#include "calibration/lattice_model.h"
#include "calibration/lattice_residuals.h"
#include "calibration/lattice_search.h"
#include "calibration/weaknesses.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostOutliers = 0.35;
constexpr double kMostMisfitPx = 0.03;
constexpr double kLeastApartMm = 100;
constexpr double kShareWithGap = 0.7;  // of the drift, if the gap were known: it is the gap then

constexpr int kPlaces = 3;  // by 3, of LatticeReport::drift

struct Drift {
  LensDrift all;
  std::array<LensDrift, kPlaces * kPlaces> at;  // row by row from the top left
  Vector2d worst_px{0, 0};
  Vector3d worst_eye{0, 0, 0};
};

// Of what eyes see through lenses; infinite where a number is unknown.
Drift DriftOf(const Matrix5d& covariance, const LatticeModel& model, const LayerCalibration& design,
              const EyeBox& box) {
  const Rigid stack_from_display = Inverse(design.display_from_stack);
  const PanelCalibration& panel = design.emitter;
  const double pixel = panel.pitch_mm * (1 + panel.scale);
  const Vector2d half = pixel / 2 * Vector2d(panel.width_px, panel.height_px);
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  Drift drift;
  if (!covariance.allFinite()) {
    drift.all = {kUnknown, kUnknown};
    drift.at.fill(drift.all);
    return drift;
  }
  const std::vector<Vector3d> eyes = box.Eyes();
  for (const Vector3d& eye : eyes) {
    for (std::size_t place = 0; place < drift.at.size(); ++place) {
      const std::size_t column = place % kPlaces, row = place / kPlaces;
      const Vector2d side(static_cast<double>(column) - 1, 1 - static_cast<double>(row));
      const Eigen::Matrix<double, 2, 5> slopes =
          model.SlopesOfDrift(half.cwiseProduct(side), stack_from_display * eye);
      const Eigen::Matrix2d of_point = slopes * covariance * slopes.transpose() / (pixel * pixel);
      // In the direction in which it is the largest.
      const double variance =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(of_point).eigenvalues()(1);
      LensDrift& at = drift.at[place];
      at.rms_px += variance / static_cast<double>(eyes.size());
      at.max_px = std::max(at.max_px, std::sqrt(variance));
      if (!(variance > drift.all.max_px * drift.all.max_px)) continue;
      drift.all.max_px = std::sqrt(variance);
      drift.worst_px =
          half / pixel +
          Vector2d(panel.mirror_x ? -side.x() : side.x(), -side.y()).cwiseProduct(half / pixel);
      drift.worst_eye = eye;
    }
  }
  for (LensDrift& at : drift.at) {
    drift.all.rms_px += at.rms_px / static_cast<double>(drift.at.size());
    at.rms_px = std::sqrt(std::max(0.0, at.rms_px));
  }
  drift.all.rms_px = std::sqrt(std::max(0.0, drift.all.rms_px));
  return drift;
}

// Of each family the distance across its lenses between the cameras that are furthest apart.
std::vector<double> ApartOf(const std::vector<Vector3d>& eyes, const std::vector<bool>& seen,
                            const LatticeModel& model) {
  std::vector<double> apart;
  for (int a = 0; a < model.num_directions(); ++a) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t view = 0; view < eyes.size(); ++view) {
      if (!seen[view]) continue;
      const double across = model.Normal(a).dot(eyes[view].head<2>());
      low = std::min(low, across);
      high = std::max(high, across);
    }
    apart.push_back(high - low);
  }
  return apart;
}

// Another place for the camera: across the lenses, beyond the middle of those it has been at.
Vector3d NextEye(const std::vector<Vector3d>& eyes, const Vector2d& normal) {
  Vector3d mean(0, 0, 0);
  for (const Vector3d& eye : eyes) mean += eye / static_cast<double>(eyes.size());
  const double across = normal.dot(mean.head<2>());
  const double step = std::max(2 * kLeastApartMm, 0.6 * mean.z()) * (across > 0 ? -1 : 1);
  mean.head<2>() += step * normal;
  return mean;
}

double FarthestApart(const LatticeReport& report) {
  return *std::max_element(report.apart_mm.begin(), report.apart_mm.end());
}

std::string CamerasApart(const LatticeReport& report) {
  if (report.num_views < 2) return "there is one camera position only";
  return fmt::format("camera positions are {:.0f} mm apart across the lenses",
                     FarthestApart(report));
}

std::string FurtherPosition(const Vector3d& next) {
  return fmt::format(
      "photograph the patterns from a further position, {:.0f} mm and more away across the lenses, "
      "for instance at ({:.0f}, {:.0f}, {:.0f}) mm",
      kLeastApartMm, next.x(), next.y(), next.z());
}

Weakness LostWithGap(const LatticeReport& report, const Vector3d& next) {
  return {fmt::format("the lenses' pitch and phase cannot be told from their gap: {}; lenses at "
                      "the panel's edge are known to {:.3f} px, not {:g}",
                      CamerasApart(report), report.drift_max_px, report.largest_drift_px),
          FurtherPosition(next)};
}

// What leaves the lattice to extrapolation, though it is known well enough.
void AddLatticeWarnings(const Vector3d& next, LatticeReport& report) {
  if (report.accepted() && FarthestApart(report) < kLeastApartMm) {
    report.next_eye = next;
    report.warnings.push_back(
        {fmt::format("the lenses' pitch and phase lean on their gap: {}", CamerasApart(report)),
         FurtherPosition(next)});
  }
  const auto in_part = SeenInPart("the sheet", report.residuals, "its lenses are");
  if (in_part) report.warnings.push_back(*in_part);
}

double MedianSigma(const std::vector<SheetRay>& rays, const LatticeModel& model) {
  std::vector<double> sigmas;
  sigmas.reserve(rays.size());
  for (const SheetRay& ray : rays) {
    sigmas.push_back(model.ResidualOf(ray, ray.sheet, 0).sigma);
  }
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return *middle;
}

// The gradient's change in every way that the cameras may be off.
std::vector<Vector5d> ChangesOf(const CameraErrors& errors, const LatticeObservations& observations,
                                const LayerCalibration& design, const LatticeFit& fit) {
  LatticeObservations some = observations;
  some.samples.clear();
  for (std::size_t i = 0; i < observations.samples.size(); i += errors.every) {
    some.samples.push_back(observations.samples[i]);
  }
  const std::vector<SheetRay> rays = SheetRaysOf(some, design);
  std::vector<Vector5d> changes;
  for (int way = 0; way < errors.num_ways; ++way) {
    const Vector5d of_some = GradientChange(rays, SheetRaysOf(errors.off(way), design), fit);
    changes.push_back(static_cast<double>(errors.every) * of_some);
  }
  return changes;
}

LayerCalibration LayerWith(const LayerCalibration& design, const LensLattice& type,
                           const Vector5d& at) {
  LensLattice lattice = type;
  lattice.pitch_mm = at(kLatticePitch);
  lattice.rotation_rad = at(kLatticeRotation);
  lattice.phase = {at(kLatticePhase0), at(kLatticePhase1)};
  if (lattice.type == LensLattice::Type::kLine) lattice.phase.y() = 0;
  lattice.phase.array() -= lattice.phase.array().floor();
  LayerCalibration layer = design;
  layer.lattice = lattice;
  layer.gap_mm = at(kLatticeGap) * layer.index;
  return layer;
}

// What helps where a printed board tells the cameras.
constexpr const char* kBoardStill =
    "check that the printed board does not move against the panel, and is flat";
constexpr const char* kMoreOfBoard =
    "add photographs of the printed board alone, slanted by 20 to 40 degrees to all sides";

// One lattice does not describe the sheet as a whole.
void AddMisfit(const LatticeMisfit& misfit, bool by_board, LatticeReport& report) {
  const double pixel = report.layer.emitter.pitch_mm;
  report.residuals = misfit.map;
  report.largest_mean_px = kMostMisfitPx + 4.5 * misfit.deviation_mm / pixel;
  if (misfit.largest_mm < report.largest_mean_px * pixel) return;
  report.failures.push_back(
      {fmt::format(
           "lenses about ({:.0f}, {:.0f}) mm are off the lattice by {:.2f} px: the sheet or "
           "the panel is bent or stands askew, or a camera is elsewhere",
           misfit.place_mm.x(), misfit.place_mm.y(), misfit.largest_mm / pixel),
       fmt::format("press the sheet flat onto the panel, and {}",
                   by_board ? kBoardStill : "measure the cameras' positions again")});
}

void AddFailures(const LensDrift& with_gap_known, const Vector3d& next, bool by_board,
                 LatticeReport& report) {
  if (report.num_used < (1 - kMostOutliers) * report.num_samples) {
    report.failures.push_back(
        {fmt::format("{:.0f} % of the samples are off the lattice",
                     100 - 100.0 * report.num_used / report.num_samples),
         by_board ? fmt::format("check that the sheet lies flat and that nothing is reflected, and "
                                "{}",
                                kBoardStill)
                  : "check that the sheet lies flat, that the cameras are where they are said to "
                    "be and that nothing is reflected"});
  }
  if (report.drift_max_px <= report.largest_drift_px) return;
  if (with_gap_known.max_px < kShareWithGap * report.drift_max_px) {
    report.next_eye = next;
    report.failures.push_back(LostWithGap(report, next));
    return;
  }
  report.failures.push_back(
      {fmt::format(
           "lenses at the panel's edge are known to {:.3f} px, not {:g}: of {} samples with "
           "a noise of {:.2f} px",
           report.drift_max_px, report.largest_drift_px, report.num_used, report.noise_px),
       fmt::format("photograph the whole panel, expose longer, and {}",
                   by_board ? kMoreOfBoard : "measure the cameras' positions better")});
}

}  // namespace

LatticeReport EstimateLattice(const LatticeObservations& observations,
                              const LayerCalibration& design, const LatticeOptions& options) {
  if (!design.lattice || !(design.gap_mm > 0)) {
    throw UsageError("lens sheet", "the layer has no lenses", "give a display with a lens sheet");
  }
  const std::vector<SheetRay> rays = SheetRaysOf(observations, design);
  const std::vector<Vector3d>& eyes = observations.eyes_mm;
  Vector5d nominal;
  nominal << design.lattice->pitch_mm, design.lattice->rotation_rad, design.lattice->phase,
      design.gap_mm / design.index;
  const LatticeModel sheet(*design.lattice, nominal);
  LatticeFit fit =
      FitLattice(rays, eyes, sheet.At(FindLattice(rays, eyes, sheet)), nominal(kLatticeGap));
  fit.together = ChangesOf(options.camera_errors, observations, design, fit);
  const auto drift = [&](const LatticeFit& of) {
    return DriftOf(of.Covariance(options.eye_sd_mm), fit.model, design, options.eye_box);
  };
  LatticeReport report;
  report.layer = LayerWith(design, *design.lattice, fit.model.parameters());
  report.covariance = fit.Covariance(options.eye_sd_mm);
  const Drift known = drift(fit);
  report.drift_rms_px = known.all.rms_px;
  report.drift_max_px = known.all.max_px;
  report.largest_drift_px = options.largest_drift_px;
  report.drift = known.at;
  report.worst_px = known.worst_px;
  report.worst_eye = known.worst_eye;
  report.num_samples = static_cast<int>(rays.size());
  report.num_used = fit.num_used;
  report.noise_px = fit.scale * MedianSigma(rays, fit.model) / design.emitter.pitch_mm;
  report.chi2 = fit.scale * fit.scale;
  std::vector<bool> seen(eyes.size(), false);
  for (const SheetRay& ray : rays) seen[static_cast<std::size_t>(ray.view)] = true;
  report.num_views = static_cast<int>(std::count(seen.begin(), seen.end(), true));
  report.views_fit = FitsOfViews(rays, fit.model, fit.most, eyes.size(), design.emitter.pitch_mm);
  report.apart_mm = ApartOf(eyes, seen, fit.model);
  const Vector3d next = design.display_from_stack * NextEye(eyes, fit.model.Normal(0));
  const bool by_board = options.camera_errors.num_ways > 0;
  AddMisfit(MisfitOf(rays, fit.model, fit.most, design.emitter), by_board, report);
  AddFailures(drift(fit.WithGapKnown()).all, next, by_board, report);
  AddLatticeWarnings(next, report);
  return report;
}

}  // namespace lamella
