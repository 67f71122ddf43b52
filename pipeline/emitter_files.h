// Writes W/layers/layer_K_slot_T.exr as the emitters come, strip by strip, and reads them by rows.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "distribute/distribute.h"
#include "distribute/emitter_strip.h"
#include "lightfield/display.h"
#include "lightfield/image_rows.h"
#include "pipeline/workspace.h"

namespace lamella {

// What the files of all slots hold while they are open to be written, or read, at most.
double BytesOfOpenFiles(const Display& display);

// The files of W/layers; refers to both. InputError where one can't be read.
OpenEmitters OpenEmitterFiles(const Workspace& workspace, const Display& display);

class EmitterFiles {
 public:
  EmitterFiles(std::filesystem::path folder, const Display& display);
  // Callable from several threads; a slot's rows in their order. Its file appears with the last.
  void Write(const EmitterRows& rows);

 private:
  const std::filesystem::path folder_;
  const int columns_, rows_;
  std::vector<std::vector<std::optional<ExrRowsWriter>>> files_;  // [layer][slot]
};

}  // namespace lamella
