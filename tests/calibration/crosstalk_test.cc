// Crosstalk against chance: lines of sight through random places of opening and pupil to emitters
// whose light is thrown at random.
#include "calibration/crosstalk.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::VectorXd;
using ::testing::HasSubstr;

// How far an emitter's light is thrown: of whole pixels, where in its pixel it came from stays.
double Thrown(SpreadKind kind, double way) {
  return kind == SpreadKind::kDiffuse ? way : std::round(way);
}

// The shares of the K views in 2e5 lines of sight.
VectorXd ByChance(const CrosstalkSetup& setup, SpreadKind kind, double spread_px, double place,
                  std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5), turn(0, 2 * std::numbers::pi);
  std::normal_distribution<double> normal;
  VectorXd views = VectorXd::Zero(setup.num_views);
  constexpr int kLines = 200000;
  for (int i = 0; i < kLines; ++i) {
    const double radius = setup.pupil_px / 2 * std::sqrt(uniform(random) + 0.5);
    const double at = 0.5 + place + setup.opening_px * uniform(random) +
                      radius * std::cos(turn(random)) + setup.drift_px * uniform(random) +
                      Thrown(kind, spread_px * normal(random));
    const double view =
        std::floor(at) - setup.num_views * std::floor(std::floor(at) / setup.num_views);
    views(static_cast<Eigen::Index>(view)) += 1.0 / kLines;
  }
  return views;
}

TEST(ViewsSeen, AreSharesOfLinesOfSight) {
  for (const CrosstalkSetup& setup :
       {CrosstalkSetup{8, 1, 0, 0.3}, CrosstalkSetup{5, 0.6, 0.8, 0}}) {
    for (const auto kind : {SpreadKind::kDiffuse, SpreadKind::kWholePixels}) {
      for (const double place : {0.0, -1.7}) {
        const VectorXd seen = ViewsSeen(setup, kind, 0.5, place);
        EXPECT_NEAR(seen.sum(), 1, 1e-9);
        EXPECT_LT((seen - ByChance(setup, kind, 0.5, place, 1)).cwiseAbs().maxCoeff(), 0.006);
      }
    }
  }
}

// A pupil of 5 % of a zone of 20 views: photographs say more crosstalk than there is.
void ExpectTruth(SpreadKind kind, double spread_px) {
  const CrosstalkSetup setup{20, 0.5, 1, 0.2};
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 2e-4);
  std::vector<VectorXd> series;
  for (int j = 0; j < 8; ++j) {
    VectorXd lights =
        ByChance(setup, kind, spread_px, 0.13 * j - 0.4 + j, static_cast<std::uint32_t>(j + 10));
    for (double& light : lights) light = 3000 * (light + 0.01 + noise(random));
    series.push_back(lights);
  }
  const CrosstalkFit fit = FitCrosstalk(series, setup, "layer 0");
  EXPECT_EQ(fit.kind, kind);
  EXPECT_NEAR(fit.spread_px, spread_px, 0.01);
  EXPECT_LT(fit.spread_sd_px, 0.005);
  const VectorXd truth = ByChance({20, 0.5, 0, 0}, kind, spread_px, 3, 99);
  EXPECT_LT((fit.without_pupil.row(3).transpose() - truth).cwiseAbs().maxCoeff(), 0.005);
  EXPECT_GT(fit.with_pupil(3, 4) - fit.without_pupil(3, 4), 0.012);
  EXPECT_NEAR(fit.without_pupil.row(0).sum(), 1, 1e-9);
  EXPECT_NEAR(fit.without_pupil(0, 19), fit.without_pupil(0, 1), 1e-9);
}

TEST(FitCrosstalk, TakesTheCamerasPupilOut) {
  ExpectTruth(SpreadKind::kDiffuse, 0.35);
  ExpectTruth(SpreadKind::kWholePixels, 0.5);
}

// What 20 displays' errors are in their stated deviations, root mean square: of the spread, of its
// kernel's middle weight and of a neighbour's share.
struct Normalised {
  double spread = 0, own = 0, neighbour = 0;
};

// Lights count photons; the pupil is not what it is taken for.
Normalised ErrorsOverDraws(const CrosstalkSetup& setup, SpreadKind kind, double spread_px,
                           double electrons) {
  constexpr int kDraws = 20, kSeries = 12;
  const CrosstalkSetup eye{setup.num_views, setup.opening_px};
  const SpreadKernel kernel = GaussianSpread(
      kind == SpreadKind::kWholePixels ? spread_px : std::sqrt(spread_px * spread_px - 1.0 / 12));
  const double own = kernel.weights[kernel.weights.size() / 2];
  const double neighbour = ViewsSeen(eye, kind, spread_px, 0)(1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Normalised sum;
  for (int draw = 0; draw < kDraws; ++draw) {
    CrosstalkSetup truth = setup;
    truth.pupil_px += setup.pupil_sd_px * normal(random);
    std::vector<VectorXd> series;
    for (int j = 0; j < kSeries; ++j) {
      VectorXd lights = ViewsSeen(truth, kind, spread_px, 0.37 * j - 0.4);
      for (double& light : lights) {
        const double counted = electrons * (light + 0.01);
        light = counted + std::sqrt(counted) * normal(random);
      }
      series.push_back(lights);
    }
    const CrosstalkFit fit = FitCrosstalk(series, setup, "layer 0");
    EXPECT_EQ(fit.kind, kind);
    sum.spread += std::pow((fit.spread_px - spread_px) / fit.spread_sd_px, 2);
    const double middle = fit.kernel.weights[fit.kernel.weights.size() / 2];
    sum.own += std::pow((middle - own) / fit.own_sd, 2);
    sum.neighbour += std::pow((fit.without_pupil(0, 1) - neighbour) / fit.neighbour_sd, 2);
  }
  const auto root = [](double squares) { return std::sqrt(squares / kDraws); };
  return {root(sum.spread), root(sum.own), root(sum.neighbour)};
}

void ExpectAboutOne(const Normalised& errors) {
  for (const double error : {errors.spread, errors.own, errors.neighbour}) {
    EXPECT_GT(error, 0.7);
    EXPECT_LT(error, 1.4);
  }
}

TEST(FitCrosstalk, ErrsByWhatItStates) {  // by noise, then by the pupil
  ExpectAboutOne(ErrorsOverDraws({8, 1, 1, 0.1, 0}, SpreadKind::kDiffuse, 0.6, 1e4));
  ExpectAboutOne(ErrorsOverDraws({8, 1, 1, 0.1, 0.05}, SpreadKind::kWholePixels, 0.6, 1e6));
}

// So narrow a diffuse spread is none in whole pixels; that is not known without error.
TEST(FitCrosstalk, IsNeverCertainOfAnEmittersOwnLight) {
  const CrosstalkSetup setup{8, 1, 1, 0.1, 0.05};
  std::vector<VectorXd> series;
  for (int j = 0; j < 4; ++j) {
    series.push_back(1e4 * ViewsSeen(setup, SpreadKind::kDiffuse, 0.2, 0.37 * j - 0.4));
    for (int k = 0; k < 8; ++k) series.back()(k) += 20 * std::sin(7.0 * j + 3.0 * k) + 100;
  }
  const CrosstalkFit fit = FitCrosstalk(series, setup, "layer 0");
  EXPECT_GT(fit.neighbour_sd, 0);
  EXPECT_GT(fit.own_sd, 0);
}

TEST(FitCrosstalk, RefusesWhatIsNotWhole) {
  const auto refusal = [](const std::vector<VectorXd>& series) {
    try {
      FitCrosstalk(series, {}, "layer 2 emitter");
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal({}), HasSubstr("layer 2 emitter: no part of it"));
  EXPECT_THAT(refusal({VectorXd::Ones(5)}), HasSubstr("are not 8 with light"));
  EXPECT_THAT(refusal({VectorXd::Zero(8)}), HasSubstr("are not 8 with light"));
}

}  // namespace
}  // namespace lamella
