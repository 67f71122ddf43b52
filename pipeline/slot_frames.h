// The frames of a layer's panels in one time slot, in W/frames: made by rows, since a slot of a
// large display is larger than memory.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "distribute/emitter_strip.h"
#include "distribute/panel_response.h"
#include "lightfield/display.h"
#include "lightfield/image.h"
#include "lightfield/image_rows.h"

namespace lamella {

// layer_K_slot_T_ROLE.png
std::string FrameFile(int layer, int slot, const char* role);

// "emitter" and, where the layer has one, "modulator". Lenses have none.
std::vector<const char*> RolesOf(const Layer& layer);

// The codes of a file of W/frames. InputError where it can't be read or is not of the panel's size.
Image<Rgb8> ReadFrame(const std::filesystem::path& file, const Display& display);
// The same by rows.
CodeRowsReader OpenFrame(const std::filesystem::path& file, const Display& display);

// Rows of emitters to hold at once: a quarter of a million panel pixels, some 13 MB with what
// decoding needs, but at least 32 rows, since an EXR is compressed in blocks of these.
int RowsAtOnce(const Display& display);

// Asks for `rows_at_once` rows of emitters at a time (fewer at the end), from the top and each
// once; the files are the same for any. Where `emitters` throws, no file is left.
void WriteSlotFrames(const ReadEmitterRows& emitters, const Display& display, int layer, int slot,
                     const PanelResponse& response, const std::filesystem::path& folder,
                     int rows_at_once);

}  // namespace lamella
