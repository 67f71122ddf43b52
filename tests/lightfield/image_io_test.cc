#include "lightfield/image_io.h"

#include <cmath>
#include <ctime>
#include <limits>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "tests/lightfield/raw_image_files.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

// IEC 61966-2-1, as the standard writes it.
double DecodeByFormula(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

void ExpectRefused(const fs::path& path, const std::string& words) {
  const auto refuse = [&](const char* reader, auto&& read) {
    try {
      read();
      ADD_FAILURE() << reader << " took " << path;
    } catch (const Error& error) {
      const std::string line = error.what();
      EXPECT_EQ(error.code(), ExitCode::kInput);
      EXPECT_NE(line.find(path.string()), std::string::npos) << line;
      EXPECT_NE(line.find(words), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  };
  refuse("ReadImage", [&] { ReadImage(path); });
  refuse("CheckImageIsWhole", [&] { CheckImageIsWhole(path); });
}

std::string SmallJpeg(int width = 64, int height = 48) {
  Image<Rgb8> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(x * 3), static_cast<std::uint8_t>(y * 5), 90};
    }
  }
  const fs::path path = ScratchFolder() / "small.jpg";
  WriteCodes8(path, image.span());
  return ReadBytes(path);
}

TEST(ReadImage, DecodesEightAndSixteenBitPng) {
  const fs::path folder = ScratchFolder();
  WriteBytes(folder / "8.png", RawPng(2, 1, 3, 8, {0, 128, 255, 7, 64, 200}));
  const Image<Rgb> eight = ReadImage(folder / "8.png");
  EXPECT_NEAR(eight(0, 0).g, DecodeByFormula(128 / 255.0), 1e-6);
  EXPECT_NEAR(eight(1, 0).b, DecodeByFormula(200 / 255.0), 1e-6);
  EXPECT_EQ(eight(0, 0).b, 1.0F);
  EXPECT_EQ(ReadSrgb8(folder / "8.png")(1, 0), (Rgb8{7, 64, 200}));

  WriteBytes(folder / "16.png", RawPng(1, 2, 3, 16, {0, 1, 65535, 30000, 257, 514}));
  const Image<Rgb> sixteen = ReadImage(folder / "16.png");
  EXPECT_NEAR(sixteen(0, 0).g, DecodeByFormula(1 / 65535.0), 1e-9);
  EXPECT_NEAR(sixteen(0, 1).r, DecodeByFormula(30000 / 65535.0), 1e-6);
  EXPECT_EQ(ReadSrgb8(folder / "16.png")(0, 1), (Rgb8{117, 1, 2}));
  EXPECT_EQ(ReadImageInfo(folder / "16.png").bits, 16);
}

TEST(ReadImage, RepeatsGreyAndLeavesAlphaOut) {
  const fs::path folder = ScratchFolder();
  WriteBytes(folder / "grey.png", RawPng(2, 1, 1, 8, {50, 200}));
  EXPECT_EQ(ReadSrgb8(folder / "grey.png")(1, 0), (Rgb8{200, 200, 200}));
  EXPECT_TRUE(ReadAlpha(folder / "grey.png").empty());

  WriteBytes(folder / "grey_alpha.png", RawPng(2, 1, 2, 8, {50, 0, 200, 255}));
  EXPECT_EQ(ReadSrgb8(folder / "grey_alpha.png")(0, 0), (Rgb8{50, 50, 50}));
  EXPECT_EQ(ReadAlpha(folder / "grey_alpha.png")(0, 0), 0.0F);
  EXPECT_EQ(ReadAlpha(folder / "grey_alpha.png")(1, 0), 1.0F);

  WriteBytes(folder / "rgba.png", RawPng(1, 1, 4, 16, {10000, 20000, 30000, 32768}));
  EXPECT_NEAR(ReadImage(folder / "rgba.png")(0, 0).r, DecodeByFormula(10000 / 65535.0), 1e-6);
  EXPECT_NEAR(ReadAlpha(folder / "rgba.png")(0, 0), 32768 / 65535.0F, 1e-6);
}

TEST(ReadImage, TakesAOnePixelImageAndAVeryWideOne) {
  const fs::path folder = ScratchFolder();
  WriteBytes(folder / "1.png", RawPng(1, 1, 3, 8, {1, 2, 3}));
  EXPECT_EQ(ReadSrgb8(folder / "1.png")(0, 0), (Rgb8{1, 2, 3}));
  std::vector<std::uint16_t> samples(3 * 30000, 77);
  samples.back() = 78;
  WriteBytes(folder / "wide.png", RawPng(30000, 1, 3, 8, samples));
  EXPECT_EQ(ReadSrgb8(folder / "wide.png")(29999, 0), (Rgb8{77, 77, 78}));
}

TEST(ReadImage, RefusesEveryCutOfAPngAndOfAJpeg) {
  const fs::path folder = ScratchFolder();
  const std::string png = RawPng(5, 4, 3, 8, std::vector<std::uint16_t>(60, 9));
  for (std::size_t length = 8; length < png.size(); length += 3) {
    WriteBytes(folder / "cut.png", png.substr(0, length));
    EXPECT_THROW(CheckImageIsWhole(folder / "cut.png"), Error) << length;
  }
  const std::string jpeg = SmallJpeg();
  for (std::size_t length = 2; length < jpeg.size(); length += 7) {
    WriteBytes(folder / "cut.jpg", jpeg.substr(0, length));
    EXPECT_THROW(CheckImageIsWhole(folder / "cut.jpg"), Error) << length;
  }
  WriteBytes(folder / "cut.jpg", jpeg.substr(0, jpeg.size() - 2));
  ExpectRefused(folder / "cut.jpg", "truncated");
  WriteBytes(folder / "cut.png", png.substr(0, png.size() / 2));
  ExpectRefused(folder / "cut.png", "truncated");
}

TEST(ReadImage, DoesNotTakeAThumbnailsEndForThePhotographs) {
  const fs::path folder = ScratchFolder();
  const std::string jpeg = SmallJpeg(), thumbnail = SmallJpeg(8, 8);
  const std::string length = {static_cast<char>((thumbnail.size() + 2) >> 8 & 255U),
                              static_cast<char>((thumbnail.size() + 2) & 255U)};
  const std::string with = jpeg.substr(0, 2) + "\xFF\xE2" + length + thumbnail + jpeg.substr(2);
  WriteBytes(folder / "whole.jpg", with);
  EXPECT_NO_THROW(CheckImageIsWhole(folder / "whole.jpg"));
  WriteBytes(folder / "cut.jpg", with.substr(0, with.size() - 30));
  ExpectRefused(folder / "cut.jpg", "truncated");
  // Bytes after the end, as phones put them there, do no harm.
  WriteBytes(folder / "more.jpg", with + "\xFF\xDA trailing");
  EXPECT_NO_THROW(CheckImageIsWhole(folder / "more.jpg"));
}

TEST(ReadImage, RefusesWhatIsNoImage) {
  const fs::path folder = ScratchFolder();
  WriteBytes(folder / "text.png", "this is a text\n");
  ExpectRefused(folder / "text.png", "PNG");
  WriteBytes(folder / "text.jpg", "this is a text\n");
  ExpectRefused(folder / "text.jpg", "JPEG");
  WriteBytes(folder / "empty.png", "");
  ExpectRefused(folder / "empty.png", "empty");
  ExpectRefused(folder / "absent.png", "no such file");
  fs::create_directory(folder / "folder.png");
  ExpectRefused(folder / "folder.png", "no such file");
  std::string lie = RawPng(4, 4, 3, 8, std::vector<std::uint16_t>(48, 9));
  lie.replace(16, 8, std::string("\x7F\xFF\xFF\xFF\x7F\xFF\xFF\xFF", 8));  // its size
  WriteBytes(folder / "lie.png", lie);
  ExpectRefused(folder / "lie.png", "readable");
}

TEST(ReadImage, TurnsThePictureUprightForAllEightOrientations) {
  const fs::path folder = ScratchFolder();
  // 32x16 with a bright quarter at the stored top left; where it goes is the EXIF standard's table.
  Image<Rgb8> stored(32, 16, {20, 20, 20});
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) stored(x, y) = {250, 250, 250};
  }
  WriteCodes8(folder / "stored.jpg", stored.span());
  const std::string jpeg = ReadBytes(folder / "stored.jpg");
  struct Row {
    int orientation;
    bool right, bottom;  // where the bright quarter is seen
  };
  for (const Row& row : {Row{1, false, false},
                         {2, true, false},
                         {3, true, true},
                         {4, false, true},
                         {5, false, false},
                         {6, true, false},
                         {7, true, true},
                         {8, false, true}}) {
    const fs::path path = folder / ("turned" + std::to_string(row.orientation) + ".jpg");
    WriteBytes(path, WithExif(jpeg, row.orientation, 5.0, 0));
    const ImageInfo info = ReadImageInfo(path);
    const Image<Rgb8> upright = ReadSrgb8(path);
    EXPECT_EQ(info.orientation, row.orientation);
    EXPECT_EQ(info.width, row.orientation >= 5 ? 16 : 32);
    ASSERT_EQ(upright.width(), info.width);
    ASSERT_EQ(upright.height(), info.height);
    const int left = info.width / 4, right = 3 * left, top = info.height / 4, bottom = 3 * top;
    const auto bright = [&](int x, int y) { return upright(x, y).g > 128; };
    EXPECT_TRUE(bright(row.right ? right : left, row.bottom ? bottom : top)) << row.orientation;
    EXPECT_FALSE(bright(row.right ? left : right, row.bottom ? top : bottom)) << row.orientation;
  }
}

TEST(ReadImageInfo, TellsTheFocalLengthOfExif) {
  const fs::path path = ScratchFolder() / "photo.jpg";
  WriteBytes(path, WithExif(SmallJpeg(), 1, 5.85, 35));
  const ImageInfo info = ReadImageInfo(path);
  EXPECT_EQ(info.format, "jpeg");
  ASSERT_TRUE(info.focal_mm);
  EXPECT_NEAR(*info.focal_mm, 5.85, 1e-6);
  ASSERT_TRUE(info.focal_35mm);
  EXPECT_EQ(*info.focal_35mm, 35);
}

TEST(ReadImage, RefusesAnExrWithAValueThatIsNotFiniteAndSaysWhere) {
  const fs::path path = ScratchFolder() / "bad.exr";
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<Channel> channels;
    for (const char* name : {"R", "G", "B"}) channels.push_back({name, Image<float>(3, 2, 0.5F)});
    channels[1].pixels(2, 1) = bad;
    WriteExr(path, channels, ExrType::kFloat);
    ExpectRefused(path, "2,1");
  }
}

TEST(Exr, KeepsFloatsAndIsTheSameBytesAtEveryTime) {
  const fs::path folder = ScratchFolder();
  std::vector<Channel> channels;
  channels.push_back({"Z", Image<float>(3, 1)});
  channels[0].pixels(0, 0) = 1e-8F;
  channels[0].pixels(1, 0) = 1e8F;
  channels[0].pixels(2, 0) = std::numeric_limits<float>::infinity();
  WriteExr(folder / "z.exr", channels, ExrType::kFloat);
  const std::vector<Channel> back = ReadExr(folder / "z.exr");
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].name, "Z");
  for (int x = 0; x < 3; ++x) EXPECT_EQ(back[0].pixels(x, 0), channels[0].pixels(x, 0));
  const std::string bytes = ReadBytes(folder / "z.exr");
  const std::time_t now = std::time(nullptr);
  const std::string year = std::to_string(1900 + std::gmtime(&now)->tm_year);
  EXPECT_EQ(bytes.find(year + ":"), std::string::npos) << "the file holds the present time";
}

TEST(Pfm, IsFlippedAndRefusedWhereItIsCutOrLies) {
  const fs::path path = ScratchFolder() / "a.pfm";
  const float values[] = {3, 4, 1, 2};  // the bottom row first
  const std::string pixels(reinterpret_cast<const char*>(values), sizeof values);
  WriteBytes(path, "Pf\n2 2\n-1.0\n" + pixels);
  const Image<float> image = ReadPfm(path);
  EXPECT_EQ(image(0, 0), 1);
  EXPECT_EQ(image(1, 1), 4);
  WriteBytes(path, "Pf\n2 2\n-1.0\n" + pixels.substr(0, 15));
  EXPECT_THROW(ReadPfm(path), Error);
  WriteBytes(path, "Pf\n1000000 1000000\n-1.0\n" + pixels);
  EXPECT_THROW(ReadPfm(path), Error);
  WriteBytes(path, "PF\n2 2\n-1.0\n" + pixels);
  EXPECT_THROW(ReadPfm(path), Error);
}

}  // namespace
}  // namespace lamella
