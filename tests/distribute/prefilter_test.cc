// The overlaps against counting: lines drawn from beams and sorted into cells one by one.
#include "distribute/prefilter.h"

#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

Display SmallSheared(bool shear) {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 120;
  display.height_px = 96;
  display.shear = shear;
  return display;
}

enum class Axis { kColumns, kRows };

std::vector<EmitterBeam> BeamsAlong(Axis axis, const Display& display, int layer) {
  LayerBeams beams = BeamsOf(display, layer, 0, display.emitter_rows());
  return axis == Axis::kColumns ? beams.columns.at(0) : beams.rows;
}

struct Setting {
  bool shear;
  int layer;
  double content_mm;
  Axis axis;
  Kernel kernel = Kernel::kBeam;
};

class Overlaps : public ::testing::TestWithParam<Setting> {};

// Share of an emitter's lines that fall into each (node, sample), by a fine grid of lines.
std::map<std::pair<int, int>, double> Count(const AxisBeam& beam, const RayMap& map, double sign,
                                            const AimPlane& aim, double content,
                                            const NodeAxis& nodes, const SampleAxis& samples,
                                            Kernel kernel) {
  constexpr int kLines = 1000;
  std::map<std::pair<int, int>, double> shares;
  for (int i = 0; i < kLines; ++i) {
    for (int j = 0; j < kLines; ++j) {
      const double x = sign * beam.element_mm + ((i + 0.5) / kLines - 0.5) * beam.aperture_mm;
      const double u = sign * beam.emitter_mm + ((j + 0.5) / kLines - 0.5) * beam.emitter_width_mm;
      // A lens gives all light of a point of the emitter the direction through its own middle.
      const double through = kernel == Kernel::kLens ? sign * beam.element_mm : x;
      const double slope = (through - u) / map.d0_mm();
      const double towards = aim.points ? x + slope * (aim.distance_mm - map.position_mm()) : slope;
      const int node = static_cast<int>(std::floor((towards - nodes.first) / nodes.step + 0.5));
      const double at_content = x + slope * (content - map.position_mm());
      const double centre = nodes.Centre(node);
      // The node's ray through the same point of the content plane, where it meets z = 0.
      const double node_slope =
          aim.points ? (centre - at_content) / (aim.distance_mm - content) : centre;
      const double reference = at_content - content * node_slope;
      const int sample =
          static_cast<int>(std::floor((reference - samples.origin_mm) / samples.size_mm));
      shares[{node, sample}] += 1.0 / kLines / kLines;
    }
  }
  return shares;
}

TEST_P(Overlaps, AreTheSharesOfTheBeamsLines) {
  const auto [shear, layer, content, axis, kernel] = GetParam();
  const Display display = SmallSheared(shear);
  const RayMap map(display, layer);
  const std::vector<EmitterBeam> beams = BeamsAlong(axis, display, layer);
  const double z = map.position_mm();
  const AimPlane aim{shear, 600};
  const AimRange range = AimsOf(beams, z, aim, kernel);
  const double step = display.pitch_mm / 5 * (shear ? 600 : 1);
  const NodeAxis nodes{range.min, step, static_cast<int>((range.max - range.min) / step) + 2};
  const SampleAxis samples{-30.3, 0.29};
  const AxisOverlaps overlaps = OverlapsOf(beams, z, aim, content, nodes, samples, kernel);
  for (const auto& [slot, index] : {std::pair(0, 20), std::pair(1, 3), std::pair(2, 90)}) {
    const auto beam = axis == Axis::kColumns ? map.Column(slot, index) : map.Row(slot, index);
    ASSERT_TRUE(beam);
    std::map<std::pair<int, int>, double> weights;
    for (int node = 0; node < nodes.count; ++node) {
      for (const Overlap& overlap : overlaps.nodes[static_cast<std::size_t>(node)]) {
        if (overlap.slot != slot || overlap.emitter != index) continue;
        for (int i = 0; i < overlap.num_samples; ++i) {
          weights[{node, overlap.first_sample + i}] =
              static_cast<double>(overlaps.weights[overlap.weights + static_cast<std::size_t>(i)]);
        }
      }
    }
    const double sign = axis == Axis::kColumns ? 1 : -1;
    double sum = 0;
    for (const auto& [cell, share] :
         Count(*beam, map, sign, aim, content, nodes, samples, kernel)) {
      EXPECT_NEAR(weights[cell], share, 2e-3) << cell.first << " " << cell.second;
    }
    for (const auto& [cell, weight] : weights) sum += weight;
    EXPECT_NEAR(sum, 1, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Settings, Overlaps,
                         ::testing::Values(Setting{true, 0, -10, Axis::kColumns},
                                           Setting{true, 1, 10, Axis::kRows},
                                           Setting{true, 1, 6, Axis::kColumns},
                                           Setting{false, 0, -10, Axis::kColumns},
                                           Setting{false, 1, 3, Axis::kRows},
                                           Setting{true, 1, 10, Axis::kRows, Kernel::kLens},
                                           Setting{false, 0, 4, Axis::kColumns, Kernel::kLens}));

TEST(OverlapsOf, GivesARayTheCellThatItPasses) {
  const Display display = SmallSheared(true);
  const RayMap map(display, 1);
  const AimPlane aim{true, 600};
  const std::vector<EmitterBeam> beams = BeamsAlong(Axis::kColumns, display, 1);
  const double layer = map.position_mm();
  const AimRange range = AimsOf(beams, layer, aim, Kernel::kRay);
  const NodeAxis nodes{range.min, 17.3, static_cast<int>((range.max - range.min) / 17.3) + 2};
  const SampleAxis samples{-30.3, 0.29};
  const AxisOverlaps overlaps = OverlapsOf(beams, layer, aim, layer, nodes, samples, Kernel::kRay);
  int rays = 0;
  for (int node = 0; node < nodes.count; ++node) {
    for (const Overlap& o : overlaps.nodes[static_cast<std::size_t>(node)]) {
      const AxisBeam beam = *map.Column(o.slot, o.emitter);
      EXPECT_NEAR(beam.At(600 - layer), nodes.Centre(node), nodes.step / 2 + 1e-3);
      // Where the node's ray through the same point of the layer meets z = 0.
      const double x =
          beam.element_mm + (beam.element_mm - nodes.Centre(node)) * layer / (600 - layer);
      EXPECT_NEAR(x, samples.origin_mm + (o.first_sample + o.num_samples / 2.0) * samples.size_mm,
                  o.num_samples * samples.size_mm / 2 + 1e-6);
      ++rays;
    }
  }
  EXPECT_GE(rays, 3 * 100);
}

TEST(OverlapsOf, GivesEveryEmitterWithABeamAWeightOfOne) {
  for (const bool shear : {false, true}) {
    const Display display = SmallSheared(shear);
    const RayMap map(display, 0);
    const AimPlane aim{shear, 600};
    const std::vector<EmitterBeam> beams = BeamsAlong(Axis::kColumns, display, 0);
    const AimRange range = AimsOf(beams, -10, aim);
    const double step = (range.max - range.min) / 7.3;
    const AxisOverlaps overlaps =
        OverlapsOf(beams, -10, aim, -10, {range.min + step / 2, step, 8}, {0, 0.3113});
    std::map<std::pair<int, int>, double> sums;
    for (const std::vector<Overlap>& node : overlaps.nodes) {
      for (const Overlap& o : node) {
        for (int i = 0; i < o.num_samples; ++i) {
          const float weight = overlaps.weights[o.weights + static_cast<std::size_t>(i)];
          EXPECT_GE(weight, 0);
          sums[{o.slot, o.emitter}] += static_cast<double>(weight);
        }
      }
    }
    for (int slot = 0; slot < 3; ++slot) {
      for (int column = 0; column < map.columns(); ++column) {
        const bool has_beam = map.Column(slot, column).has_value();
        EXPECT_EQ((sums.count({slot, column})), has_beam ? 1U : 0U);
        if (has_beam) {
          EXPECT_NEAR((sums[{slot, column}]), 1, 1e-6);
        }
      }
    }
  }
}

}  // namespace
}  // namespace lamella
