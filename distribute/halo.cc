#include "distribute/halo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "distribute/analyze.h"
#include "lightfield/color.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr double kNoParallax = std::numeric_limits<double>::infinity();
constexpr int kLinesAtOnce = 16;

// Rows of a picture, or its columns.
struct Axis {
  bool along_y = false;
  int num_lines = 0, length = 0;
  template <class T>
  auto& At(T& image, int line, int i) const {
    return along_y ? image(line, i) : image(i, line);
  }
};

class RimMarker {
 public:
  RimMarker(const SeenScene& scene, const ShadowBlur& blur, const Eye& eye)
      : scene_(scene), blur_(blur), eye_(eye) {}

  // Says whether there is an edge.
  bool MarkLine(const Axis& axis, int line, Image<Rim>& rims) const {
    bool found = false;
    for (int i = 0; i + 1 < axis.length; ++i) {
      if (!(axis.At(scene_.coverage, line, i) > 0 && axis.At(scene_.coverage, line, i + 1) > 0)) {
        continue;
      }
      const float z = axis.At(scene_.z, line, i), next = axis.At(scene_.z, line, i + 1);
      const float near = std::max(z, next), far = std::min(z, next);
      if (!Occludes(near, far, axis)) continue;
      found = true;
      const int reach = Reach(near, far, axis);
      const int first = std::max(0, i + 1 - reach), end = std::min(axis.length, i + 1 + reach);
      for (int at = first; at < end; ++at) {
        Rim& rim = axis.At(rims, line, at);
        rim = std::max(rim, (at <= i) == (z > next) ? Rim::kBefore : Rim::kBehind);
      }
    }
    return found;
  }

 private:
  bool Occludes(float near, float far, const Axis& axis) const {
    const double steepest = axis.along_y ? blur_.steepest_y : blur_.steepest_x;
    const double change = static_cast<double>(near) - static_cast<double>(far);
    return change > steepest * PixelMm(near) && blur_.LayerOf(near) != blur_.LayerOf(far);
  }
  // On a plane, as the picture's pixels are seen there.
  double PixelMm(float z) const {
    const double distance = eye_.position.z() - static_cast<double>(z);
    return eye_.pixel_mm * distance / (eye_.position.z() - eye_.plane_mm);
  }
  // Of the shadow's blur, to either side; whole pixels.
  int Reach(float near, float far, const Axis& axis) const {
    const auto layer = static_cast<std::size_t>(blur_.LayerOf(far));
    const AxisBeam& beam = axis.along_y ? blur_.beams[layer].y : blur_.beams[layer].x;
    const double offset = static_cast<double>(near) - blur_.layers_mm[layer];
    const double reach = beam.OpeningBlurMm(offset) + beam.EmitterBlurMm(offset);
    return static_cast<int>(std::min(std::ceil(reach / PixelMm(near)), 1.0 * axis.length));
  }

  const SeenScene& scene_;
  const ShadowBlur& blur_;
  const Eye& eye_;
};

}  // namespace

int ShadowBlur::LayerOf(float z) const {
  int most = 0;
  for (int layer = 1; layer < weights.num_layers(); ++layer) {
    if (weights.Weight(layer, z) > weights.Weight(most, z)) most = layer;
  }
  return most;
}

std::optional<ShadowBlur> ShadowBlurOf(const Display& display) {
  if (display.layers.size() < 2) return std::nullopt;
  ShadowBlur blur{WeightsOf(display), {}, {}, kNoParallax, kNoParallax};
  for (const Layer& layer : display.layers) {
    blur.layers_mm.push_back(layer.position_mm);
    blur.beams.push_back(MiddleBeams(display, layer));
    const double steepest = 1 / std::tan(FieldOfViewDeg(display, layer) * M_PI / 360);
    blur.steepest_x = std::min(blur.steepest_x, steepest);
    if (std::holds_alternative<Lenticular>(layer.optics)) continue;
    blur.steepest_y = std::min(blur.steepest_y, steepest);
  }
  return blur;
}

Image<Rim> RimsOf(const SeenScene& scene, const ShadowBlur& blur, const Eye& eye) {
  const int width = scene.z.width(), height = scene.z.height();
  Image<Rim> rims(width, height);
  const RimMarker marker(scene, blur, eye);
  bool occluded = false;
  for (const Axis& axis : {Axis{false, height, width}, Axis{true, width, height}}) {
    std::vector<std::uint8_t> found(static_cast<std::size_t>(axis.num_lines));
    ParallelFor(0, axis.num_lines, kLinesAtOnce, [&](std::int64_t first, std::int64_t end) {
      for (int line = static_cast<int>(first); line < end; ++line) {
        found[static_cast<std::size_t>(line)] = marker.MarkLine(axis, line, rims) ? 1 : 0;
      }
    });
    occluded = occluded || std::find(found.begin(), found.end(), 1) != found.end();
  }
  return occluded ? std::move(rims) : Image<Rim>();
}

std::optional<double> LuminanceErrors::Relative() const {
  return target > 0 ? std::optional(error / target) : std::nullopt;
}

LuminanceErrors& LuminanceErrors::operator+=(const LuminanceErrors& other) {
  pixels += other.pixels;
  target += other.target;
  error += other.error;
  squared_error += other.squared_error;
  return *this;
}

HaloErrors& HaloErrors::operator+=(const HaloErrors& other) {
  behind += other.behind;
  before += other.before;
  elsewhere += other.elsewhere;
  return *this;
}

HaloErrors SumHaloErrors(ImageSpan<const Rgb8> seen, ImageSpan<const Rgb8> target,
                         const Image<Rim>& rims, const MetricRegion& region) {
  const auto luminance = [](Rgb8 code) {
    return static_cast<double>(
        Luminance({Srgb8ToLinear(code.r), Srgb8ToLinear(code.g), Srgb8ToLinear(code.b)}));
  };
  const int border = region.border_px;
  HaloErrors errors;
  for (int y = border; y < seen.height - border; ++y) {
    for (int x = border; x < seen.width - border; ++x) {
      if (region.mask.data != nullptr && !(region.mask(x, y) >= 0.5F)) continue;
      const double aim = luminance(target(x, y)), error = luminance(seen(x, y)) - aim;
      const Rim rim = rims(x, y);
      LuminanceErrors& sums = rim == Rim::kNone     ? errors.elsewhere
                              : rim == Rim::kBehind ? errors.behind
                                                    : errors.before;
      sums += {1, aim, error, error * error};
    }
  }
  return errors;
}

std::optional<HaloFigures> FiguresOf(const HaloErrors& errors) {
  LuminanceErrors rims = errors.behind;
  rims += errors.before;
  if (rims.pixels == 0) return std::nullopt;
  LuminanceErrors all = errors.elsewhere;
  all += rims;
  HaloFigures figures{rims.Relative(), errors.behind.Relative(), errors.before.Relative(),
                      static_cast<double>(rims.pixels) / static_cast<double>(all.pixels), 0};
  if (all.squared_error > 0)
    figures.share_of_squared_error = rims.squared_error / all.squared_error;
  return figures;
}

}  // namespace lamella
