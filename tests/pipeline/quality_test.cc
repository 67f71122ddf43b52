// The presets of --quality.
#include <gtest/gtest.h>

#include "pipeline/pipeline.h"

namespace lamella {
namespace {

TEST(Quality, BalancedIsWhatTheDefaultsAre) {
  PipelineOptions defaults, balanced;
  ApplyQuality(Quality::kBalanced, balanced);
  EXPECT_EQ(ToToml(Describe(defaults)), ToToml(Describe(balanced)));
}

}  // namespace
}  // namespace lamella
