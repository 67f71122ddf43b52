// The stage frames from layers that the test writes: every panel pixel is looked up again.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/parallel.h"
#include "pipeline/layers_record.h"
#include "pipeline/panel_images.h"
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

Workspace WithRandomLayers(Display display) {
  Workspace workspace(ScratchFolder());
  LayersRecord record;
  record.display = std::move(display);
  View view;
  view.camera = {CameraModel::kPinhole, 64, 48, 50, 50, 32, 24, {}};
  record.placement = Place(view, 1, 2, record.display, {}, nullptr);
  const auto folder = workspace.Stage("layers");
  CreateFolder(folder);
  SaveLayersRecord(folder, record);
  for (int layer = 0; layer < static_cast<int>(record.display.layers.size()); ++layer) {
    const int k = SlotsPerAxis(record.display.layers[static_cast<std::size_t>(layer)]);
    for (int slot = 0; slot < k * k; ++slot) {
      SaveEmitterImage(
          folder, layer, slot,
          Emitters(layer, slot, record.display.emitter_columns(), record.display.emitter_rows()));
    }
  }
  return workspace;
}

Workspace WithRandomLayers(const std::string& name) {
  Display display = FindDisplay(name);
  display.width_px = kWidth;
  display.height_px = kHeight;
  return WithRandomLayers(std::move(display));
}

void MakeBarrierFrames(const Workspace& workspace, const FramesOptions& options = {}) {
  StageRun run(workspace, "frames", "in", "options");
  run.Commit(RunFrames(workspace, options, run, SilentProgress()), 0, 0);
}

TEST(StageFrames, PutsEveryEmitterOnItsPanelPixels) {
  const Workspace workspace = WithRandomLayers("paper-two-layer-half");
  MakeBarrierFrames(workspace);
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
  const Workspace workspace = WithRandomLayers("paper-two-layer");
  FramesOptions options;
  options.response = "gamma";
  options.gamma = 2.4;
  MakeBarrierFrames(workspace, options);
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
  const Workspace workspace = WithRandomLayers("paper-two-layer");
  std::string hashes[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    MakeBarrierFrames(workspace);
    hashes[threads - 1] = LoadStageRecord(workspace, "frames")->OutputsHash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(StageFrames, NamesADamagedSlotAndLeavesNoneOfItsFiles) {
  const Workspace workspace = WithRandomLayers("paper-two-layer");
  const auto damaged = workspace.Stage("layers") / EmitterFile(1, 4);
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  try {
    MakeBarrierFrames(workspace);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("layer_1_slot_4.exr"));
  }
  EXPECT_FALSE(std::filesystem::exists(workspace.Stage("frames") / "frames.json"));
  for (const auto& entry : std::filesystem::directory_iterator(workspace.Stage("frames"))) {
    EXPECT_THAT(entry.path().filename().string(),
                ::testing::Not(::testing::AnyOf(::testing::HasSubstr("layer_1_slot_4"),
                                                ::testing::HasSubstr("partial"))));
  }
}

Display SmallVarifocal(bool mirror_x) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 130;
  display.height_px = 92;
  display.varifocal->planes = 5;
  display.layers[0].mirror_x = mirror_x;
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
  return display;
}

TEST(StageFrames, PacksAVarifocalDisplaysPlanesSoThatTheirMeanIsTheirGrey) {
  for (const bool mirror_x : {false, true}) {
    const Workspace workspace = WithRandomLayers(SmallVarifocal(mirror_x));
    FramesOptions options;
    options.strokes = 8;
    options.channels = "GBR";
    options.bits = "msb-first";
    MakeBarrierFrames(workspace, options);
    const LayersRecord record = LoadLayersRecord(workspace);
    const LayerImages layers = LoadLayerImages(workspace, record);
    const PanelImages panels = OpenPanelImages(workspace, record);
    EXPECT_TRUE(panels.grey);
    const LayerImages decoded = ReadWhole(panels.open, record.display);
    for (int plane = 0; plane < 5; ++plane) {
      const LensletMap map(record.display, plane);
      const EmitterImage& asked = layers.slots[static_cast<std::size_t>(plane)][0];
      const EmitterImage& shown = decoded.slots[static_cast<std::size_t>(plane)][0];
      for (int y = 0; y < 92; ++y) {
        for (int x = 0; x < 130; ++x) {
          const float grey = map.Pixel(x, y) ? std::min(1.0F, Luminance(asked.color(x, y))) : 0.0F;
          // Sums over planes are right to a stroke; each plane's on its own to two.
          ASSERT_NEAR(shown.color(x, y).g, grey, 2.0F / 8) << plane << " " << x << " " << y;
          if (grey == 0) {
            ASSERT_EQ(shown.color(x, y), Rgb());
          }
        }
      }
    }
    const auto json = nlohmann::json::parse(ReadText(workspace.Stage("frames") / "frames.json"));
    EXPECT_EQ(json.at("strokes").size(), 8U);
    EXPECT_EQ(json.at("strokes")[0].at("planes"), (std::vector<int>{0, 1, 2, 3, 4}));
    EXPECT_EQ(json.at("strokes")[1].at("planes"), (std::vector<int>{4, 3, 2, 1, 0}));
    EXPECT_EQ(json.at("packing").at("channels"), "GBR");
    EXPECT_EQ(json.at("bit_depth"), 1);
    EXPECT_EQ(json.at("mirror_x"), mirror_x);
  }
}

TEST(StageFrames, ShowsAVarifocalDisplaysPlanesInGreyWhereAsked) {
  const Workspace workspace = WithRandomLayers(SmallVarifocal(false));
  FramesOptions options;
  options.planes = "grey";
  MakeBarrierFrames(workspace, options);
  EXPECT_FALSE(std::filesystem::exists(workspace.Stage("frames") / "layer_0_slot_0_modulator.png"));
  const LayersRecord record = LoadLayersRecord(workspace);
  const LayerImages layers = LoadLayerImages(workspace, record);
  const PanelImages panels = OpenPanelImages(workspace, record);
  EXPECT_FALSE(panels.grey);
  const LayerImages decoded = ReadWhole(panels.open, record.display);
  EXPECT_NEAR(decoded.slots[3][0].color(20, 10).g, layers.slots[3][0].color(20, 10).g, 0.005F);
}

TEST(StageFrames, RefusesAnOddNumberOfStrokesThereAndBack) {
  const Workspace workspace = WithRandomLayers(SmallVarifocal(false));
  FramesOptions options;
  options.strokes = 7;
  EXPECT_THROW(MakeBarrierFrames(workspace, options), Error);
  options.there_and_back = false;
  MakeBarrierFrames(workspace, options);
}

}  // namespace
}  // namespace lamella
