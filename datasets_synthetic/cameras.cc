#include "datasets_synthetic/cameras.h"

#include <cmath>
#include <numbers>
#include <random>

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;

// The standard's distributions differ between libraries, its generators don't.
class Normal {
 public:
  explicit Normal(std::uint32_t seed) : generator_(seed) {}
  double operator()() {  // Irwin-Hall: the sum of 12 uniform numbers, mean 0, variance 1
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += generator_() * (1.0 / 4294967296.0);
    return sum;
  }

 private:
  std::mt19937 generator_;
};

}  // namespace

Rigid LookAt(const Vector3d& centre, const Vector3d& target, const Vector3d& up) {
  const Vector3d z = (target - centre).normalized();
  const Vector3d x = z.cross(up).normalized();
  Eigen::Matrix3d camera_from_world;
  camera_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
  Rigid pose;
  pose.rotation = Eigen::Quaterniond(camera_from_world);
  pose.translation = -(pose.rotation * centre);
  return pose;
}

std::vector<Rigid> CamerasOnArc(const HandheldArc& arc, int num_views, std::uint32_t seed) {
  Normal normal(seed);
  std::vector<Rigid> cameras;
  for (int i = 0; i < num_views; ++i) {
    const double share = num_views > 1 ? static_cast<double>(i) / (num_views - 1) - 0.5 : 0.0;
    const double angle = share * arc.angle_deg * kRadians;
    Vector3d centre = arc.target + Vector3d(arc.radius * std::sin(angle), arc.height,
                                            arc.radius * std::cos(angle));
    for (int axis = 0; axis < 3; ++axis) centre(axis) += arc.place_jitter * arc.radius * normal();
    Vector3d aim = arc.target;
    for (int axis = 0; axis < 3; ++axis) {
      aim(axis) += std::tan(arc.aim_jitter_deg * kRadians) * arc.radius * normal();
    }
    const double roll = arc.roll_jitter_deg * kRadians * normal();
    cameras.push_back(LookAt(centre, aim, {std::sin(roll), std::cos(roll), 0}));
  }
  return cameras;
}

}  // namespace lamella
