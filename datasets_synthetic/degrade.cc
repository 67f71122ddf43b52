#include "datasets_synthetic/degrade.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "datasets_synthetic/random.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr int kTileRows = 16;

// A direction evenly from the sphere.
Vector3d Direction(NormalSequence& normal) {
  Vector3d direction;
  do {
    for (int axis = 0; axis < 3; ++axis) direction[axis] = 2 * normal.Uniform() - 1;
  } while (direction.norm() > 1 || direction.norm() < 1e-3);
  return direction.normalized();
}

Exposure Draw(const Degradation& d, int view, bool again, std::uint32_t seed,
              double focus_distance) {
  Exposure exposure;
  exposure.view = view;
  exposure.again = again;
  exposure.seed =
      MixSeeds(MixSeeds(seed, 2 * static_cast<std::uint32_t>(view) + (again ? 1 : 0)), 0x5eed);
  NormalSequence normal(exposure.seed);
  exposure.exposure = static_cast<float>(std::exp2(d.exposure_ev * normal()));
  exposure.red = static_cast<float>(std::exp2(d.white_balance_ev * normal()));
  exposure.blue = static_cast<float>(std::exp2(d.white_balance_ev * normal()));
  exposure.shutter.motion = d.shake * Direction(normal);
  exposure.shutter.turn = d.shake_deg * std::numbers::pi / 180 * Direction(normal);
  exposure.shutter.aperture = d.aperture;
  exposure.shutter.focus_distance = d.focus_distance > 0 ? d.focus_distance : focus_distance;
  exposure.shutter.samples = d.samples;
  return exposure;
}

// `count` of the numbers 0 .. n-1, evenly at random.
std::vector<bool> Choose(int count, int n, NormalSequence& random) {
  std::vector<bool> chosen(static_cast<std::size_t>(n), false);
  for (int left = n; left > 0; --left) {
    if (random.Uniform() * left >= count) continue;
    chosen[static_cast<std::size_t>(n - left)] = true;
    --count;
  }
  return chosen;
}

// Electrons that arrive where `mean` are expected. Few: by inversion; many: a normal number with
// the skewness of Poisson's law (the first terms of its Cornish-Fisher expansion), rounded; 5/36 is
// the variance that the two corrections add.
double Poisson(double mean, PixelRandom& random) {
  if (!(mean > 0)) return 0;
  if (mean < 50) {
    const double u = random.Uniform();
    double probability = std::exp(-mean), sum = probability;
    int k = 0;
    for (; u >= sum && k < 400; ++k) sum += probability *= mean / (k + 1);
    return k;
  }
  const double z = random.Normal();
  return std::max(0.0, std::floor(mean + std::sqrt(mean - 5.0 / 36) * z + (z * z - 1) / 6 + 0.5));
}

// What the sensor reports of light of `value`; it holds no more than its full well.
float Counted(const Degradation& d, float value, PixelRandom& random) {
  const double electrons = Poisson(static_cast<double>(value) * d.full_well_e, random) +
                           d.read_noise_e * random.Normal();
  return static_cast<float>(std::min(electrons / d.full_well_e, 1.0));
}

// cos^4 of the angle at which a pixel sees.
double NaturalFallOff(const Camera& camera, int x, int y) {
  const auto direction = Unproject(camera, {x + 0.5, y + 0.5});
  if (!direction) return 0;
  const double cosine = direction->z() / direction->norm();
  return cosine * cosine * cosine * cosine;
}

}  // namespace

OptionTable Describe(Degradation& d) {
  return {
      "degradation",
      {{"full_well_e", "electrons of a white pixel, for shot noise; 0: none", &d.full_well_e, 0,
        1e9},
       {"read_noise_e", "standard deviation, electrons; needs full_well_e", &d.read_noise_e, 0,
        1e6},
       {"aperture", "diameter of the lens, world units, for defocus; 0: all is in focus",
        &d.aperture, 0},
       {"focus_distance", "world units; 0: the target's", &d.focus_distance, 0},
       {"shake", "the camera's way during the exposure, world units", &d.shake, 0},
       {"shake_deg", "the camera's turn during the exposure", &d.shake_deg, 0, 360},
       {"samples", "rays per pixel for defocus and shake; blur of N px needs about N^2", &d.samples,
        1, 65536},
       {"vignetting", "1: natural (cos^4)", &d.vignetting, 0, 1},
       {"exposure_ev", "drift from view to view, standard deviation, stops", &d.exposure_ev, 0, 10},
       {"white_balance_ev", "drift of red and blue, standard deviation, stops", &d.white_balance_ev,
        0, 10},
       {"k1", "lens distortion, radial (Brown, OpenCV)", &d.k1, -10, 10},
       {"k2", "likewise, of the fourth power", &d.k2, -10, 10},
       {"p1", "lens distortion, tangential", &d.p1, -1, 1},
       {"p2", "likewise, across", &d.p2, -1, 1},
       {"jpeg_quality", "of the photographs", &d.jpeg_quality, 1, 100, {}, "--jpeg-quality"},
       {"dropped_views", "photographs that are missing", &d.dropped_views, 0, 10000},
       {"duplicated_views", "photographs taken twice", &d.duplicated_views, 0, 10000}}};
}

std::vector<Exposure> ExposuresOf(const Degradation& d, int num_views, std::uint32_t seed,
                                  double focus_distance, const std::string& where) {
  if (d.dropped_views >= num_views) {
    throw UsageError(where, fmt::format("all of the {} views are dropped", num_views),
                     fmt::format("give dropped_views = {} at most", num_views - 1));
  }
  const int kept = num_views - d.dropped_views;
  if (d.duplicated_views > kept) {
    throw UsageError(where,
                     fmt::format("{} of {} views are to be duplicated", d.duplicated_views, kept),
                     fmt::format("give duplicated_views = {} at most", kept));
  }
  NormalSequence random(MixSeeds(seed, 0xd20b));
  const std::vector<bool> dropped = Choose(d.dropped_views, num_views, random);
  const std::vector<bool> again = Choose(d.duplicated_views, kept, random);
  std::vector<Exposure> exposures;
  std::size_t number = 0;
  for (int view = 0; view < num_views; ++view) {
    if (dropped[static_cast<std::size_t>(view)]) continue;
    exposures.push_back(Draw(d, view, false, seed, focus_distance));
    if (again[number++]) exposures.push_back(Draw(d, view, true, seed, focus_distance));
  }
  return exposures;
}

Camera Distorted(const Camera& camera, const Degradation& d, const std::string& where) {
  if (d.k1 == 0 && d.k2 == 0 && d.p1 == 0 && d.p2 == 0) return camera;
  Camera distorted = camera;
  distorted.model = CameraModel::kBrown;
  distorted.distortion = {d.k1, d.k2, d.p1, d.p2};
  // Rays are bent most along the border.
  constexpr int kSteps = 64;
  for (int i = 0; i <= 4 * kSteps; ++i) {
    const double t = static_cast<double>(i % kSteps) / kSteps;
    const double w = camera.width, h = camera.height;
    const Eigen::Vector2d pixel = i < kSteps       ? Eigen::Vector2d(t * w, 0)
                                  : i < 2 * kSteps ? Eigen::Vector2d(w, t * h)
                                  : i < 3 * kSteps ? Eigen::Vector2d(w - t * w, h)
                                                   : Eigen::Vector2d(0, h - t * h);
    if (Unproject(distorted, pixel)) continue;
    throw UsageError(where, "with this distortion the picture folds over before its border",
                     "give k1, k2, p1, p2 nearer to 0 or a larger focal_per_width");
  }
  return distorted;
}

void Degrade(const Degradation& d, const Exposure& exposure, const Camera& camera,
             Image<Rgb>& linear) {
  const bool counts = d.full_well_e > 0;
  if (!counts && d.vignetting == 0 && exposure.exposure == 1 && exposure.red == 1 &&
      exposure.blue == 1) {
    return;
  }
  ParallelFor(0, linear.height(), kTileRows, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < linear.width(); ++x) {
        Rgb& color = linear(x, y);
        const double falls =
            d.vignetting == 0 ? 1 : 1 + d.vignetting * (NaturalFallOff(camera, x, y) - 1);
        color = exposure.exposure * static_cast<float>(falls) * color;
        if (counts) {
          // Numbers of its own for each pixel: no order of work can change them.
          PixelRandom random(exposure.seed, x, y);
          color = {Counted(d, color.r, random), Counted(d, color.g, random),
                   Counted(d, color.b, random)};
        }
        color.r *= exposure.red;
        color.b *= exposure.blue;
      }
    }
  });
}

}  // namespace lamella
