// The frames of a varifocal display's projector: up to 24 planes of one bit in the bits of one RGB
// frame a stroke (displays.md section 5). Frames are final: any scaling, gamma, dithering or lossy
// codec on the way to the projector mixes planes and views.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "distribute/one_bit.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// Which channel carries exposures 0-7, which 8-15, which 16-23. TI's DLPC300 projectors at 1440 Hz
// (the Light Commander's successors) start with blue, then red, then green; others differ.
enum class ChannelOrder { kRgb, kRbg, kGrb, kGbr, kBrg, kBgr };
// Whether the first of a channel's eight is its least or its most significant bit.
enum class BitOrder { kLsbFirst, kMsbFirst };

struct PlanePacking {
  ChannelOrder channels = ChannelOrder::kBrg;
  BitOrder bits = BitOrder::kLsbFirst;
  // Odd strokes show the planes from the front to the back (distribute/stroke_order.h). Off: the
  // mirror flies back unseen.
  bool there_and_back = true;

  friend bool operator==(const PlanePacking&, const PlanePacking&) = default;
};

std::vector<std::string> ChannelOrderNames();  // "RGB", "RBG", "GRB", "GBR", "BRG", "BGR"
std::vector<std::string> BitOrderNames();      // "lsb-first", "msb-first"
std::string NameOf(ChannelOrder order);
std::string NameOf(BitOrder order);
// UsageError with the nearest name where there is none such.
ChannelOrder ChannelOrderOf(std::string_view name);
BitOrder BitOrderOf(std::string_view name);

// The panel's pixels from its emitters: each fills its bin; flipped in x where the layers are seen
// by reflection. The values are bit planes.
Image<std::uint32_t> PanelBits(const Image<std::uint32_t>& emitters, const Display& display);
// Back from them.
Image<std::uint32_t> EmitterBits(const Image<std::uint32_t>& panel, const Display& display);

// One stroke's frame from bits by plane (bit k: plane k, 0 at the back), and back. `planes` are 1
// to kMaxBitPlanes; the bits of planes beyond it are 0. Unpacked bits beyond `planes` must be 0:
// InputError "a frame ..." where they are not, the sign of another packing.
Image<Rgb8> PackedFrame(const Image<std::uint32_t>& bits, int planes, int stroke,
                        const PlanePacking& packing);
Image<std::uint32_t> UnpackedFrame(ImageSpan<const Rgb8> frame, int planes, int stroke,
                                   const PlanePacking& packing);

// Strokes are to be repeated, so there and back takes an even number of them: UsageError otherwise
// (depth would be mirrored in every other repeat).
void CheckStrokes(int strokes, const PlanePacking& packing);
// A stroke's frame, of the panel's size.
Image<Rgb8> PackedStroke(const BitPlanes& bits, int stroke, const Display& display,
                         const PlanePacking& packing);

// For finding out a projector's packing: plane k shows the number k, each at a place of its own, in
// reading order, through the lit emitters only. Bits by plane of the emitters (for PanelBits).
// UsageError where the numbers do not fit, or for more than kMaxBitPlanes.
Image<std::uint32_t> NumeralPlanes(const Display& display);
// Whether the panel has lenses enough to tell the numbers: one across a numeral's square.
bool NumeralsFit(const Display& display);

}  // namespace lamella
