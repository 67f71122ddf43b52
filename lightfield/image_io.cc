#include "lightfield/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_file-inl.h"
#include "lightfield/image_rows.h"
#include "lightfield/large_pages.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

bool SwapsAxes(int orientation) { return orientation >= 5; }

// Through ImageInput and not by ImageBuf's own reading, whose cache may hold an older file of that
// name.
OIIO::ImageBuf ReadPixels(const fs::path& path, OIIO::TypeDesc type) {
  const std::unique_ptr<OIIO::ImageInput> input = OpenImage(path);
  OIIO::ImageSpec spec = input->spec();
  if (type != OIIO::TypeDesc::UNKNOWN) spec.set_format(type);
  OIIO::ImageBuf buffer(spec, OIIO::InitializePixels::No);
  UseLargePages(buffer.localpixels(), spec.image_bytes());
  if (!input->read_image(0, 0, 0, spec.nchannels, spec.format, buffer.localpixels())) {
    throw UnreadableImage(path, input->geterror());
  }
  return buffer;
}

// By the table of the EXIF standard. OpenImageIO 2.4 takes 5 and 7 for each other.
OIIO::ImageBuf Upright(const OIIO::ImageBuf& stored) {
  switch (stored.orientation()) {
    case 2:
      return OIIO::ImageBufAlgo::flop(stored);
    case 3:
      return OIIO::ImageBufAlgo::rotate180(stored);
    case 4:
      return OIIO::ImageBufAlgo::flip(stored);
    case 5:
      return OIIO::ImageBufAlgo::transpose(stored);
    case 6:
      return OIIO::ImageBufAlgo::rotate90(stored);
    case 7:
      return OIIO::ImageBufAlgo::rotate180(OIIO::ImageBufAlgo::transpose(stored));
    case 8:
      return OIIO::ImageBufAlgo::rotate270(stored);
    default:
      return stored;
  }
}

OIIO::ImageBuf ReadUpright(const fs::path& path, OIIO::TypeDesc type) {
  OIIO::ImageBuf buffer = ReadPixels(path, type);
  const OIIO::ROI picture = PictureWindow(buffer.spec());
  if (buffer.roi() != picture) buffer = OIIO::ImageBufAlgo::crop(buffer, picture);
  return buffer.orientation() == 1 ? buffer : Upright(buffer);
}

// The longer side of the sensor, from the resolution in its plane. That counts pixels as they were
// taken: a picture made smaller since keeps the entry.
std::optional<double> SensorLongerSide(const OIIO::ImageSpec& spec) {
  const double per_unit =
      static_cast<double>(spec.get_float_attribute("Exif:FocalPlaneXResolution", 0.0F));
  const int unit = spec.get_int_attribute("Exif:FocalPlaneResolutionUnit", 2);
  const double unit_mm = unit == 3 ? 10.0 : unit == 4 ? 1.0 : unit == 5 ? 0.001 : 25.4;
  const int pixels = std::max(spec.get_int_attribute("Exif:PixelXDimension", spec.width),
                              spec.get_int_attribute("Exif:PixelYDimension", spec.height));
  if (!(per_unit > 0) || pixels < 1) return std::nullopt;
  return pixels / per_unit * unit_mm;
}

// Srgb8ToLinear at hand: a call per value would take longer than the value.
std::array<float, 256> LinearOfCodes() {
  std::array<float, 256> linear{};
  for (std::size_t code = 0; code < linear.size(); ++code)
    linear[code] = Srgb8ToLinear(static_cast<std::uint8_t>(code));
  return linear;
}

// Pixels of the first three channels (grey repeated), with `convert` from T to Out::channel.
template <class T, class Out, class Convert>
Image<Out> ToImage(const OIIO::ImageBuf& buffer, Convert convert) {
  const int width = buffer.spec().width, height = buffer.spec().height;
  const int channels = buffer.nchannels();
  const bool grey = channels < 3;
  const bool as_stored =
      buffer.localpixels() && buffer.spec().format == OIIO::TypeDescFromC<T>::value();
  std::vector<T> converted(static_cast<std::size_t>(width) * static_cast<std::size_t>(channels));
  Image<Out> image(width, height);
  for (int y = 0; y < height; ++y) {
    const int x0 = buffer.spec().x, y0 = buffer.spec().y + y;
    const T* p = converted.data();
    if (as_stored) {
      p = static_cast<const T*>(buffer.pixeladdr(x0, y0));
    } else {
      buffer.get_pixels(OIIO::ROI(x0, x0 + width, y0, y0 + 1, 0, 1, 0, channels),
                        OIIO::TypeDescFromC<T>::value(), converted.data());
    }
    Out* row = image.row(y);
    for (int x = 0; x < width; ++x, p += channels) {
      row[x] = {convert(p[0]), convert(p[grey ? 0 : 1]), convert(p[grey ? 0 : 2])};
    }
  }
  return image;
}

Image<Rgb> FiniteNumbers(const OIIO::ImageBuf& buffer, const fs::path& path) {
  Image<Rgb> image = ToImage<float, Rgb>(buffer, [](float v) { return v; });
  for (std::size_t i = 0; i < image.size(); ++i) {
    const Rgb& p = image.data()[i];
    if (!std::isfinite(p.r) || !std::isfinite(p.g) || !std::isfinite(p.b)) {
      const int x = static_cast<int>(i) % image.width(), y = static_cast<int>(i) / image.width();
      throw InputError(
          path.string(),
          "has a value that is not finite at pixel " + std::to_string(x) + "," + std::to_string(y),
          kReplaceImage);
    }
  }
  return image;
}

void WriteBuffer(const fs::path& path, const OIIO::ImageSpec& spec, const void* pixels,
                 OIIO::TypeDesc type) {
  WriteAtomically(path, [&](const fs::path& temporary) {
    const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(temporary.string());
    if (!out) throw std::runtime_error(OIIO::geterror());
    if (!out->open(temporary.string(), spec) || !out->write_image(type, pixels) || !out->close()) {
      throw std::runtime_error(out->geterror());
    }
  });
}

// Numbers in [0, 1] as codes of all the type's bits.
template <class Code>
std::vector<Code> CodesOf(ImageSpan<const Rgb> numbers) {
  constexpr double kFull = std::numeric_limits<Code>::max();
  const auto width = 3 * static_cast<std::size_t>(numbers.width);
  std::vector<Code> codes(width * static_cast<std::size_t>(numbers.height));
  auto code = codes.begin();
  for (int y = 0; y < numbers.height; ++y) {
    const std::span<const float> row(&numbers.row(y)->r, width);
    code = std::transform(row.begin(), row.end(), code, [](float number) {
      // Above 0, so that what is cut off rounds.
      const double half_above = std::clamp(static_cast<double>(number), 0.0, 1.0) * kFull + 0.5;
      return static_cast<Code>(half_above);
    });
  }
  return codes;
}

}  // namespace

ImageInfo ReadImageInfo(const fs::path& path) {
  const std::unique_ptr<OIIO::ImageInput> input = OpenImage(path);
  const OIIO::ImageSpec& spec = input->spec();
  const OIIO::ROI picture = PictureWindow(spec);
  ImageInfo info;
  info.orientation = std::clamp(spec.get_int_attribute("Orientation", 1), 1, 8);
  info.format = input->format_name();
  info.width = SwapsAxes(info.orientation) ? picture.height() : picture.width();
  info.height = SwapsAxes(info.orientation) ? picture.width() : picture.height();
  info.channels = spec.nchannels;
  info.bits =
      spec.get_int_attribute("oiio:BitsPerSample", static_cast<int>(spec.format.size()) * 8);
  info.is_float = HasFloats(spec);
  const float focal = spec.get_float_attribute("Exif:FocalLength", 0.0F);
  const float focal_35mm = spec.get_float_attribute("Exif:FocalLengthIn35mmFilm", 0.0F);
  if (focal > 0) info.focal_mm = static_cast<double>(focal);
  if (focal_35mm > 0) info.focal_35mm = static_cast<double>(focal_35mm);
  info.sensor_longer_mm = SensorLongerSide(spec);
  info.camera_maker = spec.get_string_attribute("Make");
  info.camera_model = spec.get_string_attribute("Model");
  return info;
}

void CheckImageIsWhole(const fs::path& path) {
  if (ReadImageInfo(path).is_float) {
    ReadImage(path);
  } else {
    ReadUpright(path, OIIO::TypeDesc::UNKNOWN);
  }
}

Image<Rgb> ReadImage(const fs::path& path) {
  const OIIO::ImageBuf buffer = ReadUpright(path, OIIO::TypeDesc::UNKNOWN);
  if (!HasFloats(buffer.spec())) {
    if (buffer.spec().format == OIIO::TypeDesc::UINT8) {
      const std::array<float, 256> linear = LinearOfCodes();
      return ToImage<std::uint8_t, Rgb>(buffer, [&](std::uint8_t v) { return linear[v]; });
    }
    return ToImage<float, Rgb>(buffer, [](float v) { return SrgbToLinear(v); });
  }
  return FiniteNumbers(buffer, path);
}

Image<Rgb> ReadNumbers(const fs::path& path) {
  return FiniteNumbers(ReadUpright(path, OIIO::TypeDesc::UNKNOWN), path);
}

Image<Rgb8> ReadSrgb8(const fs::path& path) {
  const OIIO::ImageBuf buffer = ReadUpright(path, OIIO::TypeDesc::UNKNOWN);
  if (HasFloats(buffer.spec())) {
    return ToImage<float, Rgb8>(buffer, [](float v) { return LinearToSrgb8(v); });
  }
  return ToImage<std::uint8_t, Rgb8>(buffer, [](std::uint8_t v) { return v; });
}

Image<float> ReadAlpha(const fs::path& path) {
  const OIIO::ImageBuf buffer = ReadUpright(path, OIIO::TypeDesc::FLOAT);
  const int channel = buffer.spec().alpha_channel;
  if (channel < 0) return {};
  Image<float> alpha(buffer.spec().width, buffer.spec().height);
  OIIO::ROI roi = buffer.roi();
  roi.chbegin = channel;
  roi.chend = channel + 1;
  buffer.get_pixels(roi, OIIO::TypeDesc::FLOAT, alpha.data());
  return alpha;
}

void WriteCodes8(const fs::path& path, ImageSpan<const Rgb8> codes, int jpeg_quality,
                 PngCoding coding) {
  std::vector<Rgb8> packed;
  if (codes.stride != codes.width) {
    packed.reserve(static_cast<std::size_t>(codes.width) * static_cast<std::size_t>(codes.height));
    for (int y = 0; y < codes.height; ++y)
      packed.insert(packed.end(), codes.row(y), codes.row(y) + codes.width);
  }
  OIIO::ImageSpec spec = PngSpec(codes.width, codes.height, 3, coding);
  spec.attribute("CompressionQuality", jpeg_quality);
  WriteBuffer(path, spec, packed.empty() ? codes.data : packed.data(), OIIO::TypeDesc::UINT8);
}

std::string EncodeCodes8(ImageSpan<const Rgb8> codes, const std::string& format, int jpeg_quality) {
  std::vector<Rgb8> packed;
  packed.reserve(static_cast<std::size_t>(codes.width) * static_cast<std::size_t>(codes.height));
  for (int y = 0; y < codes.height; ++y)
    packed.insert(packed.end(), codes.row(y), codes.row(y) + codes.width);
  OIIO::ImageSpec spec = PngSpec(codes.width, codes.height, 3, PngCoding::kSmall);
  spec.attribute("CompressionQuality", jpeg_quality);
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput file(bytes);
  OIIO::Filesystem::IOProxy* proxy = &file;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, static_cast<void*>(&proxy));
  const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(format);
  if (!out) throw MachineError(format, OIIO::geterror(), "install OpenImageIO with that format");
  if (!out->open("memory." + format, spec) ||
      !out->write_image(OIIO::TypeDesc::UINT8, packed.data()) || !out->close()) {
    throw MachineError(format, out->geterror(), "install OpenImageIO with that format");
  }
  return std::string(bytes.begin(), bytes.end());
}

void WriteGrey8(const fs::path& path, ImageSpan<const std::uint8_t> codes, PngCoding coding) {
  std::vector<std::uint8_t> packed;
  for (int y = 0; y < codes.height; ++y)
    packed.insert(packed.end(), codes.row(y), codes.row(y) + codes.width);
  WriteBuffer(path, PngSpec(codes.width, codes.height, 1, coding), packed.data(),
              OIIO::TypeDesc::UINT8);
}

void WriteNumbers(const fs::path& path, ImageSpan<const Rgb> numbers, int bits) {
  OIIO::ImageSpec spec = PngSpec(numbers.width, numbers.height, 3, PngCoding::kPhotograph);
  if (bits == 16) {
    spec.set_format(OIIO::TypeDesc::UINT16);
    WriteBuffer(path, spec, CodesOf<std::uint16_t>(numbers).data(), OIIO::TypeDesc::UINT16);
  } else {
    WriteBuffer(path, spec, CodesOf<std::uint8_t>(numbers).data(), OIIO::TypeDesc::UINT8);
  }
}

Image<Rgb8> EncodeSrgb8(ImageSpan<const Rgb> linear) {
  Image<Rgb8> codes(linear.width, linear.height);
  const auto count = 3 * static_cast<std::size_t>(linear.width);
  for (int y = 0; y < linear.height; ++y) LinearToSrgb8(&linear.row(y)->r, count, &codes.row(y)->r);
  return codes;
}

void WriteSrgb8(const fs::path& path, ImageSpan<const Rgb> linear) {
  const Image<Rgb8> codes = EncodeSrgb8(linear);
  WriteBuffer(path, PngSpec(linear.width, linear.height, 3, PngCoding::kPhotograph), codes.data(),
              OIIO::TypeDesc::UINT8);
}

Image<Rgb> DecodeSrgb8(ImageSpan<const Rgb8> codes) {
  Image<Rgb> linear(codes.width, codes.height);
  const std::array<float, 256> of_code = LinearOfCodes();
  for (int y = 0; y < codes.height; ++y) {
    for (int x = 0; x < codes.width; ++x) {
      const Rgb8 p = codes(x, y);
      linear(x, y) = {of_code[p.r], of_code[p.g], of_code[p.b]};
    }
  }
  return linear;
}

void WriteCodes8(const fs::path& path, ImageSpan<const Rgb8> codes, ImageSpan<const float> alpha) {
  std::vector<std::uint8_t> packed;
  packed.reserve(4U * static_cast<std::size_t>(codes.width) *
                 static_cast<std::size_t>(codes.height));
  for (int y = 0; y < codes.height; ++y) {
    for (int x = 0; x < codes.width; ++x) {
      const Rgb8 p = codes(x, y);
      const float a = std::clamp(alpha(x, y), 0.0F, 1.0F);
      packed.insert(packed.end(),
                    {p.r, p.g, p.b, static_cast<std::uint8_t>(std::lround(a * 255.0F))});
    }
  }
  WriteBuffer(path, PngSpec(codes.width, codes.height, 4, PngCoding::kPhotograph), packed.data(),
              OIIO::TypeDesc::UINT8);
}

void WriteSrgb8(const fs::path& path, ImageSpan<const Rgb> linear, ImageSpan<const float> alpha) {
  WriteCodes8(path, EncodeSrgb8(linear).span(), alpha);
}

void WriteExr(const fs::path& path, const std::vector<Channel>& channels, ExrType type,
              ExrCompression compression) {
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name);
  const Image<float>& first = channels.at(0).pixels;
  ExrRowsWriter file(path, names, first.width(), first.height(), type, compression);
  file.Write(channels);
  file.Close();
}

std::vector<Channel> ReadExr(const fs::path& path) {
  const OIIO::ImageBuf buffer = ReadPixels(path, OIIO::TypeDesc::FLOAT);
  std::vector<Channel> channels;
  for (int c = 0; c < buffer.nchannels(); ++c) {
    Channel channel{buffer.spec().channelnames[static_cast<std::size_t>(c)],
                    Image<float>(buffer.spec().width, buffer.spec().height)};
    OIIO::ROI roi = buffer.roi();
    roi.chbegin = c;
    roi.chend = c + 1;
    buffer.get_pixels(roi, OIIO::TypeDesc::FLOAT, channel.pixels.data());
    channels.push_back(std::move(channel));
  }
  return channels;
}

Image<float> TakeChannel(std::vector<Channel>& channels, const std::string& name,
                         const fs::path& path) {
  for (Channel& channel : channels) {
    if (channel.name == name) return std::move(channel.pixels);
  }
  throw InputError(path.string(), "has no channel \"" + name + "\"",
                   "run the stage that writes it again");
}

}  // namespace lamella
