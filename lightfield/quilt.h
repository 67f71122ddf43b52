// Quilts: one image of all views, and the cameras that render them (displays.md section 4).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "lightfield/image.h"
#include "lightfield/ray_source.h"

namespace lamella {

// The part of a quilt's image that shows a view, rows from the top (quilt_tile). View 0, the
// leftmost camera's, is at the bottom left, then to the right, then upwards. What the tiles do not
// divide is left at the top and the right.
Rect QuiltTile(int view, int columns, int rows, int width_px, int height_px);

struct QuiltLayout {
  int columns = 0, rows = 0;     // 1 or more
  std::optional<double> aspect;  // width / height of the views as they are to be shown
};
constexpr int kMaxQuiltSide = 1000;  // tiles along a side

// From the last "_qsCxRaA" of a file's name; "aA" may be absent. Nothing where there is none, or it
// names no tile or an absurd number of them.
std::optional<QuiltLayout> QuiltLayoutOf(std::string_view file_name);
// "_qs8x6a0.75", as players read it; five digits of the aspect.
std::string QuiltSuffix(const QuiltLayout& layout);

// The pixels of a view, without a copy. The quilt is at least as large as its grid of tiles.
ImageSpan<const Rgb8> QuiltView(ImageSpan<const Rgb8> quilt, const QuiltLayout& layout, int view);
// Copies a picture of the tile's size to its place.
void PutQuiltView(ImageSpan<Rgb8> quilt, const QuiltLayout& layout, int view,
                  ImageSpan<const Rgb8> picture);
// All tiles but the last black ones, i.e. of a mean code below 1: a quilt of fewer views than tiles
// has such, and a lossy file's are not quite black.
int QuiltViews(ImageSpan<const Rgb8> quilt, const QuiltLayout& layout);

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
// A view's rays in the display's frame, one through every pixel of a tile of so many that is
// stretched over the screen on z = 0. Lengths are the cameras'.
RayBundle QuiltRays(const QuiltCameras& cameras, int view, int tile_width_px, int tile_height_px);

}  // namespace lamella
