#include "calibration/varifocal_observations.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

void CheckCamera(const VarifocalCamera& camera, const std::string& where) {
  Check(PhotoCamera{camera.name, camera.width, camera.height, camera.focal_px}, where);
  if (!camera.known) return;
  const auto& distortion = camera.known->distortion;
  const bool rational = std::any_of(distortion.begin() + 5, distortion.end(),
                                    [](double number) { return number != 0; });
  if (camera.known->model == CameraModel::kFisheye || rational) {
    throw InputError(where, fmt::format("camera {} has a lens model of its own", camera.name),
                     "calibrate it with k1, k2, p1, p2 and k3, or let it be found");
  }
}

void CheckPoint(const Eigen::Vector2d& shown, const Eigen::Vector2d& seen,
                const Eigen::Matrix2d& covariance, const std::string& of,
                const std::string& where) {
  if (!shown.allFinite() || !seen.allFinite()) {
    throw InputError(where, of + " has a point that is not finite", "detect its pattern again");
  }
  const bool certain = covariance.allFinite() && covariance(0, 0) > 0 &&
                       covariance.determinant() > 0 &&
                       std::abs(covariance(0, 1) - covariance(1, 0)) <= 1e-9 * covariance.trace();
  if (!certain) {
    throw InputError(where, of + " has a covariance that is not positive definite",
                     "detect its pattern again");
  }
}

void CheckPhoto(const PlanePhoto& photo, int num_views, const std::string& where) {
  if (photo.view < 0 || photo.view >= num_views) {
    throw InputError(where, fmt::format("{} is of view {}", photo.photo, photo.view),
                     fmt::format("there are {} views, from 0", num_views));
  }
  for (const Observation& point : photo.points) {
    CheckPoint(point.panel_px, point.image_px, point.covariance_px2, photo.photo, where);
  }
}

}  // namespace

void Check(const VarifocalObservations& observations, const std::string& where) {
  for (const VarifocalCamera& camera : observations.cameras) CheckCamera(camera, where);
  const int num_cameras = static_cast<int>(observations.cameras.size());
  for (const VarifocalView& view : observations.views) {
    if (view.camera < 0 || view.camera >= num_cameras) {
      throw InputError(where, fmt::format("view {} is of camera {}", view.name, view.camera),
                       fmt::format("there are {} cameras, from 0", num_cameras));
    }
    for (const MarkSighting& mark : view.marks) {
      CheckPoint(mark.frame_mm, mark.image_px, mark.covariance_px2, "view " + view.name, where);
    }
  }
  if (observations.photos.empty()) {
    throw InputError(where, "no plane was found in any photograph",
                     "photograph the planes' patterns, one plane lit at a time");
  }
  std::set<std::pair<int, int>> seen;
  for (const PlanePhoto& photo : observations.photos) {
    CheckPhoto(photo, static_cast<int>(observations.views.size()), where);
    if (!seen.emplace(photo.plane, photo.view).second) {
      throw InputError(
          where,
          fmt::format("plane {} appears twice in view {} ({})", photo.plane,
                      observations.views[static_cast<std::size_t>(photo.view)].name, photo.photo),
          "leave one out");
    }
  }
}

}  // namespace lamella
