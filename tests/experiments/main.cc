// lamella_experiments [ID...]: runs the experiments (all by default) and writes what they measured
// to standard output as JSON; scripts/experiments.sh makes docs/experiments.md of it.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/error.h"
#include "tests/experiments/experiment.h"

namespace lamella::experiments {
namespace {

using Json = nlohmann::ordered_json;

const char* NameOf(Stroke stroke) {
  switch (stroke) {
    case Stroke::kMeasured:
      return "measured";
    case Stroke::kSecond:
      return "second";
    case Stroke::kClosedForm:
      return "closed form";
  }
  return "";
}

const char* NameOf(Relation relation) {
  switch (relation) {
    case Relation::kNear:
      return "near";
    case Relation::kAtLeast:
      return "at least";
    case Relation::kAtMost:
      return "at most";
    case Relation::kReported:
      return "reported";
  }
  return "";
}

Json ToJson(const Experiment& experiment) {
  Json json;
  json["id"] = experiment.id;
  json["claim"] = experiment.claim;
  json["set_up"] = experiment.set_up;
  json["reason"] = experiment.reason;
  json["rows"] = Json::array();
  for (const Row& row : experiment.rows) {
    json["rows"].push_back({{"what", row.what},
                            {"measured", row.measured},
                            {"relation", NameOf(row.relation)},
                            {"expected", row.expected},
                            {"tolerance", row.tolerance},
                            {"holds", row.Holds()}});
  }
  json["figures"] = Json::array();
  for (const Figure& figure : experiment.figures) {
    Json curves = Json::array();
    for (const Curve& curve : figure.curves) {
      curves.push_back({{"name", curve.name},
                        {"x", curve.x},
                        {"y", curve.y},
                        {"stroke", NameOf(curve.stroke)},
                        {"color_of", curve.color_of}});
    }
    json["figures"].push_back({{"title", figure.title},
                               {"x_label", figure.x_label},
                               {"y_label", figure.y_label},
                               {"log_x", figure.log_x},
                               {"curves", std::move(curves)}});
  }
  json["tables"] = Json::array();
  for (const Table& table : experiment.tables) {
    json["tables"].push_back({{"title", table.title},
                              {"columns", table.columns},
                              {"rows", table.rows},
                              {"names", table.names}});
  }
  return json;
}

bool Wanted(const char* id, int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], id) == 0) return true;
  }
  return argc == 1;
}

void CheckKnown(const std::string& id) {
  std::string known;
  for (const NamedExperiment& experiment : AllExperiments()) {
    if (id == experiment.id) return;
    known += std::string(known.empty() ? "" : ", ") + experiment.id;
  }
  throw UsageError(id, "no such experiment", "take one of " + known);
}

int Main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) CheckKnown(argv[i]);
  Json all = Json::array();
  for (const NamedExperiment& experiment : AllExperiments()) {
    if (!Wanted(experiment.id, argc, argv)) continue;
    const auto start = std::chrono::steady_clock::now();
    all.push_back(ToJson(experiment.run(Effort::kFull)));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    fmt::print(stderr, "experiment {}: {:.1f} s\n", experiment.id, took.count());
  }
  fmt::print("{}\n", all.dump(1));
  return 0;
}

}  // namespace
}  // namespace lamella::experiments

int main(int argc, char** argv) {
  try {
    return lamella::experiments::Main(argc, argv);
  } catch (const lamella::Error& error) {
    std::fprintf(stderr, "lamella_experiments: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lamella_experiments: %s\n", error.what());
    return 1;
  }
}
