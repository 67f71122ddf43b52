// The stage frames: what each panel shows in each time slot, final codes, and frames.json.
#include <string>
#include <vector>

#include <fmt/format.h>

#include "distribute/emitter_frame.h"
#include "distribute/encode_barrier.h"
#include "distribute/encode_varifocal.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/frames_record.h"
#include "pipeline/layers_record.h"
#include "pipeline/stages.h"

namespace lamella {
namespace {

constexpr int kPngLevel = 1;       // frames are many and shown once
constexpr int kMostStrokes = 256;  // an 8-bit panel's grey

FramesRecord RecordOf(const Display& display, const FramesOptions& options) {
  FramesRecord record;
  record.curve = options.response;
  record.gamma = options.gamma;
  if (!display.varifocal || options.planes == "grey") return record;
  record.strokes = StrokeFrames{options.one_bit_method,
                                options.strokes,
                                static_cast<int>(display.layers.size()),
                                {ChannelOrderOf(options.channel_order),
                                 BitOrderOf(options.bit_order), options.there_and_back},
                                true};
  return record;
}

// A PNG per layer and slot, of lenses the emitters alone. Returns how many.
int WriteLayerFrames(const Workspace& workspace, const Display& display,
                     const FramesOptions& options, const StageRun& run, Progress& progress) {
  const PanelResponse response =
      options.response == "gamma" ? PanelResponse::Gamma(options.gamma) : PanelResponse::Srgb();
  int frames = 0;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const int layer = static_cast<int>(l), k = SlotsPerAxis(display.layers[l]);
    const bool modulated = std::holds_alternative<Barrier>(display.layers[l].optics);
    frames += (modulated ? 2 : 1) * k * k;
    ParallelForEach(0, k * k, [&](std::int64_t s) {
      const int slot = static_cast<int>(s);
      const EmitterImage emitters = LoadEmitterImage(workspace, display, layer, slot);
      WriteCodes8(run.folder() / FrameFile(layer, slot, FrameRole::kEmitter),
                  EmitterFrame(emitters, display, layer, response).span(), 95, kPngLevel);
      if (modulated) {
        WriteGrey8(run.folder() / FrameFile(layer, slot, FrameRole::kModulator),
                   ModulatorFrame(display, layer, slot).span(), kPngLevel);
      }
      progress.Advance();
    });
  }
  return frames;
}

void CheckOneBit(const Display& display) {
  constexpr const char* kFix = "give --frames-planes grey: a frame of 8 bits for every plane";
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

// A packed frame per stroke, and the numerals that tell a projector's packing.
void WriteStrokes(const Workspace& workspace, const Display& display, StrokeFrames& strokes,
                  const StageRun& run, Progress& progress, StageReport& report) {
  CheckOneBit(display);
  CheckStrokes(strokes.strokes, strokes.packing);
  std::vector<Image<float>> grey(display.layers.size());
  ParallelForEach(0, strokes.planes, [&](std::int64_t plane) {
    grey[static_cast<std::size_t>(plane)] =
        GreyOf(LoadEmitterImage(workspace, display, static_cast<int>(plane), 0));
    progress.Advance();
  });
  const BitPlanes bits =
      OneBitPlanes(grey, display, {OneBitMethodOf(strokes.method), strokes.strokes});
  const auto write = [&](const std::string& file, const Image<std::uint32_t>& emitters,
                         int stroke) {
    const Image<std::uint32_t> panel = PanelBits(emitters, display);
    WriteCodes8(run.folder() / file,
                PackedFrame(panel, strokes.planes, stroke, strokes.packing).span(), 95, kPngLevel);
  };
  ParallelForEach(0, strokes.strokes, [&](std::int64_t t) {
    write(StrokeFile(static_cast<int>(t)), bits.strokes[static_cast<std::size_t>(t)],
          static_cast<int>(t));
    progress.Advance();
  });
  strokes.numerals = NumeralsFit(display);
  if (!strokes.numerals) {
    report.warnings.push_back("no numerals.png: the panel has too few lenses to show a number");
    return;
  }
  const Image<std::uint32_t> numerals = NumeralPlanes(display);
  for (int stroke = 0; stroke < NumeralStrokes(strokes); ++stroke) {
    write(NumeralsFile(stroke), numerals, stroke);
  }
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
        "varifocal planes as packed one-bit frames, or as 8-bit frames of their own",
        &options.planes,
        {},
        {},
        {"one-bit", "grey"}},
       {"one_bit_method",
        "how one-bit planes make grey",
        &options.one_bit_method,
        {},
        {},
        OneBitMethodNames()},
       {"strokes", "of the mirror, over which one-bit planes make grey", &options.strokes, 1,
        kMostStrokes},
       {"channel_order",
        "channels in the order in which the projector shows them, eight planes each",
        &options.channel_order,
        {},
        {},
        ChannelOrderNames()},
       {"bit_order",
        "which bit of a channel the projector shows first",
        &options.bit_order,
        {},
        {},
        BitOrderNames()},
       {"there_and_back", "odd strokes show the planes from the front to the back",
        &options.there_and_back}}};
}

StageReport RunFrames(const Workspace& workspace, const FramesOptions& options, StageRun& run,
                      Progress& progress) {
  const Display display = LoadLayersRecord(workspace).display;
  FramesRecord record = RecordOf(display, options);
  StageReport report;
  if (record.strokes) {
    progress.Start("frames", record.strokes->planes + record.strokes->strokes, "planes, strokes");
    WriteStrokes(workspace, display, *record.strokes, run, progress, report);
    report.summary = {
        {"frames",
         fmt::format("{} of {} x {} px, {} planes of one bit in each", record.strokes->strokes,
                     display.width_px, display.height_px, record.strokes->planes)},
        {"grey", fmt::format("{} over {} strokes", options.one_bit_method, options.strokes)},
        {"packing", fmt::format("{}, {}, {}", options.channel_order, options.bit_order,
                                options.there_and_back ? "there and back" : "one way")}};
  } else {
    int slots = 0;
    for (const Layer& layer : display.layers) slots += SlotsPerAxis(layer) * SlotsPerAxis(layer);
    progress.Start("frames", slots, "slots");
    const int frames = WriteLayerFrames(workspace, display, options, run, progress);
    report.summary = {
        {"frames", fmt::format("{} of {} x {} px", frames, display.width_px, display.height_px)},
        {"slots", fmt::format("{}", slots)},
        {"response", options.response}};
  }
  SaveFramesRecord(run.folder(), display, record);
  return report;
}

}  // namespace lamella
