#include "pipeline/compare_images.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "depth/resize_area.h"
#include "distribute/metrics.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/image_folder.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

struct Picture {
  Image<Rgb8> codes;
  Image<float> alpha;  // empty: none
};

// Alpha as a picture of greys, so that it is resized as the colours are.
Image<float> ResizedAlpha(const Image<float>& alpha, int width, int height) {
  Image<Rgb> grey(alpha.width(), alpha.height());
  for (std::size_t i = 0; i < grey.size(); ++i) grey.data()[i].r = alpha.data()[i];
  const Image<Rgb> resized = ResizeArea(grey.span(), width, height);
  Image<float> result(width, height);
  for (std::size_t i = 0; i < result.size(); ++i) result.data()[i] = resized.data()[i].r;
  return result;
}

Picture Load(const fs::path& path, int size_px) {
  Picture picture{ReadSrgb8(path), ReadAlpha(path)};
  const int longer = std::max(picture.codes.width(), picture.codes.height());
  if (size_px <= 0 || longer == size_px) return picture;
  const double scale = static_cast<double>(size_px) / longer;
  const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
  const int width = side(picture.codes.width()), height = side(picture.codes.height());
  picture.codes = EncodeSrgb8(ResizeArea(ReadImage(path).span(), width, height).span());
  if (!picture.alpha.empty()) picture.alpha = ResizedAlpha(picture.alpha, width, height);
  return picture;
}

// 1 where both have alpha >= 0.5.
Image<float> SeenInBoth(const Picture& a, const Picture& b) {
  Image<float> seen(a.codes.width(), a.codes.height(), 1.0F);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const bool in_a = a.alpha.empty() || a.alpha.data()[i] >= 0.5F;
    const bool in_b = b.alpha.empty() || b.alpha.data()[i] >= 0.5F;
    seen.data()[i] = in_a && in_b ? 1.0F : 0.0F;
  }
  return seen;
}

ImageComparison Compare(const NamedFile& file_a, const NamedFile& file_b,
                        const CompareImagesOptions& options) {
  const Picture a = Load(file_a.path, options.size_px), b = Load(file_b.path, options.size_px);
  if (a.codes.width() != b.codes.width() || a.codes.height() != b.codes.height()) {
    throw InputError(file_a.path.string(),
                     fmt::format("is {}x{}, {} is {}x{}", a.codes.width(), a.codes.height(),
                                 file_b.path.string(), b.codes.width(), b.codes.height()),
                     "compare pictures of one size, or give --size");
  }
  const Image<float> seen = SeenInBoth(a, b);
  ImageComparison result;
  result.name = file_a.name;
  double count = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) count += static_cast<double>(seen.data()[i]);
  result.seen = count / static_cast<double>(seen.size());
  const MetricRegion all{options.border_px, {}}, only_seen{options.border_px, seen.span()};
  result.psnr = Psnr(a.codes.span(), b.codes.span(), all);
  result.ssim = Ssim(a.codes.span(), b.codes.span(), all);
  result.psnr_seen = Psnr(a.codes.span(), b.codes.span(), only_seen);
  result.ssim_seen = Ssim(a.codes.span(), b.codes.span(), only_seen);
  return result;
}

std::optional<double> Mean(const std::vector<ImageComparison>& images,
                           std::optional<double> ImageComparison::*figure) {
  double sum = 0;
  int finite = 0, infinite = 0;
  for (const ImageComparison& image : images) {
    const std::optional<double>& value = image.*figure;
    if (!value) continue;
    if (std::isinf(*value)) {
      ++infinite;
      continue;
    }
    sum += *value;
    ++finite;
  }
  if (finite > 0) return sum / finite;
  if (infinite > 0) return std::numeric_limits<double>::infinity();
  return std::nullopt;
}

}  // namespace

ImageComparisons CompareImages(const fs::path& a, const fs::path& b,
                               const CompareImagesOptions& options) {
  const std::vector<NamedFile> files_a = ImagesOf(a), files_b = ImagesOf(b);
  ImageComparisons result;
  const bool two_files = fs::is_regular_file(a) && fs::is_regular_file(b);
  if (two_files) {
    result.images.push_back(Compare(files_a[0], files_b[0], options));
  } else {
    auto in_b = files_b.begin();
    for (const NamedFile& file : files_a) {
      for (; in_b != files_b.end() && in_b->name < file.name; ++in_b)
        result.only_b.push_back(in_b->name);
      if (in_b != files_b.end() && in_b->name == file.name) {
        result.images.push_back(Compare(file, *in_b++, options));
      } else {
        result.only_a.push_back(file.name);
      }
    }
    for (; in_b != files_b.end(); ++in_b) result.only_b.push_back(in_b->name);
  }
  if (result.images.empty()) {
    throw InputError(a.string(), "has no image of a name that " + b.string() + " has",
                     "give folders whose images have the same names");
  }
  double seen = 0;
  for (const ImageComparison& image : result.images) seen += image.seen;
  result.mean.name = "mean";
  result.mean.seen = seen / static_cast<double>(result.images.size());
  result.mean.psnr = Mean(result.images, &ImageComparison::psnr);
  result.mean.ssim = Mean(result.images, &ImageComparison::ssim);
  result.mean.psnr_seen = Mean(result.images, &ImageComparison::psnr_seen);
  result.mean.ssim_seen = Mean(result.images, &ImageComparison::ssim_seen);
  return result;
}

}  // namespace lamella
