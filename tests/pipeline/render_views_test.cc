#include "pipeline/render_views.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/capture_source.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"
#include "tests/depth/analytic_scene.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing_scene::PinholeOf;
using testing_scene::PlaneScene;
using testing_scene::PoseAt;

// A workspace whose stages poses and depth left the truth of a scene; and cameras between its
// views.
class RenderViewsTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("render_views_" +
             std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
    for (const char* folder : {"photos", "W/poses", "W/depth", "between"}) {
      fs::create_directories(root_ / folder);
    }
    ViewSet inputs, between;
    for (int i = 0; i < 4; ++i) {
      inputs.views.push_back(Add("view" + std::to_string(i), {0.3 * i - 0.45, 0.02 * i, 0}));
    }
    between.views.push_back(Add("between0", {-0.3, 0.01, 0}));
    between.views.push_back(Add("between1", {0.3, 0.05, 0}));
    SaveViewSet(root_ / "W/poses", inputs, {});
    SaveViewSet(root_ / "between", between, {});
  }
  void TearDown() override { fs::remove_all(root_); }

  // Photographs of twice the rendered size, and depth of the rendered size.
  View Add(const std::string& name, const Eigen::Vector3d& centre) const {
    const PlaneScene scene = testing_scene::TwoPlanes();
    DepthView truth = scene.Capture(PinholeOf(240, 160, 220), PoseAt(centre));
    truth.view.name = name;
    truth.view.image = root_ / "photos" / (name + ".png");
    WriteSrgb8(truth.view.image, truth.color.span());
    DepthView small = scene.Capture(PinholeOf(120, 80, 110), PoseAt(centre));
    SaveDepthMap(root_ / "W/depth" / (name + ".exr"), small.depth);
    return truth.view;
  }

  ViewsArguments Arguments() const {
    ViewsArguments arguments;
    arguments.workspace = root_ / "W";
    arguments.cameras = root_ / "between" / "transforms.json";
    arguments.out = root_ / "out";
    arguments.border_px = 10;
    return arguments;
  }
  fs::path root_;
};

TEST_F(RenderViewsTest, RendersTheChosenCamerasAndComparesThemWithTheirPhotographs) {
  const std::vector<RenderedView> views = RenderViews(Arguments(), SilentProgress());
  ASSERT_EQ(views.size(), 2U);
  for (const RenderedView& view : views) {
    EXPECT_GT(view.seen, 0.9);
    ASSERT_TRUE(view.psnr && view.psnr_seen && view.psnr_seen_gain);
    EXPECT_GT(*view.psnr_seen, 33) << view.name;  // edges of depth are known to half a pixel only
    EXPECT_GE(*view.psnr_seen_gain, *view.psnr_seen - 0.05);
    const fs::path file = root_ / "out" / (view.name + ".png");
    const Image<Rgb8> picture = ReadSrgb8(file);
    EXPECT_EQ(picture.width(), 240);
    EXPECT_EQ(picture.height(), 160);
    EXPECT_FALSE(ReadAlpha(file).empty());
  }
}

TEST_F(RenderViewsTest, RendersAndComparesAtAnotherSize) {
  ViewsArguments arguments = Arguments();
  arguments.views = "between1";
  arguments.size_px = 120;
  const std::vector<RenderedView> views = RenderViews(arguments, SilentProgress());
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(ReadSrgb8(root_ / "out/between1.png").height(), 80);
  EXPECT_GT(*views[0].psnr_seen, 33);
}

TEST_F(RenderViewsTest, TakesPhotographsFromAnotherFolder) {
  ViewsArguments arguments = Arguments();
  fs::rename(root_ / "photos/between0.png", root_ / "between/between0.png");
  fs::remove(root_ / "photos/between1.png");
  arguments.images = root_ / "between";
  const std::vector<RenderedView> views = RenderViews(arguments, SilentProgress());
  EXPECT_TRUE(views[0].psnr.has_value());
  EXPECT_FALSE(views[1].psnr.has_value());
}

TEST_F(RenderViewsTest, RefusesUnknownNamesAndAbsentDepth) {
  ViewsArguments arguments = Arguments();
  arguments.views = "nothing_like_it";
  EXPECT_THROW(RenderViews(arguments, SilentProgress()), Error);
  arguments.views = "";
  fs::remove(root_ / "W/depth/view2.exr");
  try {
    RenderViews(arguments, SilentProgress());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_NE(std::string(error.what()).find("view2"), std::string::npos);
  }
}

}  // namespace
}  // namespace lamella
