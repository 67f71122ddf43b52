#include "calibration/photometric_shots.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Kind = PatternShot::Kind;

constexpr int kLevels = 16;  // steps between black and white
constexpr int kHalfCode = 128;
// The largest codes that are not overexposed where white has 80 % of full scale, of any panel with
// a gamma of 1.8 or more; what is overexposed is left out when photographs are read.
struct Exposure {
  int factor, last_code;
};
constexpr Exposure kExposures[] = {{1, 254}, {8, 96}, {64, 48}};

PatternShot Flat(const PanelId& panel, const Rgb8& color, int exposure) {
  PatternShot shot{"", Kind::kFlat, panel, {}, false};
  shot.pattern.kind = Pattern::Kind::kFlat;
  shot.pattern.color = color;
  shot.exposure = exposure;
  shot.first_position_only = true;
  return shot;
}

void AddLevels(const PanelId& panel, std::vector<PatternShot>& shots) {
  for (const Exposure& exposure : kExposures) {
    for (int level = 0; level < kLevels; ++level) {
      const auto code = static_cast<std::uint8_t>(std::lround(255.0 * level / kLevels));
      if (code > exposure.last_code) break;
      shots.push_back(Flat(panel, {code, code, code}, exposure.factor));
    }
  }
}

void AddLines(int layer, std::vector<PatternShot>& shots) {
  for (int step = 0; step < kLinesPeriodPx; ++step) {
    PatternShot shot{"", Kind::kLines, {layer, PanelId::kEmitter}, {}, false};
    shot.pattern.kind = Pattern::Kind::kColumns;
    shot.pattern.step = step;
    shot.pattern.period_px = kLinesPeriodPx;
    shot.first_position_only = true;
    shots.push_back(shot);
  }
}

// What a layer shows at the first position only.
void AddLayer(int layer, std::vector<PatternShot>& shots) {
  const PanelId emitter{layer, PanelId::kEmitter}, modulator{layer, PanelId::kModulator};
  for (const Rgb8& color : {Rgb8{255, 0, 0}, Rgb8{0, 255, 0}, Rgb8{0, 0, 255}}) {
    shots.push_back(Flat(emitter, color, 1));
  }
  PatternShot mixed = Flat(emitter, {kHalfCode, kHalfCode, kHalfCode}, 1);
  mixed.kind = Kind::kMixed;
  shots.push_back(mixed);
  AddLines(layer, shots);
  AddLevels(modulator, shots);
  AddLevels(emitter, shots);
}

const char* ColorName(const Rgb8& color) {
  if (color == Rgb8{255, 0, 0}) return "red";
  if (color == Rgb8{0, 255, 0}) return "green";
  return color == Rgb8{0, 0, 255} ? "blue" : nullptr;
}

bool HasLenses(const Calibration& calibration) {
  return std::any_of(calibration.layers.begin(), calibration.layers.end(),
                     [](const LayerCalibration& layer) { return layer.lattice.has_value(); });
}

}  // namespace

std::vector<PatternShot> PhotometricShots(const Calibration& calibration) {
  std::vector<PatternShot> shots = {{"", Kind::kDark, {}, {}, false}}, once;
  for (const Exposure& exposure : kExposures) {
    if (exposure.factor == 1) continue;
    once.push_back(shots.front());
    once.back().exposure = exposure.factor;
    once.back().first_position_only = true;
  }
  for (std::size_t l = 0; l < calibration.layers.size(); ++l) {
    if (!calibration.layers[l].modulator) continue;
    const int layer = static_cast<int>(l);
    for (const auto role : {PanelId::kModulator, PanelId::kEmitter}) {
      shots.push_back({"", Kind::kBoard, {layer, role}, {Pattern::Kind::kBoard}, false});
    }
    shots.push_back({"", Kind::kWhite, {layer, PanelId::kEmitter}, {}, false});
    AddLayer(layer, once);
  }
  if (shots.size() == 1) {
    std::string fix = "give its response by hand: `response` and `black` of calibration.json";
    if (HasLenses(calibration)) {
      fix +=
          "; to know the crosstalk, photograph one lit column without the lens sheet and give "
          "`crosstalk`";
    }
    throw UsageError(calibration.display,
                     "has no layer with a modulator, before which alone levels are one panel's",
                     fix);
  }
  shots.insert(shots.end(), once.begin(), once.end());
  return shots;
}

std::string NameOfPhotometricShot(const PatternShot& shot) {
  const std::string layer = fmt::format("layer{}", shot.panel.layer);
  if (shot.kind == Kind::kMixed) return layer + "_mixed";
  if (shot.kind == Kind::kLines) return fmt::format("{}_lines_{}", layer, shot.pattern.step);
  if (const char* color = ColorName(shot.pattern.color)) {
    return fmt::format("{}_{}", PlaceName(shot.panel), color);
  }
  return fmt::format("{}_{:03}_x{}", PlaceName(shot.panel), shot.pattern.color.g, shot.exposure);
}

std::string ExposureText(const PatternShot& shot) {
  return shot.exposure == 1 ? "" : fmt::format(", exposed {} times as long", shot.exposure);
}

std::string DescribePhotometricShot(const PatternShot& shot) {
  if (shot.kind == Kind::kMixed) {
    return fmt::format("layer {}: code {} on both panels", shot.panel.layer, kHalfCode);
  }
  if (shot.kind == Kind::kLines) {
    return fmt::format("layer {}: lines {} of {} on the emitter, openings of 1 px in the modulator",
                       shot.panel.layer, shot.pattern.step + 1, shot.pattern.period_px);
  }
  const char* other = shot.panel.role == PanelId::kEmitter ? "modulator" : "emitter";
  const char* color = ColorName(shot.pattern.color);
  const std::string what =
      color != nullptr ? std::string(color) : fmt::format("code {}", shot.pattern.color.g);
  return fmt::format("{}: {}; its {} white{}", NameOf(shot.panel), what, other, ExposureText(shot));
}

std::string DescribePhotometry(const ShotList& list) {
  const auto everywhere =
      std::count_if(list.shots.begin(), list.shots.end(),
                    [](const PatternShot& shot) { return !shot.first_position_only; });
  return fmt::format(
             "Light of {}: {} photographs from the first camera position, {} from each further "
             "one\n\n"
             "Camera: on a tripod, released from afar, in a dark room; raw, developed without any "
             "tone\n"
             "curve or automatic correction to linear 16-bit TIFF or PNG, or EXR; focus, zoom, "
             "aperture\n"
             "and sensitivity locked; exposed over many refreshes, the white panel at about 80 % "
             "of full\n"
             "scale. Only the time changes, as shots say.\n"
             "Panels: warm, brightness at its final setting, no scaling, no time slots: one image "
             "stands\n"
             "still.\n"
             "Positions: 3 or more, the first one straight before the display, the others 20 "
             "degrees and\n"
             "more to the sides, above and below, and the panel in different parts of the "
             "picture.\n"
             "At the first take all of these without touching the camera, at the others the first "
             "{}:\n\n",
             list.display, list.shots.size(), everywhere, everywhere) +
         ListOfShots(list);
}

}  // namespace lamella
