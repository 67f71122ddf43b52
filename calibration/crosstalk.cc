#include "calibration/crosstalk.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPi = std::numbers::pi;

// sin(pi x)/(pi x): the spectrum of a box of width 1.
double Sinc(double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); }

// The spectrum of a disc of diameter 1, seen from its side: 2 J1(pi x)/(pi x).
double Jinc(double x) {
  if (std::abs(x) < 1e-9) return 1;
  return 2 * std::cyl_bessel_j(1, kPi * std::abs(x)) / (kPi * std::abs(x));
}

// The share of view 0 over the place where a line of sight meets the row is periodic: a Fourier
// series, whose terms are the product of the parts' spectra.
class Profile {
 public:
  Profile(const CrosstalkSetup& setup, double spread_px) : period_(setup.num_views) {
    // The boxes' spectra fall as 1/f^2 where there is no spread.
    const int terms = 12 * setup.num_views;
    for (int h = 1; h <= terms; ++h) {
      const double f = h / period_, phase = 2 * kPi * kPi * f * f * spread_px * spread_px;
      if (phase > 40) break;
      amplitudes_.push_back(2 / period_ * Sinc(f) * Sinc(setup.opening_px * f) *
                            Jinc(setup.pupil_px * f) * std::exp(-phase));
    }
  }
  double At(double place) const {
    double sum = 1 / period_;
    for (std::size_t i = 0; i < amplitudes_.size(); ++i) {
      sum += amplitudes_[i] * std::cos(2 * kPi * static_cast<double>(i + 1) * place / period_);
    }
    return sum;
  }

 private:
  double period_;
  std::vector<double> amplitudes_;
};

VectorXd ViewsAt(const Profile& profile, int num_views, double place) {
  VectorXd views(num_views);
  for (int k = 0; k < num_views; ++k) views(k) = profile.At(place - k);
  return views;
}

// Light = level views + background, in least squares.
struct SeriesFit {
  double place = 0, level = 0, background = 0, squares = 0;
};

SeriesFit FitAt(const VectorXd& series, const Profile& profile, double place) {
  const VectorXd views = ViewsAt(profile, static_cast<int>(series.size()), place);
  const VectorXd centred = views.array() - views.mean();
  SeriesFit fit;
  fit.place = place;
  fit.level = centred.dot(series) / std::max(centred.squaredNorm(), 1e-300);
  fit.background = series.mean() - fit.level * views.mean();
  fit.squares = (series.array() - fit.level * views.array() - fit.background).square().sum();
  return fit;
}

// The least of a function with one minimum between two places.
double GoldenSection(const std::function<double(double)>& cost, double low, double high) {
  constexpr double kRatio = std::numbers::phi - 1;
  double a = high - kRatio * (high - low), b = low + kRatio * (high - low);
  double at_a = cost(a), at_b = cost(b);
  for (int i = 0; i < 28; ++i) {  // to 1e-6 of the interval
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - kRatio * (high - low);
      at_a = cost(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + kRatio * (high - low);
      at_b = cost(b);
    }
  }
  return (low + high) / 2;
}

// From the phase of the first harmonic, which is the place but for what the sampling aliases.
double RoughPlace(const VectorXd& series) {
  const double K = static_cast<double>(series.size());
  double cosine = 0, sine = 0;
  for (Index k = 0; k < series.size(); ++k) {
    cosine += series(k) * std::cos(2 * kPi * static_cast<double>(k) / K);
    sine += series(k) * std::sin(2 * kPi * static_cast<double>(k) / K);
  }
  return std::atan2(sine, cosine) * K / (2 * kPi);
}

SeriesFit FitSeries(const VectorXd& series, const Profile& profile) {
  const double rough = RoughPlace(series);
  const double place = GoldenSection([&](double at) { return FitAt(series, profile, at).squares; },
                                     rough - 0.5, rough + 0.5);
  return FitAt(series, profile, place);
}

void CheckSeries(const std::vector<VectorXd>& series, const CrosstalkSetup& setup,
                 const std::string& panel) {
  for (const VectorXd& lights : series) {
    if (lights.size() == setup.num_views && lights.sum() > 0) continue;
    throw InputError(panel,
                     fmt::format("its photographs of lines are not {} with light", setup.num_views),
                     "take them all, its modulator's openings in the picture");
  }
  if (series.empty()) {
    throw InputError(panel, "no part of it was photographed for crosstalk",
                     "take the photographs of lines");
  }
}

MatrixXd MatrixOf(const CrosstalkSetup& setup, double spread_px) {
  const Profile profile(setup, spread_px);
  MatrixXd matrix(setup.num_views, setup.num_views);
  for (int j = 0; j < setup.num_views; ++j) {
    matrix.row(j) = ViewsAt(profile, setup.num_views, j).transpose();
  }
  return matrix;
}

}  // namespace

VectorXd ViewsSeen(const CrosstalkSetup& setup, double spread_px, double place) {
  return ViewsAt(Profile(setup, spread_px), setup.num_views, place);
}

CrosstalkFit FitCrosstalk(const std::vector<VectorXd>& given, const CrosstalkSetup& setup,
                          const std::string& panel) {
  CheckSeries(given, setup, panel);
  std::vector<VectorXd> series;  // each of the same weight
  for (const VectorXd& lights : given) series.emplace_back(lights / lights.sum());
  const auto cost = [&](double spread_px) {
    const Profile profile(setup, spread_px);
    double sum = 0;
    for (const VectorXd& lights : series) sum += FitSeries(lights, profile).squares;
    return sum;
  };
  CrosstalkFit fit;
  fit.spread_px = GoldenSection(cost, 0, setup.num_views / 3.0);
  const double least = cost(fit.spread_px);
  const auto count = static_cast<double>(series.size());
  const double freedom = std::max(1.0, count * (setup.num_views - 3) - 1);
  fit.rms = std::sqrt(least / (count * setup.num_views));
  // From the curvature of the cost: variance = 2 s^2 / cost''.
  constexpr double kStepPx = 0.02;
  const double curvature =
      (cost(fit.spread_px + kStepPx) + cost(std::max(0.0, fit.spread_px - kStepPx)) - 2 * least) /
      (kStepPx * kStepPx);
  fit.spread_sd_px = std::sqrt(2 * least / freedom / std::max(curvature, 1e-12));
  fit.with_pupil = MatrixOf(setup, fit.spread_px);
  CrosstalkSetup eye = setup;
  eye.pupil_px = 0;
  fit.without_pupil = MatrixOf(eye, fit.spread_px);
  return fit;
}

}  // namespace lamella
