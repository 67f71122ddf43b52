// Sums of nodes against plain ones over all overlaps, and against those of nodes that come two at a
// time.
#include "distribute/accumulate.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
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

// By slot: light times coverage, and coverage.
using PlainSums = std::vector<Image<Eigen::Vector4d>>;

std::vector<PlainSums> PlainZeros(const std::vector<LayerSums>& layers) {
  std::vector<PlainSums> zeros(layers.size());
  for (std::size_t l = 0; l < layers.size(); ++l) {
    for (const Image<Light>& slot : layers[l].sums.slots) {
      zeros[l].emplace_back(slot.width(), slot.height(), Eigen::Vector4d(0, 0, 0, 0));
    }
  }
  return zeros;
}

// The same, tap by tap in double precision.
void AddPlainly(const std::vector<NodeSamples>& row, int node_y, const LayerWeights& weights,
                const std::vector<LayerSums>& layers, std::vector<PlainSums>& sums) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const LayerOverlaps& overlaps = layers[l].overlaps;
    for (const NodeSamples& node : row) {
      for (const Overlap& y : overlaps.y.nodes[Index(node_y)]) {
        const AxisOverlaps& columns = overlaps.x[Index(y.family)];
        for (const Overlap& x : columns.nodes[Index(node.node_x)]) {
          Eigen::Vector4d& sum =
              sums[l][Index(layers[l].sums.slots_per_axis * y.slot + x.slot)](x.emitter, y.emitter);
          for (int j = 0; j < y.num_samples; ++j) {
            for (int i = 0; i < x.num_samples; ++i) {
              const RaySample& sample = node.samples(x.first_sample + i - node.first_x,
                                                     y.first_sample + j - node.first_y);
              const double share =
                  static_cast<double>(weights.Weight(static_cast<int>(l), sample.z));
              const double weight =
                  static_cast<double>(columns.weights[x.weights + static_cast<std::uint32_t>(i)]) *
                  static_cast<double>(
                      overlaps.y.weights[y.weights + static_cast<std::uint32_t>(j)]) *
                  static_cast<double>(sample.coverage);
              const Rgb& c = sample.color;
              sum += weight * Eigen::Vector4d(share * static_cast<double>(c.r),
                                              share * static_cast<double>(c.g),
                                              share * static_cast<double>(c.b), 1);
            }
          }
        }
      }
    }
  }
}

class NodesAtOnce : public testing::TestWithParam<Display> {};

TEST_P(NodesAtOnce, GiveThePlainSumsAndTheSameBitsAsTwoAtATime) {
  const Display& display = GetParam();
  std::vector<LayerBeams> beams;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    beams.push_back(EnclosingBeamsOf(display, static_cast<int>(l)));
  }
  const NodeLattice nodes = NodesFor(display, beams, 1, 1, Kernel::kBeam);
  const LayerWeights weights = WeightsOf(display);
  std::vector<LayerSums> at_once = NoSums(display, nodes, beams);
  std::vector<LayerSums> by_twos = NoSums(display, nodes, beams);
  std::vector<PlainSums> plain = PlainZeros(at_once);
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
    AddPlainly(row, node_y, weights, at_once, plain);
    for (int node_x = 0; node_x < nodes.x.count; node_x += kNodesTogether) {
      std::vector<NodeSamples> some;
      for (const NodeSamples& node : row) {
        if (node.node_x / kNodesTogether == node_x / kNodesTogether) some.push_back(node);
      }
      Accumulate(some, node_y, weights, by_twos);
    }
  }
  for (std::size_t l = 0; l < at_once.size(); ++l) {
    double most = 0;
    for (std::size_t slot = 0; slot < at_once[l].sums.slots.size(); ++slot) {
      const Image<Light>& a = at_once[l].sums.slots[slot];
      const Image<Light>& b = by_twos[l].sums.slots[slot];
      for (std::size_t i = 0; i < a.size(); ++i) {
        const Light &one = a.data()[i], &other = b.data()[i];
        ASSERT_EQ(std::pair(one.r, one.g), std::pair(other.r, other.g)) << l << " " << slot;
        ASSERT_EQ(std::pair(one.b, one.coverage), std::pair(other.b, other.coverage));
        const Eigen::Vector4d sum =
            Eigen::Vector4f(one.r, one.g, one.b, one.coverage).cast<double>();
        ASSERT_LT((sum - plain[l][slot].data()[i]).norm(), 1e-5) << l << " " << slot << " " << i;
        most = std::max(most, sum(3));
      }
    }
    EXPECT_GT(most, 0.4) << l;  // samples' coverage is 0.5 in the mean
  }
}

Display Small(Display display) {
  display.width_px = 48;
  display.height_px = 36;
  return display;
}

// The last pair of layers is one layer, and every row is a family.
Display ThreeSlantedSheets() {
  Display display = FindDisplay("paper-two-layer");
  display.name = "three-slanted";
  for (Layer& layer : display.layers) layer.optics = Lenticular{7.5, 0.17, 9, 0.3};
  Layer middle = display.layers[0];
  middle.position_mm = 0;
  display.layers.insert(display.layers.begin() + 1, middle);
  return display;
}

INSTANTIATE_TEST_SUITE_P(Displays, NodesAtOnce,
                         testing::Values(Small(FindDisplay("paper-one-layer")),
                                         Small(FindDisplay("paper-two-layer")),
                                         Small(FindDisplay("paper-varifocal")),
                                         Small(ThreeSlantedSheets())),
                         [](const auto& display) {
                           std::string name = display.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace lamella
