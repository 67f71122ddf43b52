#include "calibration/photo_check.h"

#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

ShotList List() {
  PanelCalibration panel;
  panel.width_px = 1920;
  panel.height_px = 1080;
  panel.pitch_mm = 0.31;
  LayerCalibration layer;
  layer.emitter = panel;
  layer.modulator = panel;
  Calibration calibration{"two", {layer, layer}};
  calibration.layers[0].emitter.mirror_x = true;
  calibration.layers[0].modulator->mirror_x = true;
  return PlanShots(calibration, CalibrationMode::kQuick);
}

// What a good photograph of a shot shows.
PhotoFacts Good(const ShotList& list, std::size_t index, const Vector2d& shift = {0, 0}) {
  const PatternShot& shot = list.shots[index];
  const bool dark = shot.kind == PatternShot::Kind::kDark || shot.kind == PatternShot::Kind::kLeak;
  PhotoFacts facts{2400, 1600, 0.02, dark ? 0.03 : 0.85, 0, std::nullopt, std::nullopt};
  if (shot.kind != PatternShot::Kind::kBoard) return facts;
  facts.panel = shot.panel;
  for (std::size_t p = 0; p < list.panels.size(); ++p) {
    if (list.panels[p].id != shot.panel) continue;
    BoardSighting seen{p, list.panels[p].mirrored, 150, 1.1, 1.0, {}};
    std::mt19937 random(static_cast<unsigned>(index));
    std::normal_distribution<double> noise(0, 0.015);
    for (int c = 0; c < list.panels[p].board->num_corners(); ++c) {
      const Vector2d at = list.panels[p].board->CornerPx(c);
      seen.points.push_back({at, 1.1 * at + shift + Vector2d(noise(random), noise(random)),
                             1e-4 * Eigen::Matrix2d::Identity()});
    }
    facts.sighting = seen;
  }
  return facts;
}

TEST(PhotoCheck, FindsTwoWholePositionsGood) {
  const ShotList list = List();
  PhotoCheck check(list);
  for (int view = 0; view < 2; ++view) {
    for (std::size_t shot = 0; shot < list.shots.size(); ++shot) {
      const CheckedPhoto& photo =
          check.Add(std::to_string(view) + list.shots[shot].name, Good(list, shot));
      EXPECT_EQ(photo.view, view);
      EXPECT_EQ(photo.shot, shot);
      EXPECT_TRUE(photo.good) << photo.verdict;
    }
  }
  EXPECT_THAT(check.Missing(), IsEmpty());
  const Observations observations = ObservationsOf(list, check.photos());
  EXPECT_EQ(observations.photos.size(), 8U);  // without the repeats
  EXPECT_EQ(observations.photos[7].view, 1);
  EXPECT_EQ(observations.photos[7].panel, (PanelId{1, PanelId::kEmitter}));
  EXPECT_EQ(observations.cameras[0].width, 2400);
  Check(observations, "here");
}

// Of a display with lenses.
ShotList ListWithPrintedBoard() {
  PanelCalibration panel;
  panel.width_px = 96;
  panel.height_px = 72;
  panel.pitch_mm = 0.4;
  LayerCalibration layer;
  layer.emitter = panel;
  layer.gap_mm = 4;
  layer.lattice = LensLattice{LensLattice::Type::kLine, 2, 0, {0, 0}, 0};
  return WithPrintedBoard(PlanShots({"lenses", {layer}}, CalibrationMode::kPrecise));
}

PhotoFacts GoodPrinted(const ShotList& list, const Vector2d& shift = {0, 0}) {
  const CharucoBoard& board = list.printed->board;
  PhotoFacts seen{2400, 1600, 0.02, 0.85, 0, std::nullopt, BoardSighting{0, false, 58, 2, 1, {}}};
  seen.printed = true;
  for (int c = 0; c < board.num_corners(); ++c) {
    seen.sighting->points.push_back(
        {board.CornerPx(c), 2 * board.CornerPx(c) + shift, 1e-4 * Eigen::Matrix2d::Identity()});
  }
  return seen;
}

// The printed board tells itself, and may be all that a position has.
TEST(PhotoCheck, KnowsThePrintedBoard) {
  const ShotList list = ListWithPrintedBoard();
  ASSERT_EQ(list.shots.back().kind, PatternShot::Kind::kPrinted);
  EXPECT_THAT(list.shots.back().name, HasSubstr("_printed_board"));
  EXPECT_THAT(DescribeShots(list), HasSubstr("printed_board.pdf at 100 %"));
  EXPECT_THROW(WithPrintedBoard(List()), Error);
  const PhotoFacts seen = GoodPrinted(list);
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
    check.Add("a" + list.shots[shot].name, Good(list, shot));
  }
  EXPECT_THAT(check.Missing(), ElementsAre(HasSubstr("_printed_board")));
  EXPECT_TRUE(check.Add("board", seen).good);
  check.Add("dark", Good(list, 0));
  const CheckedPhoto& alone = check.Add("board alone", seen);
  EXPECT_EQ(alone.view, 1);
  EXPECT_TRUE(alone.good) << alone.verdict;
  EXPECT_TRUE(alone.usable);
  EXPECT_THAT(check.Missing(), IsEmpty());
  EXPECT_THAT(ObservationsOf(list, check.photos()).photos, IsEmpty());
}

// Photographed alone, again and again: what is no retake is a position of its own.
TEST(PhotoCheck, BeginsAPositionWhereThePrintedBoardIsSeenFromElsewhere) {
  const ShotList list = ListWithPrintedBoard();
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
    check.Add("a" + list.shots[shot].name, Good(list, shot));
  }
  EXPECT_EQ(check.Add("board", GoodPrinted(list)).view, 0);
  EXPECT_EQ(check.Add("retake", GoodPrinted(list, {0.5, 0})).view, 0);
  EXPECT_EQ(check.photos().size(), list.shots.size());
  for (int view = 1; view < 4; ++view) {
    EXPECT_EQ(check.Add("alone", GoodPrinted(list, {50.0 * view, 0})).view, view);
    EXPECT_TRUE(IsOfBoardAlone(list, check.photos(), view));
  }
  EXPECT_THAT(check.Missing(), IsEmpty());
}

// A board beside the display may be made out in any photograph.
TEST(PhotoCheck, TakesAFaintPrintedBoardForNoShotOfIt) {
  const ShotList list = ListWithPrintedBoard();
  PhotoCheck check(list);
  for (int view = 0; view < 2; ++view) {
    for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
      PhotoFacts facts = Good(list, shot);
      if (shot != 1) {
        facts.printed = true;
        facts.sighting = GoodPrinted(list).sighting;
      }
      const CheckedPhoto& photo = check.Add("photo", facts);
      EXPECT_EQ(photo.view, view);
      EXPECT_EQ(photo.shot, shot);
      EXPECT_TRUE(photo.good) << photo.verdict;
      EXPECT_FALSE(photo.usable);
    }
    EXPECT_TRUE(check.Add("board", GoodPrinted(list)).good);
  }
  EXPECT_THAT(check.Missing(), IsEmpty());
}

TEST(PhotoCheck, TakesAPrintedBoardThatIsNotFoundAgain) {
  const ShotList list = ListWithPrintedBoard();
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
    check.Add("photo", Good(list, shot));
  }
  PhotoFacts blurred = GoodPrinted(list);
  blurred.printed = false;
  blurred.sighting.reset();
  const CheckedPhoto& bad = check.Add("blurred", blurred);
  EXPECT_EQ(bad.shot, list.shots.size() - 1);
  EXPECT_THAT(bad.verdict, HasSubstr("the printed board is not seen"));
  PhotoFacts mirrored = GoodPrinted(list);
  mirrored.sighting->mirrored = true;
  EXPECT_THAT(check.Add("mirrored", mirrored).verdict, HasSubstr("leave the picture unflipped"));
  EXPECT_TRUE(check.Add("again", GoodPrinted(list)).good);
  EXPECT_EQ(check.photos().size(), list.shots.size());
  EXPECT_THAT(check.Missing(), IsEmpty());
}

// Dark, then a board that is not found: the same as dark and white.
TEST(PhotoCheck, SaysThatABoardAloneMayNotHaveBeenFound) {
  const ShotList list = ListWithPrintedBoard();
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
    check.Add("photo", Good(list, shot));
  }
  check.Add("board", GoodPrinted(list));
  PhotoFacts blurred = GoodPrinted(list);
  blurred.printed = false;
  blurred.sighting.reset();
  check.Add("dark", Good(list, 0));
  EXPECT_EQ(check.Add("blurred", blurred).view, 1);
  EXPECT_THAT(check.Missing(),
              ElementsAre(AllOf(HasSubstr("position 2: take"),
                                HasSubstr("the printed board alone, the board was not found"))));
}

// It is taken for the sinusoid that is due, the last sinusoid for the board, which is taken again.
TEST(PhotoCheck, NamesAPrintedBoardBetweenSinusoids) {
  const ShotList list = ListWithPrintedBoard();
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
    if (shot == 5) {
      EXPECT_EQ(check.Add("between", GoodPrinted(list)).shot, 5U);
    }
    check.Add("photo", Good(list, shot));
  }
  EXPECT_EQ(BoardInBetween(list, check.photos(), 0), std::nullopt);  // nothing to hold it against
  EXPECT_TRUE(check.Add("board", GoodPrinted(list)).good);
  EXPECT_EQ(BoardInBetween(list, check.photos(), 0), "between");
  EXPECT_THAT(check.Missing(),
              ElementsAre(HasSubstr("position 1: between shows the printed board")));
}

TEST(PhotoCheck, NoticesAMovedCamera) {
  const ShotList list = List();
  for (const double shift : {0.02, 0.1}) {
    PhotoCheck check(list);
    for (std::size_t shot = 0; shot + 1 < list.shots.size(); ++shot) {
      check.Add("photo", Good(list, shot));
    }
    const CheckedPhoto& again = check.Add("photo", Good(list, list.shots.size() - 1, {shift, 0}));
    EXPECT_EQ(again.good, shift < 0.05) << again.verdict;
    EXPECT_THAT(again.verdict, HasSubstr(shift < 0.05 ? "good: moved by 0.0" : "fix the camera"));
  }
}

TEST(PhotoCheck, TakesARetakeInItsPlace) {
  const ShotList list = List();
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot < 8; ++shot) {
    PhotoFacts facts = Good(list, shot);
    if (shot == 5) facts.sighting->blur_px = 3;
    EXPECT_EQ(check.Add("photo", facts).good, shot != 5);
  }
  EXPECT_THAT(check.Missing(), ElementsAre(HasSubstr("06_layer0_modulator_board, 09_")));
  const CheckedPhoto& retake = check.Add("retake", Good(list, 5));
  EXPECT_EQ(retake.shot, 5U);
  EXPECT_EQ(retake.view, 0);
  EXPECT_TRUE(retake.good);
  EXPECT_TRUE(check.Add("photo", Good(list, 8)).good);
  EXPECT_TRUE(check.Add("photo", Good(list, 9)).good);
  EXPECT_THAT(check.Missing(), IsEmpty());
}

TEST(PhotoCheck, BearsAModulatorThatLeaks) {
  const ShotList list = List();
  PhotoCheck check(list);
  check.Add("photo", Good(list, 0));
  check.Add("photo", Good(list, 1));
  PhotoFacts leak = Good(list, 2);
  leak.bright = 0.2;  // a contrast of 30:1
  const CheckedPhoto& photo = check.Add("photo", leak);
  EXPECT_EQ(photo.shot, 2U);
  EXPECT_TRUE(photo.good);
  EXPECT_EQ(photo.verdict, "good: up to 20 % of full scale");
}

TEST(PhotoCheck, BeginsANewPositionWithADarkPhotograph) {
  const ShotList list = List();
  PhotoCheck check(list);
  for (std::size_t shot = 0; shot < 7; ++shot) check.Add("photo", Good(list, shot));
  EXPECT_EQ(check.Add("photo", Good(list, 0)).view, 1);
  EXPECT_THAT(check.Missing(),
              ElementsAre(StartsWith("position 1: take 08_layer1_modulator_board, 09_"),
                          HasSubstr("and 5 more")));
}

TEST(PhotoCheck, KeepsCornersThatAreWorthUsing) {
  const ShotList list = List();
  const auto used = [&](const std::function<void(PhotoFacts&)>& change) {
    PhotoCheck check(list);
    for (std::size_t shot = 0; shot < 5; ++shot) check.Add("photo", Good(list, shot));
    PhotoFacts facts = Good(list, 5);
    change(facts);
    check.Add("photo", facts);
    return ObservationsOf(list, check.photos()).photos.size();
  };
  EXPECT_EQ(used([](auto&) {}), 1U);
  EXPECT_EQ(used([](auto& f) { f.sighting->scale = 0.4; }), 1U);
  EXPECT_EQ(used([](auto& f) { f.sighting->points.resize(8); }), 1U);
  EXPECT_EQ(used([](auto& f) { f.sighting->points.resize(7); }), 0U);
  EXPECT_EQ(used([](auto& f) { f.saturated = 0.05; }), 0U);
  EXPECT_EQ(used([](auto& f) { f.sighting->mirrored = false; }), 0U);
}

TEST(PhotoCheck, SaysWhatToDo) {
  const ShotList list = List();
  const auto verdict = [&](std::size_t index, const std::function<void(PhotoFacts&)>& change) {
    PhotoCheck check(list);
    for (std::size_t shot = 0; shot < index; ++shot) check.Add("photo", Good(list, shot));
    PhotoFacts facts = Good(list, index);
    change(facts);
    const CheckedPhoto& photo = check.Add("photo", facts);
    EXPECT_FALSE(photo.good);
    EXPECT_EQ(photo.verdict.find('\n'), std::string::npos);
    return photo.verdict;
  };
  EXPECT_THAT(verdict(5, [](auto& f) { f.saturated = 0.05; }), HasSubstr("expose less"));
  EXPECT_THAT(verdict(5, [](auto& f) { f.bright = 0.15; }), HasSubstr("expose longer"));
  EXPECT_THAT(verdict(5, [](auto& f) { f.sighting->blur_px = 2.5; }), HasSubstr("blurred by 2.5"));
  EXPECT_THAT(verdict(5, [](auto& f) { f.sighting->scale = 0.4; }), HasSubstr("squares of 32 px"));
  EXPECT_THAT(verdict(5, [](auto& f) { f.sighting->points.resize(100); }),
              HasSubstr("100 of 276 corners only"));
  EXPECT_THAT(verdict(5, [](auto& f) { f.sighting->mirrored = false; }), HasSubstr("mirror_x"));
  EXPECT_THAT(verdict(5,
                      [](auto& f) {
                        f.sighting.reset();
                        f.panel.reset();
                      }),
              HasSubstr("no board is seen"));
  EXPECT_THAT(verdict(0, [](auto& f) { f.bright = 0.5; }), HasSubstr("01_dark was expected"));
  EXPECT_THAT(verdict(1, [](auto& f) { f.saturated = 0.5; }), HasSubstr("expose less"));
}

}  // namespace
}  // namespace lamella
