#include "pipeline/compare_depth.h"

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"
#include "tests/depth/synthetic.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(CompareDisparity, CountsByTheBenchmarksRule) {
  Image<float> truth(40, 50, 1.0F), estimate(40, 50, 1.0F);
  // 10 x 20 pixels are inside of the border of 15.
  estimate(15, 15) = 1.08F;  // bad for all three limits
  estimate(16, 15) = 0.95F;  // for 0.03 and 0.01
  estimate(24, 34) = 1.02F;  // for 0.01
  estimate(3, 3) = 99;       // in the border
  const DepthComparison r = CompareDisparity(estimate.span(), truth.span());
  EXPECT_EQ(r.pixels, 200);
  EXPECT_EQ(r.unknown, 0);
  EXPECT_DOUBLE_EQ(r.bad_07, 0.5);
  EXPECT_DOUBLE_EQ(r.bad_03, 1.0);
  EXPECT_DOUBLE_EQ(r.bad_01, 1.5);
  EXPECT_NEAR(r.mse_x100, 100 * (0.08 * 0.08 + 0.05 * 0.05 + 0.02 * 0.02) / 200, 1e-7);
}

TEST(CompareDisparity, CountsUnknownAsBadAndLeavesOutWhereTheTruthIsUnknown) {
  Image<float> truth(40, 50, 1.0F), estimate(40, 50, 1.0F);
  estimate(15, 15) = kNaN;
  estimate(16, 15) = 5;
  truth(16, 15) = std::numeric_limits<float>::infinity();
  const DepthComparison r = CompareDisparity(estimate.span(), truth.span());
  EXPECT_EQ(r.pixels, 199);
  EXPECT_EQ(r.unknown, 1);
  EXPECT_DOUBLE_EQ(r.bad_07, 100.0 / 199);
  EXPECT_EQ(r.mse_x100, 0);
}

TEST(CompareDisparity, RefusesMapsOfDifferentSizes) {
  const Image<float> a(40, 50), b(50, 40);
  EXPECT_THROW(CompareDisparity(a.span(), b.span()), Error);
}

void WritePfm(const std::filesystem::path& path, const Image<float>& image) {
  std::ofstream file(path, std::ios::binary);
  file << "Pf\n" << image.width() << " " << image.height() << "\n-1\n";
  for (int y = image.height() - 1; y >= 0; --y) {
    file.write(std::bit_cast<const char*>(image.row(y)),
               static_cast<std::streamsize>(sizeof(float)) * image.width());
  }
}

TEST(CompareDepth, TakesTheGridsNumbersFromTheWorkspace) {
  const Workspace workspace(ScratchFolder());
  ViewSet set;
  set.views = synthetic::MakeGrid(3, 3, 40, 60, 0.2, 9);
  CreateFolder(workspace.Stage("poses"));
  CreateFolder(workspace.Stage("depth"));
  for (View& view : set.views) view.image = workspace.Stage("poses") / (view.name + ".png");
  SaveViewSet(workspace.Stage("poses"), set, {});
  // d = B f (1/Z - 1/9) = 12 (1/Z - 1/9)
  DepthMap map{Image<float>(40, 40, 6.0F), Image<float>(40, 40, 1.0F)};
  map.depth(20, 20) = std::numeric_limits<float>::infinity();
  map.depth(21, 20) = 0;
  SaveDepthMap(workspace.Stage("depth") / "view104.exr", map);
  Image<float> truth(40, 40, 12.0F / 6 - 12.0F / 9);
  truth(20, 20) = -12.0F / 9;
  WritePfm(workspace.root() / "truth.pfm", truth);
  const DepthComparison r =
      CompareDepth(workspace.Stage("depth") / "view104.exr", workspace.root() / "truth.pfm");
  EXPECT_EQ(r.pixels, 100);
  EXPECT_EQ(r.unknown, 1);
  EXPECT_DOUBLE_EQ(r.bad_01, 1);
  EXPECT_LT(r.mse_x100, 1e-6);
}

Image<float> Depths(int width, int height, float depth) { return {width, height, depth}; }

DepthMap Sure(float depth) { return {Depths(4, 4, depth), Depths(4, 4, 1)}; }

TEST(CompareWorldDepth, CountsRelativeErrorsOfKnownPixels) {
  DepthPair pair{Depths(4, 2, 10), Depths(4, 2, 10)};
  pair.estimate(0, 0) = 0;      // unknown
  pair.estimate(1, 0) = 10.5F;  // 5 %
  pair.truth(2, 0) = 0;         // not compared
  pair.truth(3, 0) = std::numeric_limits<float>::infinity();
  const WorldDepthComparison r = CompareWorldDepth(std::span(&pair, 1));
  EXPECT_EQ(r.pixels, 7);
  EXPECT_EQ(r.known, 6);
  EXPECT_EQ(r.median, 0);
  EXPECT_DOUBLE_EQ(r.within_1, 100.0 * 4 / 6);
  EXPECT_DOUBLE_EQ(r.within_1_of_all, 100.0 * 4 / 7);
  EXPECT_EQ(CompareWorldDepth({}).pixels, 0);
}

TEST(CompareWorldDepth, TakesASmallerEstimateAtItsPixelsCentres) {
  DepthPair pair{Depths(2, 1, 10), Depths(6, 3, 99)};
  pair.truth(1, 1) = 10;
  pair.truth(4, 1) = 10;
  EXPECT_EQ(CompareWorldDepth(std::span(&pair, 1)).p90, 0);
  pair.truth = Depths(3, 6, 10);
  EXPECT_THROW(CompareWorldDepth(std::span(&pair, 1)), Error);
}

TEST(CompareWorldDepth, MatchesTheFilesOfTwoFoldersByName) {
  const std::filesystem::path root = ScratchFolder();
  for (const char* name : {"a", "b"}) CreateFolder(root / name);
  SaveDepthMap(root / "a/1.exr", Sure(2));
  SaveDepthMap(root / "a/2.exr", Sure(2));
  std::vector<Channel> truth;
  truth.push_back({"Z", Depths(4, 4, 2.2F)});
  WriteExr(root / "b/2.exr", truth, ExrType::kFloat);
  const WorldDepthComparison r = CompareWorldDepth(root / "a", root / "b");
  EXPECT_EQ(r.maps, 1);
  EXPECT_EQ(r.only_estimate, std::vector<std::string>{"1.exr"});
  EXPECT_TRUE(r.only_truth.empty());
  EXPECT_EQ(r.pixels, 16);
  EXPECT_NEAR(r.median, 100 / 11.0, 1e-4);
  EXPECT_EQ(CompareWorldDepth(root / "a/1.exr", root / "a/2.exr").within_1, 100);
  std::filesystem::remove(root / "a/2.exr");
  EXPECT_THROW(CompareWorldDepth(root / "a", root / "b"), Error);
}

}  // namespace
}  // namespace lamella
