// Distribution to lenses against many rays a beam, and in strips against all at once.
#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"
#include "tests/reference/distribute_reference.h"

namespace lamella {
namespace {

constexpr double kEverywhere = 1e9;

Rectangle Waves(double z, double finest) {
  const auto color = [finest](double x, double y) {
    const auto wave = [&](double f, double angle, double phase) {
      return std::cos(2 * M_PI * f * (x * std::cos(angle) + y * std::sin(angle)) + phase);
    };
    const double a = wave(finest, 0.3, 1), b = wave(finest * 0.6, 1.9, 2);
    return Rgb{static_cast<float>(0.5 + 0.2 * (a + b)), static_cast<float>(0.5 + 0.2 * (b - a)),
               static_cast<float>(0.5 + 0.2 * a)};
  };
  return {z, -kEverywhere, kEverywhere, -kEverywhere, kEverywhere, color};
}

// Lenses over the panel of paper-one-layer, 60 x 48 px.
Display WithOptics(const Optics& optics, double position_mm = 0) {
  Display display = FindDisplay("paper-one-layer");
  display.name = "test";
  display.width_px = 60;
  display.height_px = 48;
  display.layers[0].optics = optics;
  display.layers[0].position_mm = position_mm;
  display.border_offset_mm = 0;
  return display;
}

Display RelayedDisplay(double relay_focal_mm) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 91;
  display.height_px = 70;
  display.varifocal->planes = 3;
  display.varifocal->depth_mm = 40;
  display.varifocal->relay_focal_mm = relay_focal_mm;
  Layer layer = display.layers[0];
  layer.magnification = 1;
  display.layers = PlanesOf(*display.varifocal, layer);
  return display;
}

LayersOptions Fine(int nodes, int samples) {
  LayersOptions options;
  options.nodes_per_step = nodes;
  options.samples_per_pixel = samples;
  return options;
}

double Agreement(const AnalyticScene& scene, const Display& display, const LayersOptions& options,
                 int layer, int m) {
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  return EmitterPsnr(images.slots[static_cast<std::size_t>(layer)][0],
                     ReferenceEmitters(scene, display, layer, 0, m));
}

struct LensCase {
  const char* name;
  Optics optics;
  double z;
  double least_db;
};

class Lenses : public ::testing::TestWithParam<LensCase> {};

TEST_P(Lenses, AgreeWithManyRaysABeam) {
  const LensCase& c = GetParam();
  for (const bool shear : {true, false}) {
    Display display = WithOptics(c.optics);
    display.shear = shear;
    AnalyticScene scene;
    scene.rectangles = {Waves(c.z, 0.3)};
    const double db = Agreement(scene, display, Fine(2, 2), 0, 6);
    RecordProperty(shear ? "psnr_shear" : "psnr", std::to_string(db));
    EXPECT_GE(db, c.least_db) << "shear " << shear;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Optics, Lenses,
    ::testing::Values(
        LensCase{"square", LensletArray{LensletArray::Lattice::kSquare, 6, 6}, 6, 48},
        LensCase{"fractional", LensletArray{LensletArray::Lattice::kSquare, 5.37, 5, 0.4, -0.3}, 6,
                 48},
        LensCase{"focused", LensletArray{LensletArray::Lattice::kSquare, 6, 6, 0, 0, true, 4.0}, 6,
                 48},
        LensCase{"hexagonal", LensletArray{LensletArray::Lattice::kHexagonal, 8, 6, 0.2, 0.6}, 6,
                 48},
        // Windows as wide as the cell: hexagons cut their corners.
        LensCase{"cut", LensletArray{LensletArray::Lattice::kHexagonal, 7.3, 7}, -4, 48}),
    [](const auto& optics) { return std::string(optics.param.name); });

TEST(LenticularLayers, HaveABeamOfTheirOwnForEverySubpixel) {
  for (const double slant : {1.0 / 6, -0.2371}) {
    Display display = WithOptics(Lenticular{7.5, slant, 9, 0.3});
    display.width_px = 24;
    AnalyticScene scene;
    scene.rectangles = {Waves(5, 0.25)};
    const LayerImages images = Distribute(scene, display, Fine(2, 3), SilentProgress());
    for (int channel = 0; channel < 3; ++channel) {
      const EmitterImage truth = ReferenceEmitters(scene, display, 0, 0, 6, false, channel);
      double sum = 0;
      for (std::size_t i = 0; i < truth.color.size(); ++i) {
        const auto of = [channel](const Rgb& c) {
          return static_cast<double>(channel == 0 ? c.r : channel == 1 ? c.g : c.b);
        };
        sum += std::pow(of(truth.color.data()[i]) - of(images.slots[0][0].color.data()[i]), 2);
      }
      EXPECT_GE(-10 * std::log10(sum / static_cast<double>(truth.color.size())), 48)
          << slant << " " << channel;
    }
  }
}

TEST(VarifocalPlanes, AgreeWithManyRaysABeam) {
  for (const double focal : {std::numeric_limits<double>::infinity(), 300.0}) {
    const Display display = RelayedDisplay(focal);
    AnalyticScene scene;
    scene.rectangles = {Waves(-20, 0.1), {3, -4, 5, -3, 4, Waves(0, 0.1).color}};
    for (int plane = 0; plane < 3; ++plane) {
      EXPECT_GE(Agreement(scene, display, Fine(2, 1), plane, 6), 40) << focal << " " << plane;
    }
  }
}

// Emitters with beams of their own where nothing is askew: the same light, but for those at the
// border of a window, which is rounded in the design's map (without shear there is none).
TEST(CalibratedLenses, AreAsDesignedWhereNothingIsAskew) {
  using Lattice = LensletArray::Lattice;
  for (const Optics& optics : {Optics(LensletArray{Lattice::kSquare, 6, 6}),
                               Optics(LensletArray{Lattice::kHexagonal, 8, 6, 0.2, 0.6}),
                               Optics(Lenticular{7.5, -0.2371, 9, 0.3})}) {
    Display display = WithOptics(optics);
    display.shear = false;
    const Calibration design = DesignCalibration(display);
    AnalyticScene scene;
    scene.rectangles = {Waves(5, 0.25)};
    const EmitterImage expected =
        std::move(Distribute(scene, display, Fine(1, 1), SilentProgress()).slots[0][0]);
    const EmitterImage image =
        std::move(Distribute(scene, display, Fine(1, 1), SilentProgress(), &design).slots[0][0]);
    int same = 0;
    for (std::size_t i = 0; i < image.color.size(); ++i) {
      const Rgb d = image.color.data()[i] - expected.color.data()[i];
      const float most =
          std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b),
                    std::abs(image.coverage.data()[i] - expected.coverage.data()[i])});
      same += most < 1e-4F ? 1 : 0;
    }
    EXPECT_GE(same, 0.99 * static_cast<double>(image.color.size())) << NameOf(optics);
  }
}

Rectangle Grey(Rectangle rectangle) {
  rectangle.color = [color = rectangle.color](double x, double y) {
    const float value = color(x, y).g;
    return Rgb{value, value, value};
  };
  return rectangle;
}

// What an eye sees of the display against a grey scene along the same lines, in dB. Of the mean of
// the channels, since single lenses of a striped panel show single channels.
double SeenPsnr(const AnalyticScene& scene, const Display& display, const Eigen::Vector3d& at) {
  const LayerImages images = Distribute(scene, display, Fine(1, 1), SilentProgress());
  Eye eye;
  eye.position = at;
  eye.pixel_mm = 4 * display.pitch_mm;
  eye.width = display.width_px / 4 - 12;
  eye.height = display.height_px / 4 - 6;
  eye.left_mm = -eye.width * eye.pixel_mm / 2;
  eye.top_mm = eye.height * eye.pixel_mm / 2;
  const EyePicture seen = SimulateEye(images, display, eye);
  const RayBundle rays = BundleOfEye(eye, 4);
  double sum = 0;
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      double direct = 0;
      for (int i = 0; i < 16; ++i) {
        const int u = 4 * x + i % 4, v = 4 * y + i / 4;
        const RaySample sample = scene.Trace(rays.RayAt(u + 0.5, v + 0.5));
        direct += static_cast<double>(sample.color.g) / 16;
      }
      const Rgb& color = seen.color(x, y);
      sum += std::pow(direct - static_cast<double>(color.r + color.g + color.b) / 3, 2);
    }
  }
  return 10 * std::log10(eye.width * eye.height / sum);
}

TEST(LensDisplays, ShowEyesTheSceneWithItsParallax) {
  for (const Optics& optics : {Optics(LensletArray{LensletArray::Lattice::kSquare, 6, 6}),
                               Optics(LensletArray{LensletArray::Lattice::kHexagonal, 6, 5}),
                               Optics(Lenticular{18, 0.2, 18})}) {
    Display display = WithOptics(optics);
    display.width_px = 320;
    display.height_px = 160;
    const bool full = !std::holds_alternative<Lenticular>(optics);
    AnalyticScene scene;  // a card before a wall: parallax of 4 mm between the outer eyes
    scene.rectangles = {Grey(Waves(-6, 0.05)), Grey({10, -12, 6, -9, 12, Waves(0, 0.06).color})};
    for (const double x : {-40.0, 0.0, 55.0}) {
      const Eigen::Vector3d at(x, full ? 0.5 * x : 0, 600);
      EXPECT_GE(SeenPsnr(scene, display, at), 27) << NameOf(optics) << " " << x;
    }
  }
}

TEST(Distribute, GivesTheSameEmittersInStrips) {
  const Display hexagonal = WithOptics(LensletArray{LensletArray::Lattice::kHexagonal, 8, 6});
  const Display barrier = WithOptics(Barrier{6, 2, 3});
  for (const auto& [display, prefilter] : {std::pair(hexagonal, "gather"),
                                           {WithOptics(Lenticular{7.5, 0.17, 9, 0.3}), "gather"},
                                           {barrier, "gather"},
                                           {hexagonal, "blur"},
                                           {barrier, "blur"}}) {
    Display tall = display;
    tall.width_px = 36;
    tall.height_px = 390;
    AnalyticScene scene;
    scene.rectangles = {Waves(6, 0.3), {12, -3, 2, -1, 4, Waves(0, 0.1).color}};
    scene.background_known = false;
    LayersOptions options = Fine(1, 1);
    options.prefilter = prefilter;
    const LayerImages whole = Distribute(scene, tall, options, SilentProgress());
    options.memory_gib = 1e-7;
    int blocks = 0;  // of 32 rows, a strip each
    const SeenShares seen = Distribute(
        scene, tall, options, {},
        [&](const EmitterRows& rows) {
          const EmitterImage& all = whole.slots[0][static_cast<std::size_t>(rows.slot)];
          for (int y = 0; y < rows.emitters.color.height(); ++y) {
            for (int x = 0; x < 36; ++x) {
              ASSERT_EQ(rows.emitters.color(x, y), all.color(x, rows.first_row + y));
              ASSERT_EQ(rows.emitters.coverage(x, y), all.coverage(x, rows.first_row + y));
            }
          }
          if (rows.slot == 0) ++blocks;
        },
        SilentProgress());
    EXPECT_EQ(blocks, 13);
    EXPECT_NEAR(seen.of_all, whole.seen_share, 1e-12);
  }
}

}  // namespace
}  // namespace lamella
