// From captured photographs to a sparse model: features, exact matches, verification, then mapping
// or, where the cameras are known, triangulation with the cameras held.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "lightfield/progress.h"
#include "pipeline/capture_record.h"
#include "pipeline/poses/colmap.h"
#include "pipeline/poses/model.h"

namespace lamella {

struct ReconstructionOptions {
  ExtractionOptions extraction;
  // Frees the principal points in a second mapping where at least 8 views were all registered.
  bool refine_principal_point = false;
};

struct Reconstruction {
  ColmapModel model;              // images are named by their view
  std::vector<std::string> lost;  // names of views without a pose
  std::vector<std::pair<std::string, std::string>> summary;
  std::vector<std::string> warnings;
};

// Works in `scratch`, which is emptied at the start and gone at the end. InputError where the
// photographs do not overlap, or too little to start; MachineError where COLMAP is absent or fails.
// The same photographs give the same bytes, whatever the number of threads.
Reconstruction Reconstruct(const CaptureRecord& capture, const ReconstructionOptions& options,
                           const std::filesystem::path& scratch, Progress& progress);

}  // namespace lamella
