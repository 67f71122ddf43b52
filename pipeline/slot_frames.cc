#include "pipeline/slot_frames.h"

#include <algorithm>
#include <optional>
#include <variant>

#include <fmt/format.h>

#include "distribute/emitter_frame.h"
#include "distribute/encode_barrier.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"

namespace lamella {

std::string FrameFile(int layer, int slot, const char* role) {
  return fmt::format("layer_{}_slot_{}_{}.png", layer, slot, role);
}

std::vector<const char*> RolesOf(const Layer& layer) {
  if (std::holds_alternative<Barrier>(layer.optics)) return {"emitter", "modulator"};
  return {"emitter"};
}

CodeRowsReader OpenFrame(const std::filesystem::path& file, const Display& display) {
  CodeRowsReader codes(file);
  if (codes.width() != display.width_px || codes.height() != display.height_px) {
    throw InputError(file.string(),
                     fmt::format("is {} x {} px, the panel {} x {}", codes.width(), codes.height(),
                                 display.width_px, display.height_px),
                     "run `lamella frames` again");
  }
  return codes;
}

Image<Rgb8> ReadFrame(const std::filesystem::path& file, const Display& display) {
  return OpenFrame(file, display).Read(0, display.height_px);
}

int RowsAtOnce(const Display& display) {
  constexpr int kPixels = 1 << 18, kBlock = 32;
  return std::max(1, kPixels / display.width_px / display.binning_px / kBlock) * kBlock;
}

void WriteSlotFrames(const ReadEmitterRows& emitters, const Display& display, int layer, int slot,
                     const PanelResponse& response, const std::filesystem::path& folder,
                     int rows_at_once) {
  PngRowsWriter emitter(folder / FrameFile(layer, slot, "emitter"), display.width_px,
                        display.height_px, 3, PngCoding::kPhotograph);
  std::optional<PngRowsWriter> modulator;
  if (RolesOf(display.layers[static_cast<std::size_t>(layer)]).size() == 2) {
    modulator.emplace(folder / FrameFile(layer, slot, "modulator"), display.width_px,
                      display.height_px, 1, PngCoding::kFast);
  }
  for (int row = 0; row < display.emitter_rows(); row += rows_at_once) {
    const int end = std::min(row + rows_at_once, display.emitter_rows());
    emitter.Write(EmitterFrame(emitters(row, end), display, layer, response, row));
    if (modulator) modulator->Write(ModulatorFrame(display, layer, slot, row, end));
  }
  emitter.Close();
  if (modulator) modulator->Close();
}

}  // namespace lamella
