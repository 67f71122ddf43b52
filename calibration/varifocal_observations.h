// What photographs of a varifocal display say: points of each of its planes, shown one at a time,
// and the marks of a printed sheet that is fixed to its frame. Pixels as in observations.h.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

// A mark of the sheet as a photograph shows it. The sheet lies in the plane z = 0 of the frame: mm,
// x right, y up, z towards the viewer. It is what gives all lengths: a plane's own pixels are of
// unknown size.
struct MarkSighting {
  Eigen::Vector2d frame_mm{0, 0};
  Eigen::Vector2d image_px{0, 0};
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

struct VarifocalCamera {
  std::string name;
  int width = 0, height = 0;  // px
  double focal_px = 0;        // a guess; 0: none, one is estimated
  // Calibrated beforehand: taken as exact. A pinhole or Brown's model with k1, k2, p1, p2, k3.
  std::optional<Camera> known = {};
};

// A camera position.
struct VarifocalView {
  std::string name;
  int camera = 0;
  std::vector<MarkSighting> marks;              // may be all that is photographed from here
  std::optional<Rigid> camera_from_frame = {};  // known beforehand: taken as exact
};

// The points of one plane from one view. A point of a plane is one of its lens sheet, in pixels of
// the panel behind it: through the lens at panel_px the camera sees light at image_px.
struct PlanePhoto {
  int plane = 0, view = 0;
  std::string photo;  // its name
  std::vector<Observation> points;
};

struct VarifocalObservations {
  std::vector<VarifocalCamera> cameras;
  std::vector<VarifocalView> views;
  std::vector<PlanePhoto> photos;
};

// InputError (one line naming the photograph or view) where a number is not finite, a covariance is
// not positive definite, a camera or view is not in the list, a camera has no size or another model
// than those above, a plane appears twice in one view, or there is no photograph of any plane.
void Check(const VarifocalObservations& observations, const std::string& where);

}  // namespace lamella
