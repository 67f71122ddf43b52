#include "pipeline/emitter_files.h"

#include <memory>
#include <utility>

#include "distribute/strips.h"
#include "pipeline/layers_record.h"

namespace lamella {

EmitterFiles::EmitterFiles(std::filesystem::path folder, const Display& display)
    : folder_(std::move(folder)),
      columns_(display.emitter_columns()),
      rows_(display.emitter_rows()) {
  for (const Layer& layer : display.layers) {
    const int k = SlotsPerAxis(layer);
    files_.emplace_back(static_cast<std::size_t>(k * k));
  }
}

void EmitterFiles::Write(const EmitterRows& rows) {
  std::optional<ExrRowsWriter>& file =
      files_[static_cast<std::size_t>(rows.layer)][static_cast<std::size_t>(rows.slot)];
  if (!file) file.emplace(EmitterWriter(folder_, rows.layer, rows.slot, columns_, rows_));
  file->Write(ChannelsOf(rows.emitters));
  if (rows.first_row + rows.emitters.color.height() < rows_) return;
  file->Close();
  file.reset();
}

double BytesOfOpenFiles(const Display& display) {
  // Without threads of its own (image_io.cc) OpenEXR keeps a block of 32 rows, of four half floats
  // a pixel, and what its compressor needs: the same twice and a table.
  constexpr double kPixelBytes = 8, kCopies = 3, kTableBytes = 1 << 17;
  double files = 0;
  for (const Layer& layer : display.layers) files += SlotsPerAxis(layer) * SlotsPerAxis(layer);
  return files * (kCopies * kBlockRows * display.emitter_columns() * kPixelBytes + kTableBytes);
}

OpenEmitters OpenEmitterFiles(const Workspace& workspace, const Display& display) {
  return [&](int layer, int slot) -> ReadEmitterRows {
    const auto file = std::make_shared<EmitterReader>(workspace, display, layer, slot);
    return [file](int first_row, int end_row) { return file->Read(first_row, end_row); };
  };
}

}  // namespace lamella
