#include "pipeline/panel_images.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "datasets_synthetic/prototype.h"
#include "distribute/panel_pixels-inl.h"
#include "distribute/panel_response.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/json_file.h"
#include "pipeline/slot_frames.h"
#include "pipeline/varifocal_frames.h"

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

// The scene's light that a panel's codes stand for.
using Decode = std::function<Image<Rgb>(ImageSpan<const Rgb8>)>;

Decode DecoderOf(const LayersRecord& record, int layer, const JsonObject& frames) {
  if (!record.calibration) {
    return [light = ResponseOf(frames.Object("response"))](ImageSpan<const Rgb8> codes) {
      Image<Rgb> decoded(codes.width, codes.height);
      for (int y = 0; y < codes.height; ++y) {
        for (int x = 0; x < codes.width; ++x) {
          const Rgb8& code = codes(x, y);
          decoded(x, y) = {light[code.r], light[code.g], light[code.b]};
        }
      }
      return decoded;
    };
  }
  const LayerCalibration& of = record.calibration->layers[static_cast<std::size_t>(layer)];
  const auto scale = static_cast<float>(of.gain / CommonWhite(*record.calibration));
  return [&of, scale](ImageSpan<const Rgb8> codes) {
    Image<Rgb> decoded = LightOfEmitter(of.emitter, codes);
    for (std::size_t i = 0; i < decoded.size(); ++i) {
      decoded.data()[i] = scale * decoded.data()[i];
    }
    return decoded;
  };
}

EmitterImage LoadPanel(const Workspace& workspace, const Display& display, int layer, int slot,
                       const fs::path& file, const Decode& decode) {
  EmitterImage emitters = LoadEmitterImage(workspace, display, layer, slot);
  const Image<Rgb> light = decode(ReadFrame(file, display).span());
  emitters.color = EmittersFromPanel<Rgb>(display, display.layers[static_cast<std::size_t>(layer)],
                                          light.span());
  return emitters;
}

LayerImages LoadStrokes(const Workspace& workspace, const LayersRecord& record,
                        const StrokeFrames& frames) {
  const std::vector<Image<float>> grey =
      ReadStrokeFrames(workspace.Stage("frames"), frames, record.display);
  LayerImages images = LoadLayerImages(workspace, record);  // for their coverage
  for (std::size_t plane = 0; plane < grey.size(); ++plane) {
    Image<Rgb>& color = images.slots[plane][0].color;
    for (std::size_t i = 0; i < color.size(); ++i) {
      const float light = grey[plane].data()[i];
      color.data()[i] = {light, light, light};
    }
  }
  return images;
}

}  // namespace

PanelImages LoadPanelImages(const Workspace& workspace, const LayersRecord& record) {
  const fs::path folder = workspace.Stage("frames");
  const JsonObject json(folder / "frames.json");
  json.CheckFormatVersion(1);
  if (const auto strokes = LoadStrokeFrames(folder, record.display)) {
    return {LoadStrokes(workspace, record, *strokes), true};
  }
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
    const Decode decode = DecoderOf(record, static_cast<int>(l), json);
    ParallelForEach(0, k * k, [&](std::int64_t s) {
      const std::size_t slot = static_cast<std::size_t>(s);
      images.slots[l][slot] = LoadPanel(workspace, record.display, static_cast<int>(l),
                                        static_cast<int>(s), files[slot], decode);
    });
  }
  return {std::move(images), false};
}

}  // namespace lamella
