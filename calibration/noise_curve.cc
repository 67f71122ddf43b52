#include "calibration/noise_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lamella {
namespace {

constexpr double kCodeNoise = 1 / (255 * 3.4641016151377544);  // of rounding to 8 bits

// A pixel and its neighbours.
struct Neighbourhood {
  float grey;        // weighted mean
  float gradient;    // length of the central differences, per pixel
  float difference;  // absolute; of a kind that vanishes on straight edges along either axis
};

Neighbourhood NeighbourhoodAt(ImageSpan<const float> image, int x, int y) {
  const float corners =
      image(x - 1, y - 1) + image(x + 1, y - 1) + image(x - 1, y + 1) + image(x + 1, y + 1);
  const float sides = image(x - 1, y) + image(x + 1, y) + image(x, y - 1) + image(x, y + 1);
  return {(corners + 2 * sides + 4 * image(x, y)) / 16,
          std::hypot(image(x + 1, y) - image(x - 1, y), image(x, y + 1) - image(x, y - 1)) / 2,
          std::abs(corners - 2 * sides + 4 * image(x, y))};
}

std::vector<Neighbourhood> NeighbourhoodsOf(ImageSpan<const float> image) {
  constexpr int kStep = 3;
  std::vector<Neighbourhood> around;
  for (int y = 1; y + 1 < image.height; y += kStep) {
    for (int x = 1; x + 1 < image.width; x += kStep) around.push_back(NeighbourhoodAt(image, x, y));
  }
  return around;
}

template <class Number>
double Quantile(std::vector<Neighbourhood>& around, double share, Number Neighbourhood::*number) {
  const auto at =
      around.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(around.size() - 1));
  std::nth_element(
      around.begin(), at, around.end(),
      [number](const Neighbourhood& a, const Neighbourhood& b) { return a.*number < b.*number; });
  return static_cast<double>((*at).*number);
}

// Immerkaer 1996, with a median: the mask's numbers have the square sum 36, the median of
// |normal| is 0.6745 sigma.
double NoiseOf(std::vector<Neighbourhood>& around) {
  return std::max(kCodeNoise, Quantile(around, 0.5, &Neighbourhood::difference) / (6 * 0.6745));
}

}  // namespace

NoiseCurve::NoiseCurve(ImageSpan<const float> image) : median_deviation_(kCodeNoise) {
  constexpr int kBins = 16, kFewestOfABin = 200;
  constexpr double kRare = 1e-3;      // brighter than that: glints and hot pixels
  constexpr double kFlat = 1.0 / 20;  // of the picture's range, per pixel
  std::vector<Neighbourhood> around = NeighbourhoodsOf(image);
  if (around.empty()) return;
  median_deviation_ = NoiseOf(around);
  const double low = Quantile(around, kRare, &Neighbourhood::grey);
  const double range = Quantile(around, 1 - kRare, &Neighbourhood::grey) - low;
  // An oblique edge would be noise. Gradients are odd and the difference is even: of white noise
  // they are independent, so that to choose by one does not bias the other. (The mean is not quite:
  // by 1/9, which a bin's width hides.)
  std::vector<std::vector<Neighbourhood>> flat(kBins);
  for (const Neighbourhood& one : around) {
    const double level = range > 0 ? (static_cast<double>(one.grey) - low) / range : 0;
    if (static_cast<double>(one.gradient) > kFlat * range || level < 0 || level > 1) continue;
    flat[static_cast<std::size_t>(std::min(level * kBins, kBins - 1.0))].push_back(one);
  }
  for (std::vector<Neighbourhood>& level : flat) {
    if (level.size() < kFewestOfABin) continue;
    const double noise = NoiseOf(level);
    levels_.push_back({Quantile(level, 0.5, &Neighbourhood::grey), noise * noise});
  }
}

double NoiseCurve::VarianceAt(double grey) const {
  if (levels_.empty()) return median_deviation_ * median_deviation_;
  const auto above = std::lower_bound(levels_.begin(), levels_.end(), grey,
                                      [](const Level& a, double b) { return a.grey < b; });
  if (above == levels_.begin()) return above->variance;
  if (above == levels_.end()) return levels_.back().variance;
  const Level& below = *(above - 1);
  const double share = (grey - below.grey) / (above->grey - below.grey);
  return below.variance + share * (above->variance - below.variance);
}

}  // namespace lamella
