// A few points of every experiment, by the tolerances of the full ones.
#include <string>

#include <gtest/gtest.h>

#include "tests/experiments/experiment.h"

namespace lamella::experiments {
namespace {

class Claims : public ::testing::TestWithParam<NamedExperiment> {};

TEST_P(Claims, Hold) {
  const Experiment experiment = GetParam().run(Effort::kQuick);
  EXPECT_EQ(experiment.id, GetParam().id);
  EXPECT_FALSE(experiment.rows.empty());
  for (const Row& row : experiment.rows) {
    EXPECT_TRUE(row.Holds()) << row.what << ": measured " << row.measured << ", expected "
                             << row.expected;
  }
}

INSTANTIATE_TEST_SUITE_P(Experiments, Claims, ::testing::ValuesIn(AllExperiments()),
                         [](const auto& test) {
                           return "Experiment_" + std::string(test.param.id);
                         });

}  // namespace
}  // namespace lamella::experiments
