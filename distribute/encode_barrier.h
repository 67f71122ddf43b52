// What a parallax barrier's modulator shows, and in which order (displays.md section 2). Its
// emissive panel's frames are any layer's (distribute/emitter_frame.h).
#pragma once

#include <cstdint>
#include <vector>

#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// The order in which the k x k slots are shown, as file numbers k * slot_y + slot_x: at time t slot
// (t mod k, (t + floor(t/k)) mod k). Any k consecutive ones touch every row and column of slots.
std::vector<int> SlotOrder(int slots_per_axis);

// As final as the emitters' frame: 255 where the modulator is open, 0 elsewhere; of the rows of
// elements [first_row, end_row). UsageError where the layer has no barrier.
Image<std::uint8_t> ModulatorFrame(const Display& display, int layer, int slot, int first_row,
                                   int end_row);
Image<std::uint8_t> ModulatorFrame(const Display& display, int layer, int slot);  // of all rows

}  // namespace lamella
