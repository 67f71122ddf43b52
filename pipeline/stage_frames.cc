// The stage frames: what each panel shows in each time slot, final codes, and frames.json.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "distribute/encode_barrier.h"
#include "distribute/encode_varifocal.h"
#include "distribute/one_bit.h"
#include "distribute/stroke_order.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/emitter_files.h"
#include "pipeline/layers_record.h"
#include "pipeline/slot_frames.h"
#include "pipeline/stages.h"
#include "pipeline/varifocal_frames.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFramesVersion = 1;

PanelResponse ResponseOf(const FramesOptions& options, const LayersRecord& record, int layer) {
  if (record.calibration) return PanelResponse::Of(*record.calibration, layer);
  return options.response == "gamma" ? PanelResponse::Gamma(options.gamma) : PanelResponse::Srgb();
}

Json PanelJson(const Display& display) {
  return {{"width_px", display.width_px},
          {"height_px", display.height_px},
          {"pitch_mm", display.pitch_mm}};
}

Json ToJson(const LayersRecord& record, const FramesOptions& options) {
  const Display& display = record.display;
  Json layers = Json::array();
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Layer& layer = display.layers[l];
    const int k = SlotsPerAxis(layer);
    Json frames = Json::array();
    for (int slot = 0; slot < k * k; ++slot) {
      for (const char* role : RolesOf(layer)) {
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
  Json response = {{"curve", record.calibration ? "calibration" : options.response}};
  if (options.response == "gamma") response["gamma"] = options.gamma;
  return {{"format_version", kFramesVersion},
          {"display", display.name},
          {"panel", PanelJson(display)},
          {"bit_depth", 8},
          {"response", response},
          {"layers", layers}};
}

Json ToJson(const Display& display, const FramesOptions& options, const StrokeFrames& frames,
            const std::vector<std::string>& numerals) {
  Json positions = Json::array(), strokes = Json::array();
  for (const Layer& layer : display.layers) positions.push_back(layer.position_mm);
  const FocusSweep sweep = display.varifocal->spacing == Varifocal::Spacing::kSinusoidal
                               ? FocusSweep::kSinusoidal
                               : FocusSweep::kUniform;
  for (std::size_t stroke = 0; stroke < frames.files.size(); ++stroke) {
    const int direction = options.there_and_back ? static_cast<int>(stroke) : 0;
    Json planes = Json::array(), phases = Json::array();
    for (const ShownPlane& shown : StrokeSchedule(*display.varifocal, sweep, direction)) {
      planes.push_back(shown.plane);
      phases.push_back(shown.phase);
    }
    strokes.push_back({{"file", frames.files[stroke]}, {"planes", planes}, {"phases", phases}});
  }
  return {{"format_version", kFramesVersion},
          {"display", display.name},
          {"panel", PanelJson(display)},
          {"bit_depth", 1},
          {"mirror_x", display.layers[0].mirror_x},
          {"positions_mm", positions},
          {"method", options.one_bit_method},
          {"packing",
           {{"channels", options.channels},
            {"bits", options.bits},
            {"there_and_back", options.there_and_back}}},
          {"strokes", strokes},
          {"numerals", numerals}};
}

void CheckOneBit(const Display& display) {
  constexpr const char* kFix = "give --planes grey: a frame of 8 bits for every plane";
  if (display.layers.size() > static_cast<std::size_t>(kMaxBitPlanes)) {
    throw UsageError(display.name,
                     fmt::format("{} planes: a frame carries {} of one bit", display.layers.size(),
                                 kMaxBitPlanes),
                     kFix);
  }
  if (!std::holds_alternative<LensletArray>(display.layers.front().optics)) {
    throw UsageError(display.name,
                     fmt::format("one-bit planes are made for lenslets, and it has {}",
                                 NameOf(display.layers.front().optics)),
                     kFix);
  }
}

// Of all planes' grey and all strokes' bits, not by rows: kDiffusion hands errors from row to row
// and kSigmaDelta from plane to plane along sheared rays (distribute/one_bit.h), so every row needs
// others of all planes; and panels that show some thousand frames a second have about a million
// pixels.
StageReport RunStrokes(const Workspace& workspace, const LayersRecord& record,
                       const FramesOptions& options, StageRun& run, Progress& progress) {
  const Display& display = record.display;
  CheckOneBit(display);
  progress.Start("frames", 1, "sets of strokes");
  OneBitOptions one_bit;
  one_bit.method = OneBitMethodOf(options.one_bit_method);
  one_bit.strokes = options.strokes;
  const PlanePacking packing{ChannelOrderOf(options.channels), BitOrderOf(options.bits),
                             options.there_and_back};
  CheckStrokes(one_bit.strokes, packing);
  std::vector<std::string> numerals;
  const StrokeFrames frames =
      WriteStrokeFrames(run.folder(), ReadGrey(OpenEmitterFiles(workspace, display), display),
                        display, one_bit, packing, numerals);
  WriteTextAtomically(run.folder() / "frames.json",
                      ToJson(display, options, frames, numerals).dump(1) + "\n");
  progress.Advance();
  StageReport report;
  report.summary = {
      {"frames", fmt::format("{} strokes of {} one-bit planes, {} x {} px", frames.files.size(),
                             frames.planes, display.width_px, display.height_px)},
      {"grey", fmt::format("{}, {} levels", options.one_bit_method, options.strokes + 1)},
      {"packing", fmt::format("{}, {}", options.channels, options.bits)}};
  if (numerals.empty())
    report.warnings.emplace_back("the panel is too small for frames of numerals");
  return report;
}

}  // namespace

OptionTable Describe(FramesOptions& options) {
  return {
      "frames",
      {{"response",
        "curve of the panels from code to light",
        &options.response,
        {},
        {},
        {"srgb", "gamma"}},
       {"gamma", "exponent of the panels' curve where response is gamma", &options.gamma, 0.1, 10},
       {"planes",
        "a varifocal display's: one-bit (packed, as its projector shows them) or grey",
        &options.planes,
        {},
        {},
        {"one-bit", "grey"},
        "--planes"},
       {"one_bit_method",
        "how strokes of one bit make grey",
        &options.one_bit_method,
        {},
        {},
        OneBitMethodNames(),
        "--one-bit-method"},
       {"strokes",
        "after which one-bit frames repeat; even where the mirror goes there and back",
        &options.strokes,
        1,
        4096,
        {},
        "--strokes"},
       {"channels",
        "which channel of a frame carries exposures 0 to 7, 8 to 15, 16 to 23",
        &options.channels,
        {},
        {},
        ChannelOrderNames(),
        "--channels"},
       {"bits",
        "whether a channel's first exposure is its least or most significant bit",
        &options.bits,
        {},
        {},
        BitOrderNames(),
        "--bits"},
       {"there_and_back", "odd strokes show the planes from the front to the back",
        &options.there_and_back}}};
}

StageReport RunFrames(const Workspace& workspace, const FramesOptions& options, StageRun& run,
                      Progress& progress) {
  const LayersRecord record = LoadLayersRecord(workspace);
  const Display& display = record.display;
  if (display.varifocal && options.planes == "one-bit") {
    return RunStrokes(workspace, record, options, run, progress);
  }
  if (record.calibration && options.response != "srgb") {
    throw UsageError("--frames-response", "the layers' calibration says the panels' response",
                     "leave it out");
  }
  int slots = 0, frames = 0;
  for (const Layer& layer : display.layers) {
    const int k = SlotsPerAxis(layer);
    slots += k * k;
    frames += k * k * static_cast<int>(RolesOf(layer).size());
  }
  progress.Start("frames", slots, "slots");
  const OpenEmitters open = OpenEmitterFiles(workspace, display);
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const int layer = static_cast<int>(l), k = SlotsPerAxis(display.layers[l]);
    const PanelResponse response = ResponseOf(options, record, layer);
    ParallelForEach(0, k * k, [&](std::int64_t slot) {
      WriteSlotFrames(open(layer, static_cast<int>(slot)), display, layer, static_cast<int>(slot),
                      response, run.folder(), RowsAtOnce(display));
      progress.Advance();
    });
  }
  WriteTextAtomically(run.folder() / "frames.json", ToJson(record, options).dump(1) + "\n");
  StageReport report;
  report.summary = {
      {"frames", fmt::format("{} of {} x {} px", frames, display.width_px, display.height_px)},
      {"slots", fmt::format("{}", slots)},
      {"response", record.calibration ? "as calibrated" : options.response}};
  return report;
}

}  // namespace lamella
