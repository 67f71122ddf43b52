// What beams leave of a scene, against the closed forms of displays.md section 1.3.
#include "distribute/band_limit.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/parallel.h"
#include "tests/distribute/centred_eye.h"

namespace lamella {
namespace {

constexpr double kInfinitelyFar = std::numeric_limits<double>::infinity();
constexpr double kDistance = 600, kGap = 5, kPitch = 0.311316;  // of the paper's displays, mm
constexpr int kAcross = 41;  // px: of a wave's picture, wider than what two layers blur
constexpr double kMean = 0.5, kContrast = 0.4;

double Sinc(double t) { return t == 0 ? 1 : std::sin(M_PI * t) / (M_PI * t); }

Eye EyeAt(double x, double pixel_mm, int width, int height, double plane_mm = 0) {
  Eye eye = CentredEye({x, 0, kDistance}, pixel_mm, width, height);
  eye.plane_mm = plane_mm;
  return eye;
}

// All of it at one depth and known.
SeenScene SceneOf(const Eye& eye, double z, const std::function<float(int, int)>& light) {
  SeenScene scene{Image<Rgb>(eye.width, eye.height),
                  Image<float>(eye.width, eye.height, static_cast<float>(z)),
                  Image<float>(eye.width, eye.height, 1)};
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      const float value = light(x, y);
      scene.light(x, y) = {value, value, value};
    }
  }
  return scene;
}

// How much is left of the contrast of a wave on a plane, its frequency per mm of that plane (-inf:
// per radian, as an eye sees it), by the row or the column in the picture's middle.
double LeftOfWave(const Display& display, double z, double frequency, bool along_y, double plane_mm,
                  double pixel_mm) {
  const Eye eye = EyeAt(30, pixel_mm, along_y ? kAcross : 1201, along_y ? 1201 : kAcross, plane_mm);
  const double per_picture_mm = std::isinf(z)
                                    ? frequency / (kDistance - plane_mm)
                                    : frequency * (kDistance - z) / (kDistance - plane_mm);
  const double per_px = per_picture_mm * pixel_mm;
  const SeenScene scene = SceneOf(eye, z, [&](int x, int y) {
    const double at = (along_y ? y : x) - 600;
    return static_cast<float>(kMean + kContrast * std::cos(2 * M_PI * per_px * at));
  });
  const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display).value(), eye);
  const Rgb middle = along_y ? limited(kAcross / 2, 600) : limited(600, kAcross / 2);
  return (static_cast<double>(middle.g) - kMean) / kContrast;
}

struct Widths {
  double a = 0, b = 0;
  double Mtf(double frequency) const { return Sinc(frequency * a) * Sinc(frequency * b); }
  // The blur is interpolated between depths; beyond the cut-off little is left to be right about.
  double Tolerance(double frequency) const {
    return frequency * std::max(a, b) <= 0.5 ? 0.01 : 0.05;
  }
};
Widths OfBarrier(double offset) {
  return {2 * kPitch * std::abs(1 + offset / kGap), kPitch * std::abs(offset) / kGap};
}

TEST(BandLimit, LeavesOfAPlaneWhatTheBeamLeaves) {
  const Display display = FindDisplay("paper-two-layer");
  for (const double z : {-35.0, -21.3, -14.0, -10.0, -6.0, -3.1, 3.0, 7.7, 10.0, 14.9, 33.0}) {
    const Widths beam = OfBarrier(z - (z < 0 ? -10 : 10));
    for (const double f : {0.1, 0.25, 0.4, 0.8}) {
      for (const bool along_y : {false, true}) {
        EXPECT_NEAR(LeftOfWave(display, z, f, along_y, 0, 0.1), beam.Mtf(f), beam.Tolerance(f))
            << z << " mm, " << f << " per mm" << (along_y ? ", along y" : "");
      }
    }
  }
}

TEST(BandLimit, OfLensesIsThePapersBox) {
  Display display = FindDisplay("paper-one-layer");
  LensletArray lenses;
  lenses.lattice = LensletArray::Lattice::kSquare;
  lenses.pitch_px = 6;
  lenses.rays = 6;
  display.layers[0].optics = lenses;
  for (const double z : {-60.0, -20.0, 0.0, 11.0, 60.0}) {
    const Widths beam{6 * kPitch, kPitch * std::abs(z) / kGap};
    for (const double f : {0.05, 0.15, 0.26}) {
      for (const bool along_y : {false, true}) {
        EXPECT_NEAR(LeftOfWave(display, z, f, along_y, 0, 0.1), beam.Mtf(f), beam.Tolerance(f))
            << z << " mm, " << f << " per mm" << (along_y ? ", along y" : "");
      }
    }
  }
}

// The mean of a wave over a regular hexagon whose sides are `pitch` apart along x, by its points.
double OverHexagon(double frequency, double pitch, bool along_y) {
  constexpr int kSteps = 400;
  double sum = 0;
  int inside = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const int column = i % kSteps, row = i / kSteps;
    const double x = pitch * 1.2 * ((column + 0.5) / kSteps - 0.5);
    const double y = pitch * 1.2 * ((row + 0.5) / kSteps - 0.5);
    const double tilted = std::abs(x) / 2 + std::abs(y) * std::sqrt(3.0) / 2;
    if (std::max(std::abs(x), tilted) > pitch / 2) continue;
    sum += std::cos(2 * M_PI * frequency * (along_y ? y : x));
    ++inside;
  }
  return sum / inside;
}

TEST(BandLimit, OfHexagonalLensesIsTheirMeanBelowTheirCutoff) {
  Display display = FindDisplay("paper-one-layer");
  LensletArray lenses;
  lenses.pitch_px = 6;
  lenses.rays = 6;
  display.layers[0].optics = lenses;
  for (const double z : {-20.0, 0.0, 11.0}) {
    for (const double f : {0.05, 0.15, 0.26}) {
      const double emitter = Sinc(f * kPitch * std::abs(z) / kGap);
      for (const bool along_y : {false, true}) {
        EXPECT_NEAR(LeftOfWave(display, z, f, along_y, 0, 0.1),
                    OverHexagon(f, 6 * kPitch, along_y) * emitter, 0.01)
            << z << " mm, " << f << " per mm" << (along_y ? ", along y" : "");
      }
    }
  }
}

TEST(BandLimit, BetweenTwoLayersIsTheMeanByTheirWeights) {
  const Display display = FindDisplay("paper-two-layer");  // w = 4 around 0
  for (const double z : {0.0, 1.0, -1.5}) {
    for (const double f : {0.1, 0.15}) {
      const double front = OfBarrier(z - 10).Mtf(f), back = OfBarrier(z + 10).Mtf(f);
      const double of_front = 0.5 + z / 4;
      EXPECT_NEAR(LeftOfWave(display, z, f, false, 0, 0.1),
                  of_front * front + (1 - of_front) * back, 0.01)
          << z << " mm, " << f << " per mm";
    }
  }
}

TEST(BandLimit, IsLeastWhereTheBeamIsNarrowest) {
  const Display display = FindDisplay("paper-one-layer");
  const double narrowest = LeftOfWave(display, -4, 0.5, false, 0, 0.1);
  for (const double z : {-12.0, -8.0, -1.0, 4.0}) {
    EXPECT_GT(narrowest, LeftOfWave(display, z, 0.5, false, 0, 0.1) + 0.02) << z;
  }
}

// The same content, however large its picture is.
TEST(BandLimit, GrowsWithThePicture) {
  const Display display = FindDisplay("paper-two-layer");
  for (const double z : {-150.0, 40.0, 100.0}) {
    const double expected = OfBarrier(z - (z < 0 ? -10 : 10)).Mtf(0.03);
    for (const double plane : {-100.0, 0.0, 60.0}) {
      EXPECT_NEAR(LeftOfWave(display, z, 0.03, false, plane, 0.3), expected, 0.01)
          << z << ", seen on " << plane;
    }
  }
}

// The fan of a beam is what is left of it: w_x/d0 by w_u/d0, in radians.
TEST(BandLimit, OfWhatIsInfinitelyFarIsTheBeamsFan) {
  const Display display = FindDisplay("paper-two-layer");
  for (const double per_radian : {1.0, 3.0, 5.0}) {
    const double expected = Sinc(per_radian * 2 * kPitch / kGap) * Sinc(per_radian * kPitch / kGap);
    EXPECT_NEAR(LeftOfWave(display, -kInfinitelyFar, per_radian, false, 0, 1), expected, 0.01);
    // So far that it is nearly that.
    EXPECT_NEAR(LeftOfWave(display, -1e6, per_radian / 1e6, false, 0, 1), expected, 0.01);
  }
}

TEST(BandLimit, UnknownStaysUnknownAndDarkensNothing) {
  const Display display = FindDisplay("paper-two-layer");
  const Eye eye = EyeAt(0, kPitch, 90, 70);
  SeenScene scene = SceneOf(eye, 25, [](int, int) { return 0.7F; });
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < 30; ++x) {
      scene.coverage(x, y) = 0;
      scene.light(x, y) = {9, 9, 9};
    }
    for (int x = 30; x < 40; ++x) {
      scene.coverage(x, y) = 0.25F;
      scene.light(x, y) = 0.25F * scene.light(x, y);
    }
  }
  scene.light(60, 35).g = std::numeric_limits<float>::quiet_NaN();
  scene.light(61, 35).r = std::numeric_limits<float>::infinity();
  scene.z(70, 35) = std::numeric_limits<float>::quiet_NaN();
  const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display).value(), eye);
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      ASSERT_NEAR(limited(x, y).g, x < 30 ? 0 : 0.7, 1e-5) << x << " " << y;
    }
  }
}

TEST(BandLimit, KeepsOneColourAtManyDepths) {
  const Display display = FindDisplay("paper-two-layer");
  const Eye eye = EyeAt(12, 0.5, 200, 150);
  SeenScene scene = SceneOf(eye, 0, [](int, int) { return 0.25F; });
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      scene.z(x, y) = x < 40 ? -std::numeric_limits<float>::infinity()
                             : static_cast<float>((x * 37 + y * 11) % 400 - 200);
    }
  }
  const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display).value(), eye);
  for (std::size_t i = 0; i < limited.size(); ++i) ASSERT_NEAR(limited.data()[i].b, 0.25, 1e-5);
}

// A near thing is as blurred as its own beams, what lies behind it as others.
TEST(BandLimit, GivesEveryDepthItsOwnWidth) {
  const Display display = FindDisplay("paper-one-layer");
  const Eye eye = EyeAt(0, 0.1, 400, 3);
  const auto width_of_edge = [&](double z) {
    const SeenScene scene = SceneOf(eye, z, [](int x, int) { return x < 200 ? 0.0F : 1.0F; });
    const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display).value(), eye);
    int between = 0;
    for (int x = 0; x < eye.width; ++x)
      between += limited(x, 1).r > 0.001F && limited(x, 1).r < 0.999F;
    return between * 0.1 * (kDistance - z) / kDistance;
  };
  for (const double z : {-5.0, 12.0, 30.0}) {
    const double full_base = 2 * kPitch * std::abs(1 + z / kGap) + kPitch * std::abs(z) / kGap;
    EXPECT_NEAR(width_of_edge(z), full_base, 0.25 + 0.1 * full_base) << z;
  }
}

TEST(BandLimit, IsNotThereForSlantedLenses) {
  EXPECT_TRUE(BandLimitOf(FindDisplay("paper-varifocal")));
  Display sheet = FindDisplay("paper-one-layer");
  Lenticular lenses;
  sheet.layers[0].optics = lenses;
  EXPECT_FALSE(BandLimitOf(sheet)) << "slanted";
  lenses.slant = 0;
  sheet.layers[0].optics = lenses;
  ASSERT_TRUE(BandLimitOf(sheet));
  // An emitter's height at every depth; a lens by a sub-pixel along the row.
  EXPECT_NEAR(LeftOfWave(sheet, 20, 0.5, true, 0, 0.1), Sinc(0.5 * kPitch), 0.01);
  EXPECT_NEAR(LeftOfWave(sheet, 20, 0.2, false, 0, 0.1),
              Sinc(0.2 * 1.5 * kPitch) * Sinc(0.2 * kPitch / 3 * 20 / kGap), 0.01);
}

TEST(BandLimit, DoesNotDependOnThreads) {
  const Display display = FindDisplay("paper-two-layer");
  const Eye eye = EyeAt(-20, kPitch, 150, 200);
  SeenScene scene = SceneOf(eye, 0, [](int x, int y) { return static_cast<float>(x * y % 17); });
  for (std::size_t i = 0; i < scene.z.size(); ++i) {
    scene.z.data()[i] = static_cast<float>(static_cast<int>(i / 13 % 60) - 30);
  }
  Image<Rgb> limited[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    limited[threads - 1] = BandLimited(scene, BandLimitOf(display).value(), eye);
  }
  for (std::size_t i = 0; i < scene.z.size(); ++i) {
    ASSERT_EQ(limited[0].data()[i], limited[1].data()[i]);
  }
}

}  // namespace
}  // namespace lamella
