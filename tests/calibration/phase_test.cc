// Decoded phases against the sinusoids and homographies that they came from.
#include "calibration/phase.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "tests/calibration/panel_view.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

constexpr int kPanelWidth = 1920, kPanelHeight = 1080;
constexpr double kSigma = 0.0056;

// PhasePhotographs that own their pixels.
struct PhasePhotographs {
  std::vector<Image<float>> images;
  PhaseCapture capture;
};

// Every series of the panel, each image made by `photograph(series, step)`.
template <class Make>
PhasePhotographs AllSeries(Make photograph, Image<float> white, Image<float> black) {
  PhasePhotographs photos;
  const auto all = PhaseSeriesOf(kPanelWidth, kPanelHeight);
  for (const PhaseSeries& series : all) {
    for (int k = 0; k < series.steps; ++k) photos.images.push_back(photograph(series, k));
  }
  std::size_t next = 0;
  for (const PhaseSeries& series : all) {
    PhasePhotos group{series, {}};
    for (int k = 0; k < series.steps; ++k) group.photos.push_back(photos.images[next++].span());
    photos.capture.series.push_back(group);
  }
  photos.images.push_back(std::move(white));
  photos.capture.white = photos.images.back().span();
  photos.images.push_back(std::move(black));
  photos.capture.black = photos.images.back().span();
  photos.capture.width_px = kPanelWidth;
  photos.capture.height_px = kPanelHeight;
  return photos;
}

// Ideal sinusoids: pixel (x, y) of the photograph sees (u, v) = (x + 0.5, y + 0.5) / 2.2 + where.
PhasePhotographs Ideal(int size, double modulation, const Vector2d& where, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, kSigma);
  const auto level = [&](double light) {
    Image<float> image(size, size);
    for (std::size_t i = 0; i < image.size(); ++i) {
      image.data()[i] = static_cast<float>(light + noise(random));
    }
    return image;
  };
  const auto photograph = [&](const PhaseSeries& series, int k) {
    Image<float> image(size, size);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double u = (series.axis == PanelAxis::kU ? where.x() + (x + 0.5) / 2.2
                                                       : where.y() + (y + 0.5) / 2.2);
        const double turns = u / series.period_px - static_cast<double>(k) / series.steps;
        image(x, y) = static_cast<float>(
            0.45 + 0.45 * modulation * std::cos(2 * std::numbers::pi * turns) + noise(random));
      }
    }
    return image;
  };
  return AllSeries(photograph, level(0.45 + 0.45 * modulation), level(0.45 - 0.45 * modulation));
}

TEST(DecodePhase, HasTheErrorOfItsFormulaAndNoWrongFringe) {
  for (const double modulation : {0.8, 0.2}) {
    for (const Vector2d& where : {Vector2d(0, 0), Vector2d(1780, 940)}) {
      const PhasePhotographs photos = Ideal(300, modulation, where, 5);
      const ScreenMap map = DecodePhase(photos.capture);
      double sum = 0, ratio = 0;
      int count = 0, wrong = 0;
      for (int y = 0; y < 300; ++y) {
        for (int x = 0; x < 300; ++x) {
          if (map.valid(x, y) == 0) continue;
          const double error = static_cast<double>(map.u_px(x, y)) - where.x() - (x + 0.5) / 2.2;
          const double error_v = static_cast<double>(map.v_px(x, y)) - where.y() - (y + 0.5) / 2.2;
          if (std::abs(error) > 4 || std::abs(error_v) > 4) ++wrong;
          const auto sigma = static_cast<double>(map.sigma_u(x, y));
          sum += error * error;
          ratio += error * error / (sigma * sigma);
          ++count;
        }
      }
      EXPECT_EQ(wrong, 0);
      EXPECT_GT(count, 300 * 300 * 85 / 100);
      EXPECT_NEAR(std::sqrt(ratio / count), 1, 0.05);
      EXPECT_LT(std::sqrt(sum / count), modulation == 0.8 ? 0.02 : 0.08);
    }
  }
}

TEST(DecodePhase, TakesTheGivenNoise) {
  const PhasePhotographs photos = Ideal(60, 0.8, {100, 100}, 1);
  const ScreenMap estimated = DecodePhase(photos.capture);
  const ScreenMap given = DecodePhase(photos.capture, SensorNoise{0, 4 * kSigma * kSigma});
  const ScreenMap shot = DecodePhase(photos.capture, SensorNoise{kSigma * kSigma / 0.45, 0});
  EXPECT_NEAR(given.sigma_u(30, 30) / estimated.sigma_u(30, 30), 2, 0.1);
  EXPECT_NEAR(shot.sigma_u(30, 30) / estimated.sigma_u(30, 30), 1, 0.05);
}

// A panel's staircase through a blurred camera, 2.2 px per panel px, in perspective.
PhasePhotographs Rendered(const PanelView& view, const PhotoNoise& noise) {
  std::uint32_t seed = 1;
  const auto shown = [&](const Image<Rgb8>& codes) {
    return Exposed(view.Photograph(codes.span()).span(), noise, seed++);
  };
  return AllSeries([&](const PhaseSeries& series,
                       int k) { return shown(DrawPhase(kPanelWidth, kPanelHeight, series, k)); },
                   shown(Image<Rgb8>(kPanelWidth, kPanelHeight, {255, 255, 255})),
                   shown(Image<Rgb8>(kPanelWidth, kPanelHeight)));
}

TEST(ObserveNodes, AreWithinThousandthsOfAPixel) {
  PanelViewOptions options;
  options.width_px = 190;
  options.height_px = 150;
  options.scale = 2.2;
  options.yaw_deg = 20;
  options.roll_deg = 7;
  options.focal_px = 4000;
  options.middle_u = 0.7;
  options.middle_v = 0.4;
  const PanelView view(kPanelWidth, kPanelHeight, options);
  const PhasePhotographs photos = Rendered(view, {0.02, 0.85, kSigma, false});
  const ScreenMap map = DecodePhase(photos.capture);
  // Per pixel: random and staircase.
  double sum = 0;
  int count = 0;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.valid(x, y) == 0) continue;
      const Vector2d truth = view.PanelFromImage({x + 0.5, y + 0.5});
      sum += (Vector2d(static_cast<double>(map.u_px(x, y)), static_cast<double>(map.v_px(x, y))) -
              truth)
                 .squaredNorm() /
             2;
      ++count;
    }
  }
  EXPECT_GT(count, 150 * 100);
  EXPECT_LT(std::sqrt(sum / count), 0.03);
  // Nodes every few pixels, in the photograph's pixels.
  std::vector<Vector2d> nodes;
  const Vector2d middle = view.PanelFromImage({95, 75});
  for (int j = -2; j <= 2; ++j) {
    for (int i = -2; i <= 2; ++i) nodes.emplace_back(middle + Vector2d(12.3 * i, 9.7 * j));
  }
  const std::vector<Observation> seen = ObserveNodes(map, nodes);
  EXPECT_EQ(seen.size(), nodes.size());
  double squares = 0, normalised = 0;
  Vector2d bias(0, 0);
  for (const Observation& node : seen) {
    const Vector2d error = node.image_px - view.ImageFromPanel(node.panel_px);
    squares += error.squaredNorm() / 2;
    bias += error / static_cast<double>(seen.size());
    normalised += error.dot(node.covariance_px2.inverse() * error) / 2;
  }
  const auto n = static_cast<double>(seen.size());
  EXPECT_LT(std::sqrt(squares / n), 0.003);
  EXPECT_LT(bias.norm(), 0.002);
  EXPECT_LT(normalised / n, 3);
  EXPECT_GT(normalised / n, 0.3);
}

// An amplitude of two standard deviations: one pixel is 0.64 px wrong, and a whole period often.
TEST(DecodePeriod, IsTheFinePhaseOfFaintSinusoids) {
  const PhasePhotographs photos = Ideal(120, 2 * kSigma / 0.45, {300, 500}, 3);
  const ScreenMap whole = DecodePhase(photos.capture), fine = DecodePeriod(photos.capture, 16);
  double sum = 0, ratio = 0;
  int count = 0, whole_count = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 120; ++x) {
      whole_count += whole.valid(x, y);
      if (fine.valid(x, y) == 0) continue;
      double off = static_cast<double>(fine.v_px(x, y)) - 500 - (y + 0.5) / 2.2;
      off -= 16 * std::round(off / 16);
      sum += off * off;
      ratio += std::pow(off / static_cast<double>(fine.sigma_v(x, y)), 2);
      ++count;
    }
  }
  EXPECT_LT(whole_count, 100);
  EXPECT_GT(count, 120 * 120 * 6 / 10);
  EXPECT_NEAR(std::sqrt(sum / count), 0.62, 0.04);
  EXPECT_NEAR(std::sqrt(ratio / count), 1, 0.1);
  EXPECT_THROW(DecodePeriod(photos.capture, 17), Error);
}

TEST(DecodePhase, LeavesOutWhatIsDarkOrOverexposed) {
  PhasePhotographs photos = Ideal(80, 0.8, {500, 500}, 2);
  for (Image<float>& image : photos.images) {
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 20; ++x) image(x, y) = 0.01F;
      for (int x = 60; x < 80; ++x) image(x, y) = std::min(1.0F, 3 * image(x, y));
    }
  }
  const ScreenMap map = DecodePhase(photos.capture, SensorNoise{0, kSigma * kSigma});
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 23; ++x) EXPECT_EQ(map.valid(x, y), 0) << x << " " << y;
    for (int x = 57; x < 80; ++x) EXPECT_EQ(map.valid(x, y), 0) << x << " " << y;
  }
  EXPECT_EQ(map.valid(40, 40), 1);
}

TEST(DecodePhase, HasTheSinusoidsThroughLensesOnly) {
  constexpr int kSize = 60;
  const Vector2d where(500, 300);
  PhasePhotographs photos = Ideal(kSize, 0.8, where, 3);
  for (Image<float>& image : photos.images) image(7, 9) = 0.01F;
  EXPECT_TRUE(DecodePhase(photos.capture).sinusoids.empty());
  photos.capture.through_lenses = true;
  const ScreenMap map = DecodePhase(photos.capture, SensorNoise{0, kSigma * kSigma});
  const auto all = PhaseSeriesOf(kPanelWidth, kPanelHeight);
  ASSERT_EQ(map.sinusoids.size(), all.size());
  for (std::size_t s = 0; s < all.size(); ++s) {
    EXPECT_EQ(map.sinusoids[s](7, 9), std::complex<float>(0, 0));
    double sum = 0;
    for (int y = 20; y < kSize; ++y) {
      for (int x = 20; x < kSize; ++x) {
        const double at = all[s].axis == PanelAxis::kU ? where.x() + (x + 0.5) / 2.2
                                                       : where.y() + (y + 0.5) / 2.2;
        const auto truth = std::polar(std::sqrt(all[s].steps / 2.0) * 0.45 * 0.8,
                                      2 * std::numbers::pi * at / all[s].period_px);
        sum += std::norm(std::complex<double>(map.sinusoids[s](x, y)) - truth) / 2;
      }
    }
    EXPECT_NEAR(std::sqrt(sum) / (kSize - 20), kSigma, 0.03 * kSigma) << s;
  }
}

TEST(DecodePhase, RefusesWhatIsNotWhole) {
  const auto refusal = [](auto change) {
    PhasePhotographs photos = Ideal(8, 0.8, {500, 500}, 2);
    change(photos.capture);
    try {
      DecodePhase(photos.capture);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal([](auto& c) { c.series[0].photos.pop_back(); }),
              ::testing::HasSubstr("u_0016: has 7 photographs, not 8"));
  EXPECT_THAT(refusal([](auto& c) { c.series.erase(c.series.begin() + 2); }),
              ::testing::HasSubstr("the coarsest period is 128 px"));
  EXPECT_THAT(refusal([](auto& c) { c.white.width = 4; }), ::testing::HasSubstr("different sizes"));
}

TEST(PhaseSeries, AreFineToCoarseAndCoverThePanel) {
  const auto series = PhaseSeriesOf(1920, 1080);
  ASSERT_EQ(series.size(), 6U);
  EXPECT_EQ(series[0], (PhaseSeries{PanelAxis::kU, 16, 8}));
  EXPECT_EQ(series[2], (PhaseSeries{PanelAxis::kU, 2048, 4}));
  EXPECT_EQ(series[5], (PhaseSeries{PanelAxis::kV, 2048, 4}));
  EXPECT_EQ(PhaseSeriesOf(3840, 2160)[3], (PhaseSeries{PanelAxis::kU, 4096, 4}));
  EXPECT_EQ(PhaseSeriesOf(100000, 10)[4].period_px, 131072);
  EXPECT_EQ(PhaseSeriesOf(128, 129)[1], (PhaseSeries{PanelAxis::kU, 128, 4}));
  EXPECT_EQ(PhaseSeriesOf(128, 129)[2], (PhaseSeries{PanelAxis::kV, 16, 8}));
  EXPECT_EQ(PhaseSeriesOf(128, 129).back(), (PhaseSeries{PanelAxis::kV, 2048, 4}));
}

TEST(DrawPhase, IsASinusoidOfLight) {
  const Image<Rgb8> image = DrawPhase(64, 3, {PanelAxis::kU, 16, 8}, 2);
  // Brightest where u/16 = 2/8: u = 4, between columns 3 and 4.
  EXPECT_EQ(image(3, 0).g, image(4, 0).g);
  EXPECT_GT(image(4, 0).g, image(5, 0).g);
  EXPECT_EQ(image(3, 0).g, image(19, 2).g);
  EXPECT_EQ(DrawPhase(3, 64, {PanelAxis::kV, 16, 8}, 2)(1, 9).g, image(9, 1).g);
}

}  // namespace
}  // namespace lamella
