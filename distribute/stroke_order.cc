#include "distribute/stroke_order.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>

#include "lightfield/varifocal.h"

namespace lamella {

std::vector<int> StrokeOrder(int planes, int stroke) {
  std::vector<int> order(static_cast<std::size_t>(planes));
  std::iota(order.begin(), order.end(), 0);
  if (stroke % 2 != 0) std::reverse(order.begin(), order.end());
  return order;
}

std::vector<ShownPlane> StrokeSchedule(const Varifocal& varifocal, FocusSweep sweep, int stroke) {
  const std::vector<double> depths = PlaneDepthsMm(varifocal);
  const double count = varifocal.planes;
  // Phase of a rising stroke at which the focus is at z; `end` is the outer plane's.
  const auto phase = [&](double z) {
    const double end = varifocal.depth_mm / 2;
    if (varifocal.planes == 1) return 0.5;
    if (sweep == FocusSweep::kUniform) return 0.5 + z / end * (count - 1) / (2 * count);
    const double amplitude = end / std::cos(std::numbers::pi / (2 * count));
    return std::acos(-z / amplitude) / std::numbers::pi;
  };
  std::vector<ShownPlane> shown;
  for (const int plane : StrokeOrder(varifocal.planes, stroke)) {
    const double rising = phase(depths[static_cast<std::size_t>(plane)]);
    shown.push_back({plane, stroke % 2 == 0 ? rising : 1 - rising});
  }
  return shown;
}

}  // namespace lamella
