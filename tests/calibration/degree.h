#pragma once

#include <numbers>

namespace lamella {

inline constexpr double kDegree = std::numbers::pi / 180;  // radians

}  // namespace lamella
