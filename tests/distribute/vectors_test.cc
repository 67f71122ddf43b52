// The published test vectors of displays (displays.json: closed forms that agree with ray casting,
// counting and quadrature), against the program's own functions.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/assign.h"
#include "distribute/displays.h"
#include "distribute/encode_barrier.h"
#include "lightfield/color.h"
#include "lightfield/display.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

using Json = nlohmann::json;
using Numbers = std::vector<double>;

// A display of one layer, wide enough for every case.
Display OneLayer(double pitch, double d0, Barrier barrier = {1, 1, 1}, double position = 0,
                 int width = 1920) {
  Display display{"vector", width, 1080, pitch, 1, 1e4, false, 0, 0, {}};
  display.layers = {{position, d0, barrier, false}};
  return display;
}

Barrier BarrierOf(const Json& in) {
  const int period = in.at("P"), aperture = in.at("a");
  return {period, aperture, in.value("k", 1)};
}

AxisBeam BeamOf(double element, double emitter, double d0) {
  return {0, element, 0, emitter, 0, d0};
}

Numbers PixelCentre(const Json& in) {
  Display display = OneLayer(in.at("p"), 5, {1, 1, 1}, 0, in.at("w"));
  display.height_px = in.at("h");
  const RayMap map(display, 0);
  return {map.ColumnCentre(in.at("i")), map.RowCentre(in.at("r"))};
}

Numbers RayPair(const Json& in) {
  const double offset = in.at("zq").get<double>() - in.at("zl").get<double>(), d0 = in.at("d0");
  const AxisBeam x = BeamOf(in.at("xm"), in.at("xe"), d0), y = BeamOf(in.at("ym"), in.at("ye"), d0);
  return {x.slope() * d0, y.slope() * d0, x.At(offset), y.At(offset)};
}

Numbers BlurWidths(const Json& in) {
  const AxisBeam beam{0, 0, in.at("wx"), 0, in.at("wu"), in.at("d0")};
  const double opening = beam.OpeningBlurMm(in.at("delta"));
  const double emitter = beam.EmitterBlurMm(in.at("delta"));
  return {opening, emitter, std::sqrt((opening * opening + emitter * emitter) / 12)};
}

Numbers EmitterSeen(const Json& in) {
  const RayMap map(OneLayer(in.at("p"), in.at("d0"), {1, 1, 1}, in.at("zl"), in.at("w")), 0);
  const double x = in.at("xpin"), eye = in.at("ex");
  const double slope = (eye - x) / (in.at("D").get<double>() - in.at("zl").get<double>());
  return {static_cast<double>(map.SeenColumn(x, slope).value().emitter)};
}

Numbers BarrierRays(const Json& in) {
  const Barrier barrier = BarrierOf(in);
  const RayMap map(OneLayer(in.at("p"), 5, barrier), 0);
  Numbers rays;
  for (int column = 0; column < 1920; ++column) {  // all emitters of an opening in the middle
    const auto beam = map.Column(0, column);
    if (beam && beam->opening == 100) rays.push_back(beam->element_mm - beam->emitter_mm);
  }
  return rays;
}

Numbers BarrierSlot(const Json& in) {
  // Two periods more to each side, so that emitters beyond the panel's edge exist here.
  const Barrier barrier = BarrierOf(in);
  const int margin = 2 * barrier.period_px, slot = in.at("s"), opening = in.at("i");
  const Display display = OneLayer(0.3, 5, barrier, 0, 1920 + 2 * margin);
  const RayMap map(display, 0);
  Numbers result;
  for (int c = 0; c < display.width_px && result.empty(); ++c) {
    const bool starts = map.ColumnOpen(slot, c) && !(c > 0 && map.ColumnOpen(slot, c - 1));
    if (starts && c >= margin + barrier.period_px * opening) {
      result.push_back(c - margin);
    }
  }
  int first = -1, last = -1;
  for (int c = 0; c < display.width_px; ++c) {
    const auto beam = map.Column(slot, c);
    if (!beam || beam->opening != opening + 2) continue;
    first = first < 0 ? c : first;
    last = c;
  }
  result.insert(result.end(),
                {static_cast<double>(first - margin), static_cast<double>(last - margin)});
  return result;
}

Numbers BrightnessOf(const Json& in) {
  Display display = OneLayer(0.3, 5, BarrierOf(in));
  display.layers.resize(in.at("n").get<std::size_t>(), display.layers[0]);
  return {Brightness(display, display.layers[0])};
}

Numbers WindowPitch(const Json& in) {
  Display display = OneLayer(in.at("p"), in.at("d0"), {in.at("P"), in.at("P"), 1});
  display.viewing_distance_mm = in.at("D");
  display.shear = true;
  return {WindowPitchMm(display, display.layers[0])};
}

Numbers SlotOrderOf(const Json& in) {
  const int k = in.at("k");
  Numbers result;
  for (const int slot : SlotOrder(k))
    result.insert(result.end(), {1.0 * (slot % k), 1.0 * (slot / k)});
  return result;
}

Numbers FuzzyWeights(const Json& in) {
  const LayerWeights weights(in.at("layers").get<Numbers>(), in.at("w"));
  Numbers result;
  for (int l = 0; l < weights.num_layers(); ++l) {
    result.push_back(static_cast<double>(weights.Weight(l, in.at("z").get<float>())));
  }
  return result;
}

// Displays whose lattice is a whole number of emitters, as barriers' are.
std::optional<Display> Lattice(const Json& in) {
  const double dx = in.at("dx"), du = in.at("du");
  const int stride = static_cast<int>(std::lround(dx / du));
  if (std::abs(stride * du - dx) > 1e-9) return std::nullopt;
  return OneLayer(du, in.at("d0"), {stride, stride, 1});
}

Numbers SharpRange(const Json& in) {
  const std::optional<Display> display = Lattice(in);
  return display ? Numbers{SharpRangeMm(*display, display->layers[0])} : Numbers();
}

Numbers Cutoff(const Json& in) {
  const std::optional<Display> display = Lattice(in);
  return display ? Numbers{CutoffPerMm(*display, display->layers[0], in.at("z"))} : Numbers();
}

Numbers LinearMix(const Json& in) {
  const auto light = [&](const char* key) { return Srgb8ToLinear(in.at(key).get<std::uint8_t>()); };
  const float w = in.at("w");
  return {1.0 * PanelResponse::Srgb().Code(w * light("a8") + (1 - w) * light("b8"))};
}

// An empty answer leaves a case out (a lens array, or a lattice that no barrier has).
const std::map<std::string, std::function<Numbers(const Json&)>>& Functions() {
  static const std::map<std::string, std::function<Numbers(const Json&)>> functions = {
      {"panel_pitch", [](const Json&) { return Numbers{FindDisplay("paper-two-layer").pitch_mm}; }},
      {"pixel_centre", PixelCentre},
      {"ray_pair", RayPair},
      {"blur_widths",
       [](const Json& in) { return in.at("model") == "barrier" ? BlurWidths(in) : Numbers(); }},
      {"emitter_seen", EmitterSeen},
      {"view_spacing",
       [](const Json& in) {
         const Display display = OneLayer(in.at("p"), in.at("d0"));
         return Numbers{ViewSpacingMm(display, display.layers[0], in.at("D"))};
       }},
      {"barrier_rays", BarrierRays},
      {"barrier_slot", BarrierSlot},
      {"barrier_brightness", BrightnessOf},
      {"window_pitch", WindowPitch},
      {"shear_shift_px",
       [](const Json& in) {
         return Numbers{1.0 * ShearShiftPx(in.at("x"), in.at("d0"), in.at("D"), in.at("p"))};
       }},
      {"slot_order", SlotOrderOf},
      {"fov_deg",
       [](const Json& in) {
         const Display display = OneLayer(in.at("extent"), in.at("d0"));
         return Numbers{FieldOfViewDeg(display, display.layers[0])};
       }},
      {"fuzzy_weights", FuzzyWeights},
      {"zmax", SharpRange},
      {"cutoff", Cutoff},
      {"linear_mix", LinearMix}};
  return functions;
}

Numbers Flat(const Json& json) {
  if (!json.is_array()) return {json.get<double>()};
  Numbers numbers;
  for (const Json& part : json) {
    for (const double number : Flat(part)) numbers.push_back(number);
  }
  return numbers;
}

TEST(Vectors, AreMetByTheProgramsOwnFunctions) {
  std::ifstream file(LAMELLA_DISPLAY_VECTORS);
  const Json document = Json::parse(file);
  int passed = 0;
  for (const Json& vector : document.at("cases")) {
    const auto function = Functions().find(vector.at("fn"));
    if (function == Functions().end()) continue;
    const Numbers expected = Flat(vector.at("expect")), got = function->second(vector.at("input"));
    if (got.empty()) continue;
    double largest = 1;
    for (const double number : expected) largest = std::max(largest, std::abs(number));
    ASSERT_EQ(got.size(), expected.size()) << vector;
    for (std::size_t i = 0; i < got.size(); ++i) {
      const double rounding = 1e-10 * largest;  // expectations are printed with ten digits
      EXPECT_NEAR(got[i], expected[i], vector.at("tol").get<double>() * largest + rounding)
          << vector;
    }
    ++passed;
  }
  EXPECT_GE(passed, 60);
  std::printf("%d vectors met\n", passed);
}

}  // namespace
}  // namespace lamella
