#include "calibration/calibrate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "calibration/covariance.h"
#include "calibration/gates.h"
#include "calibration/initialise.h"
#include "calibration/panel_edges.h"
#include "calibration/weaknesses.h"

namespace lamella {
namespace {

constexpr double kLargestOutlierShare = 0.35;

// In one order whatever the input's, so that the same photographs give the same bytes.
Observations Sorted(Observations observations) {
  for (PanelPhoto& photo : observations.photos) {
    std::sort(photo.points.begin(), photo.points.end(),
              [](const Observation& a, const Observation& b) {
                return std::tuple(a.panel_px.y(), a.panel_px.x(), a.image_px.y(), a.image_px.x()) <
                       std::tuple(b.panel_px.y(), b.panel_px.x(), b.image_px.y(), b.image_px.x());
              });
  }
  std::sort(observations.photos.begin(), observations.photos.end(),
            [](const PanelPhoto& a, const PanelPhoto& b) {
              return std::tie(a.view, a.panel, a.photo) < std::tie(b.view, b.panel, b.photo);
            });
  return observations;
}

// Sums of the photographs that one FitOf is of.
struct Sums {
  int points = 0, used = 0;
  double squares_px2 = 0, chi2 = 0;
};

FitOf Summary(const std::string& name, const Sums& sums) {
  FitOf fit{name, sums.points, sums.used, 0, 0};
  if (sums.used == 0) return fit;
  fit.rms_px = std::sqrt(sums.squares_px2 / sums.used);
  fit.chi2 = sums.chi2 / (2 * sums.used);
  return fit;
}

void Summarise(const Fit& fit, const Structure& structure, const Observations& observations,
               CalibrationReport& report) {
  std::map<PanelId, Sums> panels;
  std::map<int, Sums> views;
  const auto residuals = WhitenedResiduals(fit.state, structure, observations);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const PanelPhoto& photo = observations.photos[i];
    for (Sums* sums : {&panels[photo.panel], &views[photo.view]}) {
      for (std::size_t k = 0; k < photo.points.size(); ++k) {
        ++sums->points;
        if (!fit.weighting.inlier[i][k]) continue;
        ++sums->used;
        const double chi2 = residuals[i].col(static_cast<Eigen::Index>(k)).squaredNorm();
        sums->chi2 += chi2;
        // In pixels: the whitened square times the covariance's mean variance.
        sums->squares_px2 += chi2 * photo.points[k].covariance_px2.trace() / 2;
      }
    }
  }
  for (const auto& [panel, sums] : panels) {
    report.panels.push_back(Summary(NameOf(panel), sums));
  }
  for (const auto& [view, sums] : views) {
    report.views_fit.push_back(Summary(fmt::format("view {}", view + 1), sums));
  }
}

void CopyResult(const Fit& fit, const Structure& structure, const Observations& observations,
                CalibrationReport& report) {
  report.calibration = CalibrationOf(fit.state, structure);
  report.reference = structure.reference;
  report.views = structure.views;
  for (std::size_t i = 0; i < observations.cameras.size(); ++i) {
    const PhotoCamera& body = observations.cameras[i];
    report.cameras.push_back(CameraOf(fit.state.cameras[i], body.width, body.height));
  }
  const auto reference = static_cast<std::size_t>(structure.reference.layer);
  const Rigid world_from_display = Inverse(structure.design.layers[reference].display_from_stack);
  for (const Rigid& camera_from_world : fit.state.camera_from_world) {
    report.camera_from_display.push_back(camera_from_world * world_from_display);
  }
  report.slip_px = fit.weighting.slip_sd_px;
  report.chi2 = fit.variance;
  report.rejected = fit.rejected;
}

// Panels and positions that the design has and no photograph shows.
void CheckAllSeen(const Structure& structure, CalibrationReport& report) {
  for (std::size_t i = 0; i < structure.design.layers.size(); ++i) {
    const int layer = static_cast<int>(i);
    for (const PanelId panel :
         {PanelId{layer, PanelId::kEmitter}, PanelId{layer, PanelId::kModulator}}) {
      if (panel.role == PanelId::kModulator && !structure.design.layers[i].modulator) continue;
      if (std::binary_search(structure.panels.begin(), structure.panels.end(), panel)) continue;
      report.failures.push_back(
          {fmt::format("the place of {}: no photograph shows it", NameOf(panel)),
           "photograph its pattern from the same positions as the others"});
    }
  }
}

// One view fits whatever it shows: nothing checks the place that it gives a panel.
void CheckSeenTwice(const Fit& fit, const Structure& structure, const Observations& observations,
                    CalibrationReport& report) {
  std::map<PanelId, std::set<int>> views;
  for (std::size_t i = 0; i < observations.photos.size(); ++i) {
    const std::vector<char>& inlier = fit.weighting.inlier[i];
    if (std::find(inlier.begin(), inlier.end(), 1) == inlier.end()) continue;
    views[observations.photos[i].panel].insert(observations.photos[i].view);
  }
  for (const PanelId& panel : structure.panels) {
    if (views[panel].size() >= 2) continue;
    report.failures.push_back(
        {fmt::format("{} is in {} views only: its distance or gap, with its scale, is checked by "
                     "nothing",
                     NameOf(panel), views[panel].size()),
         "photograph it from 6 positions or more, on opposite sides"});
  }
}

void CheckOutliers(CalibrationReport& report) {
  for (const FitOf& panel : report.panels) {
    const double share = 1 - static_cast<double>(panel.num_used) / std::max(1, panel.num_points);
    if (share <= kLargestOutlierShare) continue;
    report.failures.push_back(
        {fmt::format("{}: {:.0f} % of its points disagree with the rest", panel.name, 100 * share),
         "look at the photographs that were left out and take them again"});
  }
}

// Gates on rays, named by what the worst one leans on.
void CheckRays(const Fit& fit, const Structure& structure, const CalibrateOptions& options,
               CalibrationReport& report) {
  const Eigen::MatrixXd covariance = CovarianceOf(fit);
  if (covariance.size() == 0) return;  // UnknownDirections has told
  report.rays = UncertaintyOfRays(fit, structure, covariance, options.eye_box);
  report.probed = RaysToProbe(structure, options.eye_box);
  for (int i = 0; i < fit.columns.num_display; ++i) {
    const auto at = static_cast<std::size_t>(i);
    report.deviations.push_back(
        {fit.columns.names[at], fit.columns.units[at], std::sqrt(covariance(i, i))});
  }
  if (report.rays.rms_sd_px <= options.largest_ray_rms_px &&
      report.rays.max_sd_px <= options.largest_ray_max_px) {
    return;
  }
  report.failures.push_back(
      {fmt::format(
           "rays are known to {:.3f} px RMS, {:.3f} px at worst ({}); {:.3f} and {:.3f} are "
           "asked for. Weakest: {}",
           report.rays.rms_sd_px, report.rays.max_sd_px, NameOf(report.rays.worst.panel),
           options.largest_ray_rms_px, options.largest_ray_max_px,
           NameOfDirection(report.degeneracy, fit.columns)),
       "add photographs of all panels, slanted by 20 degrees to both sides and up and down"});
}

}  // namespace

CalibrationReport Calibrate(const Observations& given, const Calibration& design,
                            const CalibrateOptions& options) {
  Check(given, kSolveWhere);
  Check(design, kSolveWhere);
  const Observations all = Sorted(given);
  const Structure structure = StructureOf(all, design);
  const CalibrationState start = Initialise(all, structure);
  const Fit first = Solve(start, structure, all, {});
  const ClearOfEdges clear = WithoutPanelEdges(first.state, structure, all);
  const Observations& observations = clear.observations;
  // From the start again: from where a solution without shapes settled, one with them may not find
  // back.
  Selection selection = SelectGroups(start, structure, observations, options.eye_box);
  const Fit& fit = selection.fit;

  CalibrationReport report;
  CopyResult(fit, structure, observations, report);
  report.at_edges = clear.left_out;
  Summarise(fit, structure, observations, report);
  report.groups = std::move(selection.verdicts);
  report.degeneracy = DegeneracyOf(fit);
  report.failures = UnknownDirections(fit);
  CheckAllSeen(structure, report);
  CheckSeenTwice(fit, structure, observations, report);
  CheckOutliers(report);
  CheckRays(fit, structure, options, report);
  // Of what is not determined anyway, residuals say nothing.
  if (report.accepted()) report.failures = Contradictions(fit, structure, observations);
  if (!fit.converged && report.accepted()) {
    report.failures.push_back({"the solution did not settle", "look at the photographs left out"});
  }
  report.residuals = MapResiduals(fit, structure, observations);
  report.limits = options;
  report.next_view = BestNextView(fit, structure, observations, options.eye_box);
  report.warnings = ThinCoverage(fit, structure, report.residuals, options.eye_box);
  return report;
}

}  // namespace lamella
