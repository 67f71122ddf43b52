#include "pipeline/report/picture.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/report/preview_page.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(PageCodes, AreTheMeanOfLinearLight) {
  Image<Rgb> picture(4, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; x += 2) picture(x, y) = {1, 1, 1};
  }
  const Image<Rgb8> small = PageCodes(picture.span(), 2);
  ASSERT_EQ(small.width(), 2);
  ASSERT_EQ(small.height(), 1);
  EXPECT_EQ(small(0, 0), (Rgb8{188, 188, 188}));  // not 128
  EXPECT_EQ(PageCodes(picture.span(), 4)(0, 0), (Rgb8{255, 255, 255}));
}

TEST(DataUri, IsBase64OfTheFile) {
  const Image<Rgb8> picture(3, 2, {1, 2, 3});
  // The first bytes of every PNG (89 50 4E 47 0D 0A 1A 0A 00) in base 64.
  EXPECT_THAT(DataUri(picture.span(), "png"), StartsWith("data:image/png;base64,iVBORw0KGgoA"));
  EXPECT_THAT(DataUri(picture.span(), "jpeg"), StartsWith("data:image/jpeg;base64,/9j/"));
}

DepthMap MapOf(std::initializer_list<float> depths) {
  DepthMap map{Image<float>(static_cast<int>(depths.size()), 1), {}};
  int x = 0;
  for (const float depth : depths) map.depth(x++, 0) = depth;
  return map;
}

TEST(ColoredDepth, IsRedNearBlueFarAndGreyWhereUnknown) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const DepthMap map = MapOf({1, 100, kInfinity, 0});
  const Image<Rgb8> picture = ColoredDepth(map, {0, 1}, 100);
  EXPECT_GT(picture(0, 0).r, 100);
  EXPECT_LT(picture(0, 0).b, 40);
  EXPECT_LT(picture(1, 0).r, 80);
  EXPECT_EQ(picture(2, 0), DepthColor(0));
  EXPECT_EQ(picture(3, 0).r, picture(3, 0).g);
  EXPECT_EQ(KnownShare(map), 0.75);
}

TEST(ScaleOf, SpansTheKnownDepthsAndCopesWithOneOrNone) {
  const DepthMap map = MapOf({2, 0, 0, 0, 0, 0, 0, 4});  // every seventh pixel is looked at
  const DepthScale scale = ScaleOf({&map});
  EXPECT_NEAR(scale.near_inverse, 0.5, 1e-6);
  EXPECT_NEAR(scale.far_inverse, 0.25, 1e-6);
  const DepthMap one = MapOf({2});
  EXPECT_LT(ScaleOf({&one}).far_inverse, 0.5);
  EXPECT_GT(ScaleOf({&one}).near_inverse, 0.5);
  const DepthMap none = MapOf({0});
  EXPECT_EQ(ScaleOf({&none}).near_inverse, 1);
  const DepthMap infinite = MapOf({std::numeric_limits<float>::infinity()});
  const DepthScale scale_of_infinite = ScaleOf({&infinite});
  EXPECT_GT(scale_of_infinite.near_inverse, scale_of_infinite.far_inverse);
}

TEST(PreviewPage, HoldsNoMarkupOfTheDataAndNoAddress) {
  PreviewPage page;
  page.title = "</script><script>alert(1)</script><!--";
  page.warnings = {"broken \xff UTF-8"};
  const std::string html = ToHtml(page);
  EXPECT_THAT(html, Not(HasSubstr("alert(1)</script>")));
  EXPECT_THAT(html, HasSubstr("\\u003c/script>"));
  EXPECT_THAT(html, Not(HasSubstr("@DATA@")));
  EXPECT_THAT(html, Not(HasSubstr("@STYLE@")));
  EXPECT_THAT(html, Not(HasSubstr("@SCRIPT@")));
  EXPECT_THAT(html, Not(HasSubstr("https://")));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
}

}  // namespace
}  // namespace lamella
