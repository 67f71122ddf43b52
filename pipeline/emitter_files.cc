#include "pipeline/emitter_files.h"

#include <utility>

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

double EmitterFiles::Bytes() const {
  // Without threads of its own (image_io.cc) OpenEXR keeps a block of 32 rows, of four half floats
  // a pixel, and what its compressor needs: the same twice and a table.
  constexpr double kBlockRows = 32, kPixelBytes = 8, kCopies = 3, kTableBytes = 1 << 17;
  double files = 0;
  for (const auto& layer : files_) files += static_cast<double>(layer.size());
  return files * (kCopies * kBlockRows * columns_ * kPixelBytes + kTableBytes);
}

}  // namespace lamella
