#include "distribute/metrics.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "tests/reference/ssim_reference.h"

namespace lamella {
namespace {

Image<Rgb8> Noise(int width, int height, std::uint32_t seed) {
  std::mt19937 random(seed);
  Image<Rgb8> image(width, height);
  const auto code = [&] { return static_cast<std::uint8_t>(random() >> 24); };
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = {code(), code(), code()};
  return image;
}

TEST(Psnr, OfAConstantDifferenceIsTheClosedForm) {
  const Image<Rgb8> a(7, 5, {100, 100, 100}), b(7, 5, {110, 100, 90});
  const double mse = 2.0 * 100 / 3 / (255.0 * 255.0);
  EXPECT_NEAR(*Psnr(a.span(), b.span()), -10 * std::log10(mse), 1e-12);
}

TEST(Psnr, OfEqualPicturesIsInfinite) {
  const Image<Rgb8> a = Noise(9, 4, 1);
  EXPECT_TRUE(std::isinf(*Psnr(a.span(), a.span())));
}

TEST(Psnr, LeavesOutTheBorderAndWhatTheMaskLeavesOut) {
  Image<Rgb8> a(6, 6, {50, 50, 50}), b = a.Clone();
  b(0, 3) = {0, 0, 0};  // border
  b(2, 2) = {0, 0, 0};  // masked
  b(3, 3) = {60, 50, 50};
  Image<float> mask(6, 6, 1.0F);
  mask(2, 2) = 0.49F;
  const SquaredError error = SumSquaredError(a.span(), b.span(), {1, mask.span()});
  EXPECT_EQ(error.count, 3 * 15);
  EXPECT_NEAR(error.sum, 100 / (255.0 * 255.0), 1e-15);
}

TEST(Psnr, OfNoPixelIsNothing) {
  const Image<Rgb8> a(6, 6), none;
  EXPECT_FALSE(Psnr(a.span(), a.span(), {3, {}}).has_value());
  EXPECT_FALSE(Psnr(none.span(), none.span()).has_value());
  EXPECT_FALSE(Ssim(none.span(), none.span()).has_value());
  EXPECT_FALSE(Ssim(a.span(), a.span(), {100, {}}).has_value());
}

TEST(Metrics, RefuseDifferentSizes) {
  const Image<Rgb8> a(6, 6), b(6, 7);
  EXPECT_THROW(Psnr(a.span(), b.span()), Error);
  EXPECT_THROW(Ssim(a.span(), b.span()), Error);
}

TEST(Ssim, IsOneForEqualPicturesAndLowForUnrelatedOnes) {
  const Image<Rgb8> a = Noise(40, 30, 1), b = Noise(40, 30, 2);
  EXPECT_NEAR(*Ssim(a.span(), a.span()), 1.0, 1e-12);
  EXPECT_LT(*Ssim(a.span(), b.span()), 0.1);
}

TEST(Ssim, OfFlatPicturesIsTheLuminanceTermAlone) {
  const Image<Rgb8> a(20, 20, {51, 51, 51}), b(20, 20, {102, 102, 102});
  const double u = 0.2, v = 0.4, c1 = 1e-4;
  EXPECT_NEAR(*Ssim(a.span(), b.span()), (2 * u * v + c1) / (u * u + v * v + c1), 1e-9);
}

TEST(Ssim, MatchesTheDirectWindowAtEverySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {13, 4}, {31, 27}}) {
    const Image<Rgb8> a = Noise(width, height, 3), b = Noise(width, height, 4);
    Image<float> mask(width, height, 1.0F);
    for (std::size_t i = 0; i < mask.size(); i += 3) mask.data()[i] = 0;
    EXPECT_NEAR(*Ssim(a.span(), b.span()), *reference::Ssim(a.span(), b.span(), {}), 1e-12);
    const MetricRegion inner{std::min(width, height) / 4, mask.span()};
    const auto ssim = Ssim(a.span(), b.span(), inner);
    const auto expected = reference::Ssim(a.span(), b.span(), inner);
    ASSERT_EQ(ssim.has_value(), expected.has_value());
    if (ssim) {
      EXPECT_NEAR(*ssim, *expected, 1e-12);
    }
  }
}

TEST(Ssim, DoesNotDependOnTheNumberOfThreads) {
  const Image<Rgb8> a = Noise(50, 60, 5), b = Noise(50, 60, 6);
  const double many = *Ssim(a.span(), b.span());
  const ThreadLimit one(1);
  EXPECT_EQ(many, *Ssim(a.span(), b.span()));
}

}  // namespace
}  // namespace lamella
