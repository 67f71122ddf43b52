#include "calibration/shot_list.h"

#include <algorithm>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/display.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two barrier layers of 1920 x 1080, the one at the back seen in a mirror.
Calibration TwoLayers() {
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
  return calibration;
}

TEST(LayOutBoards, FillsTheReferencePanel) {
  const auto boards = LayOutBoards({{1920, 1080}, {1920, 1080}, {1920, 1080}, {1920, 1080}});
  ASSERT_EQ(boards.size(), 4U);
  EXPECT_EQ(boards[0].columns, 24);
  EXPECT_EQ(boards[0].rows, 13);
  EXPECT_EQ(boards[0].square_px, 80);
  EXPECT_EQ(boards[0].marker_px(), 48);
  EXPECT_EQ(boards[0].top_px, 20);
  EXPECT_EQ(boards[0].num_corners(), 276);
  EXPECT_EQ(boards[0].num_markers(), 156);
  EXPECT_EQ(boards[3].first_id, 468);
  EXPECT_EQ(boards[0].CornerPx(0), Eigen::Vector2d(80, 100));
  EXPECT_EQ(boards[0].CornerPx(275), Eigen::Vector2d(1840, 980));
}

TEST(LayOutBoards, SuitsOtherPanels) {
  for (const PanelSize size : {PanelSize{1080, 1920}, {3840, 2160}, {640, 480}, {160, 120}}) {
    const CharucoBoard board = LayOutBoards({size})[0];
    EXPECT_EQ(board.rows % 2, 1);
    EXPECT_EQ(board.square_px % 5, 0);
    EXPECT_GE(board.left_px, 0);
    EXPECT_LE(board.left_px + board.columns * board.square_px, size.width_px);
    EXPECT_LE(board.top_px + board.rows * board.square_px, size.height_px);
    EXPECT_LE(board.num_markers(), 200);
  }
  // Ten panels share the dictionary's 1000 markers.
  const auto ten = LayOutBoards(std::vector<PanelSize>(10, {1920, 1080}));
  EXPECT_LE(ten[9].first_id + ten[9].num_markers(), 1000);
  EXPECT_EQ(ten[9].first_id, 9 * ten[0].num_markers());
  EXPECT_THROW(LayOutBoards({{150, 120}}), Error);
  EXPECT_THROW(LayOutBoards(std::vector<PanelSize>(400, {200, 100})), Error);
}

TEST(PlanShots, ShowsEveryPanelOnceAndTheFirstAgain) {
  const ShotList list = PlanShots(TwoLayers(), CalibrationMode::kQuick);
  std::vector<std::string> names;
  for (const PatternShot& shot : list.shots) names.push_back(shot.name);
  EXPECT_THAT(names, ElementsAre("01_dark", "02_layer0_white", "03_layer0_leak", "04_layer1_white",
                                 "05_layer1_leak", "06_layer0_modulator_board",
                                 "07_layer0_emitter_board", "08_layer1_modulator_board",
                                 "09_layer1_emitter_board", "10_layer0_modulator_board_again"));
  EXPECT_TRUE(list.panels[0].mirrored);
  EXPECT_FALSE(list.panels[3].mirrored);
}

TEST(PlanShots, LightsThePanelUnderTestOnly) {
  const ShotList list = PlanShots(TwoLayers(), CalibrationMode::kQuick);
  const Pattern white{Pattern::Kind::kWhite}, black{Pattern::Kind::kBlack};
  const auto shown = [&](std::size_t shot) { return ShownIn(list.shots[shot], 2); };
  EXPECT_EQ(shown(0)[0].emitter, black);
  EXPECT_EQ(shown(1)[0].emitter, white);
  EXPECT_EQ(shown(1)[0].modulator, white);
  EXPECT_EQ(shown(2)[0].emitter, white);
  EXPECT_EQ(shown(2)[0].modulator, black);
  EXPECT_EQ(shown(5)[0].emitter, white);  // behind the modulator under test
  EXPECT_EQ(shown(5)[0].modulator.kind, Pattern::Kind::kBoard);
  EXPECT_EQ(shown(6)[0].emitter.kind, Pattern::Kind::kBoard);
  EXPECT_EQ(shown(6)[0].modulator, white);
  EXPECT_EQ(shown(6)[1].emitter, black);
  EXPECT_EQ(shown(8)[0].emitter, black);
  EXPECT_EQ(shown(8)[1].emitter.kind, Pattern::Kind::kBoard);
}

// calibration.md section 3: 34 photographs per panel; white and dark or leak are shared.
TEST(PlanShots, AddsSinusoidsInPreciseMode) {
  const ShotList list = PlanShots(TwoLayers(), CalibrationMode::kPrecise);
  EXPECT_EQ(list.shots.size(), 10U + 4 * 32);
  EXPECT_EQ(list.shots[9].name, "010_layer0_modulator_u_0016_0");
  EXPECT_EQ(list.shots.back().name, "138_layer0_modulator_board_again");
  EXPECT_EQ(PatternFile(list.panels[0], list.shots[12].pattern), "phase_1920x1080_u_0016_3.png");
}

TEST(PlanShots, PutsNoBoardUnderLenses) {
  Calibration calibration = TwoLayers();
  calibration.layers[1].modulator.reset();
  calibration.layers[1].lattice = LensLattice{};
  const ShotList list = PlanShots(calibration, CalibrationMode::kQuick);
  EXPECT_EQ(list.panels.size(), 3U);
  EXPECT_FALSE(list.panels[2].board);
  calibration.layers.erase(calibration.layers.begin());
  EXPECT_THROW(PlanShots(calibration, CalibrationMode::kQuick), Error);
  const ShotList precise = PlanShots(calibration, CalibrationMode::kPrecise);
  EXPECT_EQ(precise.shots.size(), 2U + 32 + 1);
  EXPECT_EQ(precise.shots.back().name, "35_layer0_emitter_u_0016_0_again");
}

TEST(PlanShots, LeavesOutBoardsThatHaveNoRoom) {
  Calibration calibration = TwoLayers();
  calibration.layers.pop_back();
  calibration.layers[0].emitter.width_px = calibration.layers[0].modulator->width_px = 60;
  EXPECT_THROW(PlanShots(calibration, CalibrationMode::kQuick), Error);
  const ShotList list = PlanShots(calibration, CalibrationMode::kPrecise);
  EXPECT_FALSE(list.panels[0].board);
  // A period of 128 px is the coarsest that 60 px need.
  EXPECT_EQ(list.shots.size(), 3U + 2 * (12 + 16) + 1);
}

TEST(PlanShots, MeasuresLightAtTheFirstPositionInFull) {
  const ShotList list = PlanShots(TwoLayers(), CalibrationMode::kPhotometry);
  const auto named = [&](const std::string& name) {
    const auto shot = std::find_if(list.shots.begin(), list.shots.end(), [&](const auto& s) {
      return s.name.substr(s.name.find('_') + 1) == name;
    });
    EXPECT_NE(shot, list.shots.end()) << name;
    return *shot;
  };
  // Dark, and of each layer two boards and white; then dark twice, per layer 3 colours, both panels
  // mixed and 8 lines, per panel 16 levels but white, 7 of them again and 4 a third time.
  EXPECT_EQ(list.shots.size(), 1U + 2 * 3 + 2 + 2 * 12 + 4 * 27);
  EXPECT_EQ(list.shots[6].name, "007_layer1_white");
  EXPECT_FALSE(list.shots[6].first_position_only);
  EXPECT_TRUE(list.shots[7].first_position_only);
  EXPECT_EQ(named("dark_x64").exposure, 64);
  EXPECT_EQ(named("layer1_modulator_032_x8").pattern.color, (Rgb8{32, 32, 32}));
  const PatternShot level = named("layer1_modulator_032_x8");
  const std::vector<LayerPatterns> shown = ShownIn(level, 2);
  EXPECT_EQ(shown[0].emitter.kind, Pattern::Kind::kBlack);
  EXPECT_EQ(shown[1].emitter.kind, Pattern::Kind::kWhite);
  EXPECT_EQ(shown[1].modulator, level.pattern);
  EXPECT_EQ(PatternFile(list.panels[0], level.pattern), "flat_1920x1080_202020.png");
  const LayerPatterns lines = ShownIn(named("layer0_lines_3"), 2)[0];
  EXPECT_EQ(lines.emitter.step, 3);
  EXPECT_EQ(lines.modulator.step, kOpeningPx);
  EXPECT_EQ(PatternFile(list.panels[0], lines.modulator), "columns_1920x1080_8_4.png");
  EXPECT_EQ(ShownIn(named("layer0_emitter_red"), 2)[0].emitter.color, (Rgb8{255, 0, 0}));
  EXPECT_THAT(DescribeShots(list), HasSubstr("141 photographs from the first camera position, 7"));
  EXPECT_THAT(DescribeShots(list),
              HasSubstr("layer 0 emitter: code 48; its modulator white, exposed 64 times as long"));
  Calibration lenses = TwoLayers();
  for (LayerCalibration& layer : lenses.layers) {
    layer.modulator.reset();
    layer.lattice = LensLattice{};
  }
  try {
    PlanShots(lenses, CalibrationMode::kPhotometry);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("photograph one lit column without the lens sheet"));
  }
}

TEST(DescribeShots, SaysWhatEveryShotIs) {
  const std::string text = DescribeShots(PlanShots(TwoLayers(), CalibrationMode::kPrecise));
  EXPECT_THAT(text, HasSubstr("138 photographs"));
  EXPECT_THAT(text, HasSubstr("layer 1 emitter: board; its modulator white"));
  EXPECT_THAT(text, HasSubstr("sinusoid along v of 2048 px, step 4 of 4; its emitter white"));
}

TEST(DescribeShots, SaysHowManyPositionsLensesNeed) {
  Calibration calibration = TwoLayers();
  calibration.layers.pop_back();
  calibration.layers[0].modulator.reset();
  calibration.layers[0].lattice = LensLattice{LensLattice::Type::kLine, 2, 0.1, {0, 0}, 0};
  const std::string text = DescribeShots(PlanShots(calibration, CalibrationMode::kPrecise));
  EXPECT_THAT(text, HasSubstr("Positions: 2 and more"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("two rings")));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("modulator")));
}

TEST(ShotList, LightsAVarifocalDisplaysPlanesOneAtATime) {
  Display display;
  display.name = "planes";
  display.width_px = 104;
  display.height_px = 78;
  display.pitch_mm = 0.3;
  display.viewing_distance_mm = 400;
  display.varifocal = Varifocal{};
  display.varifocal->planes = 3;
  Layer layer;
  layer.optics = LensletArray{};
  display.layers = PlanesOf(*display.varifocal, layer);
  const ShotList list = PlanShots(DesignCalibration(display), CalibrationMode::kPrecise, true);
  EXPECT_TRUE(list.planes_in_turn);
  for (const PatternShot& shot : list.shots) {
    int lit = 0;
    for (const LayerPatterns& shown : ShownIn(shot, list.num_layers)) {
      lit += shown.emitter.kind != Pattern::Kind::kBlack ? 1 : 0;
    }
    EXPECT_EQ(lit, shot.kind == PatternShot::Kind::kDark ? 0 : 1) << shot.name;
  }
  const std::string text = DescribeShots(list);
  EXPECT_THAT(text,
              testing::HasSubstr("plane 2 lit alone: sinusoid along v of 16 px, step 8 of 8"));
  EXPECT_THAT(text, testing::HasSubstr("in the time slot of its plane alone"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("modulator")));
}

}  // namespace
}  // namespace lamella
