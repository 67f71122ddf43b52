#include "pipeline/solve_varifocal.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "calibration/lens_sightings.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "pipeline/calibration_report.h"
#include "pipeline/calibration_set_up.h"
#include "pipeline/check_photos.h"
#include "pipeline/observe_photos.h"
#include "pipeline/position_cameras.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// Of a lens in the list; adds one that is not there yet.
int NumberOf(const Camera& camera, std::vector<VarifocalCamera>& cameras) {
  const auto same = std::find_if(cameras.begin(), cameras.end(), [&](const VarifocalCamera& other) {
    const Camera& known = *other.known;
    return known.model == camera.model && known.width == camera.width &&
           known.height == camera.height && known.fx == camera.fx && known.fy == camera.fy &&
           known.cx == camera.cx && known.cy == camera.cy && known.distortion == camera.distortion;
  });
  if (same == cameras.end()) {
    cameras.push_back(
        {fmt::format("{}", cameras.size() + 1), camera.width, camera.height, 0, camera});
    return static_cast<int>(cameras.size()) - 1;
  }
  return static_cast<int>(same - cameras.begin());
}

// The view of every position that is complete; -1 for the others.
using ViewOfPosition = std::vector<int>;

ViewOfPosition AddViewsOfFile(const CheckedPhotos& checked, const fs::path& file,
                              VarifocalObservations& observations) {
  const std::map<int, View> cameras = CamerasOfPositions(checked, file);
  ViewOfPosition view_of(static_cast<std::size_t>(checked.num_views), -1);
  for (int position = 0; position < checked.num_views; ++position) {
    if (!IsComplete(checked, position)) continue;
    const View& view = CameraOfPosition(cameras, position, checked, file);
    view_of[static_cast<std::size_t>(position)] = static_cast<int>(observations.views.size());
    const int camera = NumberOf(view.camera, observations.cameras);
    observations.views.push_back(
        {fmt::format("{}", position + 1), camera, {}, view.camera_from_world});
  }
  return view_of;
}

// Positions from which the board alone is seen have a view, too.
ViewOfPosition AddViewsOfBoard(const CheckedPhotos& checked, const SolveVarifocalOptions& options,
                               SolvedVarifocal& solved, VarifocalObservations& observations,
                               std::set<std::string>& names) {
  const PhotoCamera body = BodyOf(checked, options.photos.focal_px);
  observations.cameras.push_back({body.name, body.width, body.height, body.focal_px, {}});
  const PrintedBoard printed = BoardOf(checked, options.board_square_mm);
  const PanelCalibration sheet = PanelOf(printed);
  const std::vector<BoardPhoto> photos = BoardPhotosOf(checked, options.photos.photos);
  // Corners are known as well as they fit the board alone, relative to one another as each says: a
  // page is not flat to a hundredth of a pixel, and with less its marks would be taken for errors
  // beside the planes' points.
  const double chi2 = CamerasOfBoard(photos, body, printed).chi2;
  ViewOfPosition view_of(static_cast<std::size_t>(checked.num_views), -1);
  std::vector<int> positions;
  for (const BoardPhoto& photo : photos) {
    const auto position = static_cast<std::size_t>(photo.view);
    if (IsComplete(checked, photo.view)) {
      view_of[position] = static_cast<int>(observations.views.size());
    }
    VarifocalView view{fmt::format("{}", photo.view + 1), 0, {}, {}};
    for (const Observation& point : photo.points) {
      view.marks.push_back({PanelPoint(sheet, point.panel_px).head<2>(), point.image_px,
                            chi2 * point.covariance_px2});
    }
    observations.views.push_back(view);
    positions.push_back(photo.view);
    names.insert(photo.photo);
  }
  const std::vector<std::string> without = PositionsWithoutBoard(checked, positions);
  solved.left_out.insert(solved.left_out.end(), without.begin(), without.end());
  return view_of;
}

// `names` gains those of the photographs that tell the cameras.
ViewOfPosition AddViews(const CheckedPhotos& checked, const SolveVarifocalOptions& options,
                        SolvedVarifocal& solved, VarifocalObservations& observations,
                        std::set<std::string>& names) {
  solved.left_out = IncompletePositions(checked);
  if (options.cameras.empty() && checked.list.printed) {
    return AddViewsOfBoard(checked, options, solved, observations, names);
  }
  return AddViewsOfFile(checked, options.cameras, observations);
}

// `names` gains those of the photographs that were used.
void AddPlanes(const CheckedPhotos& checked, const ViewOfPosition& view_of,
               const Calibration& design, const fs::path& photos, Progress& progress,
               VarifocalObservations& observations, std::set<std::string>& names) {
  const fs::path folder = fs::is_directory(photos) ? photos : photos.parent_path();
  const auto num_planes = static_cast<std::int64_t>(checked.list.panels.size());
  progress.Start("sinusoids", static_cast<std::int64_t>(checked.num_views) * num_planes, "planes");
  for (int position = 0; position < checked.num_views; ++position) {
    const int view = view_of[static_cast<std::size_t>(position)];
    for (const CalibratedPanel& panel : checked.list.panels) {
      const auto seen = view < 0 ? std::nullopt : DecodePanel(checked, folder, position, panel);
      progress.Advance();
      if (!seen) continue;
      names.insert(seen->photos.begin(), seen->photos.end());
      const LayerCalibration& layer = design.layers[static_cast<std::size_t>(panel.id.layer)];
      observations.photos.push_back({panel.id.layer, view, seen->photos.front(),
                                     ObserveLenses(seen->map, layer.emitter, *layer.lattice)});
    }
  }
}

}  // namespace

SolvedVarifocal SolveVarifocalPhotos(const SolveVarifocalOptions& options, Progress& progress) {
  const fs::path &patterns = options.photos.patterns, &photos = options.photos.photos;
  const CalibrationSetUp set_up = LoadCalibrationSetUp(patterns, options.photos.display);
  const Calibration& design = set_up.design;
  SolvedVarifocal solved;
  solved.display = set_up.display;
  for (const LayerCalibration& layer : design.layers) {
    if (layer.lattice && layer.lattice->type != LensLattice::Type::kLine) continue;
    throw UsageError(solved.display.name, "has planes without lenslets",
                     "calibrate lenslets alone");
  }
  const CheckedPhotos checked = CheckPhotos(
      patterns, photos, [](const CheckedPhoto&, const std::string&) {}, progress);
  CheckOneSize(checked);
  VarifocalObservations observations;
  std::set<std::string> names;
  const ViewOfPosition view_of = AddViews(checked, options, solved, observations, names);
  AddPlanes(checked, view_of, design, photos, progress, observations, names);
  solved.photos = HashPhotos(names, photos);
  for (const CheckedPhoto& photo : checked.photos) {
    if (photo.good) continue;
    (names.count(photo.photo) > 0 ? solved.doubtful : solved.left_out)
        .push_back(photo.photo + ": " + photo.verdict);
  }
  progress.Start("solution", 1, "calibration");
  CalibrateVarifocalOptions calibrate;
  calibrate.eye_box = CleanEyesOf(solved.display);
  // A board says nothing of where the display is to stand.
  if (!options.cameras.empty()) calibrate.display_from_frame = Rigid{};
  solved.report = CalibrateVarifocal(observations, solved.display, calibrate);
  const std::vector<std::string>& rejected = solved.report.rejected;
  solved.left_out.insert(solved.left_out.end(), rejected.begin(), rejected.end());
  progress.Advance();
  return solved;
}

std::string DescribeNextPlaneView(const VarifocalReport& report) {
  if (!report.next_view) return "";
  const NextPlaneView& next = *report.next_view;
  return fmt::format(
      "all planes from {}, after which the worst known one would be known to {:.4f} mm and {:.1e} "
      "of its magnification, {:.2f} times what is asked for (now {:.2f} times)",
      DescribePlace(next.right_deg, next.up_deg, next.distance_mm), next.next_depth_sd_mm,
      next.next_magnification_sd, next.next_times_limit, next.times_limit);
}

std::string DescribeVarifocal(const SolvedVarifocal& solved) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const VarifocalReport& report = solved.report;
  std::string text =
      report.accepted()
          ? fmt::format("The planes of {} are known well enough.\n", solved.display.name)
          : fmt::format("The planes of {} are not known well enough.\n", solved.display.name);
  text += DescribeWeaknesses("what the photographs leave open", report.failures);
  text += DescribeWeaknesses("what is weak", report.warnings);
  const std::string next = DescribeNextPlaneView(report);
  if (!next.empty()) text += "\nthe next photographs that help most\n  " + next + "\n";
  text += fmt::format(
      "\nchi^2 {:.3f} per degree of freedom, slip {:.4f} px, views over {:.1f} degrees\n"
      "{}\n\n"
      "planes: z mm, magnification, tilt x and y in degrees, each with its standard "
      "deviation; chi^2\n",
      report.chi2, report.slip_px, report.view_angles_deg, Describe(report.mirror));
  for (std::size_t k = 0; k < report.planes.size(); ++k) {
    const CalibratedPlane& plane = report.planes[k];
    const Eigen::AngleAxisd turn(plane.display_from_plane.rotation);
    const Eigen::Vector3d tilt = kDegrees * turn.angle() * turn.axis();
    text += fmt::format(
        "  {:>3} {:>10.4f} +- {:.4f} {:>9.6f} +- {:.6f} {:>8.4f} {:>8.4f} +- {:.4f} {:>7.3f}\n", k,
        plane.display_from_plane.translation.z(), plane.depth_sd_mm, plane.magnification,
        plane.magnification_sd, tilt.x(), tilt.y(), kDegrees * plane.tilt_sd_rad,
        report.planes_fit[k].chi2);
  }
  text += "\nbeyond poses and magnifications\n";
  for (const GroupVerdict& group : report.groups) {
    text += fmt::format("  {}: {}, {}\n", group.group, group.freed ? "freed" : "as designed",
                        group.reason);
  }
  return text + DescribeLines("left out", solved.left_out) +
         DescribeLines("used, though better ones would help", solved.doubtful);
}

}  // namespace lamella
