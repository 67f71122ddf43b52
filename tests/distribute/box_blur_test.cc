#include "distribute/box_blur.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace lamella {
namespace {

constexpr int kPixels = 41, kMiddle = kPixels / 2;

// A row with one pixel of light in its middle, and room for what any of these filters reads.
std::vector<Light> Blurred(const BoxFilter& box, const std::vector<Light>& row) {
  const std::size_t room = static_cast<std::size_t>(box.core) + 1;
  std::vector<Light> padded(row.size() + 2 * room);
  std::copy(row.begin(), row.end(), padded.begin() + static_cast<std::ptrdiff_t>(room));
  std::vector<Light> blurred(row.size());
  BlurRow(box, padded.data() + room, static_cast<int>(row.size()), blurred.data());
  return blurred;
}

std::vector<Light> Spike(float light) {
  std::vector<Light> row(kPixels);
  row[kMiddle] = {light, 2 * light, 3 * light, 1};
  return row;
}

TEST(BoxBlur, HasTheVarianceOfTheBoxAtEveryWidth) {
  for (double width = 0; width < 15; width += 0.37) {
    const std::vector<Light> blurred = Blurred(BoxOfWidth(width), Spike(1));
    double sum = 0, variance = 0;
    for (int i = 0; i < kPixels; ++i) {
      const double weight = static_cast<double>(blurred[static_cast<std::size_t>(i)].g) / 2;
      EXPECT_GE(weight, 0);
      sum += weight;
      variance += weight * (i - kMiddle) * (i - kMiddle);
    }
    EXPECT_NEAR(sum, 1, 1e-6) << width;
    EXPECT_NEAR(variance, width * width / 12, 1e-4) << width;
  }
}

TEST(BoxBlur, LeavesOfAWaveWhatABoxLeaves) {
  constexpr double kFrequency = 0.05;  // per px
  for (double width = 0.3; width < 15; width += 0.7) {
    std::vector<Light> row(400);
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i].r = static_cast<float>(std::cos(2 * M_PI * kFrequency * static_cast<double>(i)));
    }
    const double left = static_cast<double>(Blurred(BoxOfWidth(width), row)[200].r);
    const double angle = M_PI * kFrequency * width;
    EXPECT_NEAR(left, std::sin(angle) / angle, 0.003) << width;
  }
}

TEST(BoxBlur, BlursColumnsAsRows) {
  for (const double width : {0.0, 0.8, 2.3, 6.0}) {
    const BoxFilter box = BoxOfWidth(width);
    const std::vector<Light> row = Blurred(box, Spike(0.7F));
    const int room = box.core + 1;
    Image<Light> in(2, kPixels + 2 * room), out(2, kPixels);
    in(1, kMiddle + room) = Spike(0.7F)[kMiddle];
    BlurColumns(box, in.span(), out.span());
    for (int y = 0; y < kPixels; ++y) {
      EXPECT_EQ(out(1, y).b, row[static_cast<std::size_t>(y)].b) << width << " " << y;
      EXPECT_EQ(out(0, y).coverage, 0);
    }
  }
}

TEST(BoxBlur, LeavesNothingBehindBrightLight) {
  std::vector<Light> row = Spike(1e8F);
  row[0] = {0.3F, 0.3F, 0.3F, 1};
  row[kPixels - 1] = row[0];
  const std::vector<Light> blurred = Blurred(BoxOfWidth(5.5), row);
  EXPECT_NEAR(blurred[kPixels - 1].r, blurred[0].r, 1e-6);
  EXPECT_GT(blurred[0].r, 0.05);
}

}  // namespace
}  // namespace lamella
