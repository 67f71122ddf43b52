// The stage frames from layers that the test writes: every panel pixel is looked up again.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/layers_record.h"
#include "pipeline/stages.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

constexpr int kWidth = 24, kHeight = 12;

// Every emitter's colour tells where it is; one is unknown.
EmitterImage Emitters(int layer, int slot, int columns, int rows) {
  EmitterImage image{Image<Rgb>(columns, rows), Image<float>(columns, rows, 1.0F)};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      image.color(x, y) = {Srgb8ToLinear(static_cast<std::uint8_t>(40 + 4 * x)),
                           Srgb8ToLinear(static_cast<std::uint8_t>(40 + 4 * y)),
                           Srgb8ToLinear(static_cast<std::uint8_t>(100 * layer + 10 * slot))};
    }
  }
  image.color(1, 1) = {};
  image.coverage(1, 1) = 0;
  return image;
}

Workspace WithLayers(const std::string& name) {
  Workspace workspace(ScratchFolder());
  LayersRecord record;
  record.display = FindDisplay(name);
  record.display.width_px = kWidth;
  record.display.height_px = kHeight;
  View view;
  view.camera = {CameraModel::kPinhole, 64, 48, 50, 50, 32, 24, {}};
  record.placement = Place(view, 1, 2, record.display, {}, nullptr);
  const auto folder = workspace.Stage("layers");
  CreateFolder(folder);
  SaveLayersRecord(folder, record);
  for (int layer = 0; layer < static_cast<int>(record.display.layers.size()); ++layer) {
    for (int slot = 0; slot < 9; ++slot) {
      SaveEmitterImage(
          folder, layer, slot,
          Emitters(layer, slot, record.display.emitter_columns(), record.display.emitter_rows()));
    }
  }
  return workspace;
}

void MakeFrames(const Workspace& workspace, const FramesOptions& options = {}) {
  StageRun run(workspace, "frames", "in", "options");
  run.Commit(RunFrames(workspace, options, run, SilentProgress()), 0, 0);
}

TEST(StageFrames, PutsEveryEmitterOnItsPanelPixels) {
  const Workspace workspace = WithLayers("paper-two-layer-half");
  MakeFrames(workspace);
  const Image<Rgb8> back = ReadSrgb8(workspace.Stage("frames") / "layer_0_slot_7_emitter.png");
  const Image<Rgb8> front = ReadSrgb8(workspace.Stage("frames") / "layer_1_slot_7_emitter.png");
  ASSERT_EQ(back.width(), kWidth);
  ASSERT_EQ(back.height(), kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool unknown = x / 2 == 1 && y / 2 == 1;
      const Rgb8 expected{static_cast<std::uint8_t>(40 + 4 * (x / 2)),
                          static_cast<std::uint8_t>(40 + 4 * (y / 2)), 170};
      EXPECT_EQ(front(x, y), unknown ? Rgb8() : expected) << x << " " << y;
      Rgb8 mirrored = expected;
      mirrored.b = 70;
      EXPECT_EQ(back(kWidth - 1 - x, y), unknown ? Rgb8() : mirrored) << x << " " << y;
    }
  }
  const Image<Rgb8> open = ReadSrgb8(workspace.Stage("frames") / "layer_1_slot_7_modulator.png");
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool is_open = x / 2 % 3 == 1 && y / 2 % 3 == 2;  // slot 7: x 1, y 2
      EXPECT_EQ(open(x, y).g, is_open ? 255 : 0);
    }
  }
}

TEST(StageFrames, DescribesEveryFrame) {
  const Workspace workspace = WithLayers("paper-two-layer");
  FramesOptions options;
  options.response = "gamma";
  options.gamma = 2.4;
  MakeFrames(workspace, options);
  const auto folder = workspace.Stage("frames");
  const auto json = nlohmann::json::parse(ReadText(folder / "frames.json"));
  EXPECT_EQ(json.at("format_version"), 1);
  EXPECT_EQ(json.at("panel").at("width_px"), kWidth);
  EXPECT_EQ(json.at("bit_depth"), 8);
  EXPECT_EQ(json.at("response").at("gamma"), 2.4);
  ASSERT_EQ(json.at("layers").size(), 2U);
  int frames = 0;
  for (const auto& layer : json.at("layers")) {
    EXPECT_THAT(layer.at("order").get<std::vector<int>>(),
                ::testing::ElementsAre(0, 4, 8, 3, 7, 2, 6, 1, 5));
    for (const auto& frame : layer.at("frames")) {
      ++frames;
      EXPECT_TRUE(std::filesystem::exists(folder / frame.at("file").get<std::string>()));
      EXPECT_EQ(frame.at("slot"),
                3 * frame.at("slot_y").get<int>() + frame.at("slot_x").get<int>());
    }
  }
  EXPECT_EQ(frames, 36);
}

TEST(StageFrames, WritesTheSameBytesWithAnyNumberOfThreads) {
  const Workspace workspace = WithLayers("paper-two-layer");
  std::string hashes[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    MakeFrames(workspace);
    hashes[threads - 1] = LoadStageRecord(workspace, "frames")->OutputsHash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace lamella
