#include "distribute/encode_barrier.h"

#include <set>

#include <gtest/gtest.h>

#include "distribute/displays.h"

namespace lamella {
namespace {

Display SmallBarrier(const std::string& name) {
  Display display = FindDisplay(name);
  display.width_px = 36;
  display.height_px = 24;
  return display;
}

TEST(ModulatorFrame, OpensSquaresOfTheApertureEveryPeriod) {
  const Display display = SmallBarrier("paper-one-layer");
  for (int slot = 0; slot < 9; ++slot) {
    const Image<std::uint8_t> frame = ModulatorFrame(display, 0, slot);
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 36; ++x) {
        const bool open = x % 6 / 2 == slot % 3 && y % 6 / 2 == slot / 3;
        EXPECT_EQ(frame(x, y), open ? 255 : 0);
      }
    }
  }
}

TEST(SlotOrder, TouchesEveryRowAndColumnOfSlotsInAnyRun) {
  for (const int k : {1, 2, 3, 4, 6}) {
    const std::vector<int> order = SlotOrder(k);
    EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), static_cast<std::size_t>(k * k));
    for (int t = 0; t + k <= k * k; t += k) {
      std::set<int> columns, rows;
      for (int i = t; i < t + k; ++i) {
        columns.insert(order[static_cast<std::size_t>(i)] % k);
        rows.insert(order[static_cast<std::size_t>(i)] / k);
      }
      EXPECT_EQ(columns.size(), static_cast<std::size_t>(k));
      EXPECT_EQ(rows.size(), static_cast<std::size_t>(k));
    }
  }
}

}  // namespace
}  // namespace lamella
