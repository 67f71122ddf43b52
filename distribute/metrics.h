// How far two pictures are apart, on 8-bit sRGB codes: PSNR and SSIM.
//
// Say with every figure which pixels counted (border, mask) and that it is on sRGB codes: PSNR in
// linear light differs by 1 to 3 dB. Sums are double and in a fixed order.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lightfield/image.h"

namespace lamella {

// The pixels that count: those at least `border_px` from every side and, where there is a mask,
// with mask >= 0.5.
struct MetricRegion {
  int border_px = 0;
  ImageSpan<const float> mask = {};  // of the pictures' size; no data: all pixels
};

// Of channel values in [0, 1].
struct SquaredError {
  double sum = 0;
  std::int64_t count = 0;  // channel values, 3 a pixel
};

// Both pictures have one size, as has the mask; a UsageError says so otherwise.
SquaredError SumSquaredError(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                             const MetricRegion& region = {});

// 10 log10(1 / mean squared error), dB; +inf for equal pictures, nothing where no pixel counts.
std::optional<double> Psnr(const SquaredError& error);
std::optional<double> Psnr(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                           const MetricRegion& region = {});

// Mean structural similarity (Wang et al. 2004) over the region's pixels and the three channels:
// Gaussian window of sigma 1.5 px and 11 x 11 px (cut and renormalised at the picture's sides),
// population covariances, K1 = 0.01, K2 = 0.03, L = 1. Nothing where no pixel counts.
std::optional<double> Ssim(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                           const MetricRegion& region = {});
// Over each of some regions, in the time of one.
std::vector<std::optional<double>> SsimOfRegions(ImageSpan<const Rgb8> a, ImageSpan<const Rgb8> b,
                                                 const std::vector<MetricRegion>& regions);

}  // namespace lamella
