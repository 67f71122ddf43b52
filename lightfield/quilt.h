// Quilts: one image of all views, and the cameras that render them (displays.md section 4).
#pragma once

#include "lightfield/image.h"

namespace lamella {

// The part of a quilt's image that shows a view, rows from the top (quilt_tile). View 0, the
// leftmost camera's, is at the bottom left, then to the right, then upwards. What the tiles do not
// divide is left at the top and the right.
Rect QuiltTile(int view, int columns, int rows, int width_px, int height_px);

// The cameras stand on a line that is parallel to the screen, at equal angles; they look straight
// ahead and their pictures are shifted, never turned.
struct QuiltCameras {
  int views = 48;
  double cone_deg = 40;      // from the first to the last
  double half_height = 80;   // of the focal plane, any length
  double aspect = 0.75;      // of the screen
  double vertical_deg = 14;  // field of view
};
struct QuiltCamera {
  double distance = 0;  // from the focal plane
  double x = 0;         // along the line
  double shift = 0;     // entry [0][2] of an OpenGL projection
};
QuiltCamera CameraOf(const QuiltCameras& cameras, int view);  // quilt_camera
// Where a point that is x right of the screen's middle and z in front of it lands in a view, -1 to
// 1 across the tile (quilt_ndc).
double QuiltPosition(const QuiltCameras& cameras, int view, double x, double z);

}  // namespace lamella
