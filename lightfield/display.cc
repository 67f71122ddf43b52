#include "lightfield/display.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr double kLongestMm = 1e6;
constexpr double kShortestMm = 1e-9;
constexpr std::int64_t kMostEmitters = std::int64_t{1} << 28;
constexpr int kMostSlotsPerAxis = 32;  // a bit each in RayMap
constexpr int kMostLayers = 1024;
constexpr double kSteepest = 57;  // tangent of half the fan: 178 degrees

struct Checker {
  const std::string& where;

  void Require(bool holds, const std::string& what, const std::string& fix) const {
    if (!holds) throw UsageError(where, what, fix);
  }
  void Length(double value, const std::string& name) const {
    Require(std::isfinite(value) && value >= kShortestMm && value <= kLongestMm,
            fmt::format("{} = {} is no length", name, value),
            fmt::format("give millimetres from {} to {}", kShortestMm, kLongestMm));
  }
};

void CheckPanel(const Display& display, const Checker& check) {
  check.Require(display.width_px >= 1 && display.height_px >= 1,
                fmt::format("the panel has {} x {} pixels", display.width_px, display.height_px),
                "give width_px and height_px of at least 1");
  check.Length(display.pitch_mm, "pitch_mm");
  const int binning = display.binning_px;
  check.Require(binning >= 1 && display.width_px % binning == 0 && display.height_px % binning == 0,
                fmt::format("binning_px = {} does not divide {} x {} pixels", binning,
                            display.width_px, display.height_px),
                "give a binning that divides width and height");
  const std::int64_t emitters =
      static_cast<std::int64_t>(display.emitter_columns()) * display.emitter_rows();
  check.Require(emitters <= kMostEmitters, fmt::format("the panel has {} emitters", emitters),
                fmt::format("at most {} can be handled", kMostEmitters));
  check.Length(display.viewing_distance_mm, "viewing_distance_mm");
}

void CheckBarrier(const Display& display, const Barrier& barrier, const std::string& layer,
                  const Checker& check) {
  const auto [period, aperture, slots] = barrier;
  check.Require(period >= 1 && period <= 4096, fmt::format("{}: period_px = {}", layer, period),
                "give a period of 1 to 4096 emitters");
  check.Require(aperture >= 1 && aperture <= period,
                fmt::format("{}: aperture_px = {} in a period of {}", layer, aperture, period),
                "give an aperture of at least 1 and at most the period");
  check.Require((period - aperture) % 2 == 0,
                fmt::format("{}: period_px = {} and aperture_px = {} are not both even or both odd",
                            layer, period, aperture),
                "make them of equal parity, or fans are off by half an emitter");
  check.Require(slots >= 1 && slots <= kMostSlotsPerAxis && period % slots == 0,
                fmt::format("{}: slots = {} per axis in a period of {}", layer, slots, period),
                fmt::format("give slots from 1 to {} that divide the period", kMostSlotsPerAxis));
  check.Require(aperture <= display.emitter_columns() && aperture <= display.emitter_rows(),
                fmt::format("{}: no opening of {} emitters fits the panel", layer, aperture),
                "give a larger panel or a smaller aperture");
}

void CheckLayer(const Display& display, std::size_t index, const Checker& check) {
  const Layer& layer = display.layers[index];
  const std::string name = fmt::format("layer {}", index);
  check.Require(std::isfinite(layer.position_mm) && std::abs(layer.position_mm) <= kLongestMm,
                fmt::format("{}: position_mm = {}", name, layer.position_mm),
                fmt::format("give millimetres from -{0} to {0}", kLongestMm));
  check.Length(layer.d0_mm, name + ": the gap d0_mm");
  CheckBarrier(display, layer.barrier, name, check);
  const double steepest = layer.barrier.period_px * display.emitter_pitch_mm() / (2 * layer.d0_mm);
  check.Require(steepest <= kSteepest,
                fmt::format("{}: a gap of {} mm makes a fan of {:.2f} degrees", name, layer.d0_mm,
                            FieldOfViewDeg(display, layer)),
                "give a wider gap or a shorter period (at most 178 degrees)");
  check.Require(display.distance_mm(layer) > layer.d0_mm,
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

void Check(const Display& display, const std::string& where) {
  const Checker check{where};
  CheckPanel(display, check);
  check.Require(!display.layers.empty(), "the display has no layer", "add a [[layer]]");
  check.Require(display.layers.size() <= static_cast<std::size_t>(kMostLayers),
                fmt::format("the display has {} layers", display.layers.size()),
                fmt::format("at most {} can be handled", kMostLayers));
  check.Require(std::isfinite(display.border_mm) && display.border_mm >= 0,
                fmt::format("border_mm = {}", display.border_mm), "give 0 or more millimetres");
  check.Require(std::isfinite(display.border_offset_mm),
                fmt::format("border_offset_mm = {}", display.border_offset_mm),
                "give millimetres; 0 puts borders in the middles between layers");
  for (std::size_t i = 0; i < display.layers.size(); ++i) CheckLayer(display, i, check);
}

double FieldOfViewDeg(const Display& display, const Layer& layer) {
  const double window = layer.barrier.period_px * display.emitter_pitch_mm();
  return 2 * std::atan(window / (2 * layer.d0_mm)) * 180 / std::numbers::pi;
}

double LatticePitchMm(const Display& display, const Layer& layer) {
  return layer.barrier.stride_px() * display.emitter_pitch_mm();
}

double SharpRangeMm(const Display& display, const Layer& layer) {
  return layer.d0_mm * LatticePitchMm(display, layer) / display.emitter_pitch_mm();
}

double SharpestOffsetMm(const Layer& layer) {
  const double opening = layer.barrier.aperture_px;  // in emitters, so w_u = 1
  return -layer.d0_mm * opening * opening / (opening * opening + 1);
}

double MeanSharpestOffsetMm(const std::vector<Layer>& layers) {
  double sum = 0;
  for (const Layer& layer : layers) sum += SharpestOffsetMm(layer);
  return layers.empty() ? 0 : sum / static_cast<double>(layers.size());
}

double CutoffPerMm(const Display& display, const Layer& layer, double offset_mm) {
  const double lattice = 1 / (2 * LatticePitchMm(display, layer));
  if (offset_mm == 0) return lattice;
  return std::min(layer.d0_mm / (2 * display.emitter_pitch_mm() * std::abs(offset_mm)), lattice);
}

double ViewSpacingMm(const Display& display, const Layer& layer, double distance_mm) {
  return display.emitter_pitch_mm() * distance_mm / layer.d0_mm;
}

double WindowPitchMm(const Display& display, const Layer& layer) {
  const double pitch = layer.barrier.period_px * display.emitter_pitch_mm();
  const double distance = display.distance_mm(layer);
  return display.shear ? pitch * (distance + layer.d0_mm) / distance : pitch;
}

double Brightness(const Display& display, const Layer& layer) {
  const double open = static_cast<double>(layer.barrier.aperture_px) / layer.barrier.period_px;
  return open * open / static_cast<double>(display.layers.size());
}

double DepthBudgetMm(const Display& display) {
  double budget = 0;
  for (const Layer& layer : display.layers) {
    budget = std::max(budget, std::abs(layer.position_mm) + SharpRangeMm(display, layer));
  }
  return budget;
}

}  // namespace lamella
