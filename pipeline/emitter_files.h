// Writes W/layers/layer_K_slot_T.exr as the emitters come, strip by strip.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "distribute/distribute.h"
#include "lightfield/display.h"
#include "lightfield/image_io.h"

namespace lamella {

class EmitterFiles {
 public:
  EmitterFiles(std::filesystem::path folder, const Display& display);
  // Callable from several threads; a slot's rows in their order. Its file appears with the last.
  void Write(const EmitterRows& rows);

  // What the files hold while they are all open, at most.
  double Bytes() const;

 private:
  const std::filesystem::path folder_;
  const int columns_, rows_;
  std::vector<std::vector<std::optional<ExrRowsWriter>>> files_;  // [layer][slot]
};

}  // namespace lamella
