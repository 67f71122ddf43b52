#include "tests/lightfield/raw_image_files.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

namespace lamella {
namespace {

std::string BigEndian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 255U);
  return text;
}

std::uint32_t Crc32(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1U ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

std::uint32_t Adler32(const std::string& bytes) {
  std::uint32_t a = 1, b = 0;
  for (const char byte : bytes) {
    a = (a + static_cast<std::uint8_t>(byte)) % 65521;
    b = (b + a) % 65521;
  }
  return b << 16 | a;
}

// zlib's format with stored blocks.
std::string Stored(const std::string& bytes) {
  std::string stream = "\x78\x01";
  for (std::size_t at = 0; at < bytes.size(); at += 65535) {
    const std::size_t length = std::min<std::size_t>(65535, bytes.size() - at);
    const auto little = [&](std::size_t v) {
      stream += static_cast<char>(v & 255U);
      stream += static_cast<char>(v >> 8 & 255U);
    };
    stream += at + length == bytes.size() ? '\1' : '\0';
    little(length);
    little(~length);
    stream += bytes.substr(at, length);
  }
  return stream + BigEndian(Adler32(bytes), 4);
}

std::string Chunk(const std::string& kind, const std::string& data) {
  return BigEndian(static_cast<std::uint32_t>(data.size()), 4) + kind + data +
         BigEndian(Crc32(kind + data), 4);
}

// A TIFF directory entry, big endian; types: 3 short, 4 long, 5 rational (value: its offset).
std::string Entry(std::uint32_t tag, std::uint32_t type, std::uint32_t value) {
  const std::string field = type == 3 ? BigEndian(value, 2) + BigEndian(0, 2) : BigEndian(value, 4);
  return BigEndian(tag, 2) + BigEndian(type, 2) + BigEndian(1, 4) + field;
}

}  // namespace

std::string RawPng(int width, int height, int channels, int bits,
                   const std::vector<std::uint16_t>& samples) {
  constexpr int kColorTypes[] = {0, 0, 4, 2, 6};
  std::string header = BigEndian(static_cast<std::uint32_t>(width), 4) +
                       BigEndian(static_cast<std::uint32_t>(height), 4);
  for (const int byte : {bits, kColorTypes[channels], 0, 0, 0}) header += static_cast<char>(byte);
  std::string rows;
  std::size_t next = 0;
  for (int y = 0; y < height; ++y) {
    rows += '\0';  // no filter
    for (int i = 0; i < width * channels; ++i) rows += BigEndian(samples.at(next++), bits / 8);
  }
  return "\x89PNG\r\n\x1a\n" + Chunk("IHDR", header) + Chunk("IDAT", Stored(rows)) +
         Chunk("IEND", "");
}

std::string WithExif(const std::string& jpeg, int orientation, double focal_mm, int focal_35mm) {
  // Header (8), directory 0 with orientation and a pointer (2 + 24 + 4), the EXIF directory
  // (2 + 24 + 4), a rational.
  const std::uint32_t exif_at = 38, rational_at = 68;
  std::string tiff = "MM" + BigEndian(42, 2) + BigEndian(8, 4);
  tiff += BigEndian(2, 2) + Entry(0x0112, 3, static_cast<std::uint32_t>(orientation)) +
          Entry(0x8769, 4, exif_at) + BigEndian(0, 4);
  tiff += BigEndian(focal_35mm > 0 ? 2 : 1, 2) + Entry(0x920A, 5, rational_at);
  tiff += focal_35mm > 0 ? Entry(0xA405, 3, static_cast<std::uint32_t>(focal_35mm))
                         : std::string(12, '\0');
  tiff += BigEndian(0, 4);
  tiff += BigEndian(static_cast<std::uint32_t>(std::lround(focal_mm * 100)), 4) + BigEndian(100, 4);
  const std::string segment = std::string("Exif\0\0", 6) + tiff;
  return jpeg.substr(0, 2) + "\xFF\xE1" +
         BigEndian(static_cast<std::uint32_t>(segment.size() + 2), 2) + segment + jpeg.substr(2);
}

void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

}  // namespace lamella
