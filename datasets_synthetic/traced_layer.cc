#include "datasets_synthetic/traced_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "datasets_synthetic/cut_pixel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

// Lines of sight turn so smoothly that those within a rectangle stay within the border's, but for
// what bends between two corners of pixels.
std::optional<Rect> PixelsUnder(const CornerHits& hits, const Rect& rectangle,
                                Vector2d SightHit::*on, const PanelCalibration& panel) {
  constexpr double kRoomPx = 0.01;
  constexpr int kMost = 32;  // in a row
  const int right = rectangle.x + rectangle.width, bottom = rectangle.y + rectangle.height;
  Vector2d low = hits.At(rectangle.x, rectangle.y).*on, high = low;
  const auto hold = [&](const SightHit& hit) {
    low = low.cwiseMin(hit.*on);
    high = high.cwiseMax(hit.*on);
  };
  for (int x = rectangle.x; x <= right; ++x) {
    hold(hits.At(x, rectangle.y));
    hold(hits.At(x, bottom));
  }
  for (int y = rectangle.y; y <= bottom; ++y) {
    hold(hits.At(rectangle.x, y));
    hold(hits.At(right, y));
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
    const T* row = image.row(y) + rect.x;
    if (!std::all_of(row, row + rect.width, [&](const T& other) { return other == first; })) {
      return false;
    }
  }
  return true;
}

bool IsDark(const ShownLayer& shown) {
  return std::all_of(shown.emitter.begin(), shown.emitter.end(), [](const auto& image) {
    return std::all_of(image->data(), image->data() + image->size(),
                       [](const Rgb& light) { return light == Rgb(); });
  });
}

}  // namespace

TracedLayer::TracedLayer(const LayerCalibration& calibration, std::vector<const ShownLayer*> shown)
    : calibration_(&calibration),
      sights_(calibration),
      falloff_(calibration.emitter.photometry.falloff +
               (calibration.modulator ? calibration.modulator->photometry.falloff : 0)),
      shown_(std::move(shown)) {}

// What the emitter sends from a place within its pixel.
Rgb TracedLayer::Emitted(const Image<Rgb>& image, int x, int y, double u) const {
  const Rgb& light = image(x, y);
  if (!calibration_->emitter.rgb_stripes) return light;
  const int channel = std::clamp(static_cast<int>(3 * (u - x)), 0, 2);
  const float level = channel == 0 ? light.r : channel == 1 ? light.g : light.b;
  const Eigen::Vector3f stripe =
      3 * level * calibration_->emitter.photometry.primaries.col(channel).cast<float>();
  return {stripe.x(), stripe.y(), stripe.z()};
}

void TracedLayer::AddLight(const SightHit& hit, std::size_t show, double weight,
                           LightSum& sum) const {
  if (!IsLit(show)) return;
  const ShownLayer& images = *shown_[show];
  const PanelCalibration& emitter = calibration_->emitter;
  const std::optional<int> x = PixelOf(hit.emitter.x(), emitter.width_px),
                           y = PixelOf(hit.emitter.y(), emitter.height_px);
  if (!x || !y) return;
  const std::size_t slots = images.emitter.size();
  double scale = weight * calibration_->gain / static_cast<double>(slots);
  if (falloff_ > 0) scale *= std::pow(hit.cosine, falloff_);
  if (!calibration_->modulator) {
    for (const auto& image : images.emitter) {
      sum.Add(scale, Emitted(*image, *x, *y, hit.emitter.x()));
    }
    return;
  }
  const std::optional<int> u = PixelOf(hit.modulator.x(), calibration_->modulator->width_px),
                           v = PixelOf(hit.modulator.y(), calibration_->modulator->height_px);
  if (!u || !v) return;
  for (std::size_t slot = 0; slot < slots; ++slot) {
    const float transmittance = (*images.modulator[slot])(*u, *v);
    if (transmittance == 0) continue;
    sum.Add(scale * static_cast<double>(transmittance),
            Emitted(*images.emitter[slot], *x, *y, hit.emitter.x()));
  }
}

PanelsUnder TracedLayer::Under(const CornerHits& hits, const Rect& rectangle) const {
  PanelsUnder under;
  under.emitter = PixelsUnder(hits, rectangle, &SightHit::emitter, calibration_->emitter);
  if (calibration_->modulator) {
    under.modulator = PixelsUnder(hits, rectangle, &SightHit::modulator, *calibration_->modulator);
  }
  return under;
}

bool TracedLayer::IsEmitterEven(const ShownLayer& shown, const std::optional<Rect>& pixels) const {
  if (!pixels || (calibration_->emitter.rgb_stripes && pixels->width > 0)) return false;
  return std::all_of(shown.emitter.begin(), shown.emitter.end(),
                     [&](const auto& image) { return IsOneColour(*image, *pixels); });
}

bool TracedLayer::IsModulatorEven(const ShownLayer& shown,
                                  const std::optional<Rect>& pixels) const {
  if (!calibration_->modulator) return true;
  return pixels && std::all_of(shown.modulator.begin(), shown.modulator.end(),
                               [&](const auto& image) { return IsOneColour(*image, *pixels); });
}

bool TracedLayer::IsOneLight(std::size_t show, const PanelsUnder& under) const {
  const ShownLayer& shown = *shown_[show];
  return IsEmitterEven(shown, under.emitter) && IsModulatorEven(shown, under.modulator);
}

bool TracedLayer::AddMean(std::size_t show, const PanelsUnder& under, const CornerHits& hits, int x,
                          int y, LightSum& sum) const {
  const ShownLayer& shown = *shown_[show];
  std::vector<int> axes;
  if (!IsModulatorEven(shown, under.modulator)) axes.insert(axes.end(), {0, 1});
  if (!IsEmitterEven(shown, under.emitter)) axes.insert(axes.end(), {2, 3});
  const double stripes = calibration_->emitter.rgb_stripes ? 3 : 1;  // of a pixel
  std::array<OnPanels, 4> corners;
  const auto about = hits.About(x, y);
  std::transform(about.begin(), about.end(), corners.begin(), [&](const SightHit* hit) {
    return OnPanels(hit->modulator.x(), hit->modulator.y(), stripes * hit->emitter.x(),
                    hit->emitter.y());
  });
  const double cosine = hits.Within(x, y, 0.5, 0.5).cosine;
  return CutPixel(corners, axes, [&](const OnPanels& within, double share) {
    const Vector2d emitter(within[2] / stripes, within[3]);
    AddLight({within.head<2>(), emitter, cosine}, show, share, sum);
  });
}

std::vector<TracedLayer> LitLayers(const Calibration& calibration, std::span<const Show> shows) {
  std::vector<TracedLayer> layers;
  for (std::size_t l = 0; l < calibration.layers.size(); ++l) {
    std::vector<const ShownLayer*> shown;
    for (const Show& show : shows) {
      shown.push_back(IsDark(show.layers[l]) ? nullptr : &show.layers[l]);
    }
    if (std::all_of(shown.begin(), shown.end(), [](const auto* lit) { return !lit; })) continue;
    layers.emplace_back(calibration.layers[l], std::move(shown));
  }
  return layers;
}

}  // namespace lamella
