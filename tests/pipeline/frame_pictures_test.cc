// The page's pictures of frames against files that the test writes: crops and means of its own.
#include "pipeline/frame_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "tests/pipeline/data_uri.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kSrgbFrames = R"({"format_version": 1, "response": {"curve": "srgb"}})";

std::string FileOf(int layer, int slot, const char* role) {
  return "layer_" + std::to_string(layer) + "_slot_" + std::to_string(slot) + "_" + role + ".png";
}

Display Barriers(int width, int height) {
  Display display = FindDisplay("paper-two-layer");  // 2 px every 6 px in 3 x 3 slots
  display.width_px = width;
  display.height_px = height;
  return display;
}

bool IsOpen(int slot, int x, int y) { return x / 2 % 3 == slot % 3 && y / 2 % 3 == slot / 3; }

// Every other column is black, so that a mean of codes is far from the code of the mean.
std::uint8_t EmitterCode(int layer, int slot, int x, int y) {
  const double wave = std::sin(0.01 * x + 0.013 * y + slot + layer);
  return x % 2 == 0 ? static_cast<std::uint8_t>(170 + std::lround(60 * wave)) : std::uint8_t{0};
}

void WriteBarrierFrames(const fs::path& folder, const Display& display) {
  WriteTextAtomically(folder / "frames.json", kSrgbFrames);
  for (int layer = 0; layer < 2; ++layer) {
    for (int slot = 0; slot < 9; ++slot) {
      Image<Rgb8> emitter(display.width_px, display.height_px);
      Image<std::uint8_t> modulator(display.width_px, display.height_px);
      for (int y = 0; y < emitter.height(); ++y) {
        for (int x = 0; x < emitter.width(); ++x) {
          const std::uint8_t code = EmitterCode(layer, slot, x, y);
          emitter(x, y) = {code, code, code};
          modulator(x, y) = IsOpen(slot, x, y) ? 255 : 0;
        }
      }
      WriteCodes8(folder / FileOf(layer, slot, "emitter"), emitter.span());
      WriteGrey8(folder / FileOf(layer, slot, "modulator"), modulator.span());
    }
  }
}

// What the frames decode to, of which only the place of the most contrast counts: in slot 0, a
// white bar from column 200 to 209 and row 64 to 127, seen from the front.
LayerImages BarAlone(const Display& display) {
  LayerImages shown;
  for (std::size_t layer = 0; layer < display.layers.size(); ++layer) {
    EmitterImage image{Image<Rgb>(display.width_px, display.height_px),
                       Image<float>(display.width_px, display.height_px)};
    for (int y = 64; y < std::min(128, display.height_px); ++y) {
      for (int x = 200; x < std::min(210, display.width_px); ++x) image.color(x, y) = {1, 1, 1};
    }
    shown.slots.emplace_back().push_back(std::move(image));
  }
  return shown;
}

void ExpectPart(const PagePicture& picture, const Rect& part, const fs::path& folder,
                auto code_of) {
  EXPECT_TRUE(picture.is_part);
  const Image<Rgb8> shown = PictureOfUri(picture.picture, folder);
  ASSERT_EQ(shown.width(), part.width);
  ASSERT_EQ(shown.height(), part.height);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      ASSERT_EQ(int{shown(x, y).g}, int{code_of(part.x + x, part.y + y)}) << x << " " << y;
    }
  }
}

// Each pixel the mean light of `factor` x `factor` of the panel's, but for what JPEG loses.
void ExpectWhole(const PagePicture& picture, int factor, const fs::path& folder, auto code_of) {
  EXPECT_FALSE(picture.is_part);
  const Image<Rgb8> shown = PictureOfUri(picture.picture, folder);
  ASSERT_EQ(shown.width(), 480);
  for (int y = 0; y < shown.height(); ++y) {
    for (int x = 0; x < shown.width(); ++x) {
      double light = 0;
      for (int i = 0; i < factor * factor; ++i) {
        const std::uint8_t code = code_of(factor * x + i % factor, factor * y + i / factor);
        light += static_cast<double>(Srgb8ToLinear(code)) / (factor * factor);
      }
      ASSERT_NEAR(int{shown(x, y).g}, int{LinearToSrgb8(static_cast<float>(light))}, 6)
          << x << " " << y;
    }
  }
}

TEST(StepsOfFrames, ShowEverySlotsFilesAndTheirSum) {
  const fs::path folder = ScratchFolder();
  const Display display = Barriers(960, 240);
  WriteBarrierFrames(folder, display);
  const PageSteps steps = StepsOfFrames(folder, display, OpenImages(BarAlone(display)));
  EXPECT_EQ(steps.slot_name, "time slot");
  EXPECT_THAT(steps.note, HasSubstr("seen in a mirror is flipped"));
  ASSERT_EQ(steps.layers.size(), 2U);
  EXPECT_EQ(steps.layers[0].part, (Rect{960 - 288, 64, 96, 64}));  // seen in a mirror
  EXPECT_EQ(steps.layers[1].part, (Rect{192, 64, 96, 64}));
  for (int layer = 0; layer < 2; ++layer) {
    const auto& [part, slots] = steps.layers[static_cast<std::size_t>(layer)];
    ASSERT_EQ(slots.size(), 10U);
    const auto sum = [&](int x, int y) {
      return EmitterCode(layer, y / 2 % 3 * 3 + x / 2 % 3, x, y);
    };
    ASSERT_EQ(slots[0].pictures.size(), 2U);
    EXPECT_THAT(slots[0].pictures[1].caption,
                HasSubstr("from column " + std::to_string(part.x) + " and row 64 on"));
    ExpectPart(slots[0].pictures[1], part, folder, sum);
    for (int slot = 0; slot < 9; ++slot) {
      const std::vector<PagePicture>& pictures = slots[static_cast<std::size_t>(slot) + 1].pictures;
      ASSERT_EQ(pictures.size(), 3U);
      const auto emitter = [&](int x, int y) { return EmitterCode(layer, slot, x, y); };
      EXPECT_THAT(pictures[0].caption, HasSubstr(FileOf(layer, slot, "emitter")));
      ExpectWhole(pictures[0], 2, folder, emitter);
      ExpectPart(pictures[1], part, folder, emitter);
      ExpectPart(pictures[2], part, folder, [&](int x, int y) {
        return IsOpen(slot, x, y) ? std::uint8_t{255} : std::uint8_t{0};
      });
    }
  }
}

TEST(StepsOfFrames, RefuseAModulatorOfAnotherPanel) {
  const fs::path folder = ScratchFolder();
  const Display display = Barriers(60, 48);
  WriteBarrierFrames(folder, display);
  WriteGrey8(folder / FileOf(1, 4, "modulator"), Image<std::uint8_t>(60, 47).span());
  try {
    StepsOfFrames(folder, display, OpenImages(BarAlone(display)));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("layer_1_slot_4_modulator.png: is 60 x 47 px"));
  }
}

// Codes are bits: stroke 0 shows planes 0 to 23 in the bits of red, green and blue, stroke 1 the
// other way round.
TEST(StepsOfFrames, ShowThePlanesOfPackedStrokes) {
  const fs::path folder = ScratchFolder();
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 120;
  display.height_px = 90;
  WriteTextAtomically(folder / "frames.json", R"({"format_version": 1, "strokes": [
      {"file": "stroke_00.png"}, {"file": "stroke_01.png"}],
      "packing": {"channels": "RGB", "bits": "lsb-first", "there_and_back": true}})");
  std::mt19937 random(3);
  std::vector<Image<Rgb8>> strokes;
  for (int stroke = 0; stroke < 2; ++stroke) {
    Image<Rgb8>& codes = strokes.emplace_back(120, 90);
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const auto code = [&] { return static_cast<std::uint8_t>(random() & 255U); };
      codes.data()[i] = {code(), code(), code()};
    }
    WriteCodes8(folder / ("stroke_0" + std::to_string(stroke) + ".png"), codes.span());
  }
  const auto bit = [&](std::size_t stroke, unsigned plane, int x, int y) {
    const unsigned exposure = stroke == 0 ? plane : 23 - plane;
    const Rgb8& codes = strokes[stroke](x, y);
    const unsigned channel = exposure < 8 ? codes.r : exposure < 16 ? codes.g : codes.b;
    return (channel >> exposure % 8 & 1U) != 0;
  };
  LayerImages shown;
  for (unsigned plane = 0; plane < 24; ++plane) {
    EmitterImage image{Image<Rgb>(120, 90), Image<float>(120, 90)};
    for (int i = 0; i < 120 * 90; ++i) {
      const float light = 0.5F * static_cast<float>(bit(0, plane, i % 120, i / 120) +
                                                    bit(1, plane, i % 120, i / 120));
      image.color.data()[i] = {light, light, light};
    }
    shown.slots.emplace_back().push_back(std::move(image));
  }
  const PageSteps steps = StepsOfFrames(folder, display, OpenImages(shown));
  EXPECT_EQ(steps.slot_name, "stroke");
  ASSERT_EQ(steps.layers.size(), 24U);
  for (unsigned plane = 0; plane < 24; ++plane) {
    const auto& [part, slots] = steps.layers[plane];
    ASSERT_EQ(slots.size(), 3U);
    ExpectPart(slots[0].pictures[1], part, folder,
               [&](int x, int y) { return LinearToSrgb8(shown.slots[plane][0].color(x, y).g); });
    for (const std::size_t stroke : {0U, 1U}) {
      ExpectPart(slots[stroke + 1].pictures[1], part, folder, [&](int x, int y) {
        return bit(stroke, plane, x, y) ? std::uint8_t{255} : std::uint8_t{0};
      });
    }
  }
}

// Noise is the worst for PNG and JPEG.
TEST(StepsOfFrames, LeaveThePageItsRoomHoweverManyLayersThereAre) {
  const fs::path folder = ScratchFolder();
  Display display = Barriers(300, 200);
  WriteTextAtomically(folder / "frames.json", kSrgbFrames);
  const Image<std::uint8_t> modulator(300, 200, 255);
  Image<Rgb8> noise(300, 200);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const auto code = [&] { return static_cast<std::uint8_t>(random() & 255U); };
    noise.data()[i] = {code(), code(), code()};
  }
  display.layers.resize(30, display.layers[0]);
  WriteCodes8(folder / "noise.png", noise.span());
  WriteGrey8(folder / "open.png", modulator.span());
  for (int layer = 0; layer < 30; ++layer) {
    for (int slot = 0; slot < 9; ++slot) {
      fs::create_hard_link(folder / "noise.png", folder / FileOf(layer, slot, "emitter"));
      fs::create_hard_link(folder / "open.png", folder / FileOf(layer, slot, "modulator"));
    }
  }
  const PageSteps steps = StepsOfFrames(folder, display, OpenImages(BarAlone(display)));
  std::size_t bytes = 0;
  for (const PageStepLayer& layer : steps.layers) {
    EXPECT_EQ(layer.slots.size(), 4U);
    for (const PageSlot& slot : layer.slots) {
      for (const PagePicture& picture : slot.pictures) bytes += picture.picture.size();
    }
  }
  EXPECT_LT(bytes, 6U << 20U);
  EXPECT_THAT(steps.note, HasSubstr("Of 9 time slots a layer the first 3 are here."));
}

TEST(StepsOfLayers, ShowTheEmittersLight) {
  const fs::path folder = ScratchFolder();
  const Display display = Barriers(120, 90);
  LayerImages layers;
  for (int layer = 0; layer < 2; ++layer) {
    layers.slots.emplace_back();
    for (int slot = 0; slot < 9; ++slot) {
      EmitterImage image{Image<Rgb>(120, 90), Image<float>(120, 90, 1.0F)};
      for (int i = 0; i < 120 * 90; ++i) {
        const float light = Srgb8ToLinear(EmitterCode(layer, slot, i % 120, i / 120));
        image.color.data()[i] = {light, light, light};
      }
      layers.slots.back().push_back(std::move(image));
    }
  }
  const PageSteps steps = StepsOfLayers(display, OpenImages(layers));
  EXPECT_THAT(steps.note, HasSubstr("before it becomes frames"));
  for (int layer = 0; layer < 2; ++layer) {
    const auto& [part, slots] = steps.layers.at(static_cast<std::size_t>(layer));
    ASSERT_EQ(slots.size(), 9U);
    for (int slot = 0; slot < 9; ++slot) {
      ExpectPart(slots[static_cast<std::size_t>(slot)].pictures.at(1), part, folder,
                 [&](int x, int y) { return EmitterCode(layer, slot, x, y); });
    }
  }
}

}  // namespace
}  // namespace lamella
