#include "datasets_synthetic/prototype.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "datasets_synthetic/pixel_points.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Sum {
  double r = 0, g = 0, b = 0;
  void Add(double weight, const Rgb& light) {
    r += weight * static_cast<double>(light.r);
    g += weight * static_cast<double>(light.g);
    b += weight * static_cast<double>(light.b);
  }
};

// The index of the pixel that holds a coordinate; nothing beside the panel (and for NaN).
std::optional<int> PixelOf(double coordinate, int size) {
  if (!(coordinate >= 0 && coordinate < size)) return std::nullopt;
  return static_cast<int>(coordinate);
}

// A layer ready to be traced.
struct TracedLayer {
  LayerSights sights;
  const LayerCalibration* calibration;
  const ShownLayer* shown;
  double falloff;  // exponent of both panels

  // What the emitter sends from a place within its pixel.
  Rgb Emitted(const Image<Rgb>& image, int x, int y, double u) const {
    const Rgb& light = image(x, y);
    if (!calibration->emitter.rgb_stripes) return light;
    const int channel = std::clamp(static_cast<int>(3 * (u - x)), 0, 2);
    const float level = channel == 0 ? light.r : channel == 1 ? light.g : light.b;
    const Eigen::Vector3f stripe =
        3 * level * calibration->emitter.photometry.primaries.col(channel).cast<float>();
    return {stripe.x(), stripe.y(), stripe.z()};
  }

  void AddLight(const Vector3d& origin, const Vector3d& direction, double weight, Sum& sum) const {
    const std::optional<SightHit> hit = sights.Seen(origin, direction);
    if (!hit) return;
    const PanelCalibration& emitter = calibration->emitter;
    const std::optional<int> x = PixelOf(hit->emitter.x(), emitter.width_px),
                             y = PixelOf(hit->emitter.y(), emitter.height_px);
    if (!x || !y) return;
    const std::size_t slots = shown->emitter.size();
    double scale = weight * calibration->gain / static_cast<double>(slots);
    if (falloff > 0) scale *= std::pow(hit->cosine, falloff);
    if (!calibration->modulator) {
      for (const auto& image : shown->emitter) {
        sum.Add(scale, Emitted(*image, *x, *y, hit->emitter.x()));
      }
      return;
    }
    const std::optional<int> u = PixelOf(hit->modulator.x(), calibration->modulator->width_px),
                             v = PixelOf(hit->modulator.y(), calibration->modulator->height_px);
    if (!u || !v) return;
    for (std::size_t slot = 0; slot < slots; ++slot) {
      const float transmittance = (*shown->modulator[slot])(*u, *v);
      if (transmittance == 0) continue;
      sum.Add(scale * static_cast<double>(transmittance),
              Emitted(*shown->emitter[slot], *x, *y, hit->emitter.x()));
    }
  }
};

bool IsDark(const ShownLayer& shown) {
  return std::all_of(shown.emitter.begin(), shown.emitter.end(), [](const auto& image) {
    return std::all_of(image->data(), image->data() + image->size(),
                       [](const Rgb& light) { return light == Rgb(); });
  });
}

// The layers that show anything: patterns are shown on one at a time.
std::vector<TracedLayer> Traced(const Prototype& prototype) {
  std::vector<TracedLayer> layers;
  for (std::size_t l = 0; l < prototype.shown.size(); ++l) {
    if (IsDark(prototype.shown[l])) continue;
    const LayerCalibration& layer = prototype.calibration.layers[l];
    const double falloff = layer.emitter.photometry.falloff +
                           (layer.modulator ? layer.modulator->photometry.falloff : 0);
    layers.push_back({LayerSights(layer), &layer, &prototype.shown[l], falloff});
  }
  return layers;
}

template <class T>
bool Fits(const std::shared_ptr<const Image<T>>& image, const PanelCalibration& panel) {
  return image && image->width() == panel.width_px && image->height() == panel.height_px;
}

void CheckShown(const Prototype& prototype) {
  const std::vector<LayerCalibration>& layers = prototype.calibration.layers;
  if (layers.size() != prototype.shown.size()) {
    throw InputError("",
                     fmt::format("{} layers are shown of a display of {}", prototype.shown.size(),
                                 layers.size()),
                     "show every layer");
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const ShownLayer& shown = prototype.shown[l];
    const std::size_t modulators = layers[l].modulator ? shown.emitter.size() : 0;
    if (shown.emitter.empty() || shown.modulator.size() != modulators) {
      throw InputError(
          fmt::format("layer {}", l),
          fmt::format("shows {} emitter and {} modulator images", shown.emitter.size(),
                      shown.modulator.size()),
          layers[l].modulator ? "give one of each per time slot" : "give emitter images only");
    }
    for (std::size_t slot = 0; slot < shown.emitter.size(); ++slot) {
      const bool fits = Fits(shown.emitter[slot], layers[l].emitter) &&
                        (modulators == 0 || Fits(shown.modulator[slot], *layers[l].modulator));
      if (!fits) {
        throw InputError(fmt::format("layer {}, slot {}", l, slot),
                         "shows an image that has not its panel's size",
                         "give images of the panel's pixels");
      }
    }
  }
}

void CheckCamera(const Prototype& prototype, const PrototypeCamera& camera) {
  const Vector3d centre = Centre(camera.camera_from_display);
  for (std::size_t l = 0; l < prototype.calibration.layers.size(); ++l) {
    const Rigid& pose = prototype.calibration.layers[l].display_from_stack;
    if ((Inverse(pose) * centre).z() > 0) continue;
    throw UsageError("camera",
                     fmt::format("at ({:.6g}, {:.6g}, {:.6g}) mm is not in front of layer {}",
                                 centre.x(), centre.y(), centre.z(), l),
                     "move it towards the viewer (+z)");
  }
  if (camera.aperture_mm > 0 && !(camera.focus_mm > 0)) {
    throw UsageError("camera", "has an aperture but no focus distance", "give focus_mm above 0");
  }
}

// The unit disc from the unit square, area kept (Shirley and Chiu 1997).
Vector2d OnDisc(double u, double v) {
  const double a = 2 * u - 1, b = 2 * v - 1;
  if (a == 0 && b == 0) return {0, 0};
  constexpr double kQuarter = std::numbers::pi / 4;
  if (std::abs(a) > std::abs(b)) {
    return a * Vector2d(std::cos(kQuarter * b / a), std::sin(kQuarter * b / a));
  }
  return b * Vector2d(std::sin(kQuarter * a / b), std::cos(kQuarter * a / b));
}

struct Line {
  Vector3d origin, direction;
};

// The line of sight of a point of the sensor and of the pupil; nothing where the lens sees nothing.
std::optional<Line> LineOfSight(const PrototypeCamera& camera, const Rigid& display_from_camera,
                                const Vector2d& pixel, double u, double v) {
  const std::optional<Vector3d> direction = Unproject(camera.camera, pixel);
  if (!direction) return std::nullopt;
  Line line{Vector3d::Zero(), *direction};
  if (camera.aperture_mm > 0 && direction->z() > 0) {
    const Vector2d pupil = camera.aperture_mm / 2 * OnDisc(u, v);
    line.origin = {pupil.x(), pupil.y(), 0};
    line.direction = camera.focus_mm / direction->z() * *direction - line.origin;
  }
  return Line{display_from_camera * line.origin, display_from_camera.rotation * line.direction};
}

double Illumination(const PrototypeCamera& camera, double x, double y) {
  if (camera.vignetting == 0) return 1;
  const Camera& c = camera.camera;
  const double half = std::hypot(c.width, c.height) / 2;
  const double r = std::hypot(x - c.cx, y - c.cy) / half;
  return std::max(0.0, 1 - camera.vignetting * r * r);
}

float ToFloat(double value) { return static_cast<float>(value); }

}  // namespace

Image<Rgb> PhotographPrototype(const Prototype& prototype, const PrototypeCamera& camera,
                               int samples, Progress& progress) {
  Check(prototype.calibration, prototype.calibration.display);
  CheckShown(prototype);
  CheckCamera(prototype, camera);
  const std::vector<TracedLayer> layers = Traced(prototype);
  const Rigid display_from_camera = Inverse(camera.camera_from_display);
  const PixelPoints points(samples);
  const int width = camera.camera.width, height = camera.camera.height;
  Image<Rgb> photograph(width, height);
  ParallelForEach(0, height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const std::uint64_t hash = MixedHash(static_cast<std::uint64_t>(row * width + x));
      Sum sum;
      for (int i = 0; i < points.count(); ++i) {
        const std::array<double, 4> p = points.Point(i, hash);
        const std::optional<Line> line =
            LineOfSight(camera, display_from_camera, {x + p[0], y + p[1]}, p[2], p[3]);
        if (!line) continue;
        for (const TracedLayer& layer : layers)
          layer.AddLight(line->origin, line->direction, 1, sum);
      }
      const double scale = Illumination(camera, x + 0.5, y + 0.5) / points.count();
      photograph(x, y) = {ToFloat(scale * sum.r), ToFloat(scale * sum.g), ToFloat(scale * sum.b)};
    }
    progress.Advance();
  });
  return photograph;
}

Rgb LightAlong(const Prototype& prototype, const Vector3d& origin, const Vector3d& direction) {
  Sum sum;
  for (const TracedLayer& layer : Traced(prototype)) layer.AddLight(origin, direction, 1, sum);
  return {ToFloat(sum.r), ToFloat(sum.g), ToFloat(sum.b)};
}

}  // namespace lamella
