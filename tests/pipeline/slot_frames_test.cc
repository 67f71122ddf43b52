// A slot's frames made in strips are those made at once, and no more than a strip is held.
#include "pipeline/slot_frames.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/emitter_frame.h"
#include "distribute/encode_barrier.h"
#include "lightfield/image_io.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

constexpr int kSlotWidth = 30,
              kSlotHeight = 78;  // 39 rows of emitters where binned: no multiple of 7

Display Small(const std::string& name, const Optics& optics) {
  Display display = FindDisplay(name);
  display.width_px = kSlotWidth;
  display.height_px = kSlotHeight;
  for (Layer& layer : display.layers) layer.optics = optics;
  return display;
}

// Binned and of several slots; square and hexagonal lenses; slanted and upright lenticulars; bare
// panels.
std::vector<std::pair<std::string, Display>> Displays() {
  Lenticular upright;
  upright.slant = 0;
  std::vector<std::pair<std::string, Display>> displays = {
      {"barrier", Small("paper-two-layer-half", Barrier{3, 1, 3})},
      {"lenslets", Small("paper-one-layer", LensletArray{LensletArray::Lattice::kSquare, 5, 4})},
      {"hexagons", Small("paper-one-layer", LensletArray{LensletArray::Lattice::kHexagonal, 4, 3})},
      {"slanted", Small("paper-one-layer", Lenticular{})},
      {"upright", Small("paper-one-layer", upright)}};
  Display mirrored = displays[3].second;
  mirrored.layers[0].mirror_x = true;
  displays.emplace_back("mirrored", mirrored);
  displays.emplace_back("bare", Small("depth-fused", BarePanel{}));
  return displays;
}

// Every row and column differs; a few emitters are unknown.
EmitterImage Rows(const Display& display, int first_row, int end_row) {
  const int columns = display.emitter_columns();
  EmitterImage image{Image<Rgb>(columns, end_row - first_row),
                     Image<float>(columns, end_row - first_row, 1.0F)};
  for (int y = first_row; y < end_row; ++y) {
    for (int x = 0; x < columns; ++x) {
      image.color(x, y - first_row) = {static_cast<float>(y) / kSlotHeight,
                                       static_cast<float>(x) / kSlotWidth,
                                       static_cast<float>((31 * y + 7 * x) % 64) / 63};
      if ((5 * y + x) % 37 == 0) image.coverage(x, y - first_row) = 0;
    }
  }
  return image;
}

void ExpectTheSlotsPixels(const fs::path& folder, const Display& display, int layer, int slot) {
  const Image<Rgb8> truth =
      EmitterFrame(Rows(display, 0, display.emitter_rows()), display, layer, PanelResponse::Srgb());
  const Image<Rgb8> frame = ReadSrgb8(folder / FrameFile(layer, slot, "emitter"));
  ASSERT_EQ(frame.width(), kSlotWidth);
  ASSERT_EQ(frame.height(), kSlotHeight);
  EXPECT_TRUE(std::equal(truth.data(), truth.data() + truth.size(), frame.data()));
  const fs::path file = folder / FrameFile(layer, slot, "modulator");
  const bool barrier =
      std::holds_alternative<Barrier>(display.layers[static_cast<std::size_t>(layer)].optics);
  ASSERT_EQ(fs::exists(file), barrier);
  if (!barrier) return;
  const Image<std::uint8_t> open = ModulatorFrame(display, layer, slot);
  const Image<Rgb8> modulator = ReadSrgb8(file);
  ASSERT_EQ(modulator.size(), open.size());
  for (std::size_t i = 0; i < open.size(); ++i) ASSERT_EQ(modulator.data()[i].g, open.data()[i]);
}

TEST(SlotFrames, AreTheSameInStripsOfAnyHeight) {
  const fs::path folder = ScratchFolder();
  for (const auto& named : Displays()) {
    const Display& display = named.second;
    for (const int rows : {1, 7, 32, display.emitter_rows()}) {
      SCOPED_TRACE(named.first + " " + std::to_string(rows));
      for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
        const int k = SlotsPerAxis(display.layers[static_cast<std::size_t>(layer)]);
        for (int slot = 0; slot < k * k; ++slot) {
          WriteSlotFrames([&](int first, int end) { return Rows(display, first, end); }, display,
                          layer, slot, PanelResponse::Srgb(), folder, rows);
          ExpectTheSlotsPixels(folder, display, layer, slot);
        }
      }
    }
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
}

TEST(SlotFrames, AskForEveryRowOnceAndForAStripAtMost) {
  const fs::path folder = ScratchFolder();
  const Display display = Small("paper-one-layer", Barrier{6, 2, 3});
  int next = 0;
  const auto emitters = [&](int first, int end) {
    EXPECT_EQ(first, next);
    EXPECT_LE(end - first, 7);
    next = end;
    return Rows(display, first, end);
  };
  WriteSlotFrames(emitters, display, 0, 4, PanelResponse::Srgb(), folder, 7);
  EXPECT_EQ(next, kSlotHeight);
}

TEST(SlotFrames, HoldFewRowsOfALargeDisplay) {
  Display display = FindDisplay("paper-one-layer");
  for (const auto& [width, binning, rows] :
       {std::tuple{16384, 1, 32}, {16384, 4, 32}, {1920, 1, 128}, {1920, 2, 64}, {16, 1, 16384}}) {
    display.width_px = width;
    display.binning_px = binning;
    EXPECT_EQ(RowsAtOnce(display), rows) << width << " " << binning;
  }
}

TEST(SlotFrames, LeaveNoFileWhereRowsCannotBeRead) {
  const fs::path folder = ScratchFolder();
  const Display display = Small("paper-one-layer", Barrier{6, 2, 3});
  for (const int bad : {0, 35, 77}) {
    const auto emitters = [&](int first, int end) {
      if (end > bad) throw std::runtime_error("damaged");
      return Rows(display, first, end);
    };
    EXPECT_THROW(WriteSlotFrames(emitters, display, 0, 4, PanelResponse::Srgb(), folder, 7),
                 std::runtime_error);
    EXPECT_TRUE(fs::is_empty(folder)) << bad;
  }
}

}  // namespace
}  // namespace lamella
