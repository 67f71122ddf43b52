// Algorithm 2 against Algorithm 1: a scene's layers and those of a capture of it, of which nothing
// but the distribution and the display is shared.
#include "pipeline/synth_layers.h"

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/compare_layers.h"
#include "pipeline/layers_record.h"
#include "pipeline/pipeline.h"
#include "tests/pipeline/card_scene.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

// What makes the two algorithms comparable: the cameras span the eye box (from beyond them an eye
// sees of the wall what no camera saw), and a pixel of theirs is one of the panel, so that both
// worlds are band-limited alike.
constexpr CardScene kCards = {
    .views = 25, .width_px = 320, .height_px = 240, .wall_height = 8, .card_width = 0.9};

class SynthLayersTest : public testing::Test {
 protected:
  SynthLayersTest() : root_(ScratchFolder()) {
    WriteCards(kCards, root_);
    Display display = FindDisplay("paper-two-layer");
    display.width_px = 324;
    display.height_px = 240;
    WriteTextAtomically(root_ / "small.toml", ToToml(display));
    display.width_px = 96;
    display.height_px = 72;
    WriteTextAtomically(root_ / "tiny.toml", ToToml(display));
  }
  SynthLayersOptions Options() const {
    SynthLayersOptions options;
    options.scene = (root_ / "cards.toml").string();
    options.layers.display = (root_ / "small.toml").string();
    options.layers.placement.mm_per_view_px = 0.3113158871666749;
    return options;
  }
  Workspace Capture() const {
    PipelineOptions options;
    options.layers = Options().layers;
    return RunWithExactDepth(root_ / "cards.toml", "layers", options);
  }
  fs::path root_;
};

TEST_F(SynthLayersTest, AgreeWithThoseOfACaptureWithExactDepth) {
  const Workspace capture = Capture(), scene(root_ / "T");
  SynthLayersOptions options = Options();
  options.like = capture.root().string();
  SynthLayers(options, scene, SilentProgress());
  const LayersComparison comparison = CompareLayers(capture, scene, 12, SilentProgress());
  ASSERT_EQ(comparison.eyes.size(), 9U);
  for (const EyeDifference& eye : comparison.eyes)
    EXPECT_GE(*eye.metrics.psnr_db, 38) << eye.x_mm << " " << eye.y_mm;
}

TEST_F(SynthLayersTest, ArePlacedByWhatTheReferenceCameraSees) {
  SynthLayersOptions options = Options();
  options.layers.display = (root_ / "tiny.toml").string();
  SynthLayers(options, Workspace(root_ / "T"), SilentProgress());
  const LayersRecord record = LoadLayersRecord(Workspace(root_ / "T"));
  EXPECT_EQ(record.placement.reference_view, "view_013");
  EXPECT_NEAR(record.placement.near, 2.77, 0.05);  // the near card, 0.1 deep
  EXPECT_NEAR(record.placement.far, 5.45, 0.15);   // the tilted wall
  EXPECT_NEAR(record.seen_share, 1, 1e-6);         // the wall is behind all of it
}

TEST_F(SynthLayersTest, AreTheSameBytesForAnyNumberOfThreads) {
  std::string bytes[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    SynthLayersOptions options = Options();
    options.layers.scatter = true;
    options.layers.display = (root_ / "tiny.toml").string();
    SynthLayers(options, Workspace(root_ / "T"), SilentProgress());
    bytes[threads - 1] = ReadText(root_ / "T" / "layers" / EmitterFile(1, 4));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(SynthLayersTest, RefuseWhatDoesNotExist) {
  SynthLayersOptions options = Options();
  options.like = (root_ / "nowhere").string();
  EXPECT_THROW(SynthLayers(options, Workspace(root_ / "T"), SilentProgress()), Error);
  options = Options();
  options.scene = "rom";
  try {
    SynthLayers(options, Workspace(root_ / "T"), SilentProgress());
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("room"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lamella
