// Whether an image file is there to its end. Decoders are no judges of that: libjpeg pads a cut
// file with grey and calls that a warning.
#pragma once

#include <string>
#include <string_view>

namespace lamella {

// Whether WhyNotWhole looks beyond a file's first bytes, of which 8 are enough to tell.
bool EndIsLookedAt(std::string_view first_bytes);

// Why a JPEG or PNG file is not whole ("the JPEG is truncated"); empty where it is, and for all
// other formats, whose decoders tell.
std::string WhyNotWhole(std::string_view bytes);

}  // namespace lamella
