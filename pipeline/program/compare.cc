// lamella compare: images, poses or depth against other ones or against truth.
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/capture/known_cameras.h"
#include "pipeline/compare_poses.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

struct Pair {
  std::string a, b;
};

ExitCode ComparePosesOf(const Pair& pair) {
  const PoseComparison result = ComparePoses(ReadKnownCameras(pair.a), ReadKnownCameras(pair.b));
  fmt::print("{:<24} {:>12} {:>14}\n", "view", "centre", "rotation deg");
  for (const PoseError& view : result.views) {
    fmt::print("{:<24} {:>12.6g} {:>14.4f}\n", view.name, view.centre, view.rotation_deg);
  }
  for (const std::string& name : result.only_estimate) fmt::print("only in {}: {}\n", pair.a, name);
  for (const std::string& name : result.only_truth) fmt::print("only in {}: {}\n", pair.b, name);
  fmt::print(
      "views {}  scale {:.6g}  centre_rmse {:.6g}  centre_mean {:.6g}  centre_max {:.6g}  "
      "rotation_mean_deg {:.4f}\n",
      result.views.size(), result.truth_from_estimate.scale, result.rmse, result.mean, result.max,
      result.mean_rotation_deg);
  return ExitCode::kDone;
}

}  // namespace

void AddCompare(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "compare", "images, poses or depth, against other ones or against truth");
  app.require_subcommand(1);
  AddCompareImages(app, invocation);
  auto pair = std::make_shared<Pair>();
  CLI::App& poses = *app.add_subcommand(
      "poses", "cameras by name, after the best similarity of the world; errors are in units of B");
  poses.add_option("A", pair->a, "transforms.json, a folder of .camera files or a grid's folder")
      ->required();
  poses.add_option("B", pair->b, "the truth, likewise")->required();
  AddGlobalOptions(poses, invocation);
  poses.callback([pair, &invocation] {
    invocation.action = [pair](Progress&) { return ComparePosesOf(*pair); };
  });
}

}  // namespace lamella
