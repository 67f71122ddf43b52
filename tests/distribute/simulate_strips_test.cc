#include "distribute/simulate_strips.h"

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

Display Panels(int columns, int rows, const Optics& optics) {
  Display display;
  display.name = "small";
  display.width_px = columns;
  display.height_px = rows;
  display.pitch_mm = 0.5;
  display.viewing_distance_mm = 400;
  for (const double z : {-20.0, 15.0}) display.layers.push_back({z, 5, optics});
  return display;
}

Display RealBarriers() {
  Barrier barrier;
  barrier.contrast = 30;
  Display display = Panels(60, 420, barrier);
  display.contrast = 50;
  display.slot_crosstalk = 0.2;
  return display;
}

Display Lenslets(LensletArray::Lattice lattice) {
  LensletArray lenses;
  lenses.lattice = lattice;
  lenses.pitch_px = 9;
  lenses.rays = 6;
  return Panels(60, 420, lenses);
}

LayerImages RandomLayers(const Display& display) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(0, 1);
  LayerImages images;
  for (const Layer& layer : display.layers) {
    const int k = SlotsPerAxis(layer);
    std::vector<EmitterImage>& slots = images.slots.emplace_back();
    for (int slot = 0; slot < k * k; ++slot) {
      EmitterImage image{Image<Rgb>(display.emitter_columns(), display.emitter_rows()),
                         Image<float>(display.emitter_columns(), display.emitter_rows())};
      for (std::size_t i = 0; i < image.color.size(); ++i) {
        Rgb& color = image.color.data()[i];
        color.r = value(random);
        color.g = value(random);
        color.b = value(random);
        image.coverage.data()[i] = value(random);
      }
      slots.push_back(std::move(image));
    }
  }
  return images;
}

// Eyes of unlike places and rasters; one focuses on a plane in front.
std::vector<Viewer> Viewers(const Display& display) {
  std::vector<Viewer> viewers;
  for (const auto& [x, y, plane, pixel] : {std::array{0.0, 0.0, 0.0, 1.3},
                                           {30.0, 70.0, 0.0, 1.3},
                                           {-10.0, -70.0, 0.0, 2.9},
                                           {0.0, 10.0, 15.0, 1.1}}) {
    Eye eye;
    eye.position = {x, y, display.viewing_distance_mm};
    eye.plane_mm = plane;
    eye.pixel_mm = pixel;
    eye.left_mm = -12;
    eye.top_mm = 106;  // above the panel, too
    eye.width = static_cast<int>(24 / pixel);
    eye.height = static_cast<int>(212 / pixel);
    viewers.push_back({eye, {}});
  }
  viewers.back().pupil = Pupil{6, 5};
  return viewers;
}

// Refuses rows that don't rise, and counts them.
OpenEmitters OpenOnce(const LayerImages& images, std::map<std::pair<int, int>, int>& asked) {
  for (int l = 0; l < std::ssize(images.slots); ++l) {
    for (int s = 0; s < std::ssize(images.slots[static_cast<std::size_t>(l)]); ++s)
      asked[{l, s}] = 0;
  }
  return [&, open = OpenImages(images)](int layer, int slot) -> ReadEmitterRows {
    int& next = asked.at({layer, slot});
    return [&next, read = open(layer, slot)](int first, int end) {
      EXPECT_GE(first, next);
      EXPECT_LT(first, end);
      next = end;
      return read(first, end);
    };
  };
}

class StripsOf : public testing::TestWithParam<std::pair<const char*, Display>> {};

TEST_P(StripsOf, EmittersShowThePicturesOfWholeOnes) {
  const Display& display = GetParam().second;
  const LayerImages images = RandomLayers(display);
  const std::vector<Viewer> viewers = Viewers(display);
  std::vector<EyePicture> whole;
  for (const Viewer& viewer : viewers) {
    whole.push_back(SimulateEye(images, display, viewer.eye, viewer.pupil));
  }
  const double all =
      BytesOf(PlanStrips(display, viewers, std::numeric_limits<double>::infinity()), display);
  std::size_t strips_before = 1000;
  for (const double bytes : {0.0, 0.7 * all, all}) {
    const std::vector<EmitterStripPlan> plan = PlanStrips(display, viewers, bytes);
    EXPECT_LT(plan.size(), strips_before);
    strips_before = plan.size();
    if (bytes > 0) {
      EXPECT_LE(BytesOf(plan, display), bytes);
    }
    std::map<std::pair<int, int>, int> asked;
    std::vector<int> rows(viewers.size());
    SimulateStrips(
        plan, OpenOnce(images, asked), display, viewers,
        [&](std::size_t v, int first_row, const EyePicture& part) {
          rows[v] += part.color.height();
          const auto at = [&](const auto& picture) { return picture.row(first_row); };
          EXPECT_TRUE(std::equal(part.color.data(), part.color.data() + part.color.size(),
                                 at(whole[v].color)));
          EXPECT_TRUE(std::equal(part.coverage.data(), part.coverage.data() + part.coverage.size(),
                                 at(whole[v].coverage)));
        });
    for (std::size_t v = 0; v < rows.size(); ++v) EXPECT_EQ(rows[v], viewers[v].eye.height);
  }
  EXPECT_EQ(strips_before, 1U);
}

Display Slanted() {
  Lenticular lenses;
  lenses.subpixels_per_lens = 7.3;
  lenses.slant = 0.2;
  lenses.views = 7;
  return Panels(60, 420, lenses);
}

Display Bare() {
  Display display = Panels(60, 420, BarePanel{});
  for (Layer& layer : display.layers) layer.d0_mm = 0;
  return display;
}

INSTANTIATE_TEST_SUITE_P(
    Optics, StripsOf,
    testing::Values(std::pair{"barriers", RealBarriers()},
                    std::pair{"square", Lenslets(LensletArray::Lattice::kSquare)},
                    std::pair{"hexagonal", Lenslets(LensletArray::Lattice::kHexagonal)},
                    std::pair{"lenticular", Slanted()}, std::pair{"bare", Bare()}),
    [](const auto& optics) { return optics.param.first; });

TEST(PlanStrips, RefusesAnEyeInsideTheDisplay) {
  const Display display = RealBarriers();
  std::vector<Viewer> viewers = Viewers(display);
  viewers[1].eye.position.z() = 10;
  EXPECT_THROW(PlanStrips(display, viewers, 0), Error);
}

}  // namespace
}  // namespace lamella
