#include "calibration/marker_dictionary.h"

#include <bit>

#include <gtest/gtest.h>

namespace lamella {
namespace {

// A picture of 6 x 6 modules, turned with the obvious loops.
struct Picture {
  bool white[6][6] = {};
  MarkerBits Bits() const {
    MarkerBits bits = 0;
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 6; ++i)
        bits |= MarkerBits{white[j][i]} << static_cast<unsigned>(i + 6 * j);
    }
    return bits;
  }
};

Picture PictureOf(MarkerBits bits) {
  Picture picture;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) {
      picture.white[j][i] = (bits >> static_cast<unsigned>(i + 6 * j) & 1U) != 0;
    }
  }
  return picture;
}

Picture Clockwise(const Picture& p) {
  Picture turned;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) turned.white[i][5 - j] = p.white[j][i];
  }
  return turned;
}

Picture LeftToRight(const Picture& p) {
  Picture flipped;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) flipped.white[j][5 - i] = p.white[j][i];
  }
  return flipped;
}

TEST(Markers, DifferInSevenModulesInAnyPosition) {
  int least = 36;
  for (int a = 0; a < kNumMarkers; a += 7) {
    Picture picture = PictureOf(BitsOfMarker(a));
    for (int turn = 0; turn < 8; ++turn) {
      if (turn == 4) picture = LeftToRight(picture);
      for (int b = 0; b < kNumMarkers; ++b) {
        if (a == b && turn == 0) continue;
        least = std::min(least, std::popcount(picture.Bits() ^ BitsOfMarker(b)));
      }
      picture = Clockwise(picture);
    }
  }
  EXPECT_GE(least, 7);
}

TEST(FindMarker, TellsTurnAndHandednessDespiteTwoErrors) {
  for (const int id : {0, 17, 999}) {
    Picture picture = PictureOf(BitsOfMarker(id));
    // After r clockwise turns the marker's top left is the frame's corner r.
    for (int r = 0; r < 4; ++r) {
      const auto found = FindMarker(picture.Bits() ^ MarkerBits{0x80000001});
      ASSERT_TRUE(found);
      EXPECT_EQ(found->id, id);
      EXPECT_FALSE(found->turn.mirrored);
      EXPECT_EQ(found->turn.CornerOf(0), r);
      EXPECT_EQ(found->turn.CornerOf(1), (r + 1) % 4);
      picture = Clockwise(picture);
    }
    // Flipped left to right the top left is the frame's top right, and the other way round.
    const auto flipped = FindMarker(LeftToRight(picture).Bits());
    ASSERT_TRUE(flipped);
    EXPECT_EQ(flipped->id, id);
    EXPECT_TRUE(flipped->turn.mirrored);
    EXPECT_EQ(flipped->turn.CornerOf(0), 1);
    EXPECT_EQ(flipped->turn.CornerOf(1), 0);
    EXPECT_EQ(flipped->turn.CornerOf(2), 3);
  }
  EXPECT_FALSE(FindMarker(0));
  EXPECT_FALSE(FindMarker(BitsOfMarker(5) ^ MarkerBits{7}));
}

}  // namespace
}  // namespace lamella
