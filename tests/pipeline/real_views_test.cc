// Views of a real capture that were left out, rendered from the others. They run where LAMELLA_DATA
// names the folder of test data.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/metrics.h"
#include "lightfield/image_io.h"
#include "lightfield/ray_source.h"
#include "pipeline/capture/known_cameras.h"
#include "pipeline/capture_source.h"
#include "pipeline/stages.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

constexpr int kBorder = 15;  // px

// Every fourth row and column of the 9x9 grid, with depth from these nine alone.
class RealViews : public testing::Test {
 protected:
  void SetUp() override {
    const char* place = std::getenv("LAMELLA_DATA");
    if (place == nullptr || *place == '\0') GTEST_SKIP() << "LAMELLA_DATA is not set";
    grid_ = fs::path(place) / "lightfield" / "hci_antinous";
    scratch_ = ScratchFolder();
    const Workspace workspace(scratch_);
    CaptureOptions capture;
    capture.input = grid_.string();
    for (const View& view : ReadKnownCameras(grid_)) {
      const bool input = view.grid->row % 4 == 0 && view.grid->column % 4 == 0;
      if (input) capture.views += (capture.views.empty() ? "" : ",") + view.name;
      cameras_.push_back(view);
    }
    StageRun captured(workspace, "capture", "", "");
    captured.Commit(RunCapture(workspace, capture, captured, SilentProgress()), 0, 0);
    StageRun posed(workspace, "poses", "", "");
    posed.Commit(RunPoses(workspace, {}, posed, SilentProgress()), 0, 0);
    StageRun deep(workspace, "depth", "", "");
    deep.Commit(RunDepth(workspace, {}, deep, SilentProgress()), 0, 0);
    source_ = LoadCaptureSource(workspace, {}, SilentProgress());
  }

  void TearDown() override { fs::remove_all(scratch_); }

  const View& At(int row, int column) const {
    const int view = 9 * row + column;
    return cameras_[static_cast<std::size_t>(view)];
  }

  // PSNR of what is rendered at `place` against the photograph of `photograph`.
  double Rendered(const View& place, const View& photograph) const {
    const RayBundle bundle = BundleOfCamera(place.camera, place.camera_from_world);
    Image<RaySample> samples(bundle.width, bundle.height);
    source_->Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
    Image<Rgb> color(bundle.width, bundle.height);
    for (std::size_t i = 0; i < color.size(); ++i) color.data()[i] = samples.data()[i].color;
    const Image<Rgb8> truth = ReadSrgb8(grid_ / (photograph.name + ".png"));
    return *Psnr(EncodeSrgb8(color.span()).span(), truth.span(), {kBorder, {}});
  }

  fs::path grid_, scratch_;
  std::vector<View> cameras_;
  std::unique_ptr<RaySource> source_;
};

TEST_F(RealViews, LeftOutAreRenderedWith48Decibels) {
  double sum = 0;
  int count = 0;
  for (int row = 0; row < 9; ++row) {
    for (int column = row % 3; column < 9; column += 3) {
      if (row % 4 == 0 && column % 4 == 0) continue;
      const double psnr = Rendered(At(row, column), At(row, column));
      EXPECT_GT(psnr, 45) << At(row, column).name;
      sum += psnr;
      ++count;
    }
  }
  EXPECT_GT(sum / count, 48);
}

TEST_F(RealViews, TheParallaxHasItsSign) {
  for (const int step : {1, 2, 3}) {
    EXPECT_GT(Rendered(At(4, 4 + step), At(4, 4 + step)), 42);
    EXPECT_LT(Rendered(At(4, 4 - step), At(4, 4 + step)), 31);
    EXPECT_GT(Rendered(At(4 + step, 4), At(4 + step, 4)), 42);
    EXPECT_LT(Rendered(At(4 - step, 4), At(4 + step, 4)), 31);
  }
}

}  // namespace
}  // namespace lamella
