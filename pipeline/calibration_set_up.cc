#include "pipeline/calibration_set_up.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "distribute/simulate_eye.h"
#include "lightfield/error.h"
#include "pipeline/calibration_patterns.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

Display DisplayOfPatterns(const fs::path& patterns, const std::string& display,
                          const ShotList& list) {
  if (!display.empty()) return FindDisplay(display);
  const fs::path beside = patterns / kPatternsDisplay;
  std::error_code error;
  return fs::exists(beside, error) ? ReadDisplay(beside) : FindDisplay(list.display);
}

}  // namespace

void CheckDesign(const Calibration& design, const ShotList& list, const std::string& where) {
  for (const CalibratedPanel& panel : list.panels) {
    const auto i = static_cast<std::size_t>(panel.id.layer);
    const PanelCalibration* built = nullptr;
    if (i < design.layers.size()) {
      const LayerCalibration& layer = design.layers[i];
      if (panel.id.role == PanelId::kEmitter) built = &layer.emitter;
      if (panel.id.role == PanelId::kModulator && layer.modulator) built = &*layer.modulator;
    }
    if (built != nullptr && built->width_px == panel.size.width_px &&
        built->height_px == panel.size.height_px && built->mirror_x == panel.mirrored) {
      continue;
    }
    throw UsageError(
        where,
        fmt::format("display {} has no {} of {} x {} px{}, for which these patterns "
                    "of {} were made",
                    design.display, NameOf(panel.id), panel.size.width_px, panel.size.height_px,
                    panel.mirrored ? " seen in a mirror" : "", list.display),
        "give the display that the patterns were made of");
  }
}

CalibrationSetUp LoadCalibrationSetUp(const fs::path& patterns, const std::string& display) {
  CalibrationSetUp set_up;
  set_up.list = LoadShotList(patterns);
  set_up.display = DisplayOfPatterns(patterns, display, set_up.list);
  set_up.design = DesignCalibration(set_up.display);
  CheckDesign(set_up.design, set_up.list, display.empty() ? patterns.string() : display);
  return set_up;
}

EyeBox CleanEyesOf(const Display& display) {
  constexpr double kEyesApartMm = 65;
  EyeBox box;
  const double clean = CleanEyeBox(display);
  box.half_width_mm = box.half_height_mm =
      std::max(kEyesApartMm / 2, std::isfinite(clean) ? clean : 0);
  box.near_mm = 0.8 * display.viewing_distance_mm;
  box.far_mm = 1.2 * display.viewing_distance_mm;
  return box;
}

}  // namespace lamella
