#include "lightfield/quilt.h"

#include <cmath>
#include <numbers>

namespace lamella {

Rect QuiltTile(int view, int columns, int rows, int width_px, int height_px) {
  const int width = width_px / columns, height = height_px / rows;
  return {view % columns * width, height_px - (view / columns + 1) * height, width, height};
}

QuiltCamera CameraOf(const QuiltCameras& cameras, int view) {
  constexpr double kRadians = std::numbers::pi / 180;
  QuiltCamera camera;
  camera.distance = cameras.half_height / std::tan(cameras.vertical_deg * kRadians / 2);
  const double share = cameras.views > 1 ? static_cast<double>(view) / (cameras.views - 1) : 0.5;
  camera.x = camera.distance * std::tan(cameras.cone_deg * kRadians * (share - 0.5));
  camera.shift = -camera.x / (cameras.half_height * cameras.aspect);
  return camera;
}

double QuiltPosition(const QuiltCameras& cameras, int view, double x, double z) {
  const QuiltCamera camera = CameraOf(cameras, view);
  const double on_screen = camera.x + (x - camera.x) * camera.distance / (camera.distance - z);
  return on_screen / (cameras.half_height * cameras.aspect);
}

}  // namespace lamella
