// Pictures read and written some rows at a time are those read and written whole.
#include "lightfield/image_rows.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 13, kHeight = 75;  // neither a multiple of a strip nor of an EXR's block

class ImageRows : public testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("image_rows_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

// Quarters: exact as half floats.
float ValueAt(int channel, int x, int y) {
  return 0.25f * static_cast<float>(channel * 500 + (x * 31 + y * 7) % 200);
}

std::vector<Channel> Channels(int first_row, int end_row) {
  std::vector<Channel> channels;
  for (const char* name : {"R", "G", "B", "A"}) {
    Channel channel{name, Image<float>(kWidth, end_row - first_row)};
    for (int y = first_row; y < end_row; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        channel.pixels(x, y - first_row) = ValueAt(static_cast<int>(channels.size()), x, y);
      }
    }
    channels.push_back(std::move(channel));
  }
  return channels;
}

TEST_F(ImageRows, AnExrReadInStripsOfAnyHeightHasTheValuesWritten) {
  const fs::path path = folder_ / "a.exr";
  for (const ExrType type : {ExrType::kHalf, ExrType::kFloat}) {
    WriteExr(path, Channels(0, kHeight), type, ExrCompression::kPiz);
    for (const int strip : {1, 7, 32, 33, kHeight}) {
      ExrRowsReader reader(path);
      ASSERT_EQ(reader.width(), kWidth);
      ASSERT_EQ(reader.height(), kHeight);
      for (int row = 0; row < kHeight; row += strip) {
        const int end = std::min(row + strip, kHeight);
        std::vector<Channel> rows = reader.Read(row, end);
        for (int c = 0; c < 4; ++c) {
          const Image<float> read = TakeChannel(rows, std::string(1, "RGBA"[c]), path);
          for (int y = row; y < end; ++y) {
            for (int x = 0; x < kWidth; ++x) ASSERT_EQ(read(x, y - row), ValueAt(c, x, y));
          }
        }
      }
    }
  }
}

TEST_F(ImageRows, AnExrIsReadInAnyOrder) {
  const fs::path path = folder_ / "a.exr";
  WriteExr(path, Channels(0, kHeight), ExrType::kHalf);
  ExrRowsReader reader(path);
  for (const int row : {60, 0, 40, 40}) {
    std::vector<Channel> rows = reader.Read(row, row + 5);
    EXPECT_EQ(TakeChannel(rows, "G", path)(3, 2), ValueAt(1, 3, row + 2));
  }
}

TEST_F(ImageRows, ATruncatedExrIsRefused) {
  const fs::path path = folder_ / "a.exr";
  WriteExr(path, Channels(0, kHeight), ExrType::kFloat);
  fs::resize_file(path, fs::file_size(path) / 2);
  try {
    ExrRowsReader reader(path);
    reader.Read(0, kHeight);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_NE(std::string(error.what()).find("a.exr"), std::string::npos) << error.what();
  }
}

std::uint8_t CodeAt(int x, int y) { return static_cast<std::uint8_t>(x * 17 + y * 3); }

TEST_F(ImageRows, APngWrittenInStripsOfAnyHeightHasTheCodesWritten) {
  for (const int strip : {1, 7, 32, kHeight}) {
    const fs::path color = folder_ / ("color_" + std::to_string(strip) + ".png");
    const fs::path grey = folder_ / ("grey_" + std::to_string(strip) + ".png");
    PngRowsWriter colors(color, kWidth, kHeight, 3, PngCoding::kPhotograph),
        greys(grey, kWidth, kHeight, 1, PngCoding::kFast);
    for (int row = 0; row < kHeight; row += strip) {
      const int end = std::min(row + strip, kHeight);
      Image<Rgb8> three(kWidth, end - row);
      Image<std::uint8_t> one(kWidth, end - row);
      for (int y = row; y < end; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          one(x, y - row) = CodeAt(x, y);
          three(x, y - row) = {CodeAt(x, y), CodeAt(y, x), CodeAt(x + y, 5)};
        }
      }
      colors.Write(three);
      greys.Write(one);
    }
    EXPECT_FALSE(fs::exists(color));
    colors.Close();
    greys.Close();
    const Image<Rgb8> three = ReadSrgb8(color), one = ReadSrgb8(grey);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(one(x, y).r, CodeAt(x, y));
        ASSERT_EQ(three(x, y).r, CodeAt(x, y));
        ASSERT_EQ(three(x, y).g, CodeAt(y, x));
        ASSERT_EQ(three(x, y).b, CodeAt(x + y, 5));
      }
    }
  }
}

TEST_F(ImageRows, CodesReadInStripsAreTheFiles) {
  Image<Rgb8> three(kWidth, kHeight);
  Image<std::uint8_t> one(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      one(x, y) = CodeAt(x, y);
      three(x, y) = {CodeAt(x, y), CodeAt(y, x), CodeAt(x + y, 5)};
    }
  }
  const fs::path color = folder_ / "color.png", grey = folder_ / "grey.png";
  WriteCodes8(color, three.span());
  WriteGrey8(grey, one.span());
  CodeRowsReader colors(color), greys(grey);
  EXPECT_EQ(colors.width(), kWidth);
  EXPECT_EQ(colors.height(), kHeight);
  for (const auto& [first, end] : {std::pair{0, 5}, {5, 6}, {20, kHeight}, {3, 9}}) {
    const Image<Rgb8> of_color = colors.Read(first, end), of_grey = greys.Read(first, end);
    ASSERT_EQ(of_color.height(), end - first);
    for (int y = first; y < end; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(of_color(x, y - first), three(x, y));
        const std::uint8_t code = one(x, y);
        ASSERT_EQ(of_grey(x, y - first), (Rgb8{code, code, code}));
      }
    }
  }
}

TEST_F(ImageRows, NothingIsLeftOfAFileThatIsNotClosedOrLacksRows) {
  {
    PngRowsWriter dropped(folder_ / "dropped.png", kWidth, kHeight, 1, PngCoding::kFast);
    dropped.Write(Image<std::uint8_t>(kWidth, 10));
    ExrRowsWriter half(folder_ / "half.exr", {"R", "G", "B", "A"}, kWidth, kHeight, ExrType::kHalf);
    half.Write(Channels(0, 32));
    EXPECT_ANY_THROW(half.Close());
    PngRowsWriter empty(folder_ / "empty.png", kWidth, kHeight, 3, PngCoding::kFast);
    EXPECT_ANY_THROW(empty.Close());
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace lamella
