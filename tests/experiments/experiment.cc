#include "tests/experiments/experiment.h"

#include <cmath>
#include <utility>

namespace lamella::experiments {

bool Row::Holds() const {
  switch (relation) {
    case Relation::kNear:
      return std::abs(measured - expected) <= tolerance * std::abs(expected);
    case Relation::kAtLeast:
      return measured >= expected;
    case Relation::kAtMost:
      return measured <= expected;
    case Relation::kReported:
      return true;
  }
  return false;
}

Row Near(std::string what, double measured, double expected, double tolerance) {
  return {std::move(what), measured, Relation::kNear, expected, tolerance};
}
Row AtLeast(std::string what, double measured, double expected) {
  return {std::move(what), measured, Relation::kAtLeast, expected, 0};
}
Row AtMost(std::string what, double measured, double expected) {
  return {std::move(what), measured, Relation::kAtMost, expected, 0};
}
Row Reported(std::string what, double measured) {
  return {std::move(what), measured, Relation::kReported, 0, 0};
}

const std::vector<NamedExperiment>& AllExperiments() {
  static const std::vector<NamedExperiment> all = {
      {"mtf", MtfRows},       {"1", DepthOfField},    {"2", HalfTheRays},
      {"3", RayCounts},       {"4", OutsideTheRange}, {"5", EqualBandwidth},
      {"6", Aliasing},        {"7", FuzzyBorders},    {"8", Shadows},
      {"9", HaloWidth},       {"10", HaloStrength},   {"11", ShearedRays},
      {"12", Accommodation},  {"14", SeenBrightness}, {"15", EnergyPartition},
      {"16", SlotsAndDetail}, {"17", ViewRepeats},    {"trade", SpeedForAccuracy}};
  return all;
}

}  // namespace lamella::experiments
