#include <iostream>

#include <lightfield/camera.h>

int main() {
  lamella::Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500;
  camera.cx = 320;
  camera.cy = 240;
  const auto pixel = Project(camera, {0, 0, 2});
  std::cout << "pixel " << pixel->x() << " " << pixel->y() << "\n";
}
