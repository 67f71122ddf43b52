// A few points of the experiments that hold, by the tolerances of the full ones.
#include <string>
#include <vector>

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

// Without experiment 7, whose claim fails as it is worded (docs/experiments.md).
std::vector<NamedExperiment> ThatHold() {
  std::vector<NamedExperiment> holding;
  for (const NamedExperiment& experiment : AllExperiments()) {
    if (std::string(experiment.id) != "7") holding.push_back(experiment);
  }
  return holding;
}

INSTANTIATE_TEST_SUITE_P(Experiments, Claims, ::testing::ValuesIn(ThatHold()),
                         [](const auto& test) {
                           return "Experiment_" + std::string(test.param.id);
                         });

}  // namespace
}  // namespace lamella::experiments
