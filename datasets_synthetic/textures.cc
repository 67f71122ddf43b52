#include "datasets_synthetic/textures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lamella {
namespace {

using Eigen::Vector3d;

// A hash of a lattice point with good low bits (the finaliser of MurmurHash3 over a linear mix).
std::uint32_t Hash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343U +
                    static_cast<std::uint32_t>(y) * 0xd8163841U +
                    static_cast<std::uint32_t>(z) * 0xcb1ab31fU + seed * 0x9e3779b9U;
  h ^= h >> 16;
  h *= 0x85ebca6bU;
  h ^= h >> 13;
  h *= 0xc2b2ae35U;
  h ^= h >> 16;
  return h;
}

double Unit(std::uint32_t hash) { return hash * (1.0 / 4294967296.0); }

// Dot product with one of the 12 edge directions of a cube (16 cases, four doubled).
double Gradient(std::uint32_t hash, double x, double y, double z) {
  const std::uint32_t h = hash & 15U;
  const double u = h < 8 ? x : y;
  const double v = h < 4 ? y : (h == 12 || h == 14 ? x : z);
  return ((h & 1U) != 0 ? -u : u) + ((h & 2U) != 0 ? -v : v);
}

// A shift of the lattice: without it the flat faces of boxes would lie in planes of the lattice,
// where gradient noise of all octaves is 0 at the same points.
Vector3d Shift(std::uint32_t seed) {
  const std::uint32_t h = Hash(1, 2, 3, seed);
  return {0.1 + 0.8 * Unit(h), 0.1 + 0.8 * Unit(h * 0x9e3779b9U),
          0.1 + 0.8 * Unit(h * 0x7feb352dU)};
}

double Fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
double Lerp(double a, double b, double t) { return a + t * (b - a); }
double SmoothStep(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
Rgb Mix(Rgb a, Rgb b, double t) {
  const auto s = static_cast<float>(t);
  return (1 - s) * a + s * b;
}

// How much of an octave with features of `cell` survives under a footprint: noise of lattice
// spacing c has practically nothing beyond one cycle per c, so all is kept from four footprints on
// and all is gone at two.
double Survives(double cell, double footprint) { return SmoothStep(2, 4, cell / footprint); }

// Octaves of equal slope: the finer, the fainter, as in natural pictures.
double Clouds(const Texture& texture, const Vector3d& point, double footprint, std::uint32_t salt) {
  double sum = 0, amplitude = 0.6, cell = texture.scale;
  for (int octave = 0; octave < texture.octaves; ++octave, amplitude *= 0.72, cell *= 0.5) {
    const double kept = Survives(cell, footprint);
    if (kept == 0) break;
    const std::uint32_t seed = texture.seed * 131 + salt * 17 + static_cast<std::uint32_t>(octave);
    sum += kept * amplitude * GradientNoise(point / cell + Shift(seed), seed);
  }
  return sum;
}

// Spots of one size: one per lattice cell at a random place, soft at the rim. Only the 8 cells
// around the point can reach it.
double Spots(const Vector3d& point, double cell, std::uint32_t seed) {
  // Half a cell off: the faces of boxes cut the spots in the middle.
  const Vector3d p = point / cell + Vector3d::Constant(0.5);
  const auto x0 = static_cast<std::int64_t>(std::floor(p.x() - 0.5));
  const auto y0 = static_cast<std::int64_t>(std::floor(p.y() - 0.5));
  const auto z0 = static_cast<std::int64_t>(std::floor(p.z() - 0.5));
  double spot = 0;
  for (int i = 0; i < 8; ++i) {
    const std::int64_t x = x0 + (i & 1), y = y0 + ((i >> 1) & 1), z = z0 + (i >> 2);
    const std::uint32_t h = Hash(x, y, z, seed);
    const Vector3d centre(static_cast<double>(x) + 0.35 + 0.3 * Unit(h),
                          static_cast<double>(y) + 0.35 + 0.3 * Unit(h * 0x9e3779b9U),
                          static_cast<double>(z) + 0.35 + 0.3 * Unit(h * 0x7feb352dU));
    const double radius = 0.18 + 0.25 * Unit(h * 0x846ca68bU);
    spot = std::max(spot, 1 - SmoothStep(0.6 * radius, radius, (p - centre).norm()));
  }
  return spot;
}

Rgb SpottedColor(const Texture& texture, const Vector3d& point, double footprint) {
  Rgb color = Mix(texture.dark, texture.light, 0.5 + 0.5 * Clouds(texture, point, footprint, 1));
  double cell = 0.5 * texture.scale;
  for (std::uint32_t size = 0; size < 4; ++size, cell *= 0.45) {
    // A spot's rim is about a tenth of its cell.
    const double kept = Survives(0.3 * cell, footprint);
    if (kept == 0) break;
    color = Mix(color, texture.accent, 0.85 * kept * Spots(point, cell, texture.seed * 7 + size));
  }
  return color;
}

Rgb TiledColor(const Texture& texture, const Vector3d& point, double footprint) {
  const Vector3d p = point / texture.scale;
  // Joints: dark lines that widen with the footprint as they fade.
  const double joint = std::max(0.03, 1.5 * footprint / texture.scale);
  double grout = 0;
  std::array<std::int64_t, 3> tile{};
  for (int axis = 0; axis < 3; ++axis) {
    tile[static_cast<std::size_t>(axis)] = std::llround(p(axis));
    const double to_edge = 0.5 - std::abs(p(axis) - std::round(p(axis)));
    grout = std::max(grout, 1 - SmoothStep(0.3 * joint, joint, to_edge));
  }
  const std::uint32_t h = Hash(tile[0], tile[1], tile[2], texture.seed);
  const std::array<Rgb, 3> colors = {texture.dark, texture.light, texture.accent};
  const double brightness = 0.6 + 0.4 * Unit(h * 0x9e3779b9U);
  const double clouds = Clouds(texture, point, footprint, h & 0xffU);
  const Rgb color = static_cast<float>(brightness * (0.75 + 0.6 * clouds)) * colors[h % 3];
  const Rgb black{0.03F, 0.03F, 0.03F};
  return Mix(color, black, grout * 0.03 / joint);
}

// The box's extent along an axis (unit): that of the patch, which has none along its normal.
double ExtentAlong(const Vector3d& axis, double footprint, const Vector3d& normal) {
  const double c = axis.dot(normal);
  return footprint * std::sqrt(std::max(0.0, 1 - c * c));
}

// The mean of sin(2 pi f s) over a length w about s is sin(2 pi f s) sin(pi f w) / (pi f w).
double Grating(const Texture& texture, const Vector3d& point, double footprint,
               const Vector3d& normal) {
  const Vector3d axis = texture.direction.normalized();
  const double x = std::numbers::pi * texture.frequency * ExtentAlong(axis, footprint, normal);
  const double kept = std::abs(x) < 1e-8 ? 1 : std::sin(x) / x;
  return kept * std::sin(2 * std::numbers::pi * texture.frequency * axis.dot(point));
}

// The mean over [x - w/2, x + w/2] of the square wave that is 1 on [-1/2, 1/2] and -1 on the next
// unit: the difference of its integral, a triangle wave.
double MeanOfSquareWave(double x, double w) {
  const auto integral = [](double s) {
    const double r = s - 2 * std::round(s / 2);  // period 2, in [-1, 1]
    return std::abs(r) <= 0.5 ? r : std::copysign(1 - std::abs(r), r);
  };
  if (w < 1e-9) return std::abs(x - 2 * std::round(x / 2)) <= 0.5 ? 1 : -1;
  return (integral(x + 0.5 * w) - integral(x - 0.5 * w)) / w;
}

double Checker(const Texture& texture, const Vector3d& point, double footprint,
               const Vector3d& normal) {
  double sign = 1;
  for (int i = 0; i < 3; ++i) {
    const double extent = ExtentAlong(Vector3d::Unit(i), footprint, normal);
    sign *= MeanOfSquareWave(point(i) / texture.scale, extent / texture.scale);
  }
  return sign;
}

}  // namespace

double GradientNoise(const Vector3d& point, std::uint32_t seed) {
  const Vector3d base = point.array().floor();
  const auto x = static_cast<std::int64_t>(base.x()), y = static_cast<std::int64_t>(base.y()),
             z = static_cast<std::int64_t>(base.z());
  const Vector3d f = point - base;
  const double u = Fade(f.x()), v = Fade(f.y()), w = Fade(f.z());
  const auto corner = [&](int i, int j, int k) {
    return Gradient(Hash(x + i, y + j, z + k, seed), f.x() - i, f.y() - j, f.z() - k);
  };
  return Lerp(
      Lerp(Lerp(corner(0, 0, 0), corner(1, 0, 0), u), Lerp(corner(0, 1, 0), corner(1, 1, 0), u), v),
      Lerp(Lerp(corner(0, 0, 1), corner(1, 0, 1), u), Lerp(corner(0, 1, 1), corner(1, 1, 1), u), v),
      w);
}

Rgb ColorAt(const Texture& texture, const Vector3d& point, double footprint,
            const Vector3d& normal) {
  Rgb color;
  switch (texture.pattern) {
    case Texture::Pattern::kNoise: {
      const double clouds = Clouds(texture, point, footprint, 1);
      // Veins where a second, coarser noise crosses zero.
      Texture coarse = texture;
      coarse.octaves = std::max(1, texture.octaves - 3);
      const double vein = std::abs(Clouds(coarse, point, 2 * footprint, 2));
      color = Mix(texture.dark, texture.light, SmoothStep(-0.8, 0.8, clouds));
      color = Mix(color, texture.accent, 0.7 * (1 - SmoothStep(0.02, 0.2, vein)));
      break;
    }
    case Texture::Pattern::kSpots:
      color = SpottedColor(texture, point, footprint);
      break;
    case Texture::Pattern::kTiles:
      color = TiledColor(texture, point, footprint);
      break;
    case Texture::Pattern::kPlain:
      return texture.light;
    case Texture::Pattern::kGrating:
      return Mix(texture.dark, texture.light,
                 0.5 + 0.5 * Grating(texture, point, footprint, normal));
    case Texture::Pattern::kChecker:
      return Mix(texture.dark, texture.light,
                 0.5 + 0.5 * Checker(texture, point, footprint, normal));
  }
  const auto clamp = [](float c) { return std::clamp(c, 0.0F, 1.0F); };
  return {clamp(color.r), clamp(color.g), clamp(color.b)};
}

}  // namespace lamella
