#include "calibration/crosstalk.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/calibration.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of a spread over pixels, along one axis: from the middle pixel's share on.
std::vector<double> SharesOf(double spread_px) {
  const SpreadKernel kernel = GaussianSpread(spread_px);
  std::vector<double> shares;
  for (int x = kernel.size / 2; x < kernel.size; ++x) {
    double sum = 0;
    for (int y = 0; y < kernel.size; ++y) {
      const int index = y * kernel.size + x;
      sum += kernel.weights[static_cast<std::size_t>(index)];
    }
    shares.push_back(sum);
  }
  return shares;
}

// The double integral of a Gaussian: a ramp where there is none.
double SmoothRamp(double x, double sigma) {
  if (sigma <= 0 || std::abs(x) > 8 * sigma) return std::max(0.0, x);
  const double u = x / sigma;
  return x * std::erfc(-u / std::numbers::sqrt2) / 2 +
         sigma * std::exp(-u * u / 2) / std::sqrt(2 * std::numbers::pi);
}

// The boxes of an emitter and an opening, one over the other and over a Gaussian: of sum 1.
double Overlap(double x, double opening_px, double sigma) {
  const double outer = (1 + opening_px) / 2, inner = std::abs(1 - opening_px) / 2;
  const double overlap = SmoothRamp(x + outer, sigma) - SmoothRamp(x + inner, sigma) -
                         SmoothRamp(x - inner, sigma) + SmoothRamp(x - outer, sigma);
  return std::max(0.0, overlap) / opening_px;  // not the rounding's -1e-17
}

struct Node {
  double at, weight;
};

// A disc of a diameter as seen from its side (Gauss and Chebyshev, of the second kind).
std::vector<Node> DiscNodes(double diameter) {
  constexpr int kNodes = 10;
  if (diameter == 0) return {{0, 1}};
  std::vector<Node> nodes;
  for (int i = 1; i <= kNodes; ++i) {
    const double angle = std::numbers::pi * i / (kNodes + 1), sine = std::sin(angle);
    nodes.push_back({diameter / 2 * std::cos(angle), 2.0 / (kNodes + 1) * sine * sine});
  }
  return nodes;
}

// A box (Gauss and Legendre).
std::vector<Node> BoxNodes(double width) {
  if (width == 0) return {{0, 1}};
  const double at = width / 2 * std::sqrt(0.6);
  return {{-at, 5.0 / 18}, {0, 8.0 / 18}, {at, 5.0 / 18}};
}

// The share of view 0 over the place where a line of sight meets the row, from a table.
class Profile {
 public:
  Profile(const CrosstalkSetup& setup, SpreadKind kind, double spread_px)
      : period_(setup.num_views) {
    const bool diffuse = kind == SpreadKind::kDiffuse;
    const std::vector<double> shares = SharesOf(diffuse ? 0 : spread_px);
    const std::vector<Node> pupil = DiscNodes(setup.pupil_px), drift = BoxNodes(setup.drift_px);
    const auto once = [&](double place) {
      double sum = 0;
      const int reach = static_cast<int>(shares.size()) - 1;
      for (int i = -reach; i <= reach; ++i) {
        const double share = shares[static_cast<std::size_t>(std::abs(i))];
        for (const Node& p : pupil) {
          for (const Node& d : drift) {
            sum += share * p.weight * d.weight *
                   Overlap(place - i - p.at - d.at, setup.opening_px, diffuse ? spread_px : 0);
          }
        }
      }
      return sum;
    };
    for (int i = 0; i <= setup.num_views * kSteps / 2 + 1; ++i) {
      const double place = static_cast<double>(i) / kSteps;
      table_.push_back(once(place) + once(place - period_) + once(place + period_));
    }
  }
  double At(double place) const {
    const double wrapped = std::abs(place - period_ * std::round(place / period_)) * kSteps;
    const auto i = static_cast<std::size_t>(wrapped);
    const double t = wrapped - static_cast<double>(i);
    return (1 - t) * table_[i] + t * table_[i + 1];
  }

 private:
  static constexpr int kSteps = 64;  // per emitter
  double period_;
  std::vector<double> table_;
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
    cosine += series(k) * std::cos(2 * std::numbers::pi * static_cast<double>(k) / K);
    sine += series(k) * std::sin(2 * std::numbers::pi * static_cast<double>(k) / K);
  }
  return std::atan2(sine, cosine) * K / (2 * std::numbers::pi);
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

MatrixXd MatrixOf(const CrosstalkSetup& setup, SpreadKind kind, double spread_px) {
  const Profile profile(setup, kind, spread_px);
  MatrixXd matrix(setup.num_views, setup.num_views);
  for (int j = 0; j < setup.num_views; ++j) {
    matrix.row(j) = ViewsAt(profile, setup.num_views, j).transpose();
  }
  return matrix;
}

struct SpreadFit {
  double spread_px = 0, sd_px = 0, squares = 0;
};

// The squares that each series leaves at a spread.
VectorXd SquaresAt(const std::vector<VectorXd>& series, const CrosstalkSetup& setup,
                   SpreadKind kind, double spread_px) {
  const Profile profile(setup, kind, spread_px);
  VectorXd squares(static_cast<Index>(series.size()));
  for (Index i = 0; i < squares.size(); ++i) {
    squares(i) = FitSeries(series[static_cast<std::size_t>(i)], profile).squares;
  }
  return squares;
}

double FreedomOf(const std::vector<VectorXd>& series, const CrosstalkSetup& setup) {
  return std::max(1.0, static_cast<double>(series.size()) * (setup.num_views - 3) - 1);
}

// Squares sum to C(spread, pupil), whose slope is 0 at the solution. Noise of the residuals' size s
// moves that by a variance of 2 s^2/C''; slopes of the series that scatter by more, since bright
// lights have more noise and parts of a panel their own faults, by the sum of their squares/C''^2;
// the pupil moves it by -dC'/dpupil/C''.
double SpreadSd(const std::vector<VectorXd>& series, const CrosstalkSetup& setup, SpreadKind kind,
                const SpreadFit& fit) {
  constexpr double kStepPx = 0.02;
  const double middle = std::max(fit.spread_px, kStepPx);
  const auto at = [&](double spread_px) { return SquaresAt(series, setup, kind, spread_px); };
  const VectorXd low = at(middle - kStepPx), high = at(middle + kStepPx);
  const double curvature =
      std::max((high.sum() + low.sum() - 2 * at(middle).sum()) / (kStepPx * kStepPx), 1e-12);
  double variance = 2 * fit.squares / FreedomOf(series, setup) / curvature;
  if (series.size() > 1) {
    const VectorXd slopes = (high - low) / (2 * kStepPx);
    const double num = static_cast<double>(series.size());
    const double scatter = num / (num - 1) * (slopes.array() - slopes.mean()).square().sum();
    variance = std::max(variance, scatter / (curvature * curvature));
  }
  if (setup.pupil_sd_px > 0) {
    const auto slope = [&](double pupil_px) {
      CrosstalkSetup other = setup;
      other.pupil_px = pupil_px;
      return (SquaresAt(series, other, kind, middle + kStepPx).sum() -
              SquaresAt(series, other, kind, middle - kStepPx).sum()) /
             (2 * kStepPx);
    };
    const double narrow = std::max(0.0, setup.pupil_px - setup.pupil_sd_px);
    const double change = slope(narrow + 2 * setup.pupil_sd_px) - slope(narrow);
    variance += std::pow(change / 2 / curvature, 2);
  }
  return std::sqrt(variance);
}

SpreadFit FitSpread(const std::vector<VectorXd>& series, const CrosstalkSetup& setup,
                    SpreadKind kind) {
  const auto cost = [&](double spread_px) {
    return SquaresAt(series, setup, kind, spread_px).sum();
  };
  SpreadFit fit;
  fit.spread_px = GoldenSection(cost, 0, setup.num_views / 3.0);
  fit.squares = cost(fit.spread_px);
  fit.sd_px = SpreadSd(series, setup, kind, fit);
  return fit;
}

SpreadKernel KernelOf(SpreadKind kind, double spread_px) {
  if (kind == SpreadKind::kWholePixels) return GaussianSpread(spread_px);
  // A Gaussian integrated over pixels spreads by a pixel's own width more.
  return GaussianSpread(std::sqrt(std::max(0.0, spread_px * spread_px - 1.0 / 12)));
}

double MiddleOf(const SpreadKernel& kernel) { return kernel.weights[kernel.weights.size() / 2]; }

// Of a share of light that follows from a spread. The kinds' likelihoods are those of Gaussian
// residuals of the better fit's size.
double ShareSd(const std::function<double(SpreadKind, double)>& share, const SpreadFit& better,
               const SpreadFit& other, SpreadKind kind, double freedom) {
  const SpreadKind other_kind =
      kind == SpreadKind::kDiffuse ? SpreadKind::kWholePixels : SpreadKind::kDiffuse;
  const auto sd = [&](SpreadKind of, const SpreadFit& fit) {
    const double at = share(of, fit.spread_px);
    return std::max(std::abs(share(of, fit.spread_px + fit.sd_px) - at),
                    std::abs(share(of, std::max(0.0, fit.spread_px - fit.sd_px)) - at));
  };
  const double worse = (other.squares - better.squares) / std::max(better.squares, 1e-300);
  const double likely = 1 / (1 + std::exp(std::min(worse * freedom / 2, 700.0)));
  const double apart = share(other_kind, other.spread_px) - share(kind, better.spread_px);
  return std::sqrt((1 - likely) * std::pow(sd(kind, better), 2) +
                   likely * (std::pow(sd(other_kind, other), 2) + apart * apart));
}

}  // namespace

VectorXd ViewsSeen(const CrosstalkSetup& setup, SpreadKind kind, double spread_px, double place) {
  return ViewsAt(Profile(setup, kind, spread_px), setup.num_views, place);
}

CrosstalkFit FitCrosstalk(const std::vector<VectorXd>& series, const CrosstalkSetup& setup,
                          const std::string& panel) {
  CheckSeries(series, setup, panel);
  std::vector<VectorXd> shares;  // so that each has the same weight
  for (const VectorXd& lights : series) shares.emplace_back(lights / lights.sum());
  const SpreadFit diffuse = FitSpread(shares, setup, SpreadKind::kDiffuse);
  const SpreadFit whole = FitSpread(shares, setup, SpreadKind::kWholePixels);
  CrosstalkFit fit;
  fit.kind = diffuse.squares <= whole.squares ? SpreadKind::kDiffuse : SpreadKind::kWholePixels;
  const bool is_diffuse = fit.kind == SpreadKind::kDiffuse;
  const SpreadFit &better = is_diffuse ? diffuse : whole, &other = is_diffuse ? whole : diffuse;
  fit.spread_px = better.spread_px;
  fit.spread_sd_px = better.sd_px;
  fit.kernel = KernelOf(fit.kind, fit.spread_px);
  fit.rms = std::sqrt(better.squares / static_cast<double>(series.size()) / setup.num_views);
  CrosstalkSetup eye = setup;
  eye.drift_px = 0;
  fit.with_pupil = MatrixOf(eye, fit.kind, fit.spread_px);
  eye.pupil_px = 0;
  fit.without_pupil = MatrixOf(eye, fit.kind, fit.spread_px);
  const double freedom = FreedomOf(shares, setup);
  fit.own_sd =
      ShareSd([](SpreadKind kind, double spread_px) { return MiddleOf(KernelOf(kind, spread_px)); },
              better, other, fit.kind, freedom);
  fit.neighbour_sd = ShareSd(
      [&](SpreadKind kind, double spread_px) { return ViewsSeen(eye, kind, spread_px, 0)(1); },
      better, other, fit.kind, freedom);
  // A narrow diffuse spread is none in whole pixels, whatever it is: light that the next views may
  // have is what the middle may lack.
  if (MiddleOf(fit.kernel) == 1) fit.own_sd = std::max(fit.own_sd, 2 * fit.neighbour_sd);
  return fit;
}

}  // namespace lamella
