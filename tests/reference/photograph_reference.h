// A photograph of the virtual prototype the plain way: every half pixel is the mean of a square
// grid of lines of sight that are traced one by one, spread by the Gaussian that is summed as it
// stands. A second opinion about what the prototype gathers, not about the lines themselves, which
// the renderer of planes under homographies has.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "lightfield/camera.h"
#include "lightfield/image.h"

namespace lamella::reference {

using LightSeen = std::function<Rgb(const Eigen::Vector3d& direction)>;  // in the camera's frame

// The mean over a square of the sensor, px, from the 377 lines of sight of a Fibonacci lattice, in
// which no edge runs along a row of them.
inline Eigen::Vector3d MeanOfSquare(const Camera& camera, const LightSeen& seen, double left,
                                    double top, double side) {
  constexpr int kLines = 377, kStep = 233;
  Eigen::Vector3d sum(0, 0, 0);
  for (int i = 0; i < kLines; ++i) {
    const double x = (i + 0.5) / kLines, y = (i * kStep % kLines + 0.5) / kLines;
    const auto direction = Unproject(camera, {left + side * x, top + side * y});
    if (!direction) continue;
    const Rgb light = seen(*direction);
    sum += Eigen::Vector3f(light.r, light.g, light.b).cast<double>();
  }
  return sum / kLines;
}

// At the pictures' borders half pixels go on as they end.
inline Image<Rgb> SpreadPhotograph(const Camera& camera, const LightSeen& seen, double sigma_px) {
  const int width = 2 * camera.width, height = 2 * camera.height;
  std::vector<Eigen::Vector3d> half;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      half.push_back(MeanOfSquare(camera, seen, 0.5 * x, 0.5 * y, 0.5));
    }
  }
  const int reach = static_cast<int>(std::ceil(8 * sigma_px));
  Image<Rgb> photograph(camera.width, camera.height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Eigen::Vector3d sum(0, 0, 0);
      double weights = 0;
      for (int j = -reach; j <= reach; ++j) {
        for (int i = -reach; i <= reach; ++i) {
          const double weight = std::exp(-(i * i + j * j) / (8 * sigma_px * sigma_px));
          const int u = std::clamp(x + i, 0, width - 1), v = std::clamp(y + j, 0, height - 1);
          sum += weight * half[static_cast<std::size_t>(v * width + u)];
          weights += weight;
        }
      }
      const Eigen::Vector3f mean = (sum / (4 * weights)).cast<float>();
      photograph(x / 2, y / 2) += Rgb{mean.x(), mean.y(), mean.z()};
    }
  }
  return photograph;
}

}  // namespace lamella::reference
