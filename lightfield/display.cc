#include "lightfield/display.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

constexpr double kLongestMm = 1e6;
constexpr double kShortestMm = 1e-9;
constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;
constexpr int kMostSlotsPerAxis = 32;  // a bit each in RayMap
constexpr int kMostLayers = 1024;
constexpr double kWidestFanDeg = 178;
constexpr double kLargestRatio = 4096;  // of a lens to an emitter
constexpr double kLargestMagnification = 1000;
constexpr double kLargestSlant = 1000;
constexpr double kMostLenses = 1e9;  // they are numbered by an int
constexpr int kMostViews = 256;

struct Checker {
  const std::string& where;

  void Require(bool holds, const std::string& what, const std::string& fix) const {
    if (!holds) throw UsageError(where, what, fix);
  }
  // Written so that a NaN is outside.
  void Within(double value, double least, double most, const std::string& name) const {
    Require(value >= least && value <= most, fmt::format("{} = {}", name, value),
            fmt::format("give a number from {} to {}", least, most));
  }
  void Length(double value, const std::string& name) const {
    Require(std::isfinite(value) && value >= kShortestMm && value <= kLongestMm,
            fmt::format("{} = {} is no length", name, value),
            fmt::format("give millimetres from {} to {}", kShortestMm, kLongestMm));
  }
  // White to black; 1/contrast is a black level (lightfield/calibration.h).
  void Contrast(double contrast, const std::string& name) const {
    Require(contrast >= 1.01, fmt::format("{} = {}", name, contrast),
            "give 1.01 or more, 1000 for instance; inf, or none, is without leak");
  }
};

void CheckPanel(const Display& display, const Checker& check) {
  check.Require(display.width_px >= 1 && display.height_px >= 1,
                fmt::format("the panel has {} x {} pixels", display.width_px, display.height_px),
                "give width_px and height_px of at least 1");
  const std::int64_t pixels = static_cast<std::int64_t>(display.width_px) * display.height_px;
  check.Require(pixels <= kMostPixels, fmt::format("the panel has {} pixels", pixels),
                fmt::format("give width_px and height_px of at most {} together", kMostPixels));
  check.Length(display.pitch_mm, "pitch_mm");
  const int binning = display.binning_px;
  check.Require(binning >= 1 && display.width_px % binning == 0 && display.height_px % binning == 0,
                fmt::format("binning_px = {} does not divide {} x {} pixels", binning,
                            display.width_px, display.height_px),
                "give a binning that divides width and height");
  check.Length(display.viewing_distance_mm, "viewing_distance_mm");
  check.Contrast(display.contrast, "the panel's contrast");
  check.Within(display.slot_crosstalk, 0, 1, "slot_crosstalk");
}

struct OpticsChecker {
  const Display& display;
  const std::string& layer;
  const Checker& check;

  void operator()(const Barrier& barrier) const {
    const int period = barrier.period_px, aperture = barrier.aperture_px, slots = barrier.slots;
    check.Require(period >= 1 && period <= 4096, fmt::format("{}: period_px = {}", layer, period),
                  "give a period of 1 to 4096 emitters");
    check.Require(aperture >= 1 && aperture <= period,
                  fmt::format("{}: aperture_px = {} in a period of {}", layer, aperture, period),
                  "give an aperture of at least 1 and at most the period");
    check.Require(
        (period - aperture) % 2 == 0,
        fmt::format("{}: period_px = {} and aperture_px = {} are not both even or both odd", layer,
                    period, aperture),
        "make them of equal parity, or fans are off by half an emitter");
    check.Require(slots >= 1 && slots <= kMostSlotsPerAxis && period % slots == 0,
                  fmt::format("{}: slots = {} per axis in a period of {}", layer, slots, period),
                  fmt::format("give slots from 1 to {} that divide the period", kMostSlotsPerAxis));
    check.Require(aperture <= display.emitter_columns() && aperture <= display.emitter_rows(),
                  fmt::format("{}: no opening of {} emitters fits the panel", layer, aperture),
                  "give a larger panel or a smaller aperture_px");
    check.Contrast(barrier.contrast, layer + ": the modulator's contrast");
  }

  void operator()(const LensletArray& lenses) const {
    check.Within(lenses.pitch_px, 1, kLargestRatio, layer + ": pitch_px");
    check.Require(lenses.rays >= 1 && lenses.rays <= lenses.pitch_px,
                  fmt::format("{}: rays = {} under lenses of {} emitters", layer, lenses.rays,
                              lenses.pitch_px),
                  "give at least 1 ray and at most the pitch");
    check.Within(lenses.offset_x_px, -kLargestRatio, kLargestRatio, layer + ": offset_px right");
    check.Within(lenses.offset_y_px, -kLargestRatio, kLargestRatio, layer + ": offset_px down");
    check.Require(lenses.pitch_px <= display.emitter_columns() &&
                      lenses.row_pitch_px() <= display.emitter_rows(),
                  fmt::format("{}: no lens of {} emitters fits the panel", layer, lenses.pitch_px),
                  "give a larger panel or a smaller pitch_px");
    Focal(lenses.focal_mm);
  }

  void operator()(const Lenticular& lenses) const {
    check.Within(lenses.subpixels_per_lens, 1, kLargestRatio, layer + ": subpixels_per_lens");
    check.Within(lenses.slant, -kLargestSlant, kLargestSlant, layer + ": slant");
    check.Require(
        3 * std::abs(lenses.slant) * display.emitter_rows() <= kMostLenses,
        fmt::format("{}: slant = {} over {} rows", layer, lenses.slant, display.emitter_rows()),
        "give less slant, or fewer rows");
    check.Within(lenses.views, 1, kLargestRatio, layer + ": views");
    check.Within(lenses.offset_subpx, -kLargestRatio, kLargestRatio, layer + ": offset_subpx");
    check.Require(lenses.subpixels_per_lens <= 3.0 * display.emitter_columns(),
                  fmt::format("{}: no lens of {} sub-pixels fits the panel", layer,
                              lenses.subpixels_per_lens),
                  "give a larger panel or smaller subpixels_per_lens");
    check.Require(
        display.binning_px == 1,
        fmt::format("{}: lenticular lenses over binning_px = {}", layer, display.binning_px),
        "give binning_px = 1: each sub-pixel is an emitter of its own");
    Focal(lenses.focal_mm);
  }

  void operator()(const BarePanel& bare) const {
    check.Length(bare.eye_box_mm, layer + ": eye_box_mm");
    check.Require(bare.views >= 1 && bare.views <= kMostViews,
                  fmt::format("{}: views = {} of the eye box", layer, bare.views),
                  fmt::format("give 1 to {} eyes per axis", kMostViews));
  }

 private:
  void Focal(double focal_mm) const {
    if (focal_mm != 0) check.Length(focal_mm, layer + ": focal_mm");
  }
};

void CheckLayer(const Display& display, std::size_t index, const Checker& check) {
  const Layer& layer = display.layers[index];
  const std::string name = fmt::format("layer {}", index);
  check.Require(std::isfinite(layer.position_mm) && std::abs(layer.position_mm) <= kLongestMm,
                fmt::format("{}: position_mm = {}", name, layer.position_mm),
                fmt::format("give millimetres from -{0} to {0}", kLongestMm));
  const bool bare = std::holds_alternative<BarePanel>(layer.optics);
  if (!bare) check.Length(layer.d0_mm, name + ": the gap d0_mm");
  check.Require(!bare || layer.d0_mm == 0,
                fmt::format("{}: d0_mm = {} of a bare panel", name, layer.d0_mm),
                "leave it out: nothing stands before its emitters");
  check.Within(layer.magnification, 1 / kLargestMagnification, kLargestMagnification,
               name + ": the magnification");
  std::visit(OpticsChecker{display, name, check}, layer.optics);
  if (layer.plate) {
    const auto& [x, y, z] = layer.plate->normal;
    check.Require(bare || std::holds_alternative<Barrier>(layer.optics),
                  name + " has a plate before a lens sheet",
                  "leave it out: a plate is solved for before barriers and bare panels only");
    check.Within(layer.plate->thickness_mm, 0, kLongestMm, name + ": the plate's thickness_mm");
    check.Within(layer.plate->index, 1, 4, name + ": the plate's index");
    check.Require(std::isfinite(std::hypot(x, y, z)) && std::abs(z) > 0.1 * std::hypot(x, y, z),
                  fmt::format("{}: the plate's normal = [{}, {}, {}]", name, x, y, z),
                  "give [right, up, to the viewer], at most 84 degrees off the viewer");
  }
  check.Require(
      bare || FieldOfViewDeg(display, layer) <= kWidestFanDeg,
      fmt::format("{}: the gap d0_mm = {} makes a fan of {:.2f} degrees", name, layer.d0_mm,
                  FieldOfViewDeg(display, layer)),
      fmt::format("give a larger d0_mm or fewer emitters per element (at most {:g} degrees)",
                  kWidestFanDeg));
  check.Require(display.distance_mm(layer) > layer.seen_d0_mm(),
                fmt::format("{}: viewing_distance_mm = {} is not in front of position_mm = {}",
                            name, display.viewing_distance_mm, layer.position_mm),
                "put the viewer in front of every layer by more than its gap");
  if (index == 0) return;
  const double spacing = layer.position_mm - display.layers[index - 1].position_mm;
  check.Require(spacing > 0,
                fmt::format("layers {} and {} are at {} and {} mm", index - 1, index,
                            display.layers[index - 1].position_mm, layer.position_mm),
                "list layers by rising position_mm, back to front, no two at one place");
  check.Require(display.border_mm <= spacing,
                fmt::format("border_mm = {} is wider than the {} mm between layers {} and {}",
                            display.border_mm, spacing, index - 1, index),
                "give at most the spacing of neighbouring layers");
}

}  // namespace

void CheckVarifocal(const Varifocal& varifocal, const std::string& where) {
  const Checker check{where};
  check.Require(varifocal.planes >= 1 && varifocal.planes <= kMostLayers,
                fmt::format("[varifocal]: planes = {}", varifocal.planes),
                fmt::format("give 1 to {} planes", kMostLayers));
  check.Length(varifocal.depth_mm, "[varifocal]: depth_mm");
  check.Require(!std::isnan(varifocal.relay_focal_mm) && varifocal.relay_focal_mm != 0,
                fmt::format("[varifocal]: relay_focal_mm = {}", varifocal.relay_focal_mm),
                "give millimetres, or inf where the magnification is the same at all depths");
  for (const double end : {-0.5, 0.5}) {
    const double z = end * varifocal.depth_mm;
    check.Within(
        PlaneMagnification(varifocal, z), 1 / kLargestMagnification, kLargestMagnification,
        fmt::format("[varifocal]: magnification0 and relay_focal_mm: the magnification at {} mm",
                    z));
  }
}

void Check(const Display& display, const std::string& where) {
  const Checker check{where};
  CheckPanel(display, check);
  check.Require(!display.layers.empty(), "the display has no layer", "add a [[layer]]");
  if (display.varifocal) CheckVarifocal(*display.varifocal, where);
  check.Require(display.layers.size() <= static_cast<std::size_t>(kMostLayers),
                fmt::format("the display has {} layers", display.layers.size()),
                fmt::format("at most {} can be handled", kMostLayers));
  check.Require(std::isfinite(display.border_mm) && display.border_mm >= 0,
                fmt::format("border_mm = {}", display.border_mm), "give 0 or more millimetres");
  for (std::size_t i = 0; i < display.layers.size(); ++i) CheckLayer(display, i, check);
  check.Require(std::isfinite(display.border_offset_mm),
                fmt::format("border_offset_mm = {}", display.border_offset_mm),
                "give millimetres; 0 puts borders in the middles between layers");
  check.Require(
      !display.varifocal || display.layers == PlanesOf(*display.varifocal, display.layers.front()),
      "the layers are not the planes of [varifocal]", "give one [[layer]] without position_mm");
}

std::string NameOf(const Optics& optics) {
  if (std::holds_alternative<Barrier>(optics)) return "a barrier";
  if (std::holds_alternative<BarePanel>(optics)) return "a bare panel";
  return std::holds_alternative<LensletArray>(optics) ? "lenslets" : "lenticular lenses";
}

const Barrier& BarrierOf(const Display& display, std::size_t index) {
  const Layer& layer = display.layers.at(index);
  const Barrier* barrier = std::get_if<Barrier>(&layer.optics);
  if (barrier == nullptr) {
    throw UsageError(display.name,
                     fmt::format("layer {} has {}, no barrier", index, NameOf(layer.optics)),
                     "ask for what its optics have");
  }
  return *barrier;
}

Barrier OpeningsOf(const Layer& layer) {
  const Barrier* barrier = std::get_if<Barrier>(&layer.optics);
  return barrier != nullptr ? *barrier : Barrier{1, 1, 1};
}

int SlotsPerAxis(const Layer& layer) {
  const Barrier* barrier = std::get_if<Barrier>(&layer.optics);
  return barrier != nullptr ? barrier->slots : 1;
}

std::vector<Layer> PlanesOf(const Varifocal& varifocal, const Layer& layer) {
  std::vector<Layer> planes;
  for (const double z : PlaneDepthsMm(varifocal)) {
    planes.push_back(layer);
    planes.back().position_mm = z;
    planes.back().magnification = PlaneMagnification(varifocal, z);
  }
  return planes;
}

}  // namespace lamella
