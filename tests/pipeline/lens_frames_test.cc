// Frames of displays with lenses there and back: layers that the test writes, the stage, and what
// the panels' images say of the light again.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/displays.h"
#include "distribute/encode_varifocal.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/lenslet_map.h"
#include "pipeline/emitter_files.h"
#include "pipeline/layers_record.h"
#include "pipeline/panel_images.h"
#include "pipeline/shown_frames.h"
#include "pipeline/stages.h"
#include "pipeline/varifocal_frames.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

Display SmallVarifocal() {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 240;
  display.height_px = 180;
  // Lenses small enough that numerals fit.
  const LensletArray lenses{LensletArray::Lattice::kHexagonal, 4, 3};
  for (Layer& layer : display.layers) layer.optics = lenses;
  return display;
}

// Two square sheets, the back one seen in a mirror, over emitters of 2 x 2 pixels.
Display Lenslets() {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 64;
  display.height_px = 48;
  display.binning_px = 2;
  for (Layer& layer : display.layers) {
    layer.optics = LensletArray{LensletArray::Lattice::kSquare, 5, 4};
  }
  return display;
}

Display LenticularSheet() {
  Display display = FindDisplay("paper-one-layer");
  display.width_px = 40;
  display.height_px = 30;
  display.layers[0].optics = Lenticular{};
  display.layers[0].mirror_x = true;
  return display;
}

bool Lit(const Display& display, int layer, int x, int y) {
  return !std::holds_alternative<LensletArray>(
             display.layers[static_cast<std::size_t>(layer)].optics) ||
         LensletMap(display, layer).Pixel(x, y).has_value();
}

// Light that tells layer, place and channel apart; unknown at (1, 1), and more than white at one
// place.
EmitterImage Light(const Display& display, int layer) {
  const int columns = display.emitter_columns(), rows = display.emitter_rows();
  EmitterImage image{Image<Rgb>(columns, rows), Image<float>(columns, rows, 1.0F)};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const auto wave = [&](double f) {
        return static_cast<float>(0.5 + 0.5 * std::sin(f * (x + 0.7 * y) + layer));
      };
      image.color(x, y) = {wave(0.1), wave(0.23), wave(0.37)};
    }
  }
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (Lit(display, layer, x, y)) continue;
      image.color(x, y) = {};
      image.coverage(x, y) = 0;
    }
  }
  image.color(1, 1) = {};
  image.coverage(1, 1) = 0;
  image.color(columns / 2, rows / 2) = {2, 0.5F, 0};
  return image;
}

Workspace WithLayers(const Display& display) {
  Workspace workspace(ScratchFolder());
  LayersRecord record;
  record.display = display;
  record.seen_share = 0.5;
  View view;
  view.camera = {CameraModel::kPinhole, 64, 48, 50, 50, 32, 24, {}};
  record.placement = Place(view, 1, 2, display, {}, nullptr);
  CreateFolder(workspace.Stage("layers"));
  SaveLayersRecord(workspace.Stage("layers"), record);
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    SaveEmitterImage(workspace.Stage("layers"), layer, 0, Light(display, layer));
  }
  return workspace;
}

StageReport MakeFrames(const Workspace& workspace, const FramesOptions& options = {}) {
  StageRun run(workspace, "frames", "in", "options");
  StageReport report = RunFrames(workspace, options, run, SilentProgress());
  run.Commit(report, 0, 0);
  return report;
}

std::string Refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("\n")));
    return error.what();
  }
  return "accepted";
}

// By the sRGB code nearest to it.
double CodeOf(float light) {
  return 255 * static_cast<double>(LinearToSrgb(std::clamp(light, 0.0F, 1.0F)));
}

void ExpectTheLayersLight(const Workspace& workspace, const Display& display) {
  const LayersRecord record = LoadLayersRecord(workspace);
  const LayerImages layers = LoadLayerImages(workspace, record);
  const LayerImages shown = ReadWhole(OpenPanelImages(workspace, record).open, record.display);
  ASSERT_EQ(shown.slots.size(), display.layers.size());
  for (std::size_t l = 0; l < shown.slots.size(); ++l) {
    ASSERT_EQ(shown.slots[l].size(), 1U);
    const EmitterImage &image = shown.slots[l][0], &truth = layers.slots[l][0];
    for (int y = 0; y < image.color.height(); ++y) {
      for (int x = 0; x < image.color.width(); ++x) {
        EXPECT_EQ(image.coverage(x, y), truth.coverage(x, y));
        const bool lit = Lit(display, static_cast<int>(l), x, y) && truth.coverage(x, y) > 0;
        for (const auto channel : {&Rgb::r, &Rgb::g, &Rgb::b}) {
          const double expected = lit ? CodeOf(truth.color(x, y).*channel) : 0;
          EXPECT_NEAR(CodeOf(image.color(x, y).*channel), expected, lit ? 0.501 : 0)
              << l << " " << x << " " << y;
        }
      }
    }
  }
}

TEST(LensFrames, GiveTheLightOfTheLayersBackWithinHalfACode) {
  const Display display = Lenslets();
  const Workspace workspace = WithLayers(display);
  MakeFrames(workspace);
  ExpectTheLayersLight(workspace, display);
  const auto folder = workspace.Stage("frames");
  EXPECT_TRUE(std::filesystem::exists(folder / "layer_0_slot_0_emitter.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "layer_0_slot_0_modulator.png"));
  const auto json = nlohmann::json::parse(ReadText(folder / "frames.json"));
  EXPECT_EQ(json.at("layers").at(0).at("mirror_x"), true);
  EXPECT_EQ(json.at("layers").at(1).at("frames").size(), 1U);
  EXPECT_EQ(json.at("layers").at(1).at("frames").at(0).at("role"), "emitter");
}

TEST(LensFrames, KeepTheStripesOfALenticularInTheirPixel) {
  const Display display = LenticularSheet();
  const Workspace workspace = WithLayers(display);
  MakeFrames(workspace);
  ExpectTheLayersLight(workspace, display);
  // The panel is seen in a mirror: emitter column 3 is pixel column 36, red stays red.
  const Image<Rgb8> frame = ReadSrgb8(workspace.Stage("frames") / "layer_0_slot_0_emitter.png");
  const Rgb light = Light(display, 0).color(3, 7);
  EXPECT_NEAR(frame(36, 7).r, CodeOf(light.r), 0.6);
  EXPECT_NEAR(frame(36, 7).g, CodeOf(light.g), 0.6);
  EXPECT_NEAR(frame(36, 7).b, CodeOf(light.b), 0.6);
}

TEST(LensFrames, AreAVarifocalDisplaysGreyPlanesWhereAsked) {
  Display display = SmallVarifocal();
  for (Layer& layer : display.layers) layer.mirror_x = true;
  const Workspace workspace = WithLayers(display);
  FramesOptions options;
  options.planes = "grey";
  MakeFrames(workspace, options);
  ExpectTheLayersLight(workspace, display);
  const Shot shot = ShotOfFrames(workspace.Stage("frames"));
  ASSERT_EQ(shot.layers.size(), 24U);
  EXPECT_THAT(shot.layers[5].modulator, ::testing::ElementsAre("white"));
}

TEST(LensFrames, AreShownByTheVirtualPrototype) {
  for (const Display& display : {Lenslets(), LenticularSheet()}) {
    const Workspace workspace = WithLayers(display);
    MakeFrames(workspace);
    const std::vector<ShownLayer> shown =
        ShotLoader(DesignCalibration(display)).Load(ShotOfFrames(workspace.Stage("frames")));
    ASSERT_EQ(shown.size(), display.layers.size());
    EXPECT_EQ(shown[0].emitter.size(), 1U);
    EXPECT_TRUE(shown[0].modulator.empty());
  }
}

class OneBitFrames : public ::testing::TestWithParam<const char*> {};

TEST_P(OneBitFrames, AddUpToTheLightOfThePlanes) {
  for (const bool mirror : {false, true}) {
    Display display = SmallVarifocal();
    for (Layer& layer : display.layers) layer.mirror_x = mirror;
    const Workspace workspace = WithLayers(display);
    FramesOptions options;
    options.one_bit_method = GetParam();
    options.strokes = 8;
    options.channels = "GRB";
    options.bits = "msb-first";
    EXPECT_TRUE(MakeFrames(workspace, options).warnings.empty());
    const LayersRecord record = LoadLayersRecord(workspace);
    const LayerImages layers = LoadLayerImages(workspace, record);
    const LayerImages shown = ReadWhole(OpenPanelImages(workspace, record).open, record.display);
    ASSERT_EQ(shown.slots.size(), 24U);
    // Diffusion is right over neighbouring lenses of one direction, an emitter alone to a stroke
    // and what its neighbours gave it.
    const double tolerance = std::string(GetParam()) == "diffusion" ? 2.0 / 8 : 1.0 / 8;
    for (int plane = 0; plane < 24; ++plane) {
      const EmitterImage& image = shown.slots[static_cast<std::size_t>(plane)][0];
      const Image<float> grey = GreyOf(layers.slots[static_cast<std::size_t>(plane)][0]);
      for (int y = 0; y < 180; ++y) {
        for (int x = 0; x < 240; ++x) {
          const double light = Lit(display, plane, x, y) ? static_cast<double>(grey(x, y)) : 0;
          const double mean = static_cast<double>(image.color(x, y).g);
          EXPECT_NEAR(mean, light, light > 0 ? tolerance + 1e-6 : 0)
              << plane << " " << x << " " << y;
          EXPECT_EQ(image.color(x, y).r, image.color(x, y).b);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, OneBitFrames,
                         ::testing::Values("sigma-delta", "ordered", "diffusion"));

TEST(PackedStrokes, UnpackToTheBitsThatWerePacked) {
  const Display display = SmallVarifocal();
  const Workspace workspace = WithLayers(display);
  MakeFrames(workspace);
  const auto folder = workspace.Stage("frames");
  const BitPlanes bits =
      OneBitPlanes(ReadGrey(OpenEmitterFiles(workspace, display), display), display, {});
  const auto json = nlohmann::json::parse(ReadText(folder / "frames.json"));
  ASSERT_EQ(json.at("strokes").size(), 16U);
  for (int t = 0; t < 16; ++t) {
    const std::string file = json.at("strokes").at(static_cast<std::size_t>(t)).at("file");
    const Image<std::uint32_t> unpacked =
        EmitterBits(UnpackedFrame(ReadSrgb8(folder / file).span(), 24, t, {}), display);
    const Image<std::uint32_t>& packed = bits.strokes[static_cast<std::size_t>(t)];
    EXPECT_TRUE(std::equal(packed.data(), packed.data() + packed.size(), unpacked.data())) << t;
  }
  const Image<std::uint32_t> numerals = PanelBits(NumeralPlanes(display), display);
  ASSERT_EQ(json.at("numerals").size(), 2U);
  for (int t = 0; t < 2; ++t) {
    const std::string file = json.at("numerals").at(static_cast<std::size_t>(t));
    const Image<std::uint32_t> read = UnpackedFrame(ReadSrgb8(folder / file).span(), 24, t, {});
    EXPECT_TRUE(std::equal(read.data(), read.data() + read.size(), numerals.data()));
  }
}

TEST(PackedStrokes, TellADriverWhatComesWhen) {
  const Workspace workspace = WithLayers(SmallVarifocal());
  MakeFrames(workspace);
  const auto json = nlohmann::json::parse(ReadText(workspace.Stage("frames") / "frames.json"));
  EXPECT_EQ(json.at("bit_depth"), 1);
  EXPECT_EQ(json.at("packing").at("channels"), "BRG");
  EXPECT_EQ(json.at("packing").at("bits"), "lsb-first");
  EXPECT_EQ(json.at("packing").at("there_and_back"), true);
  EXPECT_FALSE(json.contains("response"));  // codes are bits
  for (std::size_t t = 0; t < 16; ++t) {
    const auto& stroke = json.at("strokes").at(t);
    for (std::size_t i = 0; i < 24; ++i) {
      EXPECT_EQ(stroke.at("planes").at(i), t % 2 == 0 ? i : 23 - i);
      // Evenly spaced planes under an even sweep: the middles of 24 equal times.
      EXPECT_NEAR(stroke.at("phases").at(i).get<double>(), (static_cast<double>(i) + 0.5) / 24,
                  1e-12);
    }
  }
}

TEST(PackedStrokes, GoOneWayWhereTheMirrorFliesBackUnseen) {
  const Workspace workspace = WithLayers(SmallVarifocal());
  FramesOptions options;
  options.strokes = 3;
  options.there_and_back = false;
  MakeFrames(workspace, options);
  const auto json = nlohmann::json::parse(ReadText(workspace.Stage("frames") / "frames.json"));
  EXPECT_EQ(json.at("strokes").at(1).at("planes").at(0), 0);
  EXPECT_EQ(json.at("numerals").size(), 1U);
}

TEST(PackedStrokes, SayWhatCannotBeDone) {
  Display display = SmallVarifocal();
  const Workspace workspace = WithLayers(display);
  FramesOptions odd;
  odd.strokes = 3;
  EXPECT_THAT(Refusal([&] { MakeFrames(workspace, odd); }), HasSubstr("use an even number"));
  MakeFrames(workspace);
  EXPECT_THAT(Refusal([&] { ShotOfFrames(workspace.Stage("frames")); }),
              HasSubstr("lamella frames --planes grey"));
  display.varifocal->planes = 25;
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
  const Workspace many = WithLayers(display);
  EXPECT_THAT(Refusal([&] { MakeFrames(many); }), HasSubstr("--planes grey"));
  display.varifocal->planes = 3;
  display.layers[0].optics = Barrier{6, 2, 1};
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
  const Workspace barriers = WithLayers(display);
  EXPECT_THAT(Refusal([&] { MakeFrames(barriers); }), HasSubstr("it has a barrier"));
}

TEST(PackedStrokes, WarnWhereThePanelIsTooSmallForNumerals) {
  Display display = SmallVarifocal();
  display.width_px = 40;
  display.height_px = 30;
  const Workspace workspace = WithLayers(display);
  const StageReport report = MakeFrames(workspace);
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_THAT(report.warnings[0], HasSubstr("numerals"));
  EXPECT_FALSE(std::filesystem::exists(workspace.Stage("frames") / "numerals_00.png"));
}

}  // namespace
}  // namespace lamella
