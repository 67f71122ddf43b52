// The stage frames: what each panel shows in each time slot, final codes, and frames.json.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "distribute/encode_barrier.h"
#include "lightfield/atomic_file.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/layers_record.h"
#include "pipeline/stages.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormatVersion = 1;
constexpr int kPngLevel = 1;  // frames are many and shown once

std::string FrameFile(int layer, int slot, const char* role) {
  return fmt::format("layer_{}_slot_{}_{}.png", layer, slot, role);
}

PanelResponse ResponseOf(const FramesOptions& options) {
  return options.response == "gamma" ? PanelResponse::Gamma(options.gamma) : PanelResponse::Srgb();
}

Json ToJson(const Display& display, const FramesOptions& options) {
  Json layers = Json::array();
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Layer& layer = display.layers[l];
    const int k = SlotsPerAxis(layer);
    Json frames = Json::array();
    for (int slot = 0; slot < k * k; ++slot) {
      for (const char* role : {"emitter", "modulator"}) {
        frames.push_back({{"file", FrameFile(static_cast<int>(l), slot, role)},
                          {"role", role},
                          {"slot", slot},
                          {"slot_x", slot % k},
                          {"slot_y", slot / k}});
      }
    }
    layers.push_back({{"layer", l},
                      {"position_mm", layer.position_mm},
                      {"mirror_x", layer.mirror_x},
                      {"slots_per_axis", k},
                      {"order", SlotOrder(k)},
                      {"frames", frames}});
  }
  Json response = {{"curve", options.response}};
  if (options.response == "gamma") response["gamma"] = options.gamma;
  return {{"format_version", kFormatVersion},
          {"display", display.name},
          {"panel",
           {{"width_px", display.width_px},
            {"height_px", display.height_px},
            {"pitch_mm", display.pitch_mm}}},
          {"bit_depth", 8},
          {"response", response},
          {"layers", layers}};
}

}  // namespace

OptionTable Describe(FramesOptions& options) {
  return {"frames",
          {{"response",
            "curve of the panels from code to light",
            &options.response,
            {},
            {},
            {"srgb", "gamma"}},
           {"gamma", "exponent of the panels' curve where response is gamma", &options.gamma, 0.1,
            10}}};
}

StageReport RunFrames(const Workspace& workspace, const FramesOptions& options, StageRun& run,
                      Progress& progress) {
  const LayersRecord record = LoadLayersRecord(workspace);
  const Display& display = record.display;
  const PanelResponse response = ResponseOf(options);
  int slots = 0;
  for (const Layer& layer : display.layers) slots += SlotsPerAxis(layer) * SlotsPerAxis(layer);
  progress.Start("frames", slots, "slots");
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const int layer = static_cast<int>(l), k = SlotsPerAxis(display.layers[l]);
    ParallelForEach(0, k * k, [&](std::int64_t s) {
      const int slot = static_cast<int>(s);
      const EmitterImage emitters = LoadEmitterImage(workspace, display, layer, slot);
      WriteCodes8(run.folder() / FrameFile(layer, slot, "emitter"),
                  EmitterFrame(emitters, display, layer, response).span(), 95, kPngLevel);
      WriteGrey8(run.folder() / FrameFile(layer, slot, "modulator"),
                 ModulatorFrame(display, layer, slot).span(), kPngLevel);
      progress.Advance();
    });
  }
  WriteTextAtomically(run.folder() / "frames.json", ToJson(display, options).dump(1) + "\n");
  StageReport report;
  report.summary = {
      {"frames", fmt::format("{} of {} x {} px", 2 * slots, display.width_px, display.height_px)},
      {"slots", fmt::format("{}", slots)},
      {"response", options.response}};
  return report;
}

}  // namespace lamella
