#include "pipeline/analysis_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/analysis_figure.h"
#include "pipeline/analysis_table.h"
#include "pipeline/depth_record.h"
#include "pipeline/json_file.h"
#include "pipeline/layers_record.h"
#include "pipeline/poses_record.h"
#include "tests/depth/analytic_scene.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Analysis Of(const Display& display) { return Analyze(display, DepthsWorthALook(display)); }

SceneAnalysis AnalysedScene(const Analysis& analysis) {
  SceneAnalysis scene{"middle", "paper-two-layer", 600, {}};
  scene.figures.edges_mm = {analysis.depths_mm.front(), 0, analysis.depths_mm.back()};
  scene.figures.share = {0.25, 0.5};
  scene.figures.share_behind = 0.25;
  scene.figures.detail_kept = 0.5;
  return scene;
}

TEST(AnalysisJson, HasTheFieldsOfItsDescription) {
  const Display display = FindDisplay("paper-two-layer");
  const Analysis analysis = Of(display);
  const auto path = ScratchFolder() / "analysis.json";
  WriteTextAtomically(path, AnalysisJson(display, analysis, AnalysedScene(analysis)));
  const JsonObject json(path);
  json.CheckFormatVersion(1);
  EXPECT_EQ(json.Text("display"), "paper-two-layer");
  EXPECT_EQ(json.Number("rays"), 2.0 * 1920 * 1080 * 9);
  EXPECT_EQ(json.Number("bits"), 2.0 * 1920 * 1080 * 24 * 9);
  EXPECT_NEAR(json.Number("light_efficiency"), 1.0 / 18, 1e-12);
  const std::vector<JsonObject> layers = json.Objects("layers");
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_NEAR(layers[1].Number("field_of_view_deg"), 21.16065183, 1e-7);
  EXPECT_NEAR(layers[1].Object("clean_eye_box_mm").Number("x"), 55.1, 0.01);
  EXPECT_EQ(json.Object("rays_ratio").Number("to_one_layer"), *analysis.rays_to_one_layer);
  EXPECT_EQ(json.Object("rays_ratio").Number("full_parallax"), 0.5);
  EXPECT_EQ(json.Object("rays_ratio").Number("horizontal_parallax"), 1);
  const std::size_t depths = analysis.depths_mm.size();
  EXPECT_EQ(json.Numbers("depths_mm", depths), analysis.depths_mm);
  EXPECT_EQ(json.Object("cutoff_per_mm").Numbers("combined", depths), analysis.combined);
  EXPECT_EQ(json.Object("cutoff_per_mm").Numbers("layers", 2 * depths).size(), 2 * depths);
  EXPECT_EQ(json.Object("mtf").Object("paper").Numbers("fixed_eye", 3 * depths).size(), 3 * depths);
  EXPECT_EQ(json.Object("scene").Number("detail_kept"), 0.5);
  EXPECT_EQ(json.Object("scene").Object("histogram").Numbers("share", 2),
            (std::vector<double>{0.25, 0.5}));
}

TEST(AnalysisFigure, NamesAxesAndUnitsAndEscapesNames) {
  Display display = FindDisplay("paper-two-layer");
  display.name = "<mine> & yours";
  const Analysis analysis = Of(display);
  const std::string plain = AnalysisFigure(display, analysis, std::nullopt);
  EXPECT_THAT(plain, HasSubstr("&lt;mine&gt; &amp; yours"));
  EXPECT_THAT(plain, HasSubstr("cut-off, cycles/mm"));
  EXPECT_THAT(plain, HasSubstr("depth z, mm"));
  EXPECT_THAT(plain, Not(HasSubstr("pixels, %")));
  EXPECT_THAT(plain, Not(HasSubstr("nan")));
  const std::string scene = AnalysisFigure(display, analysis, AnalysedScene(analysis));
  EXPECT_THAT(scene, HasSubstr("pixels, %"));
  EXPECT_THAT(scene, HasSubstr("50.0 % of its detail"));
}

TEST(AnalysisTable, SaysWhatTheDisplayIs) {
  for (const std::string& name : DisplayNames()) {
    const Display display = FindDisplay(name);
    EXPECT_THAT(AnalysisTable(display, Of(display), std::nullopt), HasSubstr(name));
  }
}

TEST(SceneDepths, RefusesAWorkspaceWithoutLayers) {
  const Workspace workspace(ScratchFolder());
  EXPECT_THROW(SceneDepths(workspace), Error);
}

// A capture of one view and its placement for a display: all that the scene's analysis reads.
Workspace PlacedFor(const Display& display, const std::filesystem::path& root) {
  Workspace workspace(root / "W");
  for (const char* stage : {"poses", "depth", "layers"}) CreateFolder(workspace.Stage(stage));
  testing_scene::TexturedRectangle wall;
  wall.centre = {0, 0, 9};
  wall.wavelength = 0.4;
  DepthView truth = testing_scene::PlaneScene({wall}).Capture(testing_scene::PinholeOf(96, 96, 100),
                                                              testing_scene::PoseAt({0, 0, 0}));
  truth.view.name = "middle";
  truth.view.image = root / "middle.png";
  WriteSrgb8(truth.view.image, truth.color.span());
  SaveDepthMap(workspace.Stage("depth") / "middle.exr", truth.depth);
  ViewSet set;
  set.views.push_back(truth.view);
  SaveViewSet(workspace.Stage("poses"), set, {});
  LayersRecord record;
  record.display = display;
  record.placement = Place(truth.view, 7, 9.5, display, {}, nullptr);
  SaveLayersRecord(workspace.Stage("layers"), record);
  return workspace;
}

TEST(AnalyzeWorkspace, TakesTheLayersOfAnyDisplay) {
  Display lenticular = FindDisplay("paper-one-layer");
  lenticular.name = "lenticular";
  lenticular.layers[0].optics = Lenticular{};
  const std::filesystem::path root = ScratchFolder();
  for (const Display& made_for :
       {FindDisplay("paper-two-layer"), FindDisplay("paper-varifocal"), lenticular}) {
    const Workspace workspace = PlacedFor(made_for, root / made_for.name);
    const Placement placement = LoadLayersRecord(workspace).placement;
    const DepthInterval depths = SceneDepths(workspace);
    EXPECT_DOUBLE_EQ(depths.from_mm, placement.far_mm);
    EXPECT_DOUBLE_EQ(depths.to_mm, placement.near_mm);
    for (const Display& display : {FindDisplay("paper-varifocal"), lenticular}) {
      const SceneAnalysis scene = AnalyzeWorkspace(workspace, display, Of(display));
      EXPECT_EQ(scene.placed_for, made_for.name);
      EXPECT_DOUBLE_EQ(scene.figures.known_share, 1);
      // The wall alone is seen: all of it at one depth.
      EXPECT_NEAR(scene.figures.near_mm, placement.ZFromDepth(9), 1e-3);
      EXPECT_NEAR(scene.figures.far_mm, placement.ZFromDepth(9), 1e-3);
      ASSERT_TRUE(scene.figures.detail_kept);
      EXPECT_GE(*scene.figures.detail_kept, 0);
      EXPECT_LE(*scene.figures.detail_kept, 1 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace lamella
