// Cards before a wall, seen by a square grid of cameras: their recipe, and the stages on a capture
// of it with exact depth.
#pragma once

#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "datasets_synthetic/recipe.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/progress.h"
#include "pipeline/pipeline.h"
#include "pipeline/synth_scene.h"
#include "pipeline/workspace.h"

namespace lamella {

struct CardScene {
  int views = 0, width_px = 0, height_px = 0;
  double wall_height = 0, card_width = 0;
};

// FOLDER/cards.toml.
inline std::filesystem::path WriteCards(const CardScene& scene,
                                        const std::filesystem::path& folder) {
  constexpr const char* kRecipe = R"(
[cameras]
layout = "grid"
views = {}
spacing = 0.15
width_px = {}
height_px = {}
target = [0, 0, -0.5]
height = 0
[lighting]
ambient = 0.9
lamp_strength = 0
[photographs]
format = "png"
[[surface]]
shape = "rectangle"
centre = [0, 0, -2.2]
u = [11, 0, 0]
v = [0, {}, 0.4]
texture = {{ pattern = "noise", scale = 0.9 }}
[[surface]]
shape = "rectangle"
centre = [-0.2, 0, 0.4]
u = [{}, 0, 0.1]
v = [-0.05, 0.8, 0]
texture = {{ pattern = "noise", scale = 0.5, octaves = 5, light = [0.9, 0.4, 0.2] }}
)";
  std::filesystem::path file = folder / "cards.toml";
  WriteTextAtomically(file, fmt::format(kRecipe, scene.views, scene.width_px, scene.height_px,
                                        scene.wall_height, scene.card_width));
  return file;
}

// Makes the capture, and from it the workspace, in capture/ and W/ beside the recipe.
inline Workspace RunWithExactDepth(const std::filesystem::path& recipe, const std::string& last,
                                   PipelineOptions options = {}) {
  const std::filesystem::path folder = recipe.parent_path();
  SynthScene(ReadRecipe(recipe), folder / "capture", SilentProgress());
  options.capture.input = (folder / "capture").string();
  options.depth.source = "given";
  Workspace workspace(folder / "W");
  EXPECT_EQ(RunPipeline(workspace, options, "capture", last, SilentProgress()), ExitCode::kDone);
  return workspace;
}

}  // namespace lamella
