#include "distribute/assign.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

// The paper's rule read literally: the mean, over [z - w/2, z + w/2], of "layer l is the nearest".
double WeightBySampling(const std::vector<double>& layers, double w, int layer, double z) {
  constexpr int kSamples = 20000;
  int hits = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double at = z + w * ((i + 0.5) / kSamples - 0.5);
    int nearest = 0;
    for (int l = 1; l < static_cast<int>(layers.size()); ++l) {
      const auto distance = [&](int k) {
        return std::abs(at - layers[static_cast<std::size_t>(k)]);
      };
      if (distance(l) <= distance(nearest)) nearest = l;
    }
    hits += nearest == layer ? 1 : 0;
  }
  return static_cast<double>(hits) / kSamples;
}

TEST(LayerWeights, AreTheMeanOfTheNearestLayerOverTheBorder) {
  const std::vector<double> layers = {-9, -3, 5, 9};
  for (const double w : {0.0, 0.5, 2.0, 4.0}) {
    const LayerWeights weights(layers, w);
    for (double z = -20; z < 20; z += 0.37) {
      for (int l = 0; l < 4; ++l) {
        EXPECT_NEAR(static_cast<double>(weights.Weight(l, static_cast<float>(z))),
                    WeightBySampling(layers, w, l, z), 2e-4)
            << z << " " << w;
      }
    }
  }
}

TEST(LayerWeights, ArePartitionsOfUnityEverywhere) {
  std::vector<double> layers(64);
  for (std::size_t i = 0; i < 64; ++i) layers[i] = 1000 + 1e-6 * static_cast<double>(i);
  for (const double w : {0.0, 9e-7}) {
    const LayerWeights weights(layers, w);
    for (const float z : {-INFINITY, -1e30F, 0.0F, 1000.0F, 1000.00003F, 1e30F, INFINITY}) {
      float sum = 0;
      for (int l = 0; l < 64; ++l) {
        EXPECT_GE(weights.Weight(l, z), 0);
        sum += weights.Weight(l, z);
      }
      EXPECT_FLOAT_EQ(sum, 1);
    }
  }
}

TEST(LayerWeights, ReachToInfinity) {
  const LayerWeights weights(std::vector<double>{-10, 10}, 4);
  EXPECT_EQ(weights.Weight(0, -INFINITY), 1);
  EXPECT_EQ(weights.Weight(1, -INFINITY), 0);
  EXPECT_EQ(weights.Weight(1, INFINITY), 1);
  EXPECT_EQ(LayerWeights(std::vector<double>{0}, 0).Weight(0, 123.0F), 1);
}

TEST(LayerWeights, RefuseABorderWiderThanTheSpacing) {
  EXPECT_THROW(LayerWeights(std::vector<double>{0, 1}, 1.1), Error);
  EXPECT_THROW(LayerWeights(std::vector<double>{0, 1}, -0.1), Error);
  EXPECT_THROW(LayerWeights(std::vector<double>{0, 1}, std::nan("")), Error);
}

}  // namespace
}  // namespace lamella
