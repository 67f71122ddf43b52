#include "datasets_synthetic/prototype.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

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

  void AddLight(const Vector3d& origin, const Vector3d& direction, Sum& sum) const {
    if (const std::optional<SightHit> hit = sights.Seen(origin, direction)) AddLight(*hit, sum);
  }

  void AddLight(const SightHit& hit, Sum& sum) const {
    const PanelCalibration& emitter = calibration->emitter;
    const std::optional<int> x = PixelOf(hit.emitter.x(), emitter.width_px),
                             y = PixelOf(hit.emitter.y(), emitter.height_px);
    if (!x || !y) return;
    const std::size_t slots = shown->emitter.size();
    double scale = calibration->gain / static_cast<double>(slots);
    if (falloff > 0) scale *= std::pow(hit.cosine, falloff);
    if (!calibration->modulator) {
      for (const auto& image : shown->emitter) {
        sum.Add(scale, Emitted(*image, *x, *y, hit.emitter.x()));
      }
      return;
    }
    const std::optional<int> u = PixelOf(hit.modulator.x(), calibration->modulator->width_px),
                             v = PixelOf(hit.modulator.y(), calibration->modulator->height_px);
    if (!u || !v) return;
    for (std::size_t slot = 0; slot < slots; ++slot) {
      const float transmittance = (*shown->modulator[slot])(*u, *v);
      if (transmittance == 0) continue;
      sum.Add(scale * static_cast<double>(transmittance),
              Emitted(*shown->emitter[slot], *x, *y, hit.emitter.x()));
    }
  }
};

// The hits of a pixel's corners: left and right above, left and right below.
using CornerHits = std::array<const SightHit*, 4>;

SightHit Between(const CornerHits& corners, double x, double y) {
  const double weights[] = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
  SightHit hit;
  hit.cosine = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    hit.modulator += weights[c] * corners[c]->modulator;
    hit.emitter += weights[c] * corners[c]->emitter;
    hit.cosine += weights[c] * corners[c]->cosine;
  }
  return hit;
}

// The panel's pixels that corners enclose, with some room for lines that bend; none beside the
// panel.
std::optional<Rect> Enclosed(const CornerHits& corners, Vector2d SightHit::*on,
                             const PanelCalibration& panel) {
  constexpr double kRoomPx = 0.05;
  constexpr int kMost = 8;  // in a row: beyond it samples cost less
  Vector2d low = corners[0]->*on, high = low;
  for (const SightHit* corner : corners) {
    low = low.cwiseMin(corner->*on);
    high = high.cwiseMax(corner->*on);
  }
  low.array() -= kRoomPx;
  high.array() += kRoomPx;
  const Vector2d size(panel.width_px, panel.height_px);
  if (high.minCoeff() < 0 || (low - size).maxCoeff() >= 0) return Rect{0, 0, 0, 0};
  const bool inside = low.minCoeff() >= 0 && (high - size).maxCoeff() < 0;
  if (!inside || !((high - low).maxCoeff() < kMost)) return std::nullopt;
  const int x = static_cast<int>(low.x()), y = static_cast<int>(low.y());
  return Rect{x, y, static_cast<int>(high.x()) - x + 1, static_cast<int>(high.y()) - y + 1};
}

template <class T>
bool IsOneColour(const Image<T>& image, const Rect& rect) {
  if (rect.width == 0) return true;
  const T& first = image(rect.x, rect.y);
  for (int y = rect.y; y < rect.y + rect.height; ++y) {
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      if (!(image(x, y) == first)) return false;
    }
  }
  return true;
}

bool SeeOneColour(const TracedLayer& layer, const CornerHits& corners) {
  const LayerCalibration& calibration = *layer.calibration;
  if (calibration.emitter.rgb_stripes || layer.falloff > 0) return false;
  const auto emitters = Enclosed(corners, &SightHit::emitter, calibration.emitter);
  if (!emitters) return false;
  const bool emitted =
      std::all_of(layer.shown->emitter.begin(), layer.shown->emitter.end(),
                  [&](const auto& image) { return IsOneColour(*image, *emitters); });
  if (!emitted || !calibration.modulator) return emitted;
  const auto openings = Enclosed(corners, &SightHit::modulator, *calibration.modulator);
  return openings && std::all_of(layer.shown->modulator.begin(), layer.shown->modulator.end(),
                                 [&](const auto& image) { return IsOneColour(*image, *openings); });
}

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

// The photograph, rows of it at a time.
class Exposing {
 public:
  Exposing(const Prototype& prototype, const PrototypeCamera& camera, int samples)
      : camera_(camera),
        layers_(Traced(prototype)),
        display_from_camera_(Inverse(camera.camera_from_display)),
        points_(samples),
        width_(camera.camera.width) {
    smooth_ = camera.aperture_mm == 0;
    for (const TracedLayer& layer : layers_) smooth_ = smooth_ && !layer.calibration->lattice;
  }

  void Expose(int first_row, int last_row, Image<Rgb>& photograph) const {
    std::vector<Hits> above(layers_.size()), below(layers_.size());
    if (smooth_) TraceCorners(first_row, below);
    for (int y = first_row; y < last_row; ++y) {
      if (smooth_) {
        std::swap(above, below);
        TraceCorners(y + 1, below);
      }
      for (int x = 0; x < width_; ++x) {
        Sum sum;
        for (std::size_t l = 0; smooth_ && l < layers_.size(); ++l) {
          if (!AddBetween(above[l], below[l], x, y, layers_[l], sum))
            AddSamples(x, y, l, l + 1, sum);
        }
        if (!smooth_) AddSamples(x, y, 0, layers_.size(), sum);
        const double scale = Illumination(camera_, x + 0.5, y + 0.5) / points_.count();
        photograph(x, y) = {ToFloat(scale * sum.r), ToFloat(scale * sum.g), ToFloat(scale * sum.b)};
      }
    }
  }

 private:
  using Hits = std::vector<std::optional<SightHit>>;

  std::optional<Line> Sight(double x, double y, double u, double v) const {
    return LineOfSight(camera_, display_from_camera_, {x, y}, u, v);
  }

  // Of the pixels' corners in a line between two rows.
  void TraceCorners(int y, std::vector<Hits>& hits) const {
    for (Hits& of_layer : hits) of_layer.assign(static_cast<std::size_t>(width_) + 1, std::nullopt);
    for (int x = 0; x <= width_; ++x) {
      const std::optional<Line> line = Sight(x, y, 0.5, 0.5);
      for (std::size_t l = 0; line && l < layers_.size(); ++l) {
        hits[l][static_cast<std::size_t>(x)] =
            layers_[l].sights.Seen(line->origin, line->direction);
      }
    }
  }

  // The light of some layers in all samples of a pixel, each traced.
  void AddSamples(int x, int y, std::size_t first, std::size_t last, Sum& sum) const {
    const std::uint64_t hash = HashOf(x, y);
    for (int i = 0; i < points_.count(); ++i) {
      const std::array<double, 4> p = points_.Point(i, hash);
      const std::optional<Line> line = Sight(x + p[0], y + p[1], p[2], p[3]);
      if (!line) continue;
      for (std::size_t l = first; l < last; ++l) {
        layers_[l].AddLight(line->origin, line->direction, sum);
      }
    }
  }

  // The same from the pixel's corners, where that is the same.
  bool AddBetween(const Hits& above, const Hits& below, int x, int y, const TracedLayer& layer,
                  Sum& sum) const {
    const auto left = static_cast<std::size_t>(x);
    if (!(above[left] && above[left + 1] && below[left] && below[left + 1])) return false;
    const CornerHits corners = {&*above[left], &*above[left + 1], &*below[left], &*below[left + 1]};
    const SightHit middle = Between(corners, 0.5, 0.5);
    if (SeeOneColour(layer, corners)) {
      Sum light;
      layer.AddLight(middle, light);
      const double count = points_.count();
      sum = {sum.r + count * light.r, sum.g + count * light.g, sum.b + count * light.b};
      return true;
    }
    constexpr double kClosePx = 1e-3;
    const std::optional<Line> line = Sight(x + 0.5, y + 0.5, 0.5, 0.5);
    const auto hit = line ? layer.sights.Seen(line->origin, line->direction) : std::nullopt;
    const bool even = hit && (hit->emitter - middle.emitter).norm() < kClosePx &&
                      (hit->modulator - middle.modulator).norm() < kClosePx;
    if (!even) return false;
    const std::uint64_t hash = HashOf(x, y);
    for (int i = 0; i < points_.count(); ++i) {
      const std::array<double, 4> p = points_.Point(i, hash);
      layer.AddLight(Between(corners, p[0], p[1]), sum);
    }
    return true;
  }

  std::uint64_t HashOf(int x, int y) const {
    return MixedHash(static_cast<std::uint64_t>(std::int64_t{y} * width_ + x));
  }

  const PrototypeCamera& camera_;
  std::vector<TracedLayer> layers_;
  Rigid display_from_camera_;
  PixelPoints points_;
  int width_;
  bool smooth_ = false;
};

// One direction of a Gaussian; at the borders the picture goes on as it ends.
Image<Rgb> Spread(const Image<Rgb>& image, const std::vector<float>& half_kernel, int dx, int dy) {
  Image<Rgb> spread(image.width(), image.height());
  ParallelForEach(0, image.height(), [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width(); ++x) {
      Rgb sum = half_kernel[0] * image(x, y);
      for (int k = 1; k < static_cast<int>(half_kernel.size()); ++k) {
        const auto at = [&](int step) -> const Rgb& {
          return image(std::clamp(x + step * dx, 0, image.width() - 1),
                       std::clamp(y + step * dy, 0, image.height() - 1));
        };
        sum += half_kernel[static_cast<std::size_t>(k)] * (at(k) + at(-k));
      }
      spread(x, y) = sum;
    }
  });
  return spread;
}

Image<Rgb> Blurred(const Image<Rgb>& image, double sigma_px) {
  std::vector<double> half = {1};
  double total = 1;
  for (int k = 1; k <= static_cast<int>(std::ceil(4 * sigma_px)); ++k) {
    half.push_back(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
    total += 2 * half.back();
  }
  std::vector<float> kernel;
  for (const double weight : half) kernel.push_back(ToFloat(weight / total));
  return Spread(Spread(image, kernel, 1, 0), kernel, 0, 1);
}

}  // namespace

Image<Rgb> PhotographPrototype(const Prototype& prototype, const PrototypeCamera& camera,
                               int samples, Progress& progress) {
  Check(prototype.calibration, prototype.calibration.display);
  CheckShown(prototype);
  CheckCamera(prototype, camera);
  const Exposing exposing(prototype, camera, samples);
  Image<Rgb> photograph(camera.camera.width, camera.camera.height);
  constexpr int kRows = 16;
  ParallelFor(0, photograph.height(), kRows, [&](std::int64_t first, std::int64_t last) {
    exposing.Expose(static_cast<int>(first), static_cast<int>(last), photograph);
    for (std::int64_t row = first; row < last; ++row) progress.Advance();
  });
  return camera.blur_px > 0 ? Blurred(photograph, camera.blur_px) : std::move(photograph);
}

Rgb LightAlong(const Prototype& prototype, const Vector3d& origin, const Vector3d& direction) {
  Sum sum;
  for (const TracedLayer& layer : Traced(prototype)) layer.AddLight(origin, direction, sum);
  return {ToFloat(sum.r), ToFloat(sum.g), ToFloat(sum.b)};
}

}  // namespace lamella
