#include "tests/pipeline/textured_room.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr double kFloor = 1.2, kWall = 7;  // y and z of the planes
const Vector3d kBoxMin(-0.9, -0.1, 3.4), kBoxMax(0.7, 1.2, 4.6);

double Noise(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15U ^
                    static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FU ^
                    seed * 0x165667B19E3779F9U;
  h ^= h >> 29;
  h *= 0xBF58476D1CE4E5B9U;
  h ^= h >> 32;
  return static_cast<double>(h & 0xFFFFU) / 65535.0;
}

// Smooth noise of several sizes.
double Texture(double u, double v, std::uint64_t seed) {
  double sum = 0, weight = 1;
  for (double f : {3.0, 7.0, 14.0, 25.0}) {
    const double x = u * f, y = v * f;
    const auto x0 = static_cast<std::int64_t>(std::floor(x)),
               y0 = static_cast<std::int64_t>(std::floor(y));
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double s = smooth(x - std::floor(x)), t = smooth(y - std::floor(y));
    const auto at = [&](int i, int j) { return Noise(x0 + i, y0 + j, seed); };
    sum += weight * ((1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) +
                     t * ((1 - s) * at(0, 1) + s * at(1, 1)));
    weight *= 0.8;
    ++seed;
  }
  return std::clamp(sum / 2.95 * 1.8 - 0.4, 0.02, 0.98);
}

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  int axis = 0;  // normal
};

void MeetPlane(const Vector3d& origin, const Vector3d& direction, int axis, double at, Hit& hit) {
  const double t = (at - origin[axis]) / direction[axis];
  if (t > 1e-9 && t < hit.distance) hit = {t, axis};
}

void MeetBox(const Vector3d& origin, const Vector3d& direction, Hit& hit) {
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    double a = (kBoxMin[i] - origin[i]) / direction[i], b = (kBoxMax[i] - origin[i]) / direction[i];
    if (a > b) std::swap(a, b);
    if (a > enter) {
      enter = a;
      axis = i;
    }
    leave = std::min(leave, b);
  }
  if (enter > 1e-9 && enter < leave && enter < hit.distance) hit = {enter, axis};
}

Rgb ColorOf(const Vector3d& origin, const Vector3d& direction, unsigned seed) {
  Hit hit;
  MeetPlane(origin, direction, 1, kFloor, hit);
  MeetPlane(origin, direction, 2, kWall, hit);
  MeetBox(origin, direction, hit);
  if (!std::isfinite(hit.distance)) return {0.5F, 0.6F, 0.8F};
  const Vector3d p = origin + hit.distance * direction;
  const double value = Texture(p[(hit.axis + 1) % 3], p[(hit.axis + 2) % 3],
                               1000U * seed + 100U * static_cast<unsigned>(hit.axis));
  const auto v = static_cast<float>(value);
  return {v, 0.9F * v, 0.8F * v + 0.02F};
}

}  // namespace

Image<Rgb> PhotographRoom(const Camera& camera, const Rigid& camera_from_world, unsigned seed) {
  const Rigid world_from_camera = Inverse(camera_from_world);
  Image<Rgb> image(camera.width, camera.height);
  constexpr int kSamples = 2;  // per axis
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Rgb sum;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const int column = s % kSamples, row = s / kSamples;
        const Eigen::Vector2d pixel(x + (column + 0.5) / kSamples, y + (row + 0.5) / kSamples);
        const auto direction = Unproject(camera, pixel);
        if (!direction) continue;
        sum +=
            ColorOf(world_from_camera.translation, world_from_camera.rotation * *direction, seed);
      }
      image(x, y) = 1.0F / (kSamples * kSamples) * sum;
    }
  }
  return image;
}

double DistanceFromRoom(const Vector3d& point) {
  const Vector3d outside = (kBoxMin - point).cwiseMax(point - kBoxMax).cwiseMax(0.0);
  double box = outside.norm();
  if (box == 0) box = std::min((point - kBoxMin).minCoeff(), (kBoxMax - point).minCoeff());
  return std::min({std::abs(point.y() - kFloor), std::abs(point.z() - kWall), box});
}

std::vector<Rigid> ArcOfCameras(int count) {
  std::vector<Rigid> cameras;
  const Vector3d target(0, 0.4, 4.2);
  for (int i = 0; i < count; ++i) {
    const double t = count > 1 ? 2.0 * i / (count - 1) - 1 : 0;
    const Vector3d centre(1.6 * t, -0.3 + 0.25 * std::sin(3 * t), 0.3 * t * t);
    const Vector3d forward = (target - centre).normalized();
    const Vector3d right = Vector3d(0, 1, 0).cross(forward).normalized();
    Eigen::Matrix3d world_from_camera;
    world_from_camera << right, forward.cross(right), forward;
    cameras.push_back(Inverse(Rigid{Eigen::Quaterniond(world_from_camera), centre}));
  }
  return cameras;
}

}  // namespace lamella
