// The options of the layers (distribute/distribute.h).
#include <algorithm>
#include <string>
#include <utility>

#include "distribute/distribute.h"
#include "distribute/emitter_beams.h"
#include "lightfield/error.h"

namespace lamella {

void CheckOptions(const LayersOptions& options, const Display& display, bool calibrated) {
  if (calibrated && options.directions != "true") {
    throw UsageError("--layers-directions", "a calibrated display has no ideal directions",
                     "leave it at \"true\"");
  }
  if (options.prefilter != "blur") return;
  const auto refuse = [](const std::string& what) {
    throw UsageError("--layers-prefilter", what, "leave it at \"gather\"");
  };
  if (calibrated) refuse("blur cannot follow a calibration, where every emitter has its own beam");
  if (options.scatter) refuse("blur takes whole pictures, scattered rays (scatter) are none");
  if (std::any_of(display.layers.begin(), display.layers.end(), HasRowFamilies)) {
    refuse("blur cannot follow a slanted lens sheet, where every row has its own beams");
  }
}

OptionField MemoryField(double& gib) {
  return {"memory_gib",
          "emitters are made, and shown to the preview's eyes, in strips, so that all fits into "
          "this much memory, GiB",
          &gib,
          0.1,
          1e4,
          {},
          "--memory"};
}

OptionTable Describe(LayersOptions& options) {
  OptionTable table{
      "layers",
      {{"display",
        "a display's name (see `lamella displays`) or TOML file",
        &options.display,
        {},
        {},
        {},
        "--display"},
       {"nodes_per_step",
        "directions per axis and emitter step for which the capture is rendered",
        &options.nodes_per_step,
        1,
        8,
        {},
        "--nodes-per-step"},
       {"samples_per_pixel",
        "rays per axis and emitter pitch of a rendered direction",
        &options.samples_per_pixel,
        1,
        8,
        {},
        "--samples-per-pixel"},
       {"kernel",
        "prefilter: beam (what an emitter sends, exactly), lens (the paper's box in position and "
        "direction) or ray (none: its central ray)",
        &options.kernel,
        {},
        {},
        {"beam", "lens", "ray"}},
       {"prefilter",
        "gather (all of a beam's lines, exactly) or blur (the picture along its central ray, as "
        "wide as the beam is at the depth of what is seen there: wrong where things hide others)",
        &options.prefilter,
        {},
        {},
        {"gather", "blur"}},
       {"directions",
        "of a window that is sheared to the viewer: true (rounded to whole emitters) or ideal (the "
        "paper's, not rounded: the picture jumps where the rounding steps)",
        &options.directions,
        {},
        {},
        {"true", "ideal"}},
       {"calibration",
        "calibration.json of the display (from `lamella calibrate`): where its panels really are; "
        "else as designed",
        &options.calibration,
        {},
        {},
        {},
        "--calibration"},
       {"scatter", "scatter directions and rays within their cells (low discrepancy)",
        &options.scatter},
       {"border_mm",
        "width over which neighbouring layers overlap, mm (default: the display's)",
        &options.border_mm,
        0,
        1e6,
        {},
        "--border-mm"},
       {"border_offset_mm",
        "borders lie so far in front of the middles between layers, mm (default: the display's)",
        &options.border_offset_mm,
        -1e6,
        1e6,
        {},
        "--border-offset-mm"},
       MemoryField(options.memory_gib)}};
  for (OptionField& field : Describe(options.placement)) table.fields.push_back(std::move(field));
  return table;
}

// hci_antinous on paper-two-layer, 540 x 540 px, dB of the simulated eyes within +-54 mm: 1 node
// and 1 sample 35.44, 1 and 2 35.51, 2 and 1 35.55, 2 and 2 35.56, at 1, 4, 4 and 15 times the
// rays.
void ApplyQuality(Quality quality, LayersOptions& options) {
  options.nodes_per_step = quality == Quality::kBest ? 2 : 1;
  options.samples_per_pixel = 1;
}

}  // namespace lamella
