#include "pipeline/photo_numbers.h"

#include <fmt/format.h>

#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

template <class Number>
Image<float> EachPixel(const Image<Rgb>& photo, const Number& number) {
  Image<float> numbers(photo.width(), photo.height());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers.data()[i] = number(photo.data()[i]);
  return numbers;
}

float MeanOfChannels(const Rgb& pixel) { return (pixel.r + pixel.g + pixel.b) / 3; }

}  // namespace

Image<float> ReadLuminance(const fs::path& file) {
  return EachPixel(ReadImage(file), [](const Rgb& pixel) { return Luminance(pixel); });
}

Image<float> ReadMeanLight(const fs::path& file) {
  return EachPixel(ReadImage(file), MeanOfChannels);
}

Image<float> ReadMeanNumbers(const fs::path& file) {
  return EachPixel(ReadNumbers(file), MeanOfChannels);
}

void CheckSameSize(const PhotoSize& photo, const PhotoSize& first) {
  if (photo.width == first.width && photo.height == first.height) return;
  throw InputError(photo.photo,
                   fmt::format("has {} x {} px, and {} has {} x {}", photo.width, photo.height,
                               first.photo, first.width, first.height),
                   "take all with one camera, unturned and uncropped");
}

}  // namespace lamella
