// Image files made by hand, byte by byte: truth that no image library has touched.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lamella {

// A PNG of uncompressed blocks; `samples` by rows, channels interleaved, 8 or 16 bits each.
std::string RawPng(int width, int height, int channels, int bits,
                   const std::vector<std::uint16_t>& samples);

// A JPEG's bytes with an EXIF segment put in: orientation, focal length in mm and its 35 mm
// equivalent (0: left out).
std::string WithExif(const std::string& jpeg, int orientation, double focal_mm, int focal_35mm);

void WriteBytes(const std::filesystem::path& path, const std::string& bytes);
std::string ReadBytes(const std::filesystem::path& path);

}  // namespace lamella
