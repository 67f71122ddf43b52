#include "calibration/varifocal_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "calibration/homography.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Camera CameraOfView(const VarifocalState& state, const VarifocalObservations& observations,
                    const VarifocalView& view) {
  const auto number = static_cast<std::size_t>(view.camera);
  const VarifocalCamera& body = observations.cameras[number];
  return CameraOf(state.cameras[number], body.width, body.height);
}

// Corresponding columns: points of a plane, and where they are seen, px.
struct Pairs {
  Eigen::Matrix2Xd plane, image;
};

Pairs MarksOf(const VarifocalView& view) {
  const auto num = static_cast<Eigen::Index>(view.marks.size());
  Pairs pairs{Eigen::Matrix2Xd(2, num), Eigen::Matrix2Xd(2, num)};
  for (Eigen::Index i = 0; i < num; ++i) {
    pairs.plane.col(i) = view.marks[static_cast<std::size_t>(i)].frame_mm;
    pairs.image.col(i) = view.marks[static_cast<std::size_t>(i)].image_px;
  }
  return pairs;
}

// The panel without what is only to be found: neither magnified nor bent.
Vector2d FlatPoint(PanelCalibration panel, const Vector2d& pixel) {
  panel.scale = panel.bow_mm = panel.pincushion = 0;
  return PanelPoint(panel, pixel).head<2>();
}

Pairs PointsOf(const PlanePhoto& photo, const PanelCalibration& panel) {
  const auto num = static_cast<Eigen::Index>(photo.points.size());
  Pairs pairs{Eigen::Matrix2Xd(2, num), Eigen::Matrix2Xd(2, num)};
  for (Eigen::Index i = 0; i < num; ++i) {
    const Observation& point = photo.points[static_cast<std::size_t>(i)];
    pairs.plane.col(i) = FlatPoint(panel, point.panel_px);
    pairs.image.col(i) = point.image_px;
  }
  return pairs;
}

// Into normalised coordinates, free of distortion.
std::optional<Matrix3d> NormalisedHomography(Pairs pairs, const Camera& camera) {
  for (Eigen::Index i = 0; i < pairs.image.cols(); ++i) {
    const auto direction = Unproject(camera, pairs.image.col(i));
    if (!direction) return std::nullopt;
    // FitHomography judges in pixels.
    pairs.image.col(i) = camera.fx * direction->head<2>();
  }
  const auto homography = FitHomography(pairs.plane, pairs.image);
  if (!homography) return std::nullopt;
  return Vector3d(1 / camera.fx, 1 / camera.fx, 1).asDiagonal() * *homography;
}

LensParameters StartOf(const VarifocalObservations& observations, std::size_t number) {
  const VarifocalCamera& body = observations.cameras[number];
  LensParameters lens = LensParameters::Zero();
  if (body.known) {
    const Camera& camera = *body.known;
    lens.head<4>() << camera.fx, camera.fy, camera.cx, camera.cy;
    if (camera.model == CameraModel::kPinhole) return lens;
    for (std::size_t i = 0; i < 5; ++i) lens(4 + static_cast<int>(i)) = camera.distortion[i];
    return lens;
  }
  double focal = body.focal_px;
  if (!(focal > 0)) {
    std::vector<Matrix3d> homographies;
    for (const VarifocalView& view : observations.views) {
      if (view.camera != static_cast<int>(number)) continue;
      const Pairs marks = MarksOf(view);
      const auto homography = FitHomography(marks.plane, marks.image);
      if (homography) homographies.push_back(*homography);
    }
    focal = FocalOfHomographies(homographies, body.width, body.height);
  }
  lens.head<4>() << focal, focal, body.width / 2.0, body.height / 2.0;
  return lens;
}

Rigid PoseOf(const VarifocalView& view, const Camera& camera) {
  if (view.camera_from_frame) return *view.camera_from_frame;
  const auto homography = NormalisedHomography(MarksOf(view), camera);
  if (!homography) return {};  // left out already
  Rigid camera_from_frame = PoseOfHomography(*homography);
  if (Centre(camera_from_frame).z() > 0) return camera_from_frame;
  throw InputError(kSolveWhere, fmt::format("the marks of view {} are mirrored", view.name),
                   "number the sheet's marks with x to the right and y up, as they are printed");
}

// The median distance between marks as seen from a pose and as measured.
double MedianError(const VarifocalView& view, const Camera& camera,
                   const Rigid& camera_from_frame) {
  std::vector<double> errors;
  for (const MarkSighting& mark : view.marks) {
    const Vector3d point(mark.frame_mm.x(), mark.frame_mm.y(), 0);
    const auto seen = Project(camera, camera_from_frame * point);
    errors.push_back(seen ? (*seen - mark.image_px).norm()
                          : std::numeric_limits<double>::infinity());
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

// One photograph of a plane on its own.
struct PlaneSight {
  Matrix3d normalised_from_plane;  // of the plane's mm, unmagnified
  Rigid camera_from_frame;
  Vector3d Direction(const Vector2d& plane_mm) const {
    return camera_from_frame.rotation.inverse() *
           (normalised_from_plane * plane_mm.homogeneous()).hnormalized().homogeneous();
  }
};

// Where two lines of sight come nearest to one another.
Vector3d Meeting(const Vector3d& a, const Vector3d& along_a, const Vector3d& b,
                 const Vector3d& along_b) {
  Eigen::Matrix<double, 3, 2> lines;
  lines << along_a, -along_b;
  const Vector2d far = lines.colPivHouseholderQr().solve(b - a);
  return (a + far(0) * along_a + b + far(1) * along_b) / 2;
}

using PlaneGrid = Eigen::Matrix<double, 3, 9>;  // points of a plane, z = 0

Similarity PlaneFrom(const PlaneSight& a, const PlaneSight& b, const PlaneGrid& grid) {
  Eigen::Matrix3Xd met(3, 9);
  for (int i = 0; i < 9; ++i) {
    const Vector2d at = grid.col(i).head<2>();
    met.col(i) = Meeting(Centre(a.camera_from_frame), a.Direction(at), Centre(b.camera_from_frame),
                         b.Direction(at));
  }
  return AlignSimilarity(grid, met);
}

// RMS between where a plane's points should be seen and where they are, normalised coordinates.
double Disagreement(const PlaneSight& sight, const Similarity& frame_from_plane,
                    const PlaneGrid& grid) {
  double sum = 0;
  for (int i = 0; i < 9; ++i) {
    const Vector3d point = sight.camera_from_frame * (frame_from_plane * Vector3d(grid.col(i)));
    if (!(point.z() > 0)) return std::numeric_limits<double>::infinity();
    const Vector3d seen = sight.normalised_from_plane * grid.col(i).head<2>().homogeneous();
    sum += (point.hnormalized() - seen.hnormalized()).squaredNorm();
  }
  return std::sqrt(sum / 9);
}

// The plane of two views' lines that most views agree with.
Similarity PlaneOf(const std::vector<PlaneSight>& sights, const PlaneGrid& grid) {
  Similarity best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < sights.size(); ++a) {
    for (std::size_t b = a + 1; b < sights.size(); ++b) {
      const Similarity plane = PlaneFrom(sights[a], sights[b], grid);
      if (!plane.translation.allFinite() || !(plane.scale > 0)) continue;
      std::vector<double> errors;
      for (const PlaneSight& sight : sights) errors.push_back(Disagreement(sight, plane, grid));
      const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
      std::nth_element(errors.begin(), middle, errors.end());
      if (!(*middle < least)) continue;
      least = *middle;
      best = plane;
    }
  }
  return best;
}

// Over the bounding box of all points that photographs show of it.
PlaneGrid GridOf(const std::vector<const PlanePhoto*>& photos, const PanelCalibration& panel) {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const PlanePhoto* photo : photos) {
    for (const Observation& point : photo->points) {
      const Vector2d at = FlatPoint(panel, point.panel_px);
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  }
  PlaneGrid grid = PlaneGrid::Zero();
  for (int i = 0; i < 9; ++i) {
    const int row = i / 3;
    const Vector2d share(i % 3 / 2.0, row / 2.0);
    grid.col(i).head<2>() = low + share.cwiseProduct(high - low);
  }
  return grid;
}

PlaneState StartOf(int number, const PanelCalibration& panel,
                   const VarifocalObservations& observations, const VarifocalState& state) {
  std::vector<const PlanePhoto*> photos;
  std::vector<PlaneSight> sights;
  for (const PlanePhoto& photo : observations.photos) {
    if (photo.plane != number) continue;
    const auto view = static_cast<std::size_t>(photo.view);
    const auto homography = NormalisedHomography(
        PointsOf(photo, panel), CameraOfView(state, observations, observations.views[view]));
    if (!homography) continue;
    photos.push_back(&photo);
    sights.push_back({*homography, state.camera_from_frame[view]});
  }
  if (sights.size() < 2) {
    throw InputError(
        kSolveWhere,
        fmt::format("plane {} is seen from {} camera position{} with enough points: its depth "
                    "can't be told from its magnification",
                    number, sights.size(), sights.size() == 1 ? "" : "s"),
        "photograph it from 12 positions within the angles from which it is seen");
  }
  const Similarity plane = PlaneOf(sights, GridOf(photos, panel));
  if (!(plane.rotation(2, 2) > 0)) {
    throw InputError(
        kSolveWhere,
        fmt::format("plane {} is mirrored in its photographs, in the display's file it "
                    "is the other way round",
                    number),
        "turn mirror_x of its layer over");
  }
  PlaneState start;
  start.frame_from_plane = {Eigen::Quaterniond(plane.rotation), plane.translation};
  start.shape = ShapeOf(panel);
  start.shape(0) = plane.scale - 1;
  return start;
}

}  // namespace

VarifocalObservations WithPlacedViews(const VarifocalObservations& observations,
                                      std::vector<std::string>& left_out) {
  VarifocalObservations placed = observations;
  std::vector<bool> known;
  for (VarifocalView& view : placed.views) {
    const Pairs marks = MarksOf(view);
    known.push_back(view.camera_from_frame || FitHomography(marks.plane, marks.image));
    if (known.back()) continue;
    left_out.push_back(fmt::format(
        "view {}: {} marks of the frame's sheet do not say where the camera stood: show it whole",
        view.name, view.marks.size()));
    view.marks.clear();
  }
  std::erase_if(placed.photos, [&](const PlanePhoto& photo) {
    return !known[static_cast<std::size_t>(photo.view)];
  });
  if (!placed.photos.empty()) return placed;
  throw InputError(kSolveWhere,
                   "no view shows the frame's printed marks and no pose is given: nothing gives "
                   "lengths, a plane's size goes with its distance",
                   "fix a printed sheet of markers to the frame and photograph it from every "
                   "position");
}

VarifocalState Initialise(const VarifocalObservations& observations,
                          const std::vector<PanelCalibration>& planes) {
  VarifocalState state;
  for (std::size_t i = 0; i < observations.cameras.size(); ++i) {
    state.cameras.push_back(StartOf(observations, i));
  }
  for (const VarifocalView& view : observations.views) {
    state.camera_from_frame.push_back(PoseOf(view, CameraOfView(state, observations, view)));
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    state.planes.push_back(StartOf(static_cast<int>(i), planes[i], observations, state));
  }
  state.slips_px.assign(PhotosOf(observations).size(), Vector2d::Zero());
  return state;
}

void PoseAnew(const VarifocalObservations& observations, VarifocalState& state) {
  for (std::size_t i = 0; i < observations.views.size(); ++i) {
    const VarifocalView& view = observations.views[i];
    if (view.camera_from_frame || view.marks.empty()) continue;
    const Camera camera = CameraOfView(state, observations, view);
    const auto homography = NormalisedHomography(MarksOf(view), camera);
    if (!homography) continue;
    const Rigid anew = PoseOfHomography(*homography);
    Rigid& pose = state.camera_from_frame[i];
    if (MedianError(view, camera, anew) < MedianError(view, camera, pose)) pose = anew;
  }
}

}  // namespace lamella
