// Poses of real photographs. Minutes: they run where LAMELLA_DATA names the folder of test data.
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

#include <gtest/gtest.h>

#include "lightfield/parallel.h"
#include "pipeline/capture/known_cameras.h"
#include "pipeline/compare_poses.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

class RealPoses : public testing::Test {
 protected:
  void SetUp() override {
    const char* place = std::getenv("LAMELLA_DATA");
    if (place == nullptr || *place == '\0') GTEST_SKIP() << "LAMELLA_DATA is not set";
    data_ = place;
  }

  // The views of data/`photographs`; their files' contents in `contents`.
  ViewSet Run(const std::string& photographs, Quality quality, int threads,
              std::map<std::string, std::string>* contents = nullptr) {
    const ThreadLimit limit(threads);
    const Workspace workspace(ScratchFolder());
    CaptureOptions capture;
    capture.input = (data_ / photographs).string();
    PosesOptions poses;
    ApplyQuality(quality, poses);
    StageRun captured(workspace, "capture", "", "");
    captured.Commit(RunCapture(workspace, capture, captured, SilentProgress()), 0, 0);
    StageRun posed(workspace, "poses", "", "");
    posed.Commit(RunPoses(workspace, poses, posed, SilentProgress()), 0, 0);
    for (const auto& entry : fs::recursive_directory_iterator(workspace.Stage("poses"))) {
      if (contents == nullptr || !entry.is_regular_file()) continue;
      std::ifstream file(entry.path(), std::ios::binary);
      (*contents)[fs::relative(entry.path(), workspace.root()).string()] = {
          std::istreambuf_iterator<char>(file), {}};
    }
    EXPECT_TRUE(LoadLostViews(workspace).empty());
    return LoadViewSet(workspace);
  }

  fs::path data_;
};

TEST_F(RealPoses, OfTheCastleAreAllFound) {
  EXPECT_EQ(Run("handheld/sceaux_castle/images", Quality::kDraft, 0).views.size(), 11U);
}

TEST_F(RealPoses, OfTheFountainAreWithin8MillimetresAndTheSameBytesForOneThreadAndTwo) {
  const std::vector<View> truth =
      ReadKnownCameras(data_ / "handheld_gt/fountain-P11/gt_dense_cameras");
  std::map<std::string, std::string> one, two;
  const ViewSet set = Run("handheld_gt/fountain-P11/images", Quality::kBalanced, 1, &one);
  Run("handheld_gt/fountain-P11/images", Quality::kBalanced, 2, &two);
  ASSERT_EQ(set.views.size(), 11U);
  const PoseComparison comparison = ComparePoses(set.views, truth);
  RecordProperty("centre_rmse_m", std::to_string(comparison.rmse));
  EXPECT_LT(comparison.rmse, 0.008);
  EXPECT_TRUE(one == two);
}

}  // namespace
}  // namespace lamella
