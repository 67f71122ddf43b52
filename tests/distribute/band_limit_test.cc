// What beams leave of a scene, against the closed forms of displays.md section 1.3 and against what
// the program's own prefilter leaves in emitters.
#include "distribute/band_limit.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "lightfield/layer_map.h"
#include "lightfield/parallel.h"
#include "tests/distribute/centred_eye.h"
#include "tests/reference/analytic_scene.h"

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
  const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display), eye);
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
  const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display), eye);
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
  const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display), eye);
  for (std::size_t i = 0; i < limited.size(); ++i) ASSERT_NEAR(limited.data()[i].b, 0.25, 1e-5);
}

// A near thing is as blurred as its own beams, what lies behind it as others.
TEST(BandLimit, GivesEveryDepthItsOwnWidth) {
  const Display display = FindDisplay("paper-one-layer");
  const Eye eye = EyeAt(0, 0.1, 400, 3);
  const auto width_of_edge = [&](double z) {
    const SeenScene scene = SceneOf(eye, z, [](int x, int) { return x < 200 ? 0.0F : 1.0F; });
    const Image<Rgb> limited = BandLimited(scene, BandLimitOf(display), eye);
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

// A wave on z = `z` with a crest on the axis, its frequencies per mm to the right and upwards.
struct PlaneWave {
  double z = 0, along_x = 0, along_y = 0;
  double Phase(double x, double y) const { return 2 * M_PI * (along_x * x + along_y * y); }
  float Light(double x, double y) const {
    return static_cast<float>(kMean + kContrast * std::cos(Phase(x, y)));
  }
};

// Cylinder lenses over 60 x 48 px of the panel of the paper's displays.
Display SheetDisplay(const Lenticular& lenses) {
  Display display = FindDisplay("paper-one-layer");
  display.width_px = 60;
  display.height_px = 48;
  display.layers[0].optics = lenses;
  display.layers[0].position_mm = 0;
  return display;
}

// What a row of a sheet's emitters has for beams: a lens by a sub-pixel along x, along y a height
// that is the row's as the viewer sees it.
struct SheetBeam {
  double lens = 0, subpixel = 0, height = 0;
  double Mtf(const PlaneWave& wave) const {
    return Sinc(wave.along_x * lens) * Sinc(wave.along_x * subpixel) * Sinc(wave.along_y * height);
  }
};
SheetBeam BeamOn(const Lenticular& lenses, double z) {
  return {lenses.subpixels_per_lens * kPitch / 3, kPitch / 3 * std::abs(z) / kGap,
          kPitch * (kDistance - z) / kDistance};
}

// Upright, level and tilted both ways, below the cut-off, and where rows tell crests from nodes.
std::vector<PlaneWave> WavesBelowCutoff(const SheetBeam& beam, double z) {
  const double x = 0.5 / std::max(beam.lens, beam.subpixel), y = 0.5 / beam.height;
  return {{z, x, 0}, {z, 0, 0.8 * y}, {z, 0.6 * x, 0.8 * y}, {z, 0.6 * x, -0.8 * y}};
}

std::string Named(const Lenticular& lenses, const PlaneWave& wave) {
  return fmt::format("slant {:.3f}, {} mm, {:.3f} and {:.3f} per mm", lenses.slant, wave.z,
                     wave.along_x, wave.along_y);
}

// What is left of a wave in the middle of its band-limited picture.
double LeftInPicture(const Display& display, const PlaneWave& wave) {
  constexpr int kMiddle = 80, kSize = 2 * kMiddle + 1;  // px
  const double pixel = 0.1 * kDistance / (kDistance - wave.z);
  const Eye eye = EyeAt(0, pixel, kSize, kSize);
  const SeenScene scene = SceneOf(eye, wave.z, [&](int x, int y) {
    return wave.Light(0.1 * (x - kMiddle), 0.1 * (kMiddle - y));
  });
  const Rgb middle = BandLimited(scene, BandLimitOf(display), eye)(kMiddle, kMiddle);
  return (static_cast<double>(middle.g) - kMean) / kContrast;
}

AnalyticScene SceneOf(const PlaneWave& wave) {
  Rectangle plane;
  plane.z = wave.z;
  plane.color = [wave](double x, double y) {
    const float light = wave.Light(x, y);
    return Rgb{light, light, light};
  };
  AnalyticScene scene;
  scene.rectangles = {plane};
  return scene;
}

// What is left of it in the emitters of the first layer, each at the place of its central ray.
double LeftInEmitters(const Display& display, const PlaneWave& wave, const LayersOptions& options) {
  const LayerImages images = Distribute(SceneOf(wave), display, options, SilentProgress());
  const LayerMap map(display, 0);
  const Image<Rgb>& color = images.slots[0][0].color;
  double sum = 0, of_wave = 0;
  for (int i = 0; i < 3 * color.width() * color.height(); ++i) {
    const int channel = i % 3, column = i / 3 % color.width(), row = i / 3 / color.width();
    const Beam beam = map.BeamOf(0, channel, column, row).value();
    const double cosine = std::cos(wave.Phase(beam.x.At(wave.z), beam.y.At(wave.z)));
    const Rgb& light = color(column, row);
    const float value = channel == 0 ? light.r : channel == 1 ? light.g : light.b;
    sum += (static_cast<double>(value) - kMean) / kContrast * cosine;
    of_wave += cosine * cosine;
  }
  return sum / of_wave;
}

// The prefilter takes the scene's value in the middle of a sample for all of it, and a node's ray
// for those beside it in the node's cell: boxes of their sizes. Rows lie much alike among the
// samples; where they end in samples' middles they lose that twice, as a trapezoid rule does.
double LostBySampling(const Display& display, const PlaneWave& wave, const LayersOptions& options) {
  const double sample = kPitch / options.samples_per_pixel * (kDistance - wave.z) / kDistance;
  const double node =
      AimStep(display, display.layers[0]) / options.nodes_per_step * std::abs(wave.z) / kDistance;
  const double of_row = Sinc(wave.along_y * sample);
  return 1 - Sinc(wave.along_x * sample) * Sinc(wave.along_x * node) * of_row * of_row;
}

LayersOptions FineSampling() {
  LayersOptions options;
  options.nodes_per_step = 3;
  options.samples_per_pixel = 4;
  return options;
}

TEST(BandLimit, OfCylinderLensesIsWhatThePrefilterLeaves) {
  const LayersOptions options = FineSampling();
  for (const Lenticular& lenses :
       {Lenticular{4.5, 1.0 / 6, 9}, Lenticular{7.5, -0.2371, 9, 0.3}, Lenticular{6.3, 0, 8}}) {
    const Display display = SheetDisplay(lenses);
    for (const double z : {-300.0, -20.0, 0.0, 60.0}) {
      const SheetBeam beam = BeamOn(lenses, z);
      for (const PlaneWave& wave : WavesBelowCutoff(beam, z)) {
        EXPECT_NEAR(LeftInEmitters(display, wave, options), beam.Mtf(wave),
                    LostBySampling(display, wave, options))
            << Named(lenses, wave);
        EXPECT_NEAR(LeftInPicture(display, wave), beam.Mtf(wave), 0.01) << Named(lenses, wave);
      }
    }
  }
}

// A row is as high at every depth as it is seen on the panel: of what is infinitely far a wave per
// radian is left by the angle of a row. Without shear rows send level beams.
TEST(BandLimit, OfCylinderLensesKeepsTheRowsOfThePanel) {
  Display display = SheetDisplay({4.5, 1.0 / 6, 9});
  const auto expect_left = [&](const PlaneWave& wave, double in_picture, double left) {
    EXPECT_NEAR(in_picture, left, 0.01) << wave.z;
    EXPECT_NEAR(LeftInEmitters(display, wave, FineSampling()), left,
                LostBySampling(display, wave, FineSampling()))
        << wave.z;
  };
  for (const double per_radian : {300.0, 700.0}) {
    expect_left({-1e5, 0, per_radian / (1e5 + kDistance)},
                LeftOfWave(display, -kInfinitelyFar, per_radian, true, 0, 0.1),
                Sinc(per_radian * kPitch / kDistance));
  }
  display.shear = false;
  for (const double z : {-60.0, 60.0}) {
    const PlaneWave wave{z, 0, 1.2};
    expect_left(wave, LeftInPicture(display, wave), Sinc(1.2 * kPitch));
  }
}

// What a slanted lens's own beams leave of a wave, those that reach one height of the eye. From a
// place `a` along the row beside its vertex line (x + slant y), light of an emitter's place (b, c)
// goes through
//   X = a cos^2 - slant c - (b + slant c) z/d0,   Y = a sin cos + c   (LenticularMap::See, f = d0):
// a slice across the lens, a row's height along it, and a sub-pixel as it lies under the lens.
double LeaningMtf(const Lenticular& lenses, const SheetBeam& beam, const PlaneWave& wave) {
  const double cosine = 1 / std::hypot(1.0, lenses.slant), sine = lenses.slant * cosine;
  const double across = wave.along_x * cosine + wave.along_y * sine;
  const double along = wave.along_y - lenses.slant * wave.along_x * (1 + wave.z / kGap);
  return Sinc(across * beam.lens * cosine) * Sinc(along * beam.height) *
         Sinc(wave.along_x * beam.subpixel);
}

// What is left of a wave as eyes see it that stand within one step of the views.
double LeftBeforeEyes(const Display& display, const PlaneWave& wave, const LayersOptions& options) {
  constexpr int kEyes = 8, kMargin = 12;
  const LayerImages images = Distribute(SceneOf(wave), display, options, SilentProgress());
  const int width = 2 * (display.width_px - 2 * kMargin);
  const int height = 2 * (display.height_px - 2 * kMargin);
  const double share = (kDistance - wave.z) / kDistance, pixel = kPitch / 2;
  double sum = 0, of_wave = 0;
  for (int i = 0; i < kEyes; ++i) {
    const double at = ((i + 0.5) / kEyes - 0.5) * kDistance * kPitch / 3 / kGap;
    const EyePicture seen = SimulateEye(images, display, EyeAt(at, pixel, width, height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double right = (x + 0.5 - width / 2.0) * pixel, up = (height / 2.0 - y - 0.5) * pixel;
        const double cosine = std::cos(wave.Phase(at + share * (right - at), share * up));
        const Rgb& light = seen.color(x, y);
        const double mean = static_cast<double>(light.r + light.g + light.b) / 3;
        sum += (mean - kMean) / kContrast * cosine;
        of_wave += cosine * cosine;
      }
    }
  }
  return sum / of_wave / Sinc(wave.along_x * share * pixel) / Sinc(wave.along_y * share * pixel);
}

// The prefilter does not lean, the display does: an eye sees the band limit times that.
TEST(BandLimit, OfSlantedLensesIsSeenThroughLeaningSlices) {
  const LayersOptions options = FineSampling();
  for (const Lenticular& lenses : {Lenticular{4.5, 1.0 / 6, 9}, Lenticular{7.5, -0.2371, 9, 0.3}}) {
    Display display = SheetDisplay(lenses);
    display.width_px = 120;
    display.height_px = 96;
    for (const double z : {-20.0, 0.0}) {
      const SheetBeam beam = BeamOn(lenses, z);
      for (const PlaneWave& wave : WavesBelowCutoff(beam, z)) {
        EXPECT_NEAR(LeftBeforeEyes(display, wave, options),
                    LeftInPicture(display, wave) * LeaningMtf(lenses, beam, wave),
                    0.01 + LostBySampling(display, wave, options))
            << Named(lenses, wave);
      }
    }
  }
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
    limited[threads - 1] = BandLimited(scene, BandLimitOf(display), eye);
  }
  for (std::size_t i = 0; i < scene.z.size(); ++i) {
    ASSERT_EQ(limited[0].data()[i], limited[1].data()[i]);
  }
}

}  // namespace
}  // namespace lamella
