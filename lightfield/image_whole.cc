#include "lightfield/image_whole.h"

#include <cstddef>
#include <cstdint>

namespace lamella {
namespace {

std::size_t BigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  }
  return value;
}

// Where the next marker's code stands at or after `at`; within a scan, FF 00 is a data byte and
// FF D0..D7 are restarts (ITU-T T.81 section B.1.1). npos where there is none.
std::size_t NextMarker(std::string_view bytes, std::size_t at) {
  for (at = bytes.find('\xFF', at); at != std::string_view::npos && at + 1 < bytes.size();
       at = bytes.find('\xFF', at + 1)) {
    const auto code = static_cast<std::uint8_t>(bytes[at + 1]);
    if (code != 0x00 && code != 0xFF && (code < 0xD0 || code > 0xD7)) return at + 1;
  }
  return std::string_view::npos;
}

// Segments are skipped by their length, so that a thumbnail's end is not taken for the image's.
bool IsWholeJpeg(std::string_view bytes) {
  constexpr std::uint8_t kStart = 0xD8, kEnd = 0xD9, kTemporary = 0x01;
  std::size_t at = 0;
  while ((at = NextMarker(bytes, at)) != std::string_view::npos) {
    const auto code = static_cast<std::uint8_t>(bytes[at]);
    ++at;
    if (code == kEnd) return true;
    if (code == kStart || code == kTemporary) continue;
    if (at + 2 > bytes.size()) return false;
    at += BigEndian(bytes, at, 2);
  }
  return false;
}

bool IsWholePng(std::string_view bytes) {
  std::size_t at = 8;
  while (at + 12 <= bytes.size()) {
    const std::size_t length = BigEndian(bytes, at, 4);
    if (length > bytes.size() - at - 12) return false;
    if (bytes.substr(at + 4, 4) == "IEND") return true;
    at += 12 + length;
  }
  return false;
}

bool IsJpeg(std::string_view bytes) { return bytes.substr(0, 2) == "\xFF\xD8"; }
bool IsPng(std::string_view bytes) { return bytes.substr(0, 8) == "\x89PNG\r\n\x1a\n"; }

}  // namespace

bool EndIsLookedAt(std::string_view first_bytes) {
  return IsJpeg(first_bytes) || IsPng(first_bytes);
}

std::string WhyNotWhole(std::string_view bytes) {
  if (bytes.empty()) return "the file is empty";
  if (IsJpeg(bytes) && !IsWholeJpeg(bytes)) return "the JPEG is truncated";
  if (IsPng(bytes) && !IsWholePng(bytes)) return "the PNG is truncated";
  return "";
}

}  // namespace lamella
