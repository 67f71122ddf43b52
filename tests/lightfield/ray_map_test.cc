// The ray map against geometry that is written out: straight lines between points of two planes.
#include "lightfield/ray_map.h"

#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>

namespace lamella {
namespace {

Display OneLayer(int width, int height, Barrier barrier, bool shear, double position = 10) {
  Display display{"one", width, height, 0.3113158871666749, 1, 600, shear, 0, 0, {}};
  display.layers = {{position, 5, barrier, false}};
  return display;
}

TEST(RayMap, GivesEveryEmitterInTheMiddleOneOpeningPerSlot) {
  const RayMap map(OneLayer(36, 24, {6, 2, 3}, false), 0);
  for (int slot = 0; slot < 3; ++slot) {
    for (int column = 6; column < 30; ++column) {
      const std::optional<AxisBeam> beam = map.Column(slot, column);
      ASSERT_TRUE(beam);
      EXPECT_LT(std::abs(beam->emitter_mm - beam->element_mm), 3 * 0.3113158871666749);
    }
  }
}

TEST(RayMap, DropsRaysOfEdgeOpeningsThatHaveNoEmitter) {
  const RayMap map(OneLayer(12, 12, {6, 2, 3}, false), 0);
  // Slot 0: openings at columns 0-1 and 6-7; their windows are -2..3 and 4..9.
  EXPECT_EQ(map.Column(0, 0)->opening, 0);
  EXPECT_EQ(map.Column(0, 3)->opening, 0);
  EXPECT_EQ(map.Column(0, 4)->opening, 1);
  EXPECT_EQ(map.Column(0, 9)->opening, 1);
  EXPECT_FALSE(map.Column(0, 10));
  EXPECT_FALSE(map.Column(0, 11));
  EXPECT_FALSE(map.Column(0, 12));
  EXPECT_FALSE(map.Column(0, -1));
}

TEST(RayMap, SendsLightOfARightEmitterToTheLeftAndOfALowerOneUp) {
  const RayMap map(OneLayer(12, 12, {6, 2, 3}, false), 0);
  // Slot 1 opens columns 2-3 and rows 2-3, whose windows are 0..5.
  EXPECT_LT(map.Column(1, 5)->slope(), 0);
  EXPECT_GT(map.Column(1, 0)->slope(), 0);
  EXPECT_GT(map.Row(1, 5)->slope(), 0);
  EXPECT_LT(map.Row(1, 0)->slope(), 0);
  EXPECT_GT(map.Row(1, 0)->element_mm, 0);  // row 0 is on top
}

TEST(RayMap, AimsTheMiddleOfEveryFanAtTheViewer) {
  const Display display = OneLayer(1920, 1080, {6, 2, 3}, true);
  const RayMap map(display, 0);
  const double step = ViewSpacingMm(display, display.layers[0], 590);
  const auto aims = [&](const auto& beam_of, int count) {
    int beams = 0;
    for (int index = 0; index < count; ++index) {
      const std::optional<AxisBeam> beam = beam_of(index);
      if (!beam) continue;
      ++beams;
      // Half a period to each side of the middle, of windows as far apart as the viewer needs.
      EXPECT_LE(std::abs(beam->At(590)), 3 * (1 + 5.0 / 590) * step + 1e-6) << index;
    }
    EXPECT_GT(beams, count - 12);  // at the ends of the panel openings are missing, and only there
  };
  for (int slot = 0; slot < 3; ++slot) {
    aims([&](int i) { return map.Column(slot, i); }, 1920);
    aims([&](int i) { return map.Row(slot, i); }, 1080);
  }
}

TEST(RayMap, GivesEmittersToTheWindowThatHoldsThemAndMissedOnesToTheNearest) {
  for (const Barrier barrier :
       {Barrier{6, 2, 3}, Barrier{3, 1, 3}, Barrier{5, 1, 5}, Barrier{1, 1, 1}}) {
    const Display display = OneLayer(300, 60, barrier, true);
    const RayMap map(display, 0);
    int missed = 0;
    for (int slot = 0; slot < barrier.slots; ++slot) {
      for (int column = 0; column < 300; ++column) {
        // By search over all openings.
        int expected = -1, nearest = -1;
        bool before = false, after = false;
        double distance = 1e9;
        for (int opening = 0; opening < 300; ++opening) {
          const int c0 = barrier.period_px * opening + barrier.period_px / barrier.slots * slot;
          if (c0 + barrier.aperture_px > 300) break;
          const double x = (c0 + barrier.aperture_px / 2.0 - 150) * display.pitch_mm;
          const int first = c0 + (barrier.aperture_px - barrier.period_px) / 2 +
                            static_cast<int>(std::floor(x * 5 / (590 * display.pitch_mm) + 0.5));
          if (column >= first && column < first + barrier.period_px) expected = opening;
          before |= column == first - 1;
          after |= column == first + barrier.period_px;
          const double unrounded = x / display.pitch_mm * (1 + 5.0 / 590) + 150;
          if (std::abs(column + 0.5 - unrounded) < distance - 1e-9) {
            distance = std::abs(column + 0.5 - unrounded);
            nearest = opening;
          }
        }
        missed += expected < 0 && before && after;
        if (expected < 0 && before && after) expected = nearest;
        const std::optional<AxisBeam> beam = map.Column(slot, column);
        EXPECT_EQ(beam ? beam->opening : -1, expected) << slot << " " << column;
      }
    }
    EXPECT_GT(missed, 0);
  }
}

TEST(RayMap, SeesAlongEveryBeamTheEmitterThatMadeIt) {
  for (const bool shear : {false, true}) {
    const RayMap map(OneLayer(360, 240, {6, 2, 3}, shear, -10), 0);
    for (int slot = 0; slot < 3; ++slot) {
      for (int column = 0; column < 360; ++column) {
        const std::optional<AxisBeam> beam = map.Column(slot, column);
        if (!beam) continue;
        for (const double a : {-0.49, 0.0, 0.49}) {
          for (const double b : {-0.49, 0.0, 0.49}) {
            const double x = beam->element_mm + a * beam->aperture_mm;
            const double u = beam->emitter_mm + b * beam->emitter_width_mm;
            const std::optional<AxisHit> hit = map.SeenColumn(x, (x - u) / 5);
            ASSERT_TRUE(hit);
            EXPECT_EQ(hit->emitter, column);
            EXPECT_EQ(hit->slot, slot);
            EXPECT_TRUE(map.ColumnOpen(slot, hit->element));
          }
        }
      }
    }
  }
}

TEST(RayMap, SeesRowsTheSameWay) {
  const RayMap map(OneLayer(36, 360, {3, 1, 3}, true), 0);
  for (int slot = 0; slot < 3; ++slot) {
    for (int row = 0; row < 360; ++row) {
      const std::optional<AxisBeam> beam = map.Row(slot, row);
      if (!beam) continue;
      const std::optional<AxisHit> hit = map.SeenRow(beam->element_mm, beam->slope());
      ASSERT_TRUE(hit);
      EXPECT_EQ(hit->emitter, row);
      EXPECT_EQ(hit->slot, slot);
    }
  }
}

TEST(RayMap, OpensEveryElementOnceWhereTheApertureIsTheStride) {
  const RayMap map(OneLayer(1920, 1080, {6, 2, 3}, true), 0);
  for (int column = 0; column < 1920; ++column) {
    int open = 0;
    for (int slot = 0; slot < 3; ++slot) open += map.ColumnOpen(slot, column) ? 1 : 0;
    EXPECT_EQ(open, 1);
  }
}

TEST(RayMap, NamesEverySlotThatOpensAnElement) {
  const RayMap map(OneLayer(36, 36, {6, 2, 6}, false), 0);
  const std::optional<AxisHit> hit = map.SeenColumn(0.1, 0);  // column 18: slots 5 and 0
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->element, 18);
  EXPECT_EQ(hit->open_slots, 1U << 0 | 1U << 5);
  const RayMap sparse(OneLayer(36, 36, {9, 1, 3}, false), 0);
  EXPECT_FALSE(sparse.SeenColumn(sparse.ColumnCentre(19), 0));  // no slot opens it
  EXPECT_TRUE(sparse.SeenColumn(sparse.ColumnCentre(18), 0));
}

TEST(RayMap, SeesNothingBesideThePanel) {
  const RayMap map(OneLayer(36, 36, {6, 2, 3}, false), 0);
  const double edge = 18 * 0.3113158871666749;
  EXPECT_FALSE(map.SeenColumn(edge + 1e-9, 0));
  EXPECT_FALSE(map.SeenColumn(-edge - 1e-9, 0));
  EXPECT_FALSE(map.SeenColumn(0, 10));  // the emitter would be beyond the edge
  EXPECT_FALSE(map.SeenColumn(std::nan(""), 0));
  EXPECT_FALSE(map.SeenColumn(0, std::numeric_limits<double>::infinity()));
}

TEST(RayMap, HoldsWithAViewerAlmostInsideTheDisplayAndAPeriodOfOne) {
  Display display = OneLayer(64, 64, {1, 1, 1}, true);
  display.viewing_distance_mm = 15.0001;
  Check(display, "test");
  const RayMap map(display, 0);
  std::map<int, int> openings;  // and their emitters: windows stand two emitters apart
  for (int column = 0; column < 64; ++column) {
    const auto beam = map.Column(0, column);
    if (beam) {
      EXPECT_LE(++openings[beam->opening], 2);
    }
  }
  EXPECT_GE(openings.size(), 30U);
}

TEST(AxisBeam, BlursByItsOpeningAndItsEmitter) {
  const AxisBeam beam{0, 1, 2, 0.5, 1, 5};
  EXPECT_DOUBLE_EQ(beam.slope(), 0.1);
  EXPECT_DOUBLE_EQ(beam.At(-5), 0.5);           // the emitter itself
  EXPECT_DOUBLE_EQ(beam.OpeningBlurMm(-5), 0);  // seen sharply behind the opening
  EXPECT_DOUBLE_EQ(beam.EmitterBlurMm(-5), 1);
  EXPECT_DOUBLE_EQ(beam.OpeningBlurMm(10), 6);
  EXPECT_DOUBLE_EQ(beam.EmitterBlurMm(10), 2);
}

}  // namespace
}  // namespace lamella
