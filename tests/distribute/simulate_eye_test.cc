#include "distribute/simulate_eye.h"

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "tests/reference/encode_reference.h"
#include "tests/reference/simulate_eye_reference.h"

namespace lamella {
namespace {

Display SmallDisplay(std::vector<double> positions, Barrier barrier = {}, int binning = 1) {
  Display display;
  display.name = "small";
  display.width_px = 96 * binning;
  display.height_px = 72 * binning;
  display.pitch_mm = 0.5 / binning;
  display.binning_px = binning;
  display.viewing_distance_mm = 400;
  for (const double z : positions) display.layers.push_back({z, 5, barrier, false});
  return display;
}

// The middle 3/4 of the panel, `width` px wide.
Eye EyeAt(const Display& display, double x_mm, double y_mm, int width = 96) {
  Eye eye;
  eye.position = {x_mm, y_mm, display.viewing_distance_mm};
  eye.pixel_mm = 0.75 * display.width_mm() / width;
  eye.width = width;
  eye.height = static_cast<int>(0.75 * display.height_mm() / eye.pixel_mm);
  eye.left_mm = -eye.width * eye.pixel_mm / 2;
  eye.top_mm = eye.height * eye.pixel_mm / 2;
  return eye;
}

LayerImages Filled(
    const Display& display, const std::function<Rgb(std::size_t layer, int x, int y)>& fill,
    const std::function<float()>& coverage = [] { return 1.0F; }) {
  LayerImages images;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const int k = SlotsPerAxis(display.layers[l]);
    images.slots.emplace_back();
    for (int slot = 0; slot < k * k; ++slot) {
      EmitterImage image{Image<Rgb>(display.emitter_columns(), display.emitter_rows()),
                         Image<float>(display.emitter_columns(), display.emitter_rows())};
      for (int y = 0; y < display.emitter_rows(); ++y) {
        for (int x = 0; x < display.emitter_columns(); ++x) {
          image.color(x, y) = fill(l, x, y);
          image.coverage(x, y) = coverage();
        }
      }
      images.slots.back().push_back(std::move(image));
    }
  }
  return images;
}

Rgb Mean(const Image<Rgb>& image) {
  double r = 0, g = 0, b = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    r += static_cast<double>(image.data()[i].r);
    g += static_cast<double>(image.data()[i].g);
    b += static_cast<double>(image.data()[i].b);
  }
  const double n = static_cast<double>(image.size());
  return {static_cast<float>(r / n), static_cast<float>(g / n), static_cast<float>(b / n)};
}

void ExpectMatchesReference(const Display& display, const LayerImages& layers, const Eye& eye) {
  const EyePicture fast = SimulateEye(layers, display, eye);
  const EyePicture slow = reference::SimulateEye(layers, display, eye);
  float color = 0, coverage = 0;
  for (std::size_t i = 0; i < fast.color.size(); ++i) {
    const Rgb d = fast.color.data()[i] - slow.color.data()[i];
    color = std::max({color, std::abs(d.r), std::abs(d.g), std::abs(d.b)});
    coverage = std::max(coverage, std::abs(fast.coverage.data()[i] - slow.coverage.data()[i]));
  }
  EXPECT_LT(color, 2e-5F);
  EXPECT_LT(coverage, 2e-5F);
}

struct ReferenceCase {
  std::string name;
  Barrier barrier;
  std::vector<double> positions;
  int binning;
  bool shear;
  double eye_x, eye_y;
};

// Panels as they are: each layer with another contrast.
void MakeReal(Display& display) {
  display.contrast = 40;
  display.slot_crosstalk = 0.3;
  double contrast = 25;
  for (Layer& layer : display.layers) {
    std::get<Barrier>(layer.optics).contrast = contrast;
    contrast *= 2;
  }
}

class SimulateEyeCases : public testing::TestWithParam<ReferenceCase> {
 protected:
  static void ExpectReferenceOnRandomEmitters(const Display& display, double eye_x, double eye_y,
                                              const std::vector<int>& widths);
};

void SimulateEyeCases::ExpectReferenceOnRandomEmitters(const Display& display, double eye_x,
                                                       double eye_y,
                                                       const std::vector<int>& widths) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(0, 1);
  const LayerImages layers = Filled(
      display,
      [&](std::size_t, int, int) {
        return Rgb{value(random), value(random), value(random)};
      },
      [&] { return value(random); });
  for (const int width : widths) {
    Eye eye = EyeAt(display, eye_x, eye_y, width);
    // Beyond the panel on all sides, and off the emitters' raster.
    eye.left_mm = -0.61 * display.width_mm();
    eye.top_mm = 0.59 * display.height_mm();
    eye.pixel_mm = 1.21 * display.width_mm() / width + 0.0137;
    eye.height = std::max(1, width * 3 / 4);
    SCOPED_TRACE(std::to_string(width) + " px");
    ExpectMatchesReference(display, layers, eye);
  }
}

TEST_P(SimulateEyeCases, MatchesTheLoopOverAllPairsOnRandomEmitters) {
  const ReferenceCase& c = GetParam();
  Display display = SmallDisplay(c.positions, c.barrier, c.binning);
  display.shear = c.shear;
  ExpectReferenceOnRandomEmitters(display, c.eye_x, c.eye_y, {1, 31, 64});
  MakeReal(display);
  ExpectReferenceOnRandomEmitters(display, c.eye_x, c.eye_y, {1, 64});
}

INSTANTIATE_TEST_SUITE_P(
    Displays, SimulateEyeCases,
    testing::Values(ReferenceCase{"TwoLayers", {6, 2, 3}, {-10, 10}, 1, true, 3.3, -7.1},
                    ReferenceCase{"OneLayerOutsideTheBox", {6, 2, 3}, {0}, 1, true, 91, 55},
                    ReferenceCase{"BinnedLayers", {3, 1, 3}, {-5, 5}, 2, true, -11, 4},
                    ReferenceCase{
                        "OpeningsWiderThanTheStride", {6, 2, 6}, {-10, 10}, 1, true, 13, 0},
                    ReferenceCase{"OneSlot", {6, 2, 1}, {4}, 1, true, -20, 9},
                    ReferenceCase{"NoShear", {4, 2, 2}, {-3, 0, 8}, 1, false, 8, 8}),
    [](const auto& test) { return test.param.name; });

TEST(SimulateEye, AWhiteDisplayIsWhiteFromEverywhere) {
  const Display display = SmallDisplay({-10, 10});
  const LayerImages layers = Filled(display, [](std::size_t, int, int) {
    return Rgb{0.5F, 0.25F, 0.125F};
  });
  for (const double x : {0.0, 17.0, -60.0}) {
    const EyePicture picture = SimulateEye(layers, display, EyeAt(display, x, x / 2));
    for (std::size_t i = 0; i < picture.color.size(); ++i) {
      // Two layers that both show the colour: twice of it, since a scene's point is shown by one.
      EXPECT_NEAR(picture.color.data()[i].r, 1.0F, 1e-5F);
      EXPECT_NEAR(picture.color.data()[i].b, 0.25F, 1e-5F);
      EXPECT_NEAR(picture.coverage.data()[i], 1.0F, 1e-5F);
    }
  }
}

// displays.md section 2: seen = L (a/P)^2 + (1/c) mean(E), here with what both panels leak.
TEST(SimulateEye, BlackIsAsBrightAsTheContrastsSay) {
  Display display = SmallDisplay({-10, 10});
  display.contrast = 1000;
  for (Layer& layer : display.layers) std::get<Barrier>(layer.optics).contrast = 300;
  const double b = 1e-3, c = 1.0 / 300, open = 1.0 / 9;
  for (const float content : {0.0F, 0.25F}) {
    const LayerImages layers = Filled(display, [&](std::size_t, int, int) {
      return Rgb{content, 0, content};
    });
    const Rgb seen = Mean(SimulateEye(layers, display, EyeAt(display, 17, 8)).color);
    const auto expected = [&](double e) {
      return 2 * (open + c * (1 - open)) * (b + (1 - b) * e) / open;
    };
    EXPECT_NEAR(seen.r, expected(static_cast<double>(content)), 1e-6);
    EXPECT_NEAR(seen.g, expected(0), 1e-6);
  }
}

// Of every pair of neighbours in the order of slots, r (1 - r) of the light comes from the other.
TEST(SimulateEye, SlotsAreSeenInThoseBeforeAndAfterThem) {
  Display display = SmallDisplay({0});
  display.slot_crosstalk = 0.25;
  LayerImages layers = Filled(display, [](std::size_t, int, int) { return Rgb{}; });
  for (const int slot : {0, 4}) {  // neighbours: 0, 4, 8, ...
    Image<Rgb>& color = layers.slots[0][static_cast<std::size_t>(slot)].color;
    color = Image<Rgb>(color.width(), color.height(), Rgb{0, 1, 0});
  }
  // A pixel of the picture is one opening of one slot.
  Eye eye = EyeAt(display, 0, 0, 36);
  eye.top_mm = 24 * display.pitch_mm;
  const Image<Rgb> seen = SimulateEye(layers, display, eye).color;
  const float own = 1 - 2 * 0.1875F, cross = 0.1875F;
  const std::array<float, 9> expected{own + cross, 0, 0, 0, own + cross, 0, 0, 0, cross};
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      const std::size_t slot = 3 * static_cast<std::size_t>(y) + static_cast<std::size_t>(x);
      // The last one in the order, before slot 0, is 5: (8 mod 3, (8 + 2) mod 3).
      EXPECT_NEAR(seen(x, y).g, slot == 5 ? cross : expected[slot], 1e-5) << slot;
    }
  }
}

TEST(SimulateEye, OneSlotOfNarrowOpeningsHasTheRightMeanBrightness) {
  const Display display = SmallDisplay({0}, {6, 2, 1});
  const LayerImages layers = Filled(display, [](std::size_t, int, int) { return Rgb{1, 1, 1}; });
  Eye eye = EyeAt(display, 0, 0, 72);  // one pixel is one emitter: 12 x 9 whole periods
  const EyePicture picture = SimulateEye(layers, display, eye);
  EXPECT_NEAR(Mean(picture.color).g, 1.0F, 1e-5F);
}

TEST(SimulateEye, IsUprightAndNotMirrored) {
  const Display display = SmallDisplay({-10, 10});
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  const LayerImages layers = Filled(display, [&](std::size_t l, int x, int y) {
    if (l == 1) return Rgb{};
    return Rgb{x < columns / 2 ? 1.0F : 0.0F, y < rows / 2 ? 1.0F : 0.0F, 0};
  });
  const EyePicture picture = SimulateEye(layers, display, EyeAt(display, 0, 0, 48));
  const int right = picture.color.width() - 3, bottom = picture.color.height() - 3;
  EXPECT_EQ(picture.color(2, 2), (Rgb{1, 1, 0}));
  EXPECT_EQ(picture.color(right, 2), (Rgb{0, 1, 0}));
  EXPECT_EQ(picture.color(2, bottom), (Rgb{1, 0, 0}));
  EXPECT_EQ(picture.color(right, bottom), (Rgb{0, 0, 0}));
}

TEST(SimulateEye, ASingleEmitterIsSeenThroughItsOpeningAtTheTriangleRuleSPlace) {
  // Opening columns 48, 49 of slot 0 (c0 = 6 * 8): its centre is 1 emitter right of the middle. The
  // emitter column 47 lies 1.5 pitches left of it, so the ray goes right with slope 1.5 p / d0.
  const Display display = SmallDisplay({10});
  const double p = display.emitter_pitch_mm();
  LayerImages layers = Filled(display, [](std::size_t, int, int) { return Rgb{}; });
  const int row = 36;  // opening rows 36, 37: emitters 36 and 37 look straight on
  layers.slots[0][0].color(47, row) = {1, 1, 1};
  const double slope = 1.5 * p / 5, opening = 1 * p;
  const double eye_x = opening + slope * (400 - 10);
  Eye eye = EyeAt(display, eye_x, -p, 200);
  const EyePicture picture = SimulateEye(layers, display, eye);
  double sum = 0, x_sum = 0;
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      const double light = static_cast<double>(picture.color(x, y).g);
      sum += light;
      x_sum += light * (eye.left_mm + (x + 0.5) * eye.pixel_mm);
    }
  }
  ASSERT_GT(sum, 0);
  // On z = 0, the line from the eye through the middles of the opening and of the emitter.
  EXPECT_NEAR(x_sum / sum, opening - slope * 10, 0.02);
  // The opening and the emitter are 2 and 1 pitches wide: beyond 1.5 emitter steps nothing is left.
  const Eye beside = EyeAt(display, eye_x - 1.55 * (400 - 10) * p / 5, -p, 200);
  EXPECT_LT(Mean(SimulateEye(layers, display, beside).color).g, 1e-6F);
}

// A plane at z whose radiance rises linearly, f = 0.5 + g x + h y: symmetric blurs keep it.
reference::SceneOfLine LinearPlane(double z, double g, double h) {
  return [=](double x, double y, double slope_x, double slope_y) {
    const float value = static_cast<float>(0.5 + g * (x + slope_x * z) + h * (y + slope_y * z));
    return reference::SceneHit{{value, value, value}, z};
  };
}

TEST(SimulateEye, NearThingsMoveAgainstTheEyeAndFarThingsWithIt) {
  const Display display = SmallDisplay({-10, 10});
  const double g = 0.004, h = 0.007;
  // A whole emitter step D p / d0, so that the lattice of views drops out.
  const double step = 400 * display.emitter_pitch_mm() / 5;
  for (const double z : {-20.0, -10.0, 0.0, 10.0, 20.0}) {
    const LayerImages layers = reference::EncodeCentreRays(display, LinearPlane(z, g, h));
    const auto mean = [&](double x, double y) {
      return static_cast<double>(
          Mean(SimulateEye(layers, display, EyeAt(display, x, y, 72)).color).g);
    };
    // The eye e sees on the plane, behind the point X of z = 0, X + (e - X) z / D: the mean over a
    // symmetric picture changes by g z / D per mm of the eye. Rising: the picture's brighter right
    // part moved left.
    EXPECT_NEAR((mean(step, 0) - mean(0, 0)) / step, g * z / 400, 2e-7) << "z = " << z;
    EXPECT_NEAR((mean(0, step) - mean(0, 0)) / step, h * z / 400, 2e-7) << "z = " << z;
    EXPECT_NEAR(mean(0, 0), 0.5, 1e-3);
  }
}

TEST(SimulateEye, ANearSquareCoversAFarPlaneAtItsPlaceFromEachEye) {
  // A green square of 16 mm at z = +10 in front of a red plane at -10.
  const Display display = SmallDisplay({-10, 10});
  const auto scene = [](double x, double y, double slope_x, double slope_y) {
    const bool inside = std::abs(x + slope_x * 10) < 8 && std::abs(y + slope_y * 10) < 8;
    return inside ? reference::SceneHit{{0, 1, 0}, 10} : reference::SceneHit{{1, 0, 0}, -10};
  };
  const LayerImages layers = reference::EncodeCentreRays(display, scene);
  for (const double e : {-30.0, 0.0, 30.0}) {
    const Eye eye = EyeAt(display, e, 0, 144);
    const EyePicture picture = SimulateEye(layers, display, eye);
    double sum = 0, x_sum = 0;
    for (int x = 0; x < eye.width; ++x) {
      const double light = static_cast<double>(picture.color(x, eye.height / 2).g);
      sum += light;
      x_sum += light * (eye.left_mm + (x + 0.5) * eye.pixel_mm);
    }
    // Its middle (0, 0, 10) on z = 0, seen from e: -e z / (D - z).
    EXPECT_NEAR(x_sum / sum, -e * 10 / 390, 0.15) << "eye at " << e;
    const int middle = static_cast<int>((x_sum / sum - eye.left_mm) / eye.pixel_mm);
    EXPECT_LT(picture.color(middle, eye.height / 2).r, 0.02F) << "the plane shines through";
    EXPECT_GT(picture.color(4, eye.height / 2).r, 0.95F);
  }
}

TEST(SimulateEye, LightOutsideTheEyeBoxComesFromTheNeighboursWindow) {
  // A plane at the modulator is seen alike from everywhere; one at +40 jumps back by a whole fan
  // where the eye crosses from one window into the next.
  const Display display = SmallDisplay({0});
  const LayerImages layers = reference::EncodeCentreRays(display, LinearPlane(40, 0.004, 0));
  const double fan = 400 * 6 * display.emitter_pitch_mm() / 5;
  const auto mean = [&](double x) {
    return static_cast<double>(
        Mean(SimulateEye(layers, display, EyeAt(display, x, 0, 72)).color).g);
  };
  EXPECT_NEAR(mean(0), 0.5, 1e-3);
  EXPECT_NEAR(mean(fan / 6), 0.5 + 0.004 * 40 / 400 * fan / 6, 1e-3);
  // The neighbour's opening is one period to the left.
  EXPECT_NEAR(mean(fan), 0.5 - 0.004 * 6 * display.emitter_pitch_mm(), 1e-3);
}

TEST(SimulateEye, UnknownEmittersAreBlackAndTheirShareIsReported) {
  const Display display = SmallDisplay({-10, 10});
  LayerImages layers = Filled(display, [](std::size_t l, int, int) {
    return l == 0 ? Rgb{1, 1, 1} : Rgb{};
  });
  for (EmitterImage& slot : layers.slots[1]) {
    slot.coverage = Image<float>(display.emitter_columns(), display.emitter_rows(), 0.0F);
  }
  const EyePicture picture = SimulateEye(layers, display, EyeAt(display, 5, 0, 30));
  EXPECT_NEAR(picture.coverage(10, 10), 0.5F, 1e-6F);
  EXPECT_NEAR(picture.color(10, 10).r, 1.0F, 1e-5F);
}

TEST(SimulateEye, DoesNotDependOnTheNumberOfThreads) {
  const Display display = SmallDisplay({-10, 10});
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(0, 1);
  const LayerImages layers = Filled(display, [&](std::size_t, int, int) {
    return Rgb{value(random), value(random), value(random)};
  });
  const Eye eye = EyeAt(display, 12, -9, 61);
  EyePicture one, two;
  {
    const ThreadLimit limit(1);
    one = SimulateEye(layers, display, eye);
  }
  two = SimulateEye(layers, display, eye);
  EXPECT_TRUE(std::equal(one.color.data(), one.color.data() + one.color.size(), two.color.data()));
}

TEST(SimulateEye, RefusesLayersThatAreNotTheDisplaysAndAnEyeInsideIt) {
  const Display display = SmallDisplay({-10, 10});
  LayerImages layers = Filled(display, [](std::size_t, int, int) { return Rgb{}; });
  Eye inside = EyeAt(display, 0, 0);
  inside.position.z() = 10;
  EXPECT_THROW(SimulateEye(layers, display, inside), Error);
  layers.slots[1].pop_back();
  EXPECT_THROW(SimulateEye(layers, display, EyeAt(display, 0, 0)), Error);
  layers.slots.pop_back();
  EXPECT_THROW(SimulateEye(layers, display, EyeAt(display, 0, 0)), Error);
}

// As the reference has it, with the eye's distance from the front layer for D: 56 and 37.4 mm at D.
TEST(CleanEyeBox, IsTheReferencesForThePapersDisplays) {
  Display display = SmallDisplay({-10, 10});
  display.pitch_mm = 0.311316;
  display.viewing_distance_mm = 600;
  EXPECT_NEAR(CleanEyeBox(display), 56.04 * 590 / 600, 0.01);
  display.binning_px = 2;
  for (Layer& layer : display.layers) layer.optics = Barrier{3, 1, 3};
  EXPECT_NEAR(CleanEyeBox(display), 37.36 * 590 / 600, 0.01);
}

TEST(BundleOfEye, LooksThroughThePixelsCentresUpright) {
  Eye eye;
  eye.position = {10, 20, 600};
  eye.left_mm = -40;
  eye.top_mm = 30;
  eye.pixel_mm = 2;
  eye.width = 40;
  eye.height = 30;
  const RayBundle bundle = BundleOfEye(eye);
  EXPECT_EQ(bundle.PlanePoint(0.5, 0.5), Eigen::Vector3d(-39, 29, 0));
  EXPECT_EQ(bundle.Normal(), Eigen::Vector3d(0, 0, 1));
  const RayBundle split = BundleOfEye(eye, 2);
  EXPECT_EQ(split.width, 80);
  EXPECT_EQ(split.PlanePoint(80, 60), bundle.PlanePoint(40, 30));
}

}  // namespace
}  // namespace lamella
