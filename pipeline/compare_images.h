// Images against other ones, on 8-bit sRGB codes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lightfield/image.h"

namespace lamella {

struct ImageComparison {
  std::string name;
  double seen = 1;  // share of pixels with alpha >= 0.5 in both; 1 where neither has an alpha
  // Nothing where no pixel counts; +inf dB for equal pictures.
  std::optional<double> psnr, ssim, psnr_seen, ssim_seen;
};

struct ImageComparisons {
  std::vector<ImageComparison> images;  // by name
  std::vector<std::string> only_a, only_b;
  // Of those images that have the figure; of equal pictures only where all are equal.
  ImageComparison mean;
};

struct CompareImagesOptions {
  int border_px = 0;  // left out on every side
  int size_px = 0;    // longer side that both are resized to first (area filter, linear light)
};

// Two files, or two folders whose images are matched by their names without extension. InputError
// where no names meet or two images differ in size.
ImageComparisons CompareImages(const std::filesystem::path& a, const std::filesystem::path& b,
                               const CompareImagesOptions& options);

}  // namespace lamella
