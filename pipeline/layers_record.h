// W/layers: layers.json (docs/formats.md) and an EXR of emitters per layer and time slot.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "distribute/distribute.h"
#include "distribute/place.h"
#include "lightfield/calibration.h"
#include "lightfield/display.h"
#include "lightfield/image_io.h"
#include "lightfield/image_rows.h"
#include "pipeline/workspace.h"

namespace lamella {

// What frames and preview must know of how the layers were made.
struct LayersRecord {
  Display display;                         // with the border that was used
  std::optional<Calibration> calibration;  // for which they were made; none: as designed
  Placement placement;
  double seen_share = 0;             // of all display rays
  double seen_share_in_picture = 0;  // of those that pass the reference picture on z = 0
};

// layers.json, and calibration.json beside it.
void SaveLayersRecord(const std::filesystem::path& folder, const LayersRecord& record);
// InputError where layers.json is absent, damaged or of a newer version, or its calibration is of
// another display.
LayersRecord LoadLayersRecord(const Workspace& workspace);

// layer_K_slot_T.exr; slot = slots_per_axis * slot_y + slot_x.
std::string EmitterFile(int layer, int slot);
// Half floats R, G, B (linear, not multiplied by coverage) and A (coverage). Radiance beyond a half
// float's range is clamped to it.
void SaveEmitterImage(const std::filesystem::path& folder, int layer, int slot,
                      const EmitterImage& image);
// The same some rows at a time, each as ChannelsOf.
ExrRowsWriter EmitterWriter(const std::filesystem::path& folder, int layer, int slot, int width,
                            int height);
std::vector<Channel> ChannelsOf(const EmitterImage& image);
// A slot's emitters, some rows at a time; InputError where the file's size is not the display's.
class EmitterReader {
 public:
  EmitterReader(const Workspace& workspace, const Display& display, int layer, int slot);
  EmitterImage Read(int first_row, int end_row);

 private:
  std::filesystem::path path_;
  ExrRowsReader file_;
};
EmitterImage LoadEmitterImage(const Workspace& workspace, const Display& display, int layer,
                              int slot);
LayerImages LoadLayerImages(const Workspace& workspace, const LayersRecord& record);

}  // namespace lamella
