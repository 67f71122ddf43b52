// With image_rows.h, which has some rows at a time, the only place that decodes and encodes image
// files, and so the only place where sRGB becomes linear light and back. Every write is atomic
// (lightfield/atomic_file.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lightfield/image.h"

namespace lamella {

// What a file says of itself without its pixels being read. Width and height are of the upright
// picture, i.e. after the EXIF orientation was applied.
struct ImageInfo {
  std::string format;  // "jpeg", "png", "tiff", "openexr", ...
  int width = 0, height = 0, channels = 0;
  int bits = 8;                                // of a channel
  bool is_float = false;                       // linear by convention (EXR, PFM, float TIFF)
  int orientation = 1;                         // EXIF 1..8
  std::optional<double> focal_mm, focal_35mm;  // EXIF FocalLength, FocalLengthIn35mmFilm
  std::optional<double> sensor_longer_mm;      // from EXIF FocalPlaneXResolution
  std::string camera_maker, camera_model;
};

// Throws InputError naming the file where it is no image, is empty or truncated.
ImageInfo ReadImageInfo(const std::filesystem::path& path);

// Decodes the whole file: InputError where that is not possible (truncated, damaged, a value that
// is not finite), as ReadImage and ReadSrgb8 would.
void CheckImageIsWhole(const std::filesystem::path& path);

// Upright, linear. Integer files are decoded from sRGB, float files are taken as linear.
// Grey is repeated to three channels; an alpha channel is left out (ReadAlpha has it).
// Non-finite values of float files are an InputError.
Image<Rgb> ReadImage(const std::filesystem::path& path);

// Upright, the file's own numbers: integers as shares of their full scale, no curve taken off; of
// linear photographs, whose files do not say that they are.
Image<Rgb> ReadNumbers(const std::filesystem::path& path);

// Upright, as 8-bit sRGB codes: for features, matching costs and metrics.
Image<Rgb8> ReadSrgb8(const std::filesystem::path& path);

// The alpha channel in [0,1], upright; empty where the file has none.
Image<float> ReadAlpha(const std::filesystem::path& path);

// How PNGs are packed. kPhotograph codes runs of what differs from the mean of the neighbours: half
// the time of zlib's fast levels for pictures with noise, to write and to read, and no larger.
// kFast and kSmall look for repetitions, as patterns have them.
enum class PngCoding { kPhotograph, kFast, kSmall };

// The 8-bit sRGB codes that WriteSrgb8 would write.
Image<Rgb8> EncodeSrgb8(ImageSpan<const Rgb> linear);
Image<Rgb> DecodeSrgb8(ImageSpan<const Rgb8> codes);

// PNG, 8 bits, sRGB-encoded; alpha is unassociated and not gamma-encoded.
void WriteSrgb8(const std::filesystem::path& path, ImageSpan<const Rgb> linear);
void WriteSrgb8(const std::filesystem::path& path, ImageSpan<const Rgb> linear,
                ImageSpan<const float> alpha);
// PNG or JPEG of codes that are final.
void WriteCodes8(const std::filesystem::path& path, ImageSpan<const Rgb8> codes,
                 int jpeg_quality = 95, PngCoding coding = PngCoding::kSmall);
// PNG of final codes with an unassociated alpha.
void WriteCodes8(const std::filesystem::path& path, ImageSpan<const Rgb8> codes,
                 ImageSpan<const float> alpha);
// PNG of numbers in [0, 1] that are final, rounded to codes of 8 or 16 bits.
void WriteNumbers(const std::filesystem::path& path, ImageSpan<const Rgb> numbers, int bits);
void WriteGrey8(const std::filesystem::path& path, ImageSpan<const std::uint8_t> codes,
                PngCoding coding = PngCoding::kSmall);

// The bytes of such a file, in memory; `format` is "png" or "jpeg".
std::string EncodeCodes8(ImageSpan<const Rgb8> codes, const std::string& format,
                         int jpeg_quality = 85);

// Named float channels (EXR, 32 or 16 bits).
struct Channel {
  std::string name;
  Image<float> pixels;
};
enum class ExrType { kFloat, kHalf };
// PIZ writes half floats of pictures in a third of ZIP's time and somewhat smaller.
enum class ExrCompression { kNone, kZip, kPiz };
void WriteExr(const std::filesystem::path& path, const std::vector<Channel>& channels, ExrType type,
              ExrCompression compression = ExrCompression::kZip);

std::vector<Channel> ReadExr(const std::filesystem::path& path);
// The channel of that name; InputError where it is absent.
Image<float> TakeChannel(std::vector<Channel>& channels, const std::string& name,
                         const std::filesystem::path& path);

// PFM, one channel; rows are flipped to top-down.
Image<float> ReadPfm(const std::filesystem::path& path);

}  // namespace lamella
