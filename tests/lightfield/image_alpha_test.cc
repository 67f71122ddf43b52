#include <filesystem>

#include <gtest/gtest.h>

#include "lightfield/image_io.h"

namespace lamella {
namespace {

TEST(ReadImage, KeepsTheColoursUnderATransparentAlpha) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "lamella_unassociated_alpha.png";
  Image<Rgb> color(2, 1, {0.5F, 0.25F, 1.0F});
  Image<float> alpha(2, 1, 1.0F);
  alpha(1, 0) = 0.0F;
  WriteSrgb8(path, color.span(), alpha.span());
  const Image<Rgb8> codes = ReadSrgb8(path);
  EXPECT_EQ(codes(1, 0), codes(0, 0));
  EXPECT_EQ(codes(0, 0), EncodeSrgb8(color.span())(0, 0));
  EXPECT_EQ(ReadAlpha(path)(1, 0), 0.0F);
  EXPECT_EQ(ReadImage(path)(1, 0), ReadImage(path)(0, 0));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace lamella
