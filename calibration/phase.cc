#include "calibration/phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kLeastModulation = 15, kLeastContrast = 10;  // sigma
constexpr double kLeastFaintModulation = 3;
constexpr double kSaturated = 0.95;
constexpr int kErosionPx = 3;
constexpr double kMostOffPlane = 4;  // sigma
constexpr std::int64_t kGrainRows = 16;

double SigmaOf(const SensorNoise& noise, double light) {
  return std::sqrt(noise.per_light * std::max(0.0, light) + noise.constant);
}

// A and B e^(i phi) of a pixel.
struct Sinusoid {
  double mean = 0, cosine = 0, sine = 0;
  double modulation() const { return std::hypot(cosine, sine); }
  double turns() const {  // [0, 1)
    const double t = std::atan2(sine, cosine) / kFullTurn;
    return t < 0 ? t + 1 : t;
  }
};

// A series with the sines of its steps.
class Steps {
 public:
  explicit Steps(const PhasePhotos& photos) : photos_(photos) {
    for (int k = 0; k < photos.series.steps; ++k) {
      const double angle = kFullTurn * k / photos.series.steps;
      cos_.push_back(std::cos(angle));
      sin_.push_back(std::sin(angle));
    }
  }
  const PhaseSeries& series() const { return photos_.series; }

  Sinusoid At(int x, int y) const {
    Sinusoid s;
    const double n = static_cast<double>(cos_.size());
    for (std::size_t k = 0; k < cos_.size(); ++k) {
      const auto number = static_cast<double>(photos_.photos[k](x, y));
      s.mean += number / n;
      s.cosine += 2 / n * number * cos_[k];
      s.sine += 2 / n * number * sin_[k];
    }
    return s;
  }
  double Brightest(int x, int y) const {
    float most = 0;
    for (const auto& photo : photos_.photos) most = std::max(most, photo(x, y));
    return static_cast<double>(most);
  }
  // Mean square about the sinusoid, without bias: N - 3 degrees of freedom.
  double Variance(int x, int y) const {
    const Sinusoid s = At(x, y);
    double sum = 0;
    for (std::size_t k = 0; k < cos_.size(); ++k) {
      const double off = static_cast<double>(photos_.photos[k](x, y)) - s.mean -
                         s.cosine * cos_[k] - s.sine * sin_[k];
      sum += off * off;
    }
    return sum / (static_cast<double>(cos_.size()) - 3);
  }

 private:
  const PhasePhotos& photos_;
  std::vector<double> cos_, sin_;
};

// The series of an axis, fine to coarse.
std::vector<Steps> SeriesOf(const PhaseCapture& capture, PanelAxis axis) {
  std::vector<const PhasePhotos*> chosen;
  for (const PhasePhotos& photos : capture.series) {
    if (photos.series.axis == axis) chosen.push_back(&photos);
  }
  std::sort(chosen.begin(), chosen.end(),
            [](const auto* a, const auto* b) { return a->series.period_px < b->series.period_px; });
  const char* name = axis == PanelAxis::kU ? "u" : "v";
  const int size = axis == PanelAxis::kU ? capture.width_px : capture.height_px;
  if (chosen.empty() || chosen.back()->series.period_px < size) {
    throw InputError("phase patterns",
                     fmt::format("the panel is {} px along {}, the coarsest period is {} px", size,
                                 name, chosen.empty() ? 0 : chosen.back()->series.period_px),
                     "photograph all patterns of the shot list");
  }
  std::vector<Steps> steps;
  for (const PhasePhotos* photos : chosen) steps.emplace_back(*photos);
  return steps;
}

void CheckPhotos(const PhaseCapture& capture) {
  const auto same_size = [&](ImageSpan<const float> image) {
    return image.width == capture.white.width && image.height == capture.white.height;
  };
  bool same = same_size(capture.black);
  for (const PhasePhotos& photos : capture.series) {
    if (static_cast<int>(photos.photos.size()) != photos.series.steps || photos.series.steps < 3) {
      throw InputError(fmt::format("phase patterns {}", NameOf(photos.series)),
                       fmt::format("has {} photographs, not {}", photos.photos.size(),
                                   std::max(3, photos.series.steps)),
                       "photograph all patterns of the shot list");
    }
    for (const auto& photo : photos.photos) same = same && same_size(photo);
  }
  if (!same) {
    throw InputError("phase patterns", "have photographs of different sizes",
                     "take them with one camera, unturned and uncropped");
  }
}

// Whether a pixel's modulation is that of light, not of noise.
bool IsBright(const Steps& fine, int x, int y) { return fine.At(x, y).modulation() >= 0.02; }
bool IsAboveItsNoise(const Steps& fine, int x, int y) {
  const double modulation = fine.At(x, y).modulation();
  return modulation * modulation > 4 * 2.0 / fine.series().steps * fine.Variance(x, y);
}

// From the median over the pixels that are lit, which pixels at edges and of the staircase do not
// raise.
double EstimateVariance(const Steps& fine, const PhaseCapture& capture,
                        bool (*is_lit)(const Steps&, int, int)) {
  constexpr int kStep = 3;
  std::vector<double> variances;
  for (int y = 0; y < capture.white.height; y += kStep) {
    for (int x = 0; x < capture.white.width; x += kStep) {
      if (!is_lit(fine, x, y) || fine.Brightest(x, y) > kSaturated) continue;
      variances.push_back(fine.Variance(x, y));
    }
  }
  constexpr double kCodeVariance = 1 / (12.0 * 255 * 255);
  if (variances.empty()) return kCodeVariance;
  const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
  std::nth_element(variances.begin(), middle, variances.end());
  // The median of chi^2/n is (1 - 2/(9 n))^3 (Wilson and Hilferty 1931).
  const double n = fine.series().steps - 3;
  return std::max(*middle / std::pow(1 - 2 / (9 * n), 3), 1e-12);
}

Image<std::uint8_t> Eroded(const Image<std::uint8_t>& mask, int radius) {
  Image<std::uint8_t> along(mask.width(), mask.height()), out(mask.width(), mask.height());
  const auto all = [radius](auto&& at, int i, int size) -> std::uint8_t {
    if (i < radius || i + radius >= size) return 0;
    for (int k = i - radius; k <= i + radius; ++k) {
      if (at(k) == 0) return 0;
    }
    return 1;
  };
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      along(x, y) = all([&](int k) { return mask(k, y); }, x, mask.width());
    }
  }
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      out(x, y) = all([&](int k) { return along(x, k); }, y, mask.height());
    }
  }
  return out;
}

bool HasLight(const PhaseCapture& capture, double sigma, int x, int y) {
  const auto white = static_cast<double>(capture.white(x, y));
  return white - static_cast<double>(capture.black(x, y)) > kLeastContrast * sigma;
}

// Of one series, at all pixels where white is 10 sigma above black and nothing is overexposed.
Image<std::complex<float>> SinusoidsOf(const Steps& steps, const PhaseCapture& capture,
                                       const SensorNoise& noise) {
  const int width = capture.white.width, height = capture.white.height;
  const auto root = std::sqrt(static_cast<double>(steps.series().steps) / 2);
  Image<std::complex<float>> sinusoids(width, height);
  ParallelFor(0, height, kGrainRows, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width; ++x) {
        const Sinusoid s = steps.At(x, y);
        const double sigma = SigmaOf(noise, s.mean);
        if (!HasLight(capture, sigma, x, y) || steps.Brightest(x, y) >= kSaturated) continue;
        sinusoids(x, y) = {static_cast<float>(root * s.cosine), static_cast<float>(root * s.sine)};
      }
    }
  });
  return sinusoids;
}

// Light and modulation suffice for both axes.
bool IsLit(const PhaseCapture& capture, const std::vector<Steps>& axis, const SensorNoise& noise,
           int x, int y) {
  const Steps& fine = axis.front();
  const Sinusoid s = fine.At(x, y);
  const double sigma = SigmaOf(noise, s.mean);
  return s.modulation() > kLeastModulation * sigma * std::sqrt(2.0 / fine.series().steps) &&
         fine.Brightest(x, y) < kSaturated && HasLight(capture, sigma, x, y);
}

const Steps& SeriesOfPeriod(const std::vector<Steps>& axis, int period_px) {
  for (const Steps& steps : axis) {
    if (steps.series().period_px == period_px) return steps;
  }
  throw InputError("phase patterns", fmt::format("there is no period of {} px", period_px),
                   "photograph all patterns of the shot list");
}

bool IsFaintlyLit(const Steps& fine, double variance, int x, int y) {
  return fine.At(x, y).modulation() >
             kLeastFaintModulation * std::sqrt(2.0 / fine.series().steps * variance) &&
         fine.Brightest(x, y) < kSaturated;
}

struct Position {
  double px = 0, sigma = 0;
  bool agrees = false;  // all periods do
};

Position Unwrap(const std::vector<Steps>& axis, const SensorNoise& noise, int size_px, int x,
                int y) {
  Position position;
  position.agrees = true;
  for (auto steps = axis.rbegin(); steps != axis.rend(); ++steps) {
    const double period = steps->series().period_px;
    const Sinusoid s = steps->At(x, y);
    const double turns = s.turns();
    if (steps == axis.rbegin()) {
      position.px = period * turns;
      // Noise may carry a point at the panel's first edge to the far end of the period.
      if (position.px > (period + size_px) / 2) position.px -= period;
      continue;
    }
    const double coarse = position.px;
    position.px = period * (turns + std::round(coarse / period - turns));
    position.agrees = position.agrees && std::abs(position.px - coarse) < period / 4;
    const double sigma = SigmaOf(noise, s.mean);
    position.sigma =
        period / kFullTurn * std::sqrt(2.0 / steps->series().steps) * sigma / s.modulation();
  }
  return position;
}

// How far a pixel's value is from its neighbours' plane: from their mean, since they lie evenly
// around it. Neighbours that are not known are passed over with the pixel opposite of them; nothing
// where too few are left.
std::optional<double> OffPlane(const Image<float>& values, const Image<std::uint8_t>& known, int x,
                               int y) {
  double sum = 0;
  int pairs = 0;
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
    if (x - dx < 0 || x + dx >= known.width() || y - 1 < 0 || y + 1 >= known.height()) continue;
    if (known(x + dx, y + dy) == 0 || known(x - dx, y - dy) == 0) continue;
    sum +=
        static_cast<double>(values(x + dx, y + dy)) + static_cast<double>(values(x - dx, y - dy));
    ++pairs;
  }
  if (pairs < 2) return std::nullopt;
  return static_cast<double>(values(x, y)) - sum / (2 * pairs);
}

// The standard deviation of what is off the planes, by its median: noise, and the panel's staircase
// of pixels, which a sharp photograph shows.
double OffPlaneSigma(const Image<float>& values, const Image<std::uint8_t>& known) {
  constexpr int kStep = 3;
  std::vector<double> offs;
  for (int y = 0; y < known.height(); y += kStep) {
    for (int x = 0; x < known.width(); x += kStep) {
      if (known(x, y) == 0) continue;
      if (const auto off = OffPlane(values, known, x, y)) offs.push_back(std::abs(*off));
    }
  }
  if (offs.empty()) return 0;
  const auto middle = offs.begin() + static_cast<std::ptrdiff_t>(offs.size() / 2);
  std::nth_element(offs.begin(), middle, offs.end());
  return *middle / 0.6745;
}

// Clears what is off its plane, though not within the noise of dimmer pixels.
void KeepWhatLiesInPlane(const Image<float>& values, const Image<float>& sigmas,
                         const Image<std::uint8_t>& known, Image<std::uint8_t>& valid) {
  const double typical = OffPlaneSigma(values, known);
  for (int y = 0; y < known.height(); ++y) {
    for (int x = 0; x < known.width(); ++x) {
      if (known(x, y) == 0) continue;
      const auto off = OffPlane(values, known, x, y);
      const double most =
          kMostOffPlane * std::max(typical, 1.2 * static_cast<double>(sigmas(x, y)));
      if (!off || std::abs(*off) > most) valid(x, y) = 0;
    }
  }
}

}  // namespace

ScreenMap DecodePhase(const PhaseCapture& capture, const std::optional<SensorNoise>& noise) {
  CheckPhotos(capture);
  const std::vector<Steps> u = SeriesOf(capture, PanelAxis::kU);
  const std::vector<Steps> v = SeriesOf(capture, PanelAxis::kV);
  const SensorNoise sensor = noise
                                 ? *noise
                                 : SensorNoise{0, (EstimateVariance(u.front(), capture, IsBright) +
                                                   EstimateVariance(v.front(), capture, IsBright)) /
                                                      2};
  const int width = capture.white.width, height = capture.white.height;
  Image<std::uint8_t> lit(width, height);
  ParallelFor(0, height, kGrainRows, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width; ++x) {
        lit(x, y) = IsLit(capture, u, sensor, x, y) && IsLit(capture, v, sensor, x, y) ? 1 : 0;
      }
    }
  });
  const Image<std::uint8_t> inside = Eroded(lit, capture.through_lenses ? 1 : kErosionPx);
  ScreenMap map{
      {width, height}, {width, height}, {width, height}, {width, height}, {width, height}};
  Image<std::uint8_t> known(width, height);
  ParallelFor(0, height, kGrainRows, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width; ++x) {
        if (inside(x, y) == 0) continue;
        const Position at_u = Unwrap(u, sensor, capture.width_px, x, y);
        const Position at_v = Unwrap(v, sensor, capture.height_px, x, y);
        map.u_px(x, y) = static_cast<float>(at_u.px);
        map.v_px(x, y) = static_cast<float>(at_v.px);
        map.sigma_u(x, y) = static_cast<float>(at_u.sigma);
        map.sigma_v(x, y) = static_cast<float>(at_v.sigma);
        known(x, y) = at_u.agrees && at_v.agrees ? 1 : 0;
      }
    }
  });
  map.valid = known.Clone();
  if (capture.through_lenses) {
    for (const auto* axis : {&u, &v}) {
      for (const Steps& steps : *axis) map.sinusoids.push_back(SinusoidsOf(steps, capture, sensor));
    }
    return map;
  }
  KeepWhatLiesInPlane(map.u_px, map.sigma_u, known, map.valid);
  KeepWhatLiesInPlane(map.v_px, map.sigma_v, known, map.valid);
  return map;
}

ScreenMap DecodePeriod(const PhaseCapture& capture, int period_px) {
  CheckPhotos(capture);
  const std::vector<Steps> u = SeriesOf(capture, PanelAxis::kU);
  const std::vector<Steps> v = SeriesOf(capture, PanelAxis::kV);
  const Steps& chosen_u = SeriesOfPeriod(u, period_px);
  const Steps& chosen_v = SeriesOfPeriod(v, period_px);
  const double variance = (EstimateVariance(u.front(), capture, IsAboveItsNoise) +
                           EstimateVariance(v.front(), capture, IsAboveItsNoise)) /
                          2;
  const auto sigma_of = [&](const Steps& steps, const Sinusoid& s) {
    return period_px / kFullTurn * std::sqrt(2.0 / steps.series().steps * variance) /
           s.modulation();
  };
  const int width = capture.white.width, height = capture.white.height;
  ScreenMap map{
      {width, height}, {width, height}, {width, height}, {width, height}, {width, height}};
  ParallelFor(0, height, kGrainRows, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!IsFaintlyLit(u.front(), variance, x, y) || !IsFaintlyLit(v.front(), variance, x, y)) {
          continue;
        }
        const Sinusoid at_u = chosen_u.At(x, y), at_v = chosen_v.At(x, y);
        map.u_px(x, y) = static_cast<float>(period_px * at_u.turns());
        map.v_px(x, y) = static_cast<float>(period_px * at_v.turns());
        map.sigma_u(x, y) = static_cast<float>(sigma_of(chosen_u, at_u));
        map.sigma_v(x, y) = static_cast<float>(sigma_of(chosen_v, at_v));
        map.valid(x, y) = 1;
      }
    }
  });
  return map;
}

}  // namespace lamella
