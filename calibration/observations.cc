#include "calibration/observations.h"

#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

bool PositiveDefinite(const Eigen::Matrix2d& m) {
  return m.allFinite() && m(0, 0) > 0 && m.determinant() > 0 &&
         std::abs(m(0, 1) - m(1, 0)) <= 1e-9 * (m(0, 0) + m(1, 1));
}

void CheckPoints(const PanelPhoto& photo, const std::string& where) {
  for (const Observation& point : photo.points) {
    if (!point.panel_px.allFinite() || !point.image_px.allFinite()) {
      throw InputError(
          where,
          fmt::format("{} of {} has a point that is not finite", NameOf(photo.panel), photo.photo),
          "detect its pattern again");
    }
    if (!PositiveDefinite(point.covariance_px2)) {
      throw InputError(where,
                       fmt::format("{} of {} has a covariance that is not positive definite",
                                   NameOf(photo.panel), photo.photo),
                       "detect its pattern again");
    }
  }
}

}  // namespace

void Check(const PhotoCamera& camera, const std::string& where) {
  if (camera.width < 1 || camera.height < 1) {
    throw InputError(
        where, fmt::format("camera {} is {} x {} px", camera.name, camera.width, camera.height),
        "give its photographs' size");
  }
  if (!(camera.focal_px >= 0 && camera.focal_px < 1e9)) {
    throw InputError(where, fmt::format("camera {} has focal_px {}", camera.name, camera.focal_px),
                     "give a positive number, or 0 where none is known");
  }
}

std::string NameOf(const PanelId& panel) {
  return fmt::format("layer {} {}", panel.layer,
                     panel.role == PanelId::kEmitter ? "emitter" : "modulator");
}

void Check(const Observations& observations, const std::string& where) {
  const int num_cameras = static_cast<int>(observations.cameras.size());
  for (const PhotoCamera& camera : observations.cameras) Check(camera, where);
  std::map<int, int> camera_of_view;
  std::set<std::pair<std::string, PanelId>> seen;
  for (const PanelPhoto& photo : observations.photos) {
    if (photo.camera < 0 || photo.camera >= num_cameras) {
      throw InputError(where, fmt::format("{} is of camera {}", photo.photo, photo.camera),
                       fmt::format("there are {} cameras, from 0", num_cameras));
    }
    const auto [view, first] = camera_of_view.emplace(photo.view, photo.camera);
    if (!first && view->second != photo.camera) {
      throw InputError(
          where,
          fmt::format("view {} has photographs of two cameras ({})", photo.view, photo.photo),
          "give each camera's positions numbers of their own");
    }
    if (!seen.emplace(photo.photo, photo.panel).second) {
      throw InputError(where,
                       fmt::format("{} appears twice in {}", NameOf(photo.panel), photo.photo),
                       "leave one out");
    }
    CheckPoints(photo, where);
  }
}

}  // namespace lamella
