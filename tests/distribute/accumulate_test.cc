// Sums of nodes that come at once against those of nodes that come two at a time.
#include "distribute/accumulate.h"

#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/nodes.h"

namespace lamella {
namespace {

// Every sample another colour, at depths around both layers.
Image<RaySample> RandomSamples(int width, int height, std::mt19937& random) {
  std::uniform_real_distribution<float> light(0, 1), depth(-25, 25);
  Image<RaySample> samples(width, height);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    RaySample& sample = samples.data()[i];
    sample.color.r = light(random);
    sample.color.g = light(random);
    sample.color.b = light(random);
    sample.z = depth(random);
    sample.coverage = light(random);
  }
  return samples;
}

std::vector<LayerSums> NoSums(const Display& display, const NodeLattice& nodes,
                              const std::vector<LayerBeams>& beams) {
  std::vector<LayerSums> layers(beams.size());
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const double z = display.layers[l].position_mm;
    for (const std::vector<EmitterBeam>& family : beams[l].columns) {
      layers[l].overlaps.x.push_back(OverlapsAlongX(nodes, family, z, Kernel::kBeam, 0));
    }
    layers[l].overlaps.y = OverlapsAlongY(nodes, beams[l].rows, z, Kernel::kBeam, 0);
    const int k = SlotsPerAxis(display.layers[l]);
    layers[l].sums.slots_per_axis = k;
    for (int slot = 0; slot < k * k; ++slot) {
      layers[l].sums.slots.emplace_back(EmitterColumns(display, display.layers[l]),
                                        display.emitter_rows());
    }
  }
  return layers;
}

class NodesAtOnce : public testing::TestWithParam<const char*> {};

TEST_P(NodesAtOnce, GiveTheSameBitsAsTwoAtATime) {
  Display display = FindDisplay(GetParam());
  display.width_px = 48;
  display.height_px = 36;
  std::vector<LayerBeams> beams;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    beams.push_back(EnclosingBeamsOf(display, static_cast<int>(l)));
  }
  const NodeLattice nodes = NodesFor(display, beams, 1, 1, Kernel::kBeam);
  const LayerWeights weights = WeightsOf(display);
  std::vector<LayerSums> at_once = NoSums(display, nodes, beams);
  std::vector<LayerSums> by_twos = NoSums(display, nodes, beams);
  std::mt19937 random(1);
  for (int node_y = 0; node_y < nodes.y.count; ++node_y) {
    const SampleRange& y = nodes.samples_y[Index(node_y)];
    std::vector<Image<RaySample>> samples;
    std::vector<NodeSamples> row;
    for (int node_x = 0; node_x < nodes.x.count; ++node_x) {
      const SampleRange& x = nodes.samples_x[Index(node_x)];
      samples.push_back(RandomSamples(x.size(), y.size(), random));
      if (x.size() > 0) row.push_back({node_x, x.first, y.first, samples.back().span()});
    }
    if (y.size() == 0) continue;
    Accumulate(row, node_y, weights, at_once);
    for (int node_x = 0; node_x < nodes.x.count; node_x += kNodesTogether) {
      std::vector<NodeSamples> some;
      for (const NodeSamples& node : row) {
        if (node.node_x / kNodesTogether == node_x / kNodesTogether) some.push_back(node);
      }
      Accumulate(some, node_y, weights, by_twos);
    }
  }
  double light = 0;
  for (std::size_t l = 0; l < at_once.size(); ++l) {
    for (std::size_t slot = 0; slot < at_once[l].sums.slots.size(); ++slot) {
      const Image<Light>& a = at_once[l].sums.slots[slot];
      const Image<Light>& b = by_twos[l].sums.slots[slot];
      for (std::size_t i = 0; i < a.size(); ++i) {
        const Light &one = a.data()[i], &other = b.data()[i];
        ASSERT_EQ(std::pair(one.r, one.g), std::pair(other.r, other.g)) << l << " " << slot;
        ASSERT_EQ(std::pair(one.b, one.coverage), std::pair(other.b, other.coverage));
        light += static_cast<double>(one.r);
      }
    }
  }
  EXPECT_GT(light, 1);
}

INSTANTIATE_TEST_SUITE_P(Displays, NodesAtOnce,
                         testing::Values("paper-one-layer", "paper-two-layer", "paper-varifocal"));

}  // namespace
}  // namespace lamella
