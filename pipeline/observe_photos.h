// From the photographs of a calibration's patterns to what calibration reads.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibration/observations.h"
#include "calibration/screen_map.h"
#include "lightfield/progress.h"
#include "pipeline/check_photos.h"

namespace lamella {

// A camera position whose repeated shot shows that the camera moved there (calibration.md section
// 3).
struct MovedPosition {
  int view = 0;
  double moved_px = 0;
};
std::vector<MovedPosition> MovedPositions(const CheckedPhotos& checked);

// What a panel's sinusoids at a position say, and the names of their photographs; nothing where one
// of them is absent or bad.
struct DecodedPanel {
  ScreenMap map;
  std::vector<std::string> photos;
};
std::optional<DecodedPanel> DecodePanel(const CheckedPhotos& checked,
                                        const std::filesystem::path& folder, int view,
                                        const CalibratedPanel& panel);

// InputError where photographs differ in size.
void CheckOneSize(const CheckedPhotos& checked);

// The corners of all usable photographs of boards; where a position has all sinusoids of a panel,
// the nodes of their map instead, under the name of their first photograph. `photos` is the folder
// that was checked, its photographs of one camera. Positions where the camera moved are left out.
// InputError where photographs differ in size, or no position is left.
Observations ObservePhotos(const CheckedPhotos& checked, const std::filesystem::path& photos,
                           Progress& progress);

}  // namespace lamella
