// A camera and where it stood, from the printed board in its photographs. calibration.md sections 3
// and 5.
#pragma once

#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/charuco_board.h"
#include "calibration/observations.h"
#include "lightfield/camera.h"
#include "lightfield/rigid.h"

namespace lamella {

// The board's corners from one camera position, in the board's pixels.
struct BoardPhoto {
  int view = 0;       // the position
  std::string photo;  // its name
  std::vector<Observation> points;
};

struct CameraPoses {
  Camera camera;
  std::vector<Rigid> camera_from_board;  // of each view
};

struct BoardCameras {
  CameraPoses found;
  std::vector<int> views;  // positions, rising, of what was not rejected
  // The same, one standard deviation off in independent directions of all numbers together: the
  // differences from `found` have their joint covariance. Empty where that is not known.
  std::vector<CameraPoses> off;
  int num_corners = 0, num_used = 0;
  double rms_px = 0;       // length of used corners' residuals in the image: of both axes together
  double chi2 = 0;         // per degree of freedom: of used corners, in their own deviations
  double focal_sd_px = 0;  // the larger of two axes
  bool has_k3 = false;     // else the lens has k1, k2, p1 and p2
  std::vector<std::string> rejected;
  // Where not empty the cameras are not to be used.
  std::vector<Weakness> failures;
};

// Lens and poses together, robustly, with the board flat and as it was measured: lengths are its.
// k3 is free where chi^2 falls by more than its ln N and every direction of all numbers is known
// ten times better than what a builder would assume (calibration.md section 6). A failure where a
// direction is not known at all; what is known badly (the focal length with the distances, of
// frontal views) is in `off`, for what is made of the cameras to judge. InputError where points lie
// on a line, or there are none.
BoardCameras CamerasOfBoard(const std::vector<BoardPhoto>& photos, const PhotoCamera& body,
                            const PrintedBoard& printed);

}  // namespace lamella
