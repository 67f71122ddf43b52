// A layer of the virtual prototype as several shows light it, asked for the light along lines of
// sight and over a photograph's pixels.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "datasets_synthetic/corner_hits.h"
#include "datasets_synthetic/prototype.h"
#include "lightfield/calibration.h"
#include "lightfield/image.h"
#include "lightfield/panel_rays.h"

namespace lamella {

struct LightSum {
  double r = 0, g = 0, b = 0;
  friend bool operator==(const LightSum&, const LightSum&) = default;
  void Add(double weight, const LightSum& light) {
    r += weight * light.r;
    g += weight * light.g;
    b += weight * light.b;
  }
  void Add(double weight, const Rgb& light) {
    r += weight * static_cast<double>(light.r);
    g += weight * static_cast<double>(light.g);
    b += weight * static_cast<double>(light.b);
  }
};

// The index of the pixel that holds a coordinate; nothing beside the panel (and for NaN).
inline std::optional<int> PixelOf(double coordinate, int size) {
  if (!(coordinate >= 0 && coordinate < size)) return std::nullopt;
  return static_cast<int>(coordinate);
}

// The pixels of each panel that are seen through a rectangle of a photograph: none of them beside
// the panel; nothing where the panel's border is among them, or they are many.
struct PanelsUnder {
  std::optional<Rect> emitter, modulator;
};

class TracedLayer {
 public:
  // `shown` by each show; null where the layer is dark in it. Both outlive this.
  TracedLayer(const LayerCalibration& calibration, std::vector<const ShownLayer*> shown);

  const LayerSights& sights() const { return sights_; }
  bool IsLit(std::size_t show) const { return shown_[show] != nullptr; }
  bool HasLenses() const { return calibration_->lattice.has_value(); }
  bool FallsOff() const { return falloff_ > 0; }  // with the angle

  // Of the show along a line of sight, its weight times.
  void AddLight(const SightHit& hit, std::size_t show, double weight, LightSum& sum) const;

  PanelsUnder Under(const CornerHits& hits, const Rect& rectangle) const;
  // Whether a show in which the layer is lit has one light over all that is seen, but for its
  // falling off.
  bool IsOneLight(std::size_t show, const PanelsUnder& under) const;
  // The mean of a show over pixel (x, y) of a photograph, by the areas of the panels' pixels in it.
  // Not for one light. False, and nothing added, where the pixels are too many or seen folded over.
  bool AddMean(std::size_t show, const PanelsUnder& under, const CornerHits& hits, int x, int y,
               LightSum& sum) const;

 private:
  // In all time slots.
  bool IsEmitterEven(const ShownLayer& shown, const std::optional<Rect>& pixels) const;
  bool IsModulatorEven(const ShownLayer& shown, const std::optional<Rect>& pixels) const;
  Rgb Emitted(const Image<Rgb>& image, int x, int y, double u) const;

  const LayerCalibration* calibration_;
  LayerSights sights_;
  double falloff_;  // exponent of both panels
  std::vector<const ShownLayer*> shown_;
};

// The layers that show anything: patterns are shown on one at a time.
std::vector<TracedLayer> LitLayers(const Calibration& calibration, std::span<const Show> shows);

}  // namespace lamella
