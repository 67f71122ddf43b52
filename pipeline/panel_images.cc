#include "pipeline/panel_images.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "distribute/encode_varifocal.h"
#include "distribute/one_bit.h"
#include "distribute/panel_pixels-inl.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/frames_record.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Light = std::array<float, 256>;  // of every code

Light ResponseOf(const JsonObject& response) {
  Light light{};
  if (response.Text("curve") == "gamma") {
    const double gamma = response.Number("gamma");
    for (std::size_t code = 0; code < light.size(); ++code) {
      light[code] = static_cast<float>(std::pow(static_cast<double>(code) / 255, gamma));
    }
    return light;
  }
  Image<Rgb8> ramp(256, 1);
  for (int code = 0; code < 256; ++code) ramp(code, 0).r = static_cast<std::uint8_t>(code);
  const Image<Rgb> linear = DecodeSrgb8(ramp.span());
  for (int code = 0; code < 256; ++code) light[static_cast<std::size_t>(code)] = linear(code, 0).r;
  return light;
}

Image<Rgb8> ReadPanel(const Display& display, const fs::path& file) {
  Image<Rgb8> codes = ReadSrgb8(file);
  if (codes.width() != display.width_px || codes.height() != display.height_px) {
    throw InputError(file.string(),
                     fmt::format("is {} x {} px, the panel {} x {}", codes.width(), codes.height(),
                                 display.width_px, display.height_px),
                     "run `lamella frames` again");
  }
  return codes;
}

EmitterImage LoadPanel(const Workspace& workspace, const Display& display, int layer, int slot,
                       const fs::path& file, const Light& light) {
  EmitterImage emitters = LoadEmitterImage(workspace, display, layer, slot);
  const Image<Rgb8> panel = ReadPanel(display, file);
  const Image<Rgb8> codes = EmittersFromPanel<Rgb8>(
      display, display.layers[static_cast<std::size_t>(layer)], panel.span());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const Rgb8& code = codes.data()[i];
    emitters.color.data()[i] = {light[code.r], light[code.g], light[code.b]};
  }
  return emitters;
}

// The mean over the strokes, which is what an eye adds up.
LayerImages LoadStrokes(const Workspace& workspace, const Display& display,
                        const StrokeFrames& strokes) {
  const fs::path folder = workspace.Stage("frames");
  BitPlanes bits{strokes.planes, {}};
  bits.strokes.resize(static_cast<std::size_t>(strokes.strokes));
  ParallelForEach(0, strokes.strokes, [&](std::int64_t t) {
    const int stroke = static_cast<int>(t);
    const Image<Rgb8> frame = ReadPanel(display, folder / StrokeFile(stroke));
    bits.strokes[static_cast<std::size_t>(t)] =
        EmitterBits(UnpackedFrame(frame.span(), strokes.planes, stroke, strokes.packing), display);
  });
  LayerImages images;
  images.slots.resize(display.layers.size());
  ParallelForEach(0, strokes.planes, [&](std::int64_t plane) {
    EmitterImage emitters = LoadEmitterImage(workspace, display, static_cast<int>(plane), 0);
    const Image<float> mean = MeanOfStrokes(bits, static_cast<int>(plane));
    for (std::size_t i = 0; i < mean.size(); ++i) {
      emitters.color.data()[i] = {mean.data()[i], mean.data()[i], mean.data()[i]};
    }
    images.slots[static_cast<std::size_t>(plane)].push_back(std::move(emitters));
  });
  return images;
}

}  // namespace

LayerImages LoadPanelImages(const Workspace& workspace, const LayersRecord& record) {
  const fs::path folder = workspace.Stage("frames");
  const JsonObject json(folder / "frames.json");
  json.CheckFormatVersion(1);
  if (const std::optional<StrokeFrames> strokes = LoadStrokeFrames(folder)) {
    if (static_cast<std::size_t>(strokes->planes) != record.display.layers.size()) {
      throw json.Wrong("strokes", fmt::format("{} planes", record.display.layers.size()));
    }
    LayerImages images = LoadStrokes(workspace, record.display, *strokes);
    images.seen_share = record.seen_share;
    return images;
  }
  const Light light = ResponseOf(json.Object("response"));
  LayerImages images;
  images.seen_share = record.seen_share;
  const std::vector<JsonObject> layers = json.Objects("layers");
  if (layers.size() != record.display.layers.size()) {
    throw json.Wrong("layers", fmt::format("{} layers", record.display.layers.size()));
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const int k = SlotsPerAxis(record.display.layers[l]);
    std::vector<fs::path> files(static_cast<std::size_t>(k * k));
    for (const JsonObject& frame : layers[l].Objects("frames")) {
      if (frame.Text("role") != "emitter") continue;
      files[static_cast<std::size_t>(frame.Whole("slot", 0, k * k - 1))] =
          folder / frame.Text("file");
    }
    images.slots.emplace_back(files.size());
    ParallelForEach(0, k * k, [&](std::int64_t s) {
      const std::size_t slot = static_cast<std::size_t>(s);
      images.slots[l][slot] = LoadPanel(workspace, record.display, static_cast<int>(l),
                                        static_cast<int>(s), files[slot], light);
    });
  }
  return images;
}

}  // namespace lamella
