#include "lightfield/varifocal.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace lamella {

std::vector<double> PlaneDepthsMm(const Varifocal& varifocal) {
  const int planes = varifocal.planes;
  if (planes == 1) return {0};
  const auto relative = [&](int k) {
    if (varifocal.spacing == Varifocal::Spacing::kUniform) {
      return (2.0 * k - (planes - 1)) / (planes - 1);
    }
    // sin is odd to the last bit, so that the planes are symmetric.
    const double angle = std::numbers::pi / planes;
    return std::sin(angle * (k - (planes - 1) / 2.0)) / std::sin(angle * (planes - 1) / 2.0);
  };
  std::vector<double> depths;
  for (int k = 0; k < planes; ++k) depths.push_back(relative(k) * varifocal.depth_mm / 2);
  return depths;
}

double PlaneMagnification(const Varifocal& varifocal, double z_mm) {
  return varifocal.magnification0 + z_mm / varifocal.relay_focal_mm;
}

std::array<std::uint8_t, 3> PackBitPlanes(std::uint32_t planes, std::string_view order) {
  std::array<std::uint8_t, 3> codes{};
  for (std::size_t part = 0; part < 3; ++part) {
    const std::size_t channel = std::string_view("RGB").find(order[part]);
    codes.at(channel) = static_cast<std::uint8_t>(planes >> (8 * part) & 0xFFU);
  }
  return codes;
}

bool SigmaDelta(double grey, double& accumulator) {
  accumulator += grey;
  if (accumulator < 1) return false;
  accumulator -= 1;
  return true;
}

}  // namespace lamella
