#include "pipeline/poses_record.h"

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "pipeline/poses/model.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

ViewSet SmallSet(const fs::path& folder) {
  ViewSet set;
  for (int i = 0; i < 3; ++i) {
    View view;
    view.name = "v" + std::to_string(i);
    view.image = i == 0 ? fs::path("/elsewhere/v0.jpg")
                        : folder / ("colmap/images/v" + std::to_string(i) + ".png");
    view.camera = {.width = 64, .height = 48, .fx = 50, .fy = 50.5, .cx = 32, .cy = 24};
    if (i == 2) view.camera.cx = 31;
    view.camera_from_world = {Eigen::Quaterniond(1, 0.1 * i, 0, 0).normalized(),
                              {-0.5 * i, 0, 0.25}};
    set.views.push_back(view);
  }
  set.points = {{{0.1, 0.2, 4}, {0, 2}}, {{-0.3, 0.1, 5}, {0, 1, 2}}};
  return set;
}

TEST(PosesRecord, IsReadBackAsItWasWritten) {
  const Workspace workspace(ScratchFolder());
  const fs::path folder = workspace.Stage("poses");
  const ViewSet set = SmallSet(folder);
  SaveViewSet(folder, set, {"gone"});
  const ViewSet back = LoadViewSet(workspace);
  ASSERT_EQ(back.views.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back.views[i].name, set.views[i].name);
    EXPECT_EQ(back.views[i].image, set.views[i].image);
    EXPECT_EQ(back.views[i].camera.cx, set.views[i].camera.cx);
    EXPECT_LT(
        (Centre(back.views[i].camera_from_world) - Centre(set.views[i].camera_from_world)).norm(),
        1e-12);
  }
  ASSERT_EQ(back.points.size(), 2U);
  EXPECT_EQ(back.points[0].position, set.points[0].position);
  EXPECT_EQ(back.points[0].views, (std::vector<int>{0, 2}));
  EXPECT_EQ(back.points[1].views, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(LoadLostViews(workspace), std::vector<std::string>{"gone"});
}

TEST(PosesRecord, MovesWithItsWorkspace) {
  const fs::path folder = ScratchFolder();
  SaveViewSet(folder / "a/poses", SmallSet(folder / "a/poses"), {});
  fs::rename(folder / "a", folder / "b");
  const ViewSet back = LoadViewSet(Workspace(folder / "b"));
  EXPECT_EQ(back.views[1].image, folder / "b/poses/colmap/images/v1.png");
  EXPECT_EQ(back.views[0].image, "/elsewhere/v0.jpg");
}

TEST(PosesRecord, IsAConsistentColmapModel) {
  const fs::path folder = ScratchFolder();
  SaveViewSet(folder, SmallSet(folder), {});
  const ColmapModel model = ReadColmapModel(folder / "colmap");
  EXPECT_EQ(model.cameras.size(), 2U);  // two views share one
  EXPECT_EQ(model.images.at(1).name, "v0.jpg");
  EXPECT_EQ(model.images.at(3).observations.size(), 2U);
  EXPECT_LT(ReprojectionErrorPx(model), 1e-9);
  for (const auto& [id, point] : model.points) {
    for (const ColmapTrackElement& element : point.track) {
      EXPECT_EQ(model.images.at(element.image_id).observations.at(element.observation).point_id,
                id);
    }
  }
}

TEST(PosesRecord, OfAnotherStageIsRefused) {
  EXPECT_THROW(LoadViewSet(Workspace(ScratchFolder())), Error);
}

}  // namespace
}  // namespace lamella
