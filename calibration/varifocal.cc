#include "calibration/varifocal.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "calibration/varifocal_rays.h"
#include "calibration/varifocal_start.h"
#include "calibration/weaknesses.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPlanesKnown = 100, kLargestPlaneSlipPx = 0.05, kLargestPlaneOutlierShare = 0.35;
constexpr double kLeastPlaneChi2 = 0.7, kMostPlaneChi2 = 1.5;
constexpr double kPlaneChance = 4;  // standard deviations
constexpr double kOneDegree = std::numbers::pi / 180;
constexpr const char* kRings =
    "photograph every plane from 12 positions on two rings, the outer one as far off the axis as "
    "it is seen from (9 degrees), and the whole sheet from each";

// In one order whatever the input's, so that the same photographs give the same bytes.
VarifocalObservations Sorted(VarifocalObservations observations) {
  for (PlanePhoto& photo : observations.photos) {
    std::sort(photo.points.begin(), photo.points.end(),
              [](const Observation& a, const Observation& b) {
                return std::tuple(a.panel_px.y(), a.panel_px.x(), a.image_px.y(), a.image_px.x()) <
                       std::tuple(b.panel_px.y(), b.panel_px.x(), b.image_px.y(), b.image_px.x());
              });
  }
  std::sort(observations.photos.begin(), observations.photos.end(),
            [](const PlanePhoto& a, const PlanePhoto& b) {
              return std::tie(a.plane, a.view) < std::tie(b.plane, b.view);
            });
  return observations;
}

void CheckPlanes(const VarifocalObservations& observations, const Display& display) {
  if (!display.varifocal) {
    throw UsageError(kSolveWhere, fmt::format("display {} has no [varifocal] planes", display.name),
                     "give the file of the varifocal display that was photographed");
  }
  const int num_planes = static_cast<int>(display.layers.size());
  std::set<int> seen;
  for (const PlanePhoto& photo : observations.photos) {
    if (photo.plane < 0 || photo.plane >= num_planes) {
      throw UsageError(kSolveWhere,
                       fmt::format("{} shows plane {}, display {} has {}", photo.photo, photo.plane,
                                   display.name, num_planes),
                       "give the display's own file");
    }
    seen.insert(photo.plane);
  }
  for (int plane = 0; plane < num_planes; ++plane) {
    if (seen.count(plane) > 0) continue;
    throw InputError(kSolveWhere, fmt::format("plane {} is in no photograph", plane),
                     "photograph its pattern from the same positions as the others");
  }
}

// Of points that count, photographs of a plane or of a view.
struct PlaneSums {
  int points = 0, used = 0;
  double squares_px2 = 0, chi2 = 0;

  FitOf Summary(const std::string& name) const {
    FitOf fit{name, points, used, 0, 0};
    if (used == 0) return fit;
    fit.rms_px = std::sqrt(squares_px2 / used);
    fit.chi2 = chi2 / (2 * used);
    return fit;
  }
};

double VarianceOf(const VarifocalObservations& observations, std::size_t photo, std::size_t point) {
  const std::size_t num = observations.photos.size();
  const Eigen::Matrix2d& covariance =
      photo < num ? observations.photos[photo].points[point].covariance_px2
                  : observations.views[photo - num].marks[point].covariance_px2;
  return covariance.trace() / 2;
}

void Summarise(const VarifocalFit& fit, const VarifocalTask& task, VarifocalReport& report) {
  const VarifocalObservations& observations = task.observations;
  std::vector<PlaneSums> planes(task.planes.size()), views(observations.views.size());
  const auto residuals = WhitenedResiduals(fit.state, task.planes, observations);
  const std::vector<VarifocalPhoto> photos = PhotosOf(observations);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    std::vector<PlaneSums*> of = {&views[static_cast<std::size_t>(photos[i].view)]};
    if (photos[i].plane >= 0) of.push_back(&planes[static_cast<std::size_t>(photos[i].plane)]);
    for (PlaneSums* sums : of) {
      for (std::size_t k = 0; k < photos[i].num_points; ++k) {
        ++sums->points;
        if (!fit.weighting.inlier[i][k]) continue;
        ++sums->used;
        const double chi2 = residuals[i].col(static_cast<Eigen::Index>(k)).squaredNorm();
        sums->chi2 += chi2;
        sums->squares_px2 += chi2 * VarianceOf(observations, i, k);
      }
    }
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    report.planes_fit.push_back(planes[i].Summary(fmt::format("plane {}", i)));
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    report.views_fit.push_back(views[i].Summary("view " + observations.views[i].name));
  }
}

std::vector<ResidualMap> MapPlanes(const VarifocalFit& fit, const VarifocalTask& task) {
  const std::vector<PlanePhoto>& photos = task.observations.photos;
  const auto residuals = WhitenedResiduals(fit.state, task.planes, task.observations);
  std::vector<std::vector<PanelResiduals>> of_plane(task.planes.size());
  for (std::size_t i = 0; i < photos.size(); ++i) {
    of_plane[static_cast<std::size_t>(photos[i].plane)].push_back(
        {photos[i].view, &photos[i].points, &residuals[i], &fit.weighting.inlier[i]});
  }
  std::vector<ResidualMap> maps;
  for (std::size_t i = 0; i < of_plane.size(); ++i) {
    maps.push_back(MapOf({static_cast<int>(i), PanelId::kEmitter}, task.planes[i], of_plane[i]));
  }
  return maps;
}

// A plane's columns, from the frame's axes to the display's.
Eigen::MatrixXd CovarianceInDisplay(const VarifocalFit& fit, const Eigen::MatrixXd& covariance,
                                    const Matrix3d& display_from_frame) {
  const auto num = static_cast<Eigen::Index>(fit.columns.plane.size());
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(7 * num, covariance.rows());
  for (Eigen::Index i = 0; i < num; ++i) {
    const int first = fit.columns.plane[static_cast<std::size_t>(i)];
    turn.block<3, 3>(7 * i, first) = display_from_frame;
    turn.block<3, 3>(7 * i + 3, first + 3) = display_from_frame;
    turn(7 * i + 6, first + 6) = 1;
  }
  return turn * covariance * turn.transpose();
}

CalibratedPlane PlaneOf(const PlaneState& state, const Rigid& display_from_frame,
                        const Eigen::MatrixXd& covariance, Eigen::Index number) {
  CalibratedPlane plane;
  plane.display_from_plane = display_from_frame * state.frame_from_plane;
  plane.magnification = 1 + state.shape(0);
  plane.bow_mm = state.shape(3);
  plane.pincushion = state.shape(4);
  if (covariance.size() == 0) {
    plane.covariance.setConstant(std::numeric_limits<double>::infinity());
  } else {
    plane.covariance = covariance.block<7, 7>(7 * number, 7 * number);
  }
  plane.depth_sd_mm = std::sqrt(plane.covariance(5, 5));
  plane.magnification_sd = std::sqrt(plane.covariance(6, 6));
  plane.tilt_sd_rad = std::sqrt(std::max(plane.covariance(0, 0), plane.covariance(1, 1)));
  plane.depth_with_magnification =
      plane.covariance(5, 6) / (plane.depth_sd_mm * plane.magnification_sd);
  return plane;
}

Calibration CalibrationOf(const VarifocalFit& fit, const VarifocalTask& task,
                          const Rigid& display_from_frame) {
  Calibration calibration = task.design;
  for (std::size_t i = 0; i < calibration.layers.size(); ++i) {
    LayerCalibration& layer = calibration.layers[i];
    const PlaneState& plane = fit.state.planes[i];
    const double larger = (1 + plane.shape(0)) / (1 + layer.emitter.scale);
    layer.display_from_stack = display_from_frame * plane.frame_from_plane;
    layer.emitter = WithShape(layer.emitter, plane.shape);
    if (layer.modulator) layer.modulator = WithShape(*layer.modulator, plane.shape);
    MagnifyOptics(layer, larger);
  }
  return calibration;
}

// The widest angle under which the middle of the planes sees two cameras.
double WidestAngleDeg(const VarifocalFit& fit, const VarifocalTask& task) {
  Vector3d middle = Vector3d::Zero();
  for (const PlaneState& plane : fit.state.planes) {
    middle += plane.frame_from_plane.translation / static_cast<double>(fit.state.planes.size());
  }
  std::set<int> views;
  for (const PlanePhoto& photo : task.observations.photos) views.insert(photo.view);
  std::vector<Vector3d> directions;
  for (const int view : views) {
    const Rigid& pose = fit.state.camera_from_frame[static_cast<std::size_t>(view)];
    directions.push_back((Centre(pose) - middle).normalized());
  }
  double widest = 0;
  for (const Vector3d& a : directions) {
    for (const Vector3d& b : directions)
      widest = std::max(widest, std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  return widest / kOneDegree;
}

void CopyResult(const VarifocalFit& fit, const VarifocalTask& task,
                const CalibrateVarifocalOptions& options, const Display& display,
                VarifocalReport& report) {
  const Rigid display_from_frame =
      options.display_from_frame ? *options.display_from_frame : DisplayFromFrame(fit.state, task);
  report.display_from_frame = display_from_frame;
  report.calibration = CalibrationOf(fit, task, display_from_frame);
  const Eigen::MatrixXd covariance = CovarianceOf(fit);
  if (covariance.size() > 0) {
    report.covariance =
        CovarianceInDisplay(fit, covariance, display_from_frame.rotation.toRotationMatrix());
    report.rays = UncertaintyOfRays(fit, task, display_from_frame, covariance, options.eye_box);
    report.probed = RaysThroughPlanes(task.planes, options.eye_box);
  }
  std::vector<PlaneNumbers> numbers;
  for (std::size_t i = 0; i < task.planes.size(); ++i) {
    report.planes.push_back(PlaneOf(fit.state.planes[i], display_from_frame, report.covariance,
                                    static_cast<Eigen::Index>(i)));
    const CalibratedPlane& plane = report.planes.back();
    const Eigen::AngleAxisd turn(plane.display_from_plane.rotation *
                                 report.planes.front().display_from_plane.rotation.inverse());
    numbers.emplace_back();
    numbers.back() << turn.angle() * turn.axis(), plane.display_from_plane.translation,
        plane.magnification;
  }
  if (report.covariance.size() > 0) {
    report.mirror = FitMirrorModel(numbers, report.covariance, MirrorPhases(*display.varifocal));
  }
  for (std::size_t i = 0; i < fit.state.cameras.size(); ++i) {
    const VarifocalCamera& body = task.observations.cameras[i];
    report.cameras.push_back(CameraOf(fit.state.cameras[i], body.width, body.height));
  }
  for (const Rigid& camera_from_frame : fit.state.camera_from_frame) {
    report.camera_from_display.push_back(camera_from_frame * Inverse(display_from_frame));
  }
  report.limits = options;
  report.slip_px = fit.weighting.slip_sd_px;
  report.chi2 = fit.variance;
  report.rejected.insert(report.rejected.end(), fit.rejected.begin(), fit.rejected.end());
  report.degeneracy = DegeneracyOf(fit);
  report.view_angles_deg = WidestAngleDeg(fit, task);
}

// One view fits whatever it shows.
void CheckSeenTwice(const VarifocalFit& fit, const VarifocalTask& task, VarifocalReport& report) {
  std::vector<int> views(task.planes.size(), 0);
  for (std::size_t i = 0; i < task.observations.photos.size(); ++i) {
    const std::vector<char>& inlier = fit.weighting.inlier[i];
    const bool used = std::find(inlier.begin(), inlier.end(), 1) != inlier.end();
    views[static_cast<std::size_t>(task.observations.photos[i].plane)] += used ? 1 : 0;
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i] >= 2) continue;
    report.failures.push_back(
        {fmt::format("plane {} is in {} good views only: its depth with its magnification is "
                     "checked by nothing",
                     i, views[i]),
         kRings});
  }
}

void CheckKnown(const VarifocalFit& fit, VarifocalReport& report) {
  if (report.covariance.size() > 0 && report.degeneracy.smallest >= kPlanesKnown) return;
  const std::string names = NameOfDirection(report.degeneracy, fit.columns.common);
  const bool of_camera = names.find("camera") != std::string::npos;
  report.failures.push_back(
      {fmt::format("{}: the photographs do not settle it", names),
       of_camera
           ? "calibrate the camera beforehand, or add photographs of the sheet alone, slanted "
             "by 20 to 40 degrees to all sides"
           : kRings});
}

void CheckCertainty(const CalibrateVarifocalOptions& options, VarifocalReport& report) {
  if (report.covariance.size() == 0) return;  // CheckKnown has told
  const auto off = [&](const CalibratedPlane& plane) {
    return std::max(plane.depth_sd_mm / options.largest_depth_sd_mm,
                    plane.magnification_sd / options.largest_magnification_sd);
  };
  const auto worst = std::max_element(
      report.planes.begin(), report.planes.end(),
      [&](const CalibratedPlane& a, const CalibratedPlane& b) { return off(a) < off(b); });
  if (off(*worst) <= 1) return;
  const auto num = std::count_if(report.planes.begin(), report.planes.end(),
                                 [&](const CalibratedPlane& plane) { return off(plane) > 1; });
  report.failures.push_back(
      {fmt::format(
           "depth and magnification of {} planes, most of plane {}: known to {:.4f} mm and "
           "{:.1e} (correlation {:.2f}), {:.3f} mm and {:.0e} are asked for; the views span "
           "{:.1f} degrees",
           num, worst - report.planes.begin(), worst->depth_sd_mm, worst->magnification_sd,
           worst->depth_with_magnification, options.largest_depth_sd_mm,
           options.largest_magnification_sd, report.view_angles_deg),
       kRings});
}

void CheckFits(const std::vector<FitOf>& fits, double expected_chi2, VarifocalReport& report) {
  for (const FitOf& fit : fits) {
    if (fit.num_points == 0) continue;
    const double share = 1 - static_cast<double>(fit.num_used) / fit.num_points;
    if (share > kLargestPlaneOutlierShare) {
      report.failures.push_back(
          {fmt::format("{}: {:.0f} % of its points disagree with the rest", fit.name, 100 * share),
           "look at the photographs that were left out and take them again"});
      continue;
    }
    const double chance = kPlaneChance / std::sqrt(fit.num_used),
                 relative = fit.chi2 / expected_chi2;
    if (relative > kLeastPlaneChi2 - chance && relative < kMostPlaneChi2 + chance) continue;
    report.failures.push_back(
        {fmt::format("how certain all is: {} fits with {:.2f} times the mean chi^2", fit.name,
                     relative),
         "take its photographs again, in focus and with the others' exposure"});
  }
}

// What is extrapolated, or checked by little.
void AddPlaneWarnings(VarifocalReport& report) {
  std::optional<Weakness> in_part;
  std::size_t fewest_seen = ResidualMap::kCells, few_views = 0;
  for (const ResidualMap& map : report.residuals) {
    if (map.views.size() == 2 || map.views.size() == 3) ++few_views;
    if (map.CellsSeen() >= fewest_seen) continue;
    fewest_seen = map.CellsSeen();
    in_part = SeenInPart(fmt::format("plane {}", map.panel.layer), map);
  }
  if (in_part) report.warnings.push_back(*in_part);
  if (few_views == 0) return;
  report.warnings.push_back(
      {fmt::format("{} planes are in 2 or 3 views only: their depths with their magnifications are "
                   "checked by little",
                   few_views),
       kRings});
}

// What residuals say against a solution that would be certain enough.
void CheckResiduals(VarifocalReport& report) {
  if (report.slip_px > kLargestPlaneSlipPx) {
    report.failures.push_back(
        {fmt::format("depths: photographs of one position are shifted against one another by "
                     "{:.3f} px ({} is the most): the camera does not stand still",
                     report.slip_px, kLargestPlaneSlipPx),
         "fix the camera, release it from afar, and take all positions again"});
  }
  double chi2 = 0, used = 0;
  for (const FitOf& plane : report.planes_fit) {
    chi2 += plane.chi2 * plane.num_used;
    used += plane.num_used;
  }
  // Below a hundredth of a deviation residuals are what rounding leaves.
  if (!(chi2 > 1e-4 * used)) return;
  CheckFits(report.planes_fit, chi2 / used, report);
  CheckFits(report.views_fit, chi2 / used, report);
}

}  // namespace

VarifocalReport CalibrateVarifocal(const VarifocalObservations& given, const Display& display,
                                   const CalibrateVarifocalOptions& options) {
  Check(given, kSolveWhere);
  VarifocalReport report;
  VarifocalTask task;
  task.observations = Sorted(WithPlacedViews(given, report.rejected));
  CheckPlanes(task.observations, display);
  task.design = DesignCalibration(display);
  task.planes = PlanesOf(task.design);
  VarifocalSelection selection =
      SelectGroups(Initialise(task.observations, task.planes), task, options.eye_box);
  const VarifocalFit& fit = selection.fit;
  CopyResult(fit, task, options, display, report);
  Summarise(fit, task, report);
  report.groups = std::move(selection.verdicts);
  report.next_view =
      BestNextPlaneView(fit, task, report.display_from_frame,
                        {options.largest_depth_sd_mm, options.largest_magnification_sd});
  CheckKnown(fit, report);
  CheckSeenTwice(fit, task, report);
  CheckCertainty(options, report);
  report.residuals = MapPlanes(fit, task);
  AddPlaneWarnings(report);
  if (report.accepted()) CheckResiduals(report);
  if (!fit.converged && report.accepted()) {
    report.failures.push_back({"the solution did not settle", "look at the photographs left out"});
  }
  return report;
}

std::string Describe(const MirrorModel& mirror) {
  if (!mirror.tested) return "the mirror's model was not tested: too few planes";
  const std::string relay =
      mirror.relay_holds
          ? fmt::format("the relay's law holds: magnification {:.5f} + z/({:.1f} mm)",
                        mirror.magnification0, 1 / mirror.relay_power_per_mm)
          : fmt::format("magnifications do not follow the relay's law (chi^2 {:.0f} of {})",
                        mirror.relay_chi2, mirror.relay_freedom);
  const std::string numbers = fmt::format(
      "{} harmonic{} of the mirror's phase: chi^2 {:.0f} of {}; depths deviate by {:.4f} mm RMS "
      "(measured to {:.4f})",
      mirror.harmonics, mirror.harmonics == 1 ? "" : "s", mirror.chi2, mirror.freedom,
      mirror.depth_rms_mm, mirror.depth_sd_mm);
  if (mirror.holds) return fmt::format("the planes follow the mirror with {}; {}", numbers, relay);
  return fmt::format("the planes do not follow the mirror with {}, plane {} most, by {:.4f} mm; {}",
                     numbers, mirror.worst_plane, mirror.worst_depth_mm, relay);
}

}  // namespace lamella
