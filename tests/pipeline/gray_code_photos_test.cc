// Photographs of Gray code through a known homography, blurred, noisy and in a lit room, as files.
// The stripes are drawn here, by reflection, and not by the code that reads them.
#include "pipeline/gray_code_photos.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/image_folder.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;
using Eigen::Vector2d;

// 38 x 25 cells, of which the last column is 2 px wide: 6 and 5 bits.
constexpr int kScreenWidth = 150, kScreenHeight = 100, kCell = 4;
constexpr int kColumnBits = 6, kRowBits = 5, kPatterns = 2 * (kColumnBits + kRowBits + 1);
constexpr GrayCodePatterns kScreen{kScreenWidth, kScreenHeight, kCell};
constexpr int kPhotoWidth = 230, kPhotoHeight = 170;

// The code of twice as many numbers is the code with 0 in front, then backwards with 1 in front.
bool ReflectedBit(int number, int bits, int index) {
  int half = 1 << (bits - 1);
  bool bit = number >= half;
  for (; index > 0; --index) {
    if (bit) number = 2 * half - 1 - number;
    half /= 2;
    bit = number >= half;
  }
  return bit;
}

bool IsWhite(int pattern, int u, int v) {
  if (pattern >= kPatterns - 2) return pattern == kPatterns - 2;
  const bool bit = pattern < 2 * kColumnBits
                       ? ReflectedBit(u / kCell, kColumnBits, pattern / 2)
                       : ReflectedBit(v / kCell, kRowBits, pattern / 2 - kColumnBits);
  return bit != (pattern % 2 == 1);
}

// About 1.3 px of the photograph a pixel of the screen, whose left and right edges are seen.
Vector2d ScreenFromPhoto(const Vector2d& at) {
  Eigen::Matrix3d h;
  h << 0.76, -0.09, -6, 0.08, 0.78, -16, 2e-4, -3e-4, 1;
  return (h * at.homogeneous()).hnormalized();
}

bool IsOnScreen(const Vector2d& at) {
  return at.x() > 0 && at.y() > 0 && at.x() < kScreenWidth && at.y() < kScreenHeight;
}

// The mean of 4 x 4 lines of sight to a surface that is darker towards its right, in a lit room.
Image<float> StripesLight(int pattern) {
  Image<float> light(kPhotoWidth, kPhotoHeight);
  for (int y = 0; y < 4 * kPhotoHeight; ++y) {
    for (int x = 0; x < 4 * kPhotoWidth; ++x) {
      const Vector2d at = ScreenFromPhoto({(x + 0.5) / 4, (y + 0.5) / 4});
      const bool white =
          IsOnScreen(at) && IsWhite(pattern, static_cast<int>(at.x()), static_cast<int>(at.y()));
      const double value = 0.1 + (white ? 0.6 - 0.002 * at.x() : 0);
      light(x / 4, y / 4) += static_cast<float>(value / 16);
    }
  }
  return light;
}

// By 1/4, 1/2, 1/4 in both directions.
Image<float> BlurredLight(const Image<float>& light) {
  Image<float> blurred(light.width(), light.height());
  for (int y = 0; y < light.height(); ++y) {
    for (int x = 0; x < light.width(); ++x) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int sx = std::clamp(x + dx, 0, light.width() - 1);
          const int sy = std::clamp(y + dy, 0, light.height() - 1);
          const float weight = (dx == 0 ? 0.5F : 0.25F) * (dy == 0 ? 0.5F : 0.25F);
          blurred(x, y) += weight * light(sx, sy);
        }
      }
    }
  }
  return blurred;
}

// PNGs of 8 bits in a camera's curve, named as OpenCV's sample has it: im1.png to im24.png.
fs::path PhotographsIn(const fs::path& folder) {
  fs::create_directory(folder);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0, 0.01F);
  for (int i = 0; i < kPatterns; ++i) {
    const Image<float> light = BlurredLight(StripesLight(i));
    Image<Rgb> numbers(kPhotoWidth, kPhotoHeight);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const float value = std::pow(light.data()[k], 1 / 2.2F);
      numbers.data()[k] = {value + noise(random), value + noise(random), value + noise(random)};
    }
    WriteNumbers(folder / fmt::format("im{}.png", i + 1), numbers.span(), 8);
  }
  return folder;
}

ScreenMap ReadPhotographs(const fs::path& photos) {
  return ReadGrayCode(photos, kScreen, 0.05, SilentProgress());
}

void SwapFiles(const fs::path& folder, int i, int k) {
  const auto file = [&](int n) { return folder / fmt::format("im{}.png", n); };
  fs::rename(file(i), folder / "held");
  fs::rename(file(k), file(i));
  fs::rename(folder / "held", file(k));
}

std::string GrayCodeError(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput) << error.what();
    return error.what();
  }
  return "no error";
}

void ExpectPart(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(ReadGrayCode, TellsTheCellThatEveryPixelSeesAsWellAsItSays) {
  const ScreenMap map = ReadPhotographs(PhotographsIn(ScratchFolder() / "photos"));
  int on_screen = 0, valid_on_screen = 0;
  double sum_u = 0, sum_v = 0;  // of squares, in standard deviations
  for (int y = 0; y < kPhotoHeight; ++y) {
    for (int x = 0; x < kPhotoWidth; ++x) {
      const Vector2d truth = ScreenFromPhoto({x + 0.5, y + 0.5});
      on_screen += IsOnScreen(truth) ? 1 : 0;
      if (map.valid(x, y) == 0) continue;
      // A pixel just off the screen still sees some of it.
      const double beyond = IsOnScreen(truth) ? 0 : 1.5;
      const double error_u = static_cast<double>(map.u_px(x, y)) - truth.x();
      const double error_v = static_cast<double>(map.v_px(x, y)) - truth.y();
      const double sd_u = static_cast<double>(map.sigma_u(x, y));
      const double sd_v = static_cast<double>(map.sigma_v(x, y));
      // Half a cell is sqrt(3) of its standard deviations.
      ASSERT_LT(std::abs(error_u), std::sqrt(3.0) * sd_u + 0.05 + beyond) << x << ' ' << y;
      ASSERT_LT(std::abs(error_v), std::sqrt(3.0) * sd_v + 0.05 + beyond) << x << ' ' << y;
      if (!IsOnScreen(truth)) continue;
      ++valid_on_screen;
      sum_u += error_u * error_u / (sd_u * sd_u);
      sum_v += error_v * error_v / (sd_v * sd_v);
    }
  }
  RecordProperty("valid_share", fmt::format("{:.3f}", 1.0 * valid_on_screen / on_screen));
  RecordProperty("rms_u", fmt::format("{:.3f}", std::sqrt(sum_u / valid_on_screen)));
  EXPECT_GT(valid_on_screen, 0.6 * on_screen);
  // Pixels at the borders of cells, the least certain ones, are left out.
  for (const double sum : {sum_u, sum_v}) {
    EXPECT_GT(std::sqrt(sum / valid_on_screen), 0.75);
    EXPECT_LT(std::sqrt(sum / valid_on_screen), 1);
  }
}

TEST(ReadGrayCode, SeesTheFirstAndTheLastColumn) {
  const ScreenMap map = ReadPhotographs(PhotographsIn(ScratchFolder() / "photos"));
  const SeenOfScreen seen = SeenOf(map);
  EXPECT_EQ(seen.first_u, 2);
  EXPECT_EQ(seen.last_u, 149);  // the middle of 148 to 150
  EXPECT_EQ(seen.first_v, 2);
  EXPECT_EQ(seen.last_v, 98);
  int first = 0, last = 0;
  for (std::size_t i = 0; i < map.valid.size(); ++i) {
    if (map.valid.data()[i] == 0) continue;
    first += map.u_px.data()[i] == seen.first_u ? 1 : 0;
    last += map.u_px.data()[i] == seen.last_u ? 1 : 0;
  }
  EXPECT_GT(first, 200);
  EXPECT_GT(last, 50);
}

TEST(ReadGrayCode, RefusesPatternsInAnotherOrder) {
  const fs::path folder = PhotographsIn(ScratchFolder() / "photos");
  const auto whole = SeenOf(ReadPhotographs(folder)).num_valid;
  const auto read = [&] { ReadPhotographs(folder); };
  SwapFiles(folder, kPatterns - 1, kPatterns);  // white and black
  ExpectPart(GrayCodeError(read), "im23.png and im24.png, must be of white and black");
  SwapFiles(folder, kPatterns - 1, kPatterns);
  SwapFiles(folder, 2 * kColumnBits - 1, 2 * kColumnBits);  // the finest column bit and its inverse
  ExpectPart(GrayCodeError(read), "% of the steps from cell to cell go back");
  SwapFiles(folder, 2 * kColumnBits - 1, 2 * kColumnBits);
  for (int bit = 0; bit < kColumnBits / 2; ++bit) {  // the finest bits first
    SwapFiles(folder, 2 * bit + 1, 2 * (kColumnBits - bit) - 1);
    SwapFiles(folder, 2 * bit + 2, 2 * (kColumnBits - bit));
  }
  ExpectPart(GrayCodeError(read), "% of the steps from cell to cell go back");
  for (int bit = 0; bit < kColumnBits / 2; ++bit) {
    SwapFiles(folder, 2 * bit + 1, 2 * (kColumnBits - bit) - 1);
    SwapFiles(folder, 2 * bit + 2, 2 * (kColumnBits - bit));
  }
  EXPECT_EQ(SeenOf(ReadPhotographs(folder)).num_valid, whole);
  SwapFiles(folder, 3, 5);  // two bits, their inverses in place: clear only where the bits agree
  EXPECT_LT(SeenOf(ReadPhotographs(folder)).num_valid, 0.6 * static_cast<double>(whole));
}

TEST(ReadGrayCode, MistakesAreOneLine) {
  const fs::path folder = PhotographsIn(ScratchFolder() / "photos");
  ExpectPart(GrayCodeError([&] {
               ReadGrayCode(folder, {1024, 768, 1}, 0.05, SilentProgress());
             }),
             "photos: holds 24 photographs; 1024 x 768 px in cells of 1 px need 42; give");
  ExpectPart(GrayCodeError([&] { ReadGrayCode(folder, kScreen, 0.9, SilentProgress()); }),
             "no pixel's bits can be told");
  const auto read = [&] { ReadPhotographs(folder); };
  fs::resize_file(folder / "im7.png", 400);
  ExpectPart(GrayCodeError(read), "im7.png");
  WriteCodes8(folder / "im7.png", Image<Rgb8>(4, 3).span());
  ExpectPart(GrayCodeError(read), "im7.png: has 4 x 3 px, and im1.png has 230 x 170; take all");
  fs::remove(folder / "im7.png");
  ExpectPart(GrayCodeError(read), "holds 23 photographs");
}

TEST(WriteGrayCode, WritesWhatReflectionGivesInTheOrderOfNames) {
  const fs::path folder = ScratchFolder() / "patterns";
  WriteGrayCode(folder, kScreen, SilentProgress());
  const std::vector<NamedFile> files = ImagesByNumber(folder);
  ASSERT_EQ(files.size(), static_cast<std::size_t>(kPatterns));
  EXPECT_EQ(files[0].name, "gray_001_column_bit_5");
  EXPECT_EQ(files[11].name, "gray_012_column_bit_0_inverse");
  EXPECT_EQ(files[12].name, "gray_013_row_bit_4");
  EXPECT_EQ(files[22].name, "gray_023_white");
  EXPECT_EQ(files[23].name, "gray_024_black");
  for (int i = 0; i < kPatterns; ++i) {
    const Image<Rgb8> pattern = ReadSrgb8(files[static_cast<std::size_t>(i)].path);
    ASSERT_EQ(pattern.width(), kScreenWidth);
    ASSERT_EQ(pattern.height(), kScreenHeight);
    for (int v = 0; v < kScreenHeight; ++v) {
      for (int u = 0; u < kScreenWidth; ++u) {
        const std::uint8_t code = IsWhite(i, u, v) ? 255 : 0;
        ASSERT_EQ(pattern(u, v), (Rgb8{code, code, code})) << i << ": " << u << ' ' << v;
      }
    }
  }
}

TEST(SaveScreenMap, HasZeroWhereNothingIsKnown) {
  ScreenMap map{{2, 1, 3}, {2, 1, 4}, {2, 1, 5}, {2, 1, 6}, {2, 1, 1}};
  map.valid(1, 0) = 0;
  const fs::path file = ScratchFolder() / "map.exr";
  SaveScreenMap(file, map);
  std::vector<Channel> channels = ReadExr(file);
  EXPECT_EQ(channels.size(), 4U);
  constexpr std::array<std::pair<const char*, float>, 4> kChannels{
      {{"u", 3}, {"v", 4}, {"sd_u", 5}, {"sd_v", 6}}};
  for (const auto& [name, value] : kChannels) {
    const Image<float> channel = TakeChannel(channels, name, file);
    EXPECT_EQ(channel(0, 0), value);
    EXPECT_EQ(channel(1, 0), 0);
  }
}

}  // namespace
}  // namespace lamella
