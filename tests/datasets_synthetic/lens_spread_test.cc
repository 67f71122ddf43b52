#include "datasets_synthetic/lens_spread.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace lamella {
namespace {

// A half pixel's number by a rule of its own, borders held.
float HalfPixel(int x, int y, int width, int height) {
  x = std::clamp(x, 0, width - 1);
  y = std::clamp(y, 0, height - 1);
  return static_cast<float>((x * 7 + y * 13 + x * y) % 17) / 17;
}

// At every width about the numbers that registers hold at once.
TEST(LensSpread, IsTheGaussianSummedAsItStands) {
  for (const double sigma : {0.3, 1.0, 1.7}) {
    for (int width = 1; width <= 13; ++width) {
      const int height = 5;
      const LensSpread spread(sigma);
      Image<Rgb> rows(width, 2 * height), half(2 * width, 1);
      for (int y = 0; y < 2 * height; ++y) {
        for (int x = 0; x < 2 * width; ++x) {
          const float value = HalfPixel(x, y, 2 * width, 2 * height);
          half(x, 0) = {value, 2 * value, 1};
        }
        spread.AlongX(half.row(0), width, rows.row(y));
      }
      const int reach = static_cast<int>(std::ceil(8 * sigma));
      EXPECT_EQ(spread.reach(), reach);
      Image<Rgb> row(width, 1);
      for (int y = 0; y < height; ++y) {
        spread.AlongY(rows, 0, 2 * height, y, row.row(0));
        for (int x = 0; x < width; ++x) {
          double sum = 0, weights = 0;
          for (int j = -reach; j <= reach; ++j) {
            for (int i = -reach; i <= reach; ++i) {
              const double weight = std::exp(-(i * i + j * j) / (8 * sigma * sigma));
              weights += 4 * weight;
              for (const int part : {0, 1, 2, 3}) {
                sum += weight *
                       static_cast<double>(HalfPixel(2 * x + part % 2 + i, 2 * y + part / 2 + j,
                                                     2 * width, 2 * height));
              }
            }
          }
          EXPECT_NEAR(row(x, 0).r, sum / weights, 1e-6) << sigma << " " << width << " " << x;
          EXPECT_NEAR(row(x, 0).g, 2 * sum / weights, 2e-6);
          EXPECT_NEAR(row(x, 0).b, 1, 1e-6);
        }
      }
    }
  }
}

}  // namespace
}  // namespace lamella
