#include "pipeline/compare_images.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

class CompareImagesTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("compare_images_" +
             std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
    fs::create_directories(root_ / "a");
    fs::create_directories(root_ / "b");
  }
  void TearDown() override { fs::remove_all(root_); }

  void Write(const std::string& file, int width, int height, Rgb8 code) const {
    WriteCodes8(root_ / file, Image<Rgb8>(width, height, code).span());
  }
  fs::path root_;
};

TEST_F(CompareImagesTest, MatchesNamesWhateverTheExtensionAndNamesTheRest) {
  Write("a/one.png", 20, 16, {100, 100, 100});
  Write("b/one.png", 20, 16, {110, 110, 110});
  Write("a/two.png", 20, 16, {100, 100, 100});
  Write("b/two.tif", 20, 16, {120, 120, 120});
  Write("a/left.png", 20, 16, {0, 0, 0});
  Write("b/right.png", 20, 16, {0, 0, 0});
  std::ofstream(root_ / "b/notes.txt") << "no image";
  const ImageComparisons result = CompareImages(root_ / "a", root_ / "b", {});
  ASSERT_EQ(result.images.size(), 2U);
  EXPECT_EQ(result.images[1].name, "two");
  EXPECT_NEAR(*result.images[0].psnr, 20 * std::log10(255.0 / 10), 1e-9);
  EXPECT_NEAR(*result.mean.psnr, 0.5 * (20 * std::log10(25.5) + 20 * std::log10(12.75)), 1e-9);
  EXPECT_EQ(result.only_a, std::vector<std::string>{"left"});
  EXPECT_EQ(result.only_b, std::vector<std::string>{"right"});
}

TEST_F(CompareImagesTest, CountsAsSeenWhatHasAlphaOfOneHalf) {
  Image<Rgb> color(10, 10, {0.25F, 0.25F, 0.25F});
  Image<float> alpha(10, 10, 1.0F);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 5; ++x) {
      color(x, y) = {0.9F, 0.9F, 0.9F};
      alpha(x, y) = 0.49F;
    }
  }
  WriteSrgb8(root_ / "a/v.png", color.span(), alpha.span());
  WriteSrgb8(root_ / "b/v.png", Image<Rgb>(10, 10, {0.25F, 0.25F, 0.25F}).span());
  const ImageComparisons result = CompareImages(root_ / "a/v.png", root_ / "b/v.png", {});
  EXPECT_DOUBLE_EQ(result.images[0].seen, 0.5);
  EXPECT_TRUE(std::isinf(*result.images[0].psnr_seen));
  EXPECT_LT(*result.images[0].psnr, 20);
}

TEST_F(CompareImagesTest, ResizesBothWhereASizeIsGiven) {
  Write("a/v.png", 40, 20, {100, 100, 100});
  Write("b/v.png", 80, 40, {100, 100, 100});
  EXPECT_THROW(CompareImages(root_ / "a", root_ / "b", {}), Error);
  const ImageComparisons result = CompareImages(root_ / "a", root_ / "b", {0, 20});
  EXPECT_TRUE(std::isinf(*result.images[0].psnr));
}

TEST_F(CompareImagesTest, RefusesFoldersWithoutCommonNamesInOneLine) {
  Write("a/x.png", 4, 4, {0, 0, 0});
  Write("b/y.png", 4, 4, {0, 0, 0});
  try {
    CompareImages(root_ / "a", root_ / "b", {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
  EXPECT_THROW(CompareImages(root_ / "a", root_ / "absent", {}), Error);
}

}  // namespace
}  // namespace lamella
