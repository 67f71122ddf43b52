// The simulated eye before lenses against many lines of sight, each followed through the ray map on
// its own, and against closed forms.
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/simulate_eye.h"
#include "lightfield/bandwidth.h"
#include "lightfield/layer_map.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

Display WithLenses(const Optics& optics, double position_mm = 4) {
  Display display = FindDisplay("paper-one-layer");
  display.width_px = 64;
  display.height_px = 48;
  display.layers[0].optics = optics;
  display.layers[0].position_mm = position_mm;
  return display;
}

LayerImages RandomEmitters(const Display& display) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> light(0, 1);
  LayerImages images;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    EmitterImage image{Image<Rgb>(display.emitter_columns(), display.emitter_rows()),
                       Image<float>(display.emitter_columns(), display.emitter_rows())};
    for (std::size_t i = 0; i < image.color.size(); ++i) {
      image.color.data()[i] = {light(random), light(random), light(random)};
      image.coverage.data()[i] = light(random);
    }
    images.slots.emplace_back();
    images.slots.back().push_back(std::move(image));
  }
  return images;
}

Eye Near(const Display& display, double x, double y, double plane) {
  Eye eye;
  eye.position = {x, y, 300};
  eye.plane_mm = plane;
  eye.pixel_mm = 1.7;
  eye.width = 11;
  eye.height = 8;
  eye.left_mm = -0.45 * eye.width * eye.pixel_mm;
  eye.top_mm = 0.55 * eye.height * eye.pixel_mm;
  static_cast<void>(display);
  return eye;
}

// n x n lines a pixel.
EyePicture ByLines(const LayerImages& layers, const Display& display, const Eye& eye, int n) {
  EyePicture picture{Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height)};
  ParallelForEach(0, eye.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < eye.width; ++x) {
      double light[3] = {0, 0, 0}, known = 0, all = 0;
      for (int i = 0; i < n * n; ++i) {
        const int u = i % n, v = i / n;
        const Eigen::Vector3d at(eye.left_mm + (x + (u + 0.5) / n) * eye.pixel_mm,
                                 eye.top_mm - (y + (v + 0.5) / n) * eye.pixel_mm, eye.plane_mm);
        const Eigen::Vector3d slope = (eye.position - at) / (eye.position.z() - at.z());
        for (std::size_t l = 0; l < display.layers.size(); ++l) {
          const LayerMap map(display, static_cast<int>(l));
          const Eigen::Vector3d on = at + (map.position_mm() - at.z()) * slope;
          const auto hit = map.See(on.x(), on.y(), slope.x(), slope.y());
          if (!hit) continue;
          const double black = 1 / display.contrast;
          for (int channel = 0; channel < 3; ++channel) {
            if (hit->channel >= 0 && hit->channel != channel) continue;
            light[channel] += black * (hit->channel >= 0 ? 3 : 1);
          }
          if (hit->guard) continue;
          const EmitterImage& image = layers.slots[l][0];
          const int column = static_cast<int>(hit->column), r = static_cast<int>(hit->row);
          const Rgb c = image.color(column, r);
          const float of[3] = {c.r, c.g, c.b};
          for (int channel = 0; channel < 3; ++channel) {
            if (hit->channel >= 0 && hit->channel != channel) continue;
            light[channel] +=
                (1 - black) * static_cast<double>(of[channel]) * (hit->channel >= 0 ? 3 : 1);
          }
          known += static_cast<double>(image.coverage(column, r));
          all += 1;
        }
      }
      picture.color(x, y) = {static_cast<float>(light[0] / n / n),
                             static_cast<float>(light[1] / n / n),
                             static_cast<float>(light[2] / n / n)};
      picture.coverage(x, y) = all > 0 ? static_cast<float>(known / all) : 0;
    }
  });
  return picture;
}

void ExpectLike(const EyePicture& fast, const EyePicture& slow, double mean, const char* name) {
  double color = 0, coverage = 0;
  for (std::size_t i = 0; i < fast.color.size(); ++i) {
    const Rgb d = fast.color.data()[i] - slow.color.data()[i];
    color += static_cast<double>(std::abs(d.r) + std::abs(d.g) + std::abs(d.b)) / 3;
    coverage += static_cast<double>(std::abs(fast.coverage.data()[i] - slow.coverage.data()[i]));
  }
  const double n = static_cast<double>(fast.color.size());
  EXPECT_LT(color / n, mean) << name;
  EXPECT_LT(coverage / n, mean) << name;
}

struct SimulatedLenses {
  std::string name;
  Optics optics;
  bool mirror_x = false;
};

class LensCases : public ::testing::TestWithParam<SimulatedLenses> {};

TEST_P(LensCases, MatchManyLines) {
  for (const bool shear : {true, false}) {
    Display display = WithLenses(GetParam().optics);
    display.shear = shear;
    if (!shear) display.contrast = 20;
    display.layers[0].mirror_x = GetParam().mirror_x;
    const LayerImages layers = RandomEmitters(display);
    for (const auto& [x, y, plane] :
         {std::array{0.0, 0.0, 0.0}, {37.0, -21.0, 0.0}, {-60.0, 5.0, 9.0}, {180.0, 120.0, -3.0}}) {
      const Eye eye = Near(display, x, y, plane);
      ExpectLike(SimulateEye(layers, display, eye), ByLines(layers, display, eye, 64), 4e-3,
                 GetParam().name.c_str());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Optics, LensCases,
    ::testing::Values(SimulatedLenses{"square", LensletArray{LensletArray::Lattice::kSquare, 6, 6}},
                      SimulatedLenses{"fractional", LensletArray{LensletArray::Lattice::kSquare,
                                                                 5.37, 4, 0.4, -0.3}},
                      SimulatedLenses{"focused", LensletArray{LensletArray::Lattice::kSquare, 6, 6,
                                                              0, 0, true, 4.0}},
                      SimulatedLenses{"hexagonal", LensletArray{LensletArray::Lattice::kHexagonal,
                                                                8, 6, 0.2, 0.6}},
                      SimulatedLenses{"even_rows", LensletArray{LensletArray::Lattice::kHexagonal,
                                                                7.3, 7, 0, 0, false}},
                      SimulatedLenses{"lenticular", Lenticular{4.5, 1.0 / 6, 9, 0.3}},
                      SimulatedLenses{"leaning_left", Lenticular{7.5, -0.237, 9, 1.2, 4}, true}),
    [](const auto& optics) { return optics.param.name; });

TEST(SimulateLenses, AddsUpThePlanesOfAVarifocalDisplay) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 91;
  display.height_px = 70;
  display.varifocal->planes = 3;
  display.varifocal->depth_mm = 40;
  display.varifocal->relay_focal_mm = 300;
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
  const LayerImages layers = RandomEmitters(display);
  const Eye eye = Near(display, 12, -9, 0);
  ExpectLike(SimulateEye(layers, display, eye), ByLines(layers, display, eye, 64), 1.2e-2,
             "varifocal");  // three layers
}

// A line in a layer is sharp for a pupil that is focused on the layer, and a disc elsewhere.
TEST(SimulateEye, BlursWhatIsOutOfThePupilsFocus) {
  Display display = WithLenses(LensletArray{LensletArray::Lattice::kSquare, 4, 4}, 0);
  display.width_px = 400;
  display.height_px = 24;
  LayerImages layers;
  layers.slots.resize(1);
  layers.slots[0].push_back({Image<Rgb>(400, 24), Image<float>(400, 24, 1)});
  for (int y = 0; y < 24; ++y) {  // the lens in the middle, all directions
    for (int x = 200; x < 204; ++x) layers.slots[0][0].color(x, y) = {1, 1, 1};
  }
  const double lens_mm = 4 * display.pitch_mm, middle_mm = 2 * display.pitch_mm;
  for (const double focus : {0.0, 60.0, -90.0}) {
    Eye eye;
    eye.position = {0, 0, 400};
    eye.plane_mm = focus;
    eye.pixel_mm = 0.05;
    eye.width = 200;
    eye.height = 1;
    eye.left_mm = middle_mm * (1 - focus / 400) - eye.width * eye.pixel_mm / 2;
    eye.top_mm = 0.6;
    const Pupil pupil{6, 400};
    const EyePicture picture = SimulateEye(layers, display, eye, pupil);
    double sum = 0, mean = 0, square = 0;
    for (int x = 0; x < eye.width; ++x) {
      const double light = static_cast<double>(picture.color(x, 0).g);
      const double at = eye.left_mm + (x + 0.5) * eye.pixel_mm;
      sum += light;
      mean += light * at;
      square += light * at * at;
    }
    const double variance = square / sum - mean * mean / sum / sum;
    // On the plane in focus: the lens's width seen there, and the pupil's disc seen through it,
    // of which one coordinate has the variance diameter^2 / 16.
    const double scale = (400 - focus) / 400;
    const double blur = EyeBlurMm(6, 400, focus, 0) * scale;
    EXPECT_NEAR(variance, lens_mm * lens_mm * scale * scale / 12 + blur * blur / 16,
                0.05 * variance + 0.001)
        << focus;
  }
}

TEST(SimulateLenses, DoesNotDependOnTheNumberOfThreads) {
  const Display display = WithLenses(LensletArray{LensletArray::Lattice::kHexagonal, 8, 6});
  const LayerImages layers = RandomEmitters(display);
  Eye eye = Near(display, 3, 4, 0);
  eye.height = 40;
  eye.pixel_mm = 0.4;
  const auto run = [&](int threads) {
    const ThreadLimit limit(threads);
    return SimulateEye(layers, display, eye);
  };
  const EyePicture one = run(1), two = run(2);
  for (std::size_t i = 0; i < one.color.size(); ++i) {
    EXPECT_EQ(one.color.data()[i], two.color.data()[i]);
  }
}

}  // namespace
}  // namespace lamella
