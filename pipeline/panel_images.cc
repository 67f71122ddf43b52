#include "pipeline/panel_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets_synthetic/prototype.h"
#include "distribute/panel_pixels-inl.h"
#include "distribute/panel_response.h"
#include "lightfield/image_io.h"
#include "lightfield/image_rows.h"
#include "pipeline/emitter_files.h"
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

// Rows of a panel's frame, with the coverage of the layers' emitters. A calibrated panel is decoded
// whole: its pixels give light to each other, and where they lie says how bright they are.
class PanelRows {
 public:
  PanelRows(const ReadEmitterRows& emitters, const Display& display, int layer,
            const fs::path& frame, Decode decode, bool is_calibrated)
      : emitters_(emitters),
        display_(display),
        layer_(display.layers[static_cast<std::size_t>(layer)]),
        frame_(OpenFrame(frame, display)),
        decode_(std::move(decode)),
        is_calibrated_(is_calibrated) {}

  EmitterImage Read(int first_row, int end_row) {
    EmitterImage emitters = emitters_(first_row, end_row);
    if (is_calibrated_) {
      if (whole_.empty()) whole_ = Decoded(0, display_.emitter_rows());
      std::copy_n(whole_.row(first_row), emitters.color.size(), emitters.color.data());
    } else {
      emitters.color = Decoded(first_row, end_row);
    }
    return emitters;
  }

 private:
  Image<Rgb> Decoded(int first_row, int end_row) {
    const int binning = display_.binning_px;
    const Image<Rgb> light = decode_(frame_.Read(first_row * binning, end_row * binning).span());
    return EmittersFromPanel<Rgb>(display_, layer_, light.span());
  }

  const ReadEmitterRows emitters_;
  const Display& display_;
  const Layer& layer_;
  CodeRowsReader frame_;
  const Decode decode_;
  const bool is_calibrated_;
  Image<Rgb> whole_;
};

OpenEmitters OpenStrokes(const OpenEmitters& emitters, const fs::path& folder,
                         const StrokeFrames& frames, const Display& display) {
  const auto counts = std::make_shared<const std::vector<Image<std::uint16_t>>>(
      CountStrokes(folder, frames, display));
  return [=, shares = SharesOfStrokes(frames)](int plane, int slot) -> ReadEmitterRows {
    return [=, read = emitters(plane, slot)](int first_row, int end_row) {
      EmitterImage image = read(first_row, end_row);
      const Image<std::uint16_t>& of_plane = (*counts)[static_cast<std::size_t>(plane)];
      const std::uint16_t* count = of_plane.row(first_row);
      for (std::size_t i = 0; i < image.color.size(); ++i) {
        const float light = shares[count[i]];
        image.color.data()[i] = {light, light, light};
      }
      return image;
    };
  };
}

// What frames.json says of a layer's emissive frames, by slot.
struct LayerFrames {
  std::vector<fs::path> files;
  Decode decode;
};

std::vector<LayerFrames> FramesOf(const fs::path& folder, const LayersRecord& record,
                                  const JsonObject& json) {
  const std::vector<JsonObject> layers = json.Objects("layers");
  if (layers.size() != record.display.layers.size()) {
    throw json.Wrong("layers", fmt::format("{} layers", record.display.layers.size()));
  }
  std::vector<LayerFrames> frames(layers.size());
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const int k = SlotsPerAxis(record.display.layers[l]);
    frames[l].files.resize(static_cast<std::size_t>(k) * static_cast<std::size_t>(k));
    for (const JsonObject& frame : layers[l].Objects("frames")) {
      if (frame.Text("role") != "emitter") continue;
      frames[l].files[static_cast<std::size_t>(frame.Whole("slot", 0, k * k - 1))] =
          folder / frame.Text("file");
    }
    frames[l].decode = DecoderOf(record, static_cast<int>(l), json);
  }
  return frames;
}

}  // namespace

PanelImages OpenPanelImages(const Workspace& workspace, const LayersRecord& record) {
  const fs::path folder = workspace.Stage("frames");
  const JsonObject json(folder / "frames.json");
  json.CheckFormatVersion(1);
  const Display& display = record.display;
  const OpenEmitters emitters = OpenEmitterFiles(workspace, display);
  if (const auto strokes = LoadStrokeFrames(folder, display)) {
    return {OpenStrokes(emitters, folder, *strokes, display), true};
  }
  const auto open = [emitters, &display, is_calibrated = record.calibration.has_value(),
                     frames = FramesOf(folder, record, json)](int layer,
                                                              int slot) -> ReadEmitterRows {
    const LayerFrames& of_layer = frames[static_cast<std::size_t>(layer)];
    const auto rows = std::make_shared<PanelRows>(emitters(layer, slot), display, layer,
                                                  of_layer.files[static_cast<std::size_t>(slot)],
                                                  of_layer.decode, is_calibrated);
    return [rows](int first_row, int end_row) { return rows->Read(first_row, end_row); };
  };
  return {open, false};
}

}  // namespace lamella
