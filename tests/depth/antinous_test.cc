// The grid method on a rendered light field with true disparity (HCI benchmark, scene antinous). It
// runs where LAMELLA_DATA names the folder of test data.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "depth/grid_depth.h"
#include "depth/grid_fusion.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace {

constexpr int kSide = 9, kCentre = 40, kUnscored = 15;

class Antinous : public testing::Test {
 protected:
  void SetUp() override {
    const char* place = std::getenv("LAMELLA_DATA");
    if (place == nullptr || *place == '\0') GTEST_SKIP() << "LAMELLA_DATA is not set";
    folder_ = std::filesystem::path(place) / "lightfield" / "hci_antinous";
    for (int i = 0; i < kSide * kSide; ++i) {
      View view;
      view.camera.width = view.camera.height = 512;
      view.grid = GridPosition{i / kSide, i % kSide};
      views_.push_back(view);
    }
    labels_ = ChooseGridLabels(
        views_, [&](int v) { return Photograph(v).Clone(); }, options_, memory_);
  }

  const Image<Rgb8>& Photograph(int v) {
    Image<Rgb8>& image = photographs_[v];
    if (image.empty()) image = ReadSrgb8(folder_ / fmt::format("input_Cam{:03}.png", v));
    return image;
  }

  DisparityMap Match(int v) {
    const auto planes = [&](int view) {
      std::shared_ptr<const GridImage>& slot = planes_[view];
      if (!slot) slot = std::make_shared<const GridImage>(Photograph(view).span(), options_.color);
      return slot;
    };
    const GridArms arms = ChooseGridArms(views_, v, options_.reach, options_.per_arm);
    return EstimateGridView(views_, v, arms, planes, Photograph(v).span(), labels_, options_,
                            memory_);
  }

  // Per cent of the centre view's pixels that are wrong by more than 0.07 px.
  double BadPix(const DisparityMap& map) const {
    const Image<float> truth = ReadPfm(folder_ / "gt_disp_lowres.pfm");
    double bad = 0, pixels = 0;
    for (int y = kUnscored; y < truth.height() - kUnscored; ++y) {
      for (int x = kUnscored; x < truth.width() - kUnscored; ++x, ++pixels) {
        bad += std::abs(map.disparity(x, y) - truth(x, y)) > 0.07F ? 1 : 0;
      }
    }
    return 100 * bad / pixels;
  }

  std::filesystem::path folder_;
  std::vector<View> views_;
  GridOptions options_;
  MatchMemory memory_;
  DisparityLabels labels_;
  std::map<int, Image<Rgb8>> photographs_;
  std::map<int, std::shared_ptr<const GridImage>> planes_;
};

TEST_F(Antinous, RangeOfDisparitiesIsFoundWithoutBeingTold) {
  EXPECT_NEAR(labels_.first, -3.131, 0.4);
  EXPECT_NEAR(labels_.Disparity(labels_.count - 1), 2.689, 0.4);
}

TEST_F(Antinous, CentreViewIsGoodBeforeAndBetterAfterFusion) {
  const DisparityMap own = Match(kCentre);
  const double before = BadPix(own);
  EXPECT_LT(before, 3.6);
  std::vector<DisparityMap> maps;
  std::vector<GridNeighbour> neighbours;
  const std::vector<int> others = ChooseFusionViews(views_, kCentre, options_.reach);
  ASSERT_EQ(others.size(), 8U);
  maps.reserve(others.size());
  for (const int v : others) {
    maps.push_back(Match(v));
    neighbours.push_back({&maps.back(), v % kSide - kCentre % kSide, v / kSide - kCentre / kSide});
  }
  const double after = BadPix(FuseGridView(own, neighbours, {0.15, 0.075}));
  EXPECT_LT(after, 3.0);
  EXPECT_LT(after, before);
}

}  // namespace
}  // namespace lamella
