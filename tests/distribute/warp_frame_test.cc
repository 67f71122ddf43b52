// The pre-warp against the virtual prototype's own tracing of lines of sight.
#include "distribute/warp_frame.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

Display Small() {
  Display display = FindDisplay("depth-fused");
  display.width_px = 96;
  display.height_px = 64;
  return display;
}

Image<Rgb> Picture(int width, int height, const std::function<Rgb(double, double)>& at) {
  Image<Rgb> picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) picture(x, y) = at(x + 0.5, y + 0.5);
  }
  return picture;
}

// 6 mm off, turned by 2 degrees, tilted by 4, larger by 0.4 %, bowed by 0.3 mm.
Calibration Askew(const Display& display) {
  Calibration askew = DesignCalibration(display);
  for (LayerCalibration& layer : askew.layers) {
    layer.display_from_stack.translation += Eigen::Vector3d(1.5, -1, 6);
    layer.display_from_stack.rotation =
        Eigen::AngleAxisd(0.035, Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(0.07, Eigen::Vector3d(1, 2, 0).normalized());
    layer.emitter.scale = 0.004;
    layer.emitter.bow_mm = 0.3;
  }
  return askew;
}

TEST(WarpToPanel, LeavesThePictureAsItIsWhereNothingIsAskew) {
  const Display display = Small();
  const Image<Rgb> picture = Picture(96, 64, [](double x, double y) {
    return Rgb{static_cast<float>(std::fmod(x * 37 + y * 11, 1.7)), 0.3F, 0.9F};
  });
  for (int layer = 0; layer < 2; ++layer) {
    const EmitterImage shown =
        WarpToPanel(picture, display, DesignCalibration(display), layer, {0, 0, 600});
    for (std::size_t i = 0; i < picture.size(); ++i) {
      EXPECT_NEAR(shown.color.data()[i].r, picture.data()[i].r, 1e-5);
      EXPECT_EQ(shown.coverage.data()[i], 1);
    }
  }
}

// A picture of its own coordinates: seen along a line of sight, it must say where that meets the
// panel as designed.
TEST(WarpToPanel, PutsEveryPixelWhereTheEyeLooksForIt) {
  const Display display = Small();
  const Calibration askew = Askew(display);
  const Eigen::Vector3d eye(30, -20, 580);
  const Image<Rgb> coordinates = Picture(96, 64, [](double x, double y) {
    return Rgb{static_cast<float>(x), static_cast<float>(y), 1};
  });
  for (int layer = 0; layer < 2; ++layer) {  // the first is mirrored
    const auto l = static_cast<std::size_t>(layer);
    const EmitterImage shown = WarpToPanel(coordinates, display, askew, layer, eye);
    const LayerSights sights(askew.layers[l]);
    double worst = 0;
    int seen = 0;
    for (double v = 8.3; v < 56; v += 5.1) {
      for (double u = 8.7; u < 88; u += 6.3) {
        const Eigen::Vector3d designed((u - 48) * display.pitch_mm, (32 - v) * display.pitch_mm,
                                       display.layers[l].position_mm);
        const auto hit = sights.Seen(eye, designed - eye);
        ASSERT_TRUE(hit);
        double x = hit->emitter.x();
        if (display.layers[l].mirror_x) x = 96 - x;
        const double y = hit->emitter.y();
        if (!(x > 1 && x < 95 && y > 1 && y < 63)) continue;
        // Bilinear between the emitters' middles.
        const int i = static_cast<int>(x - 0.5), j = static_cast<int>(y - 0.5);
        const double fx = x - 0.5 - i, fy = y - 0.5 - j;
        const auto at = [&](float Rgb::*channel) {
          const auto value = [&](int a, int b) {
            return static_cast<double>(shown.color(i + a, j + b).*channel);
          };
          return (1 - fy) * ((1 - fx) * value(0, 0) + fx * value(1, 0)) +
                 fy * ((1 - fx) * value(0, 1) + fx * value(1, 1));
        };
        worst = std::max({worst, std::abs(at(&Rgb::r) - u), std::abs(at(&Rgb::g) - v)});
        ++seen;
      }
    }
    EXPECT_GT(seen, 80);
    EXPECT_LT(worst, 0.005);
  }
}

TEST(WarpToPanel, LeavesOutWhatLiesBesideThePicture) {
  const Display display = Small();
  Calibration askew = DesignCalibration(display);
  askew.layers[1].display_from_stack.translation.x() += 10.5 * display.pitch_mm;
  const EmitterImage shown = WarpToPanel(Picture(96, 64,
                                                 [](double, double) {
                                                   return Rgb{0.5F, 0.5F, 0.5F};
                                                 }),
                                         display, askew, 1, {0, 0, 600});
  int dark = 0;
  for (int x = 0; x < 96; ++x) {
    if (shown.coverage(x, 30) == 0) ++dark;
    EXPECT_EQ(shown.color(x, 30).g, 0.5F * shown.coverage(x, 30));
  }
  EXPECT_EQ(dark, 10);
}

TEST(WarpToPanel, RefusesWhatItCannotDo) {
  const auto refusal = [](const Display& display, int width, double eye_mm) -> std::string {
    try {
      WarpToPanel(Image<Rgb>(width, 64), display, DesignCalibration(display), 0, {0, 0, eye_mm});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(Small(), 96, 600), "");
  EXPECT_THAT(refusal(Small(), 95, 600), HasSubstr("95 x 64 px"));
  EXPECT_THAT(refusal(Small(), 96, -50), HasSubstr("not in front"));
  EXPECT_THAT(refusal(Small(), 96, NAN), HasSubstr("not in front"));
  Display barrier = FindDisplay("paper-two-layer");
  barrier.width_px = 96;
  barrier.height_px = 64;
  EXPECT_THAT(refusal(barrier, 96, 600), HasSubstr("a barrier"));
}

}  // namespace
}  // namespace lamella
