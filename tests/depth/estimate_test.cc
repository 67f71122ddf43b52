#include "depth/estimate.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "tests/depth/memory_store.h"
#include "tests/depth/synthetic.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

struct Rendered {
  ViewSet set;
  std::vector<Image<Rgb8>> images;
  std::vector<Image<float>> truth;
  MemoryStore Store() const {
    std::vector<Image<Rgb8>> copies;
    for (const Image<Rgb8>& image : images) copies.push_back(image.Clone());
    return MemoryStore(std::move(copies));
  }
};

Rendered RenderViews(const std::vector<synthetic::Panel>& panels, std::vector<View> views) {
  Rendered rendered;
  rendered.set.views = std::move(views);
  for (const View& view : rendered.set.views) {
    synthetic::Picture picture = synthetic::Render(panels, view.camera, view.camera_from_world);
    rendered.images.push_back(std::move(picture.image));
    rendered.truth.push_back(std::move(picture.depth));
  }
  return rendered;
}

// A slanted wall behind a card, from the middle of a 5x5 grid: |disparity| up to about 2 px.
std::vector<synthetic::Panel> WallAndCard() {
  const Vector3d u = Vector3d(1, 0, 0.25).normalized(), v = Vector3d(0, 1, 0.1).normalized();
  return {{{0, 0, 12}, u, v, 40, 40, 0.35, 1, true},
          {{0.2, 0.1, 7}, {1, 0, 0}, {0, 1, 0}, 1.2, 1, 0.2, 2, true}};
}

const Rendered& Grid() {
  static const Rendered grid =
      RenderViews(WallAndCard(), synthetic::MakeGrid(5, 5, 96, 120, 0.25, 9));
  return grid;
}

// Five photographs on an arc of 8 degree steps.
std::vector<View> ArcViews(int count, const Vector3d& offset = Vector3d::Zero()) {
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    const double a = (i - (count - 1) / 2.0) * 0.14;
    View view;
    view.name = "p" + std::to_string(i);
    view.camera = synthetic::Pinhole(160, 120, 170);
    const Vector3d target(0, 0, 9);
    view.camera_from_world = synthetic::LookAt(
        offset + target + 9 * Vector3d(std::sin(a), 0.02 * i, -std::cos(a)), offset + target);
    views.push_back(view);
  }
  return views;
}
const Rendered& Arc() {
  static const Rendered arc = RenderViews(WallAndCard(), ArcViews(5));
  return arc;
}

DepthOptions Preset(Quality quality) {
  DepthOptions options;
  ApplyQuality(quality, options);
  return options;
}

struct Score {
  double known = 0, bad = 0;  // shares: of all pixels; of known ones
  double median = 0;          // of |error| of known ones
};

// Inverse depth times `scale` against the truth; bad beyond `limit`.
Score Compare(const DepthMap& map, const Image<float>& truth, double scale, double limit,
              int border = 6) {
  Score score;
  std::vector<double> errors;
  double pixels = 0;
  for (int y = border; y < truth.height() - border; ++y) {
    for (int x = border; x < truth.width() - border; ++x, ++pixels) {
      const float z = map.depth(x, y);
      if (!(z > 0)) continue;
      errors.push_back(
          scale * std::abs(1.0 / static_cast<double>(z) - 1.0 / static_cast<double>(truth(x, y))));
      if (errors.back() > limit) score.bad += 1;
    }
  }
  if (errors.empty()) return score;
  score.bad /= static_cast<double>(errors.size());
  score.known = static_cast<double>(errors.size()) / pixels;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  score.median = errors[errors.size() / 2];
  return score;
}

// What every result must keep, whatever went in.
void ExpectSound(const Rendered& input, MemoryStore& store, int last_pass) {
  for (std::size_t v = 0; v < input.set.views.size(); ++v) {
    const DepthMap& map = store.maps.at({last_pass, static_cast<int>(v)});
    ASSERT_EQ(map.depth.size(), map.confidence.size());
    for (std::size_t i = 0; i < map.depth.size(); ++i) {
      const float z = map.depth.data()[i], c = map.confidence.data()[i];
      ASSERT_TRUE(z >= 0 && c >= 0 && c <= 1) << z << " " << c;
      ASSERT_TRUE(z > 0 || c == 0);
    }
  }
}

MemoryStore Estimate(const Rendered& input, const DepthOptions& options) {
  MemoryStore store = input.Store();
  EstimateDepth(input.set, options, store, SilentProgress());
  ExpectSound(input, store, NumDepthPasses(input.set, options) - 1);
  return store;
}

TEST(EstimateDepth, FindsAGridsSurfacesInEveryPreset) {
  const RegularGrid grid = *FindRegularGrid(Grid().set.views);
  for (const Quality quality : {Quality::kDraft, Quality::kBalanced, Quality::kBest}) {
    const DepthOptions options = Preset(quality);
    MemoryStore store = Estimate(Grid(), options);
    for (const int view : {0, 12, 24}) {
      const DepthMap& map = store.maps.at({NumDepthPasses(Grid().set, options) - 1, view});
      const Score score = Compare(map, Grid().truth[static_cast<std::size_t>(view)],
                                  grid.disparity_per_inverse_depth, 0.15);
      EXPECT_EQ(score.known, 1) << "a grid's pixels all have a value";
      EXPECT_LT(score.median, quality == Quality::kDraft ? 0.03 : 0.02) << view;
      EXPECT_LT(score.bad, 0.06) << view;
    }
  }
}

TEST(EstimateDepth, FindsPhotographsSurfacesAndLeavesTheRestUnknown) {
  for (const Quality quality : {Quality::kDraft, Quality::kBalanced, Quality::kBest}) {
    MemoryStore store = Estimate(Arc(), Preset(quality));
    for (const int view : {0, 2, 4}) {
      // A view's parallax to its neighbour is about 170 px * 1.26 / Z.
      const Score score =
          Compare(store.maps.at({1, view}), Arc().truth[static_cast<std::size_t>(view)], 214, 1);
      EXPECT_GT(score.known, 0.6) << view;
      EXPECT_LT(score.median, 0.3) << view;
      EXPECT_LT(score.bad, 0.05) << view;
    }
  }
}

TEST(EstimateDepth, DoesNotDependOnThreads) {
  for (const Rendered* input : {&Grid(), &Arc()}) {
    const DepthOptions options = Preset(Quality::kBalanced);
    std::vector<MemoryStore> stores;
    for (const int threads : {1, 2, 3}) {
      const ThreadLimit limit(threads);
      stores.push_back(Estimate(*input, options));
    }
    for (const auto& [key, map] : stores[0].maps) {
      for (std::size_t s = 1; s < stores.size(); ++s) {
        const DepthMap& other = stores[s].maps.at(key);
        ASSERT_TRUE(
            std::equal(map.depth.data(), map.depth.data() + map.depth.size(), other.depth.data()));
        ASSERT_TRUE(std::equal(map.confidence.data(), map.confidence.data() + map.confidence.size(),
                               other.confidence.data()));
      }
    }
  }
}

TEST(EstimateDepth, GoesOnWhereItWasInterrupted) {
  for (const Rendered* input : {&Grid(), &Arc()}) {
    const DepthOptions options = Preset(Quality::kBalanced);
    MemoryStore whole = Estimate(*input, options);
    const int views = static_cast<int>(input->set.views.size());
    for (const int done : {2, views + 1}) {  // in the matching and in the first check
      MemoryStore resumed = input->Store();
      for (int i = 0; i < done; ++i) {
        const std::pair<int, int> key{i / views, i % views};
        resumed.maps[key] = whole.Load(key.first, key.second);
      }
      EstimateDepth(input->set, options, resumed, SilentProgress());
      EXPECT_EQ(resumed.saved, NumDepthPasses(input->set, options) * views - done);
      for (const auto& [key, map] : whole.maps) {
        const DepthMap& other = resumed.maps.at(key);
        ASSERT_TRUE(
            std::equal(map.depth.data(), map.depth.data() + map.depth.size(), other.depth.data()));
      }
    }
  }
}

TEST(EstimateDepth, DoesNothingWhereTheResultIsThere) {
  const DepthOptions options = Preset(Quality::kBalanced);
  MemoryStore store = Estimate(Arc(), options);
  for (int v = 0; v < 5; ++v)
    store.maps.erase({0, v});  // the stage removes what is only on the way
  store.saved = 0;
  const DepthReport report = EstimateDepth(Arc().set, options, store, SilentProgress());
  EXPECT_EQ(store.saved, 0);
  EXPECT_FALSE(report.summary.empty());
}

TEST(EstimateDepth, IsTheSameWhereverTheWorldLies) {
  const Rendered far = RenderViews({}, ArcViews(5, Vector3d(1e7, 2e7, -1e7)));
  Rendered moved;
  moved.set = far.set;
  for (const Image<Rgb8>& image : Arc().images) moved.images.push_back(image.Clone());
  MemoryStore here = Estimate(Arc(), Preset(Quality::kBalanced)),
              there = Estimate(moved, Preset(Quality::kBalanced));
  const DepthMap &a = here.maps.at({1, 2}), &b = there.maps.at({1, 2});
  int different = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    different +=
        std::abs(a.depth.data()[i] - b.depth.data()[i]) > 1e-3F * a.depth.data()[i] ? 1 : 0;
  }
  EXPECT_LT(different, 0.01 * static_cast<double>(a.depth.size()));
}

TEST(EstimateDepth, UsesSparsePointsForTheRange) {
  Rendered with_points;
  with_points.set = Arc().set;
  for (const Image<Rgb8>& image : Arc().images) with_points.images.push_back(image.Clone());
  for (int i = 0; i < 60; ++i) {  // on the wall and on the card
    SparsePoint point;
    point.position = i % 2 == 0 ? Vector3d(0.2 + 0.01 * i, 0.1, 7)
                                : Vector3d(0, 0, 12) + 0.04 * i * Vector3d(1, 0, 0.25);
    point.views = {0, 1, 2, 3, 4};
    with_points.set.points.push_back(point);
  }
  MemoryStore store = Estimate(with_points, Preset(Quality::kBalanced));
  const Score score = Compare(store.maps.at({1, 2}), Arc().truth[2], 214, 1);
  EXPECT_GT(score.known, 0.6);
  EXPECT_LT(score.bad, 0.05);
}

// ------------------------------------------------------------------------------ extremes

Rendered Blank(std::vector<View> views, Rgb8 color = {90, 100, 110}) {
  Rendered rendered;
  for (const View& view : views)
    rendered.images.emplace_back(view.camera.width, view.camera.height, color);
  rendered.set.views = std::move(views);
  return rendered;
}

TEST(EstimateDepthExtremes, OneViewHasNoDepthAndSaysSo) {
  const Rendered one = Blank(ArcViews(1));
  MemoryStore store = one.Store();
  const DepthReport report =
      EstimateDepth(one.set, Preset(Quality::kBalanced), store, SilentProgress());
  ASSERT_EQ(report.warnings.size(), 1U);
  for (std::size_t i = 0; i < store.maps.at({1, 0}).depth.size(); ++i)
    ASSERT_EQ(store.maps.at({1, 0}).depth.data()[i], 0);
}

TEST(EstimateDepthExtremes, TwoPhotographsAreEnough) {
  const Rendered two = RenderViews(WallAndCard(), ArcViews(2));
  MemoryStore store = Estimate(two, Preset(Quality::kBalanced));
  const Score score = Compare(store.maps.at({1, 0}), two.truth[0], 214, 1.5);
  EXPECT_GT(score.known, 0.4);
  EXPECT_LT(score.bad, 0.1);
}

TEST(EstimateDepthExtremes, IdenticalViewsAndTinyBaselinesCarryNoDepth) {
  for (const double baseline : {0.0, 1e-9}) {
    std::vector<View> views = ArcViews(1);
    views.push_back(views[0]);
    views[1].name = "again";
    views[1].camera_from_world.translation.x() += baseline;
    Rendered same = Blank(views);
    for (int i = 0; i < 30; ++i) {  // points give the scale that the baseline is tiny against
      same.set.points.push_back({Vector3d(0.1 * i, 0, 9), {0, 1}});
    }
    MemoryStore store = Estimate(same, Preset(Quality::kBalanced));
    const Image<float>& depth = store.maps.at({1, 0}).depth;
    for (std::size_t i = 0; i < depth.size(); ++i) ASSERT_EQ(depth.data()[i], 0);
  }
}

TEST(EstimateDepthExtremes, HugeBaselineAndViewsWithNothingInCommon) {
  std::vector<View> views = ArcViews(3);
  views[1].camera_from_world.translation.x() += 1e6;
  views[2].camera_from_world = synthetic::LookAt({0, 0, -5}, {0, 0, -9});
  Estimate(Blank(views), Preset(Quality::kBalanced));
}

TEST(EstimateDepthExtremes, TinyPictures) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{1, 40}, std::pair{40, 1}, std::pair{2, 3}}) {
    std::vector<View> views = ArcViews(3);
    for (View& view : views) view.camera = synthetic::Pinhole(width, height, 60);
    Estimate(Blank(views), Preset(Quality::kBalanced));
    std::vector<View> grid = synthetic::MakeGrid(3, 3, 8, 40, 0.2, 9);
    for (View& view : grid) {
      view.camera.width = width;
      view.camera.height = height;
    }
    Estimate(Blank(grid), Preset(Quality::kBalanced));
  }
}

TEST(EstimateDepthExtremes, PhotographsOfDifferentSizes) {
  std::vector<View> views = ArcViews(4);
  views[1].camera = Resized(views[1].camera, 0.5);
  views[2].camera = synthetic::Pinhole(100, 170, 170);
  const Rendered mixed = RenderViews(WallAndCard(), views);
  MemoryStore store = Estimate(mixed, Preset(Quality::kBalanced));
  EXPECT_EQ(store.maps.at({1, 2}).depth.height(), 170);
  const Score score = Compare(store.maps.at({1, 0}), mixed.truth[0], 214, 1.5);
  EXPECT_GT(score.known, 0.3);
}

TEST(EstimateDepthExtremes, FlatPicturesAreNotTrusted) {
  MemoryStore grid =
      Estimate(Blank(synthetic::MakeGrid(3, 3, 40, 60, 0.2, 9)), Preset(Quality::kBalanced));
  for (std::size_t i = 0; i < grid.maps.at({1, 4}).confidence.size(); ++i) {
    ASSERT_LT(grid.maps.at({1, 4}).confidence.data()[i], 0.1F);
  }
  MemoryStore arc = Estimate(Blank(ArcViews(3)), Preset(Quality::kBalanced));
  for (std::size_t i = 0; i < arc.maps.at({1, 1}).confidence.size(); ++i) {
    ASSERT_LT(arc.maps.at({1, 1}).confidence.data()[i], 0.1F);
  }
}

TEST(EstimateDepthExtremes, FocalLengthsOfOneAndAMillionPixels) {
  for (const double focal : {1.0, 1e6}) {
    std::vector<View> views = ArcViews(3);
    for (View& view : views) view.camera = synthetic::Pinhole(60, 40, focal);
    Estimate(Blank(views), Preset(Quality::kBalanced));
    std::mt19937 random(1);
    Rendered noise = Blank(views);
    for (Image<Rgb8>& image : noise.images) {
      for (std::size_t i = 0; i < image.size(); ++i)
        image.data()[i].g = static_cast<std::uint8_t>(random());
    }
    Estimate(noise, Preset(Quality::kBalanced));
  }
}

TEST(EstimateDepthExtremes, WorldsOfEveryScale) {
  for (const double scale : {1e-6, 1e6}) {
    Rendered scaled;
    scaled.set = Arc().set;
    for (const Image<Rgb8>& image : Arc().images) scaled.images.push_back(image.Clone());
    for (View& view : scaled.set.views) view.camera_from_world.translation *= scale;
    MemoryStore store = Estimate(scaled, Preset(Quality::kBalanced));
    DepthMap map = store.Load(1, 2);
    for (std::size_t i = 0; i < map.depth.size(); ++i)
      map.depth.data()[i] /= static_cast<float>(scale);
    const Score score = Compare(map, Arc().truth[2], 214, 1);
    EXPECT_GT(score.known, 0.6);
    EXPECT_LT(score.bad, 0.05);
  }
}

TEST(DepthOptions, RefuseADisparityRangeThatIsEmpty) {
  DepthOptions options;
  options.disparity_min = 2;
  options.disparity_max = 1;
  MemoryStore store = Grid().Store();
  EXPECT_THROW(EstimateDepth(Grid().set, options, store, SilentProgress()), Error);
}

}  // namespace
}  // namespace lamella
