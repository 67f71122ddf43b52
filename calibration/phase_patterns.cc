#include "calibration/phase_patterns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/color.h"

namespace lamella {
namespace {

constexpr double kModulation = 0.96;  // m
constexpr int kFine = 16, kMiddle = 128, kCoarse = 2048, kMostRatio = 16;

// Periods above the fine one.
std::vector<int> CoarsePeriods(int size_px) {
  std::vector<int> periods = {kMiddle};
  // A period of many panels would be a dark photograph in one of its steps.
  if (size_px > kMiddle) periods.push_back(kCoarse);
  while (periods.back() < size_px) {
    int period = periods.back();
    for (int ratio = 1; ratio < kMostRatio && period < size_px; ratio *= 2) period *= 2;
    periods.push_back(period);
  }
  return periods;
}

}  // namespace

std::string NameOf(const PhaseSeries& series) {
  return fmt::format("{}_{:04}", series.axis == PanelAxis::kU ? "u" : "v", series.period_px);
}

std::vector<PhaseSeries> PhaseSeriesOf(int width_px, int height_px) {
  std::vector<PhaseSeries> all;
  for (const PanelAxis axis : {PanelAxis::kU, PanelAxis::kV}) {
    all.push_back({axis, kFine, 8});
    for (const int period : CoarsePeriods(axis == PanelAxis::kU ? width_px : height_px)) {
      all.push_back({axis, period, 4});
    }
  }
  return all;
}

Image<Rgb8> DrawPhase(int width_px, int height_px, const PhaseSeries& series, int step) {
  const bool along_u = series.axis == PanelAxis::kU;
  std::vector<Rgb8> codes(static_cast<std::size_t>(along_u ? width_px : height_px));
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const double turns = (static_cast<double>(i) + 0.5) / series.period_px -
                         static_cast<double>(step) / series.steps;
    const double light = 0.5 + kModulation / 2 * std::cos(2 * std::numbers::pi * turns);
    const std::uint8_t code = LinearToSrgb8(static_cast<float>(light));
    codes[i] = {code, code, code};
  }
  Image<Rgb8> image(width_px, height_px);
  for (int v = 0; v < height_px; ++v) {
    if (along_u) {
      std::copy(codes.begin(), codes.end(), image.row(v));
    } else {
      std::fill_n(image.row(v), width_px, codes[static_cast<std::size_t>(v)]);
    }
  }
  return image;
}

}  // namespace lamella
