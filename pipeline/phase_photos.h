// The photographs of a panel's sinusoids from one camera position, as decoding takes them.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calibration/phase.h"
#include "pipeline/check_photos.h"

namespace lamella {

struct PhasePhotoSet {
  std::vector<std::string> names;    // of the files: series by series, then white and black
  std::vector<Image<float>> images;  // likewise
  PhaseCapture capture;              // of `images`
};

// Nothing where a photograph is absent or not good. `read` makes light of one channel of a file,
// from many threads.
std::optional<PhasePhotoSet> ReadPhasePhotos(
    const CheckedPhotos& checked, const std::filesystem::path& folder, int view,
    const CalibratedPanel& panel,
    const std::function<Image<float>(const std::filesystem::path&)>& read);

}  // namespace lamella
