#include "pipeline/analysis_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/analysis_figure.h"
#include "pipeline/analysis_table.h"
#include "pipeline/json_file.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Analysis Of(const Display& display) { return Analyze(display, DepthsWorthALook(display)); }

SceneAnalysis Scene(const Analysis& analysis) {
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
  WriteTextAtomically(path, AnalysisJson(display, analysis, Scene(analysis)));
  const JsonObject json(path);
  json.CheckFormatVersion(1);
  EXPECT_EQ(json.Text("display"), "paper-two-layer");
  EXPECT_EQ(json.Number("rays"), 2.0 * 1920 * 1080 * 9);
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
  const std::string scene = AnalysisFigure(display, analysis, Scene(analysis));
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

}  // namespace
}  // namespace lamella
