// Depth of a regular camera grid, pass by pass.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "depth/grid_depth.h"
#include "depth/grid_fusion.h"
#include "depth/method.h"
#include "depth/recent.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr std::size_t kGridCacheBytes = std::size_t{256} << 20;
// One surface, and what is averaged, in label steps (0.15 and 0.075 px at steps of 0.065).
constexpr double kAgreeSteps = 2.3, kMergeSteps = 1.15;

float DepthOf(const RegularGrid& grid, float disparity) {
  const double w = grid.InverseDepthFromDisparity(static_cast<double>(disparity));
  return w > 0 ? static_cast<float>(1 / w) : std::numeric_limits<float>::infinity();
}

float DisparityOf(const RegularGrid& grid, float depth) {
  return static_cast<float>(grid.DisparityFromInverseDepth(1 / static_cast<double>(depth)));
}

DepthMap ToDepth(const RegularGrid& grid, DisparityMap map) {
  for (std::size_t i = 0; i < map.disparity.size(); ++i) {
    map.disparity.data()[i] = DepthOf(grid, map.disparity.data()[i]);
  }
  return {std::move(map.disparity), std::move(map.confidence)};
}

DisparityMap ToDisparity(const RegularGrid& grid, DepthMap map) {
  for (std::size_t i = 0; i < map.depth.size(); ++i) {
    map.depth.data()[i] = DisparityOf(grid, map.depth.data()[i]);
  }
  return {std::move(map.depth), std::move(map.confidence)};
}

GridOptions OptionsOfGrid(const DepthOptions& o) {
  if (o.disparity_min && o.disparity_max && !(*o.disparity_min < *o.disparity_max)) {
    throw UsageError("--depth-disparity-min", "is not below --depth-disparity-max",
                     "give the smaller one first or leave both out");
  }
  return {o.grid_reach,    o.grid_views_per_side, o.grid_color,   o.grid_step_px,
          o.median_radius, o.disparity_min,       o.disparity_max};
}

struct Photo {
  Photo(Image<Rgb8> image, bool color) : pixels(std::move(image)), planes(pixels.span(), color) {}
  Image<Rgb8> pixels;
  GridImage planes;
};

class GridMethod final : public DepthMethod {
 public:
  GridMethod(const ViewSet& set, const RegularGrid& grid, const DepthOptions& options,
             DepthStore& store)
      : views_(set.views),
        grid_(grid),
        options_(OptionsOfGrid(options)),
        store_(store),
        photos_(Capacity(9), [this](int v) { return Photo(store_.Photograph(v), options_.color); }),
        maps_(Capacity(8),
              [this](int v) { return ToDisparity(grid_, store_.Load(maps_pass_, v)); }),
        labels_(ChooseGridLabels(
            views_, [&](int v) { return store_.Photograph(v); }, options_, match_memory_)) {}

  DepthMap Match(int view) override {
    const GridArms arms = ChooseGridArms(views_, view, options_.reach, options_.per_arm);
    const auto photo = photos_.Get(view);
    const auto planes = [&](int v) {
      const auto p = photos_.Get(v);
      return std::shared_ptr<const GridImage>(p, &p->planes);
    };
    return ToDepth(grid_, EstimateGridView(views_, view, arms, planes, photo->pixels.span(),
                                           labels_, options_, match_memory_));
  }

  DepthMap Refine(int pass, int view) override {
    match_memory_ = {};
    if (maps_pass_ != pass - 1) maps_.Clear();
    maps_pass_ = pass - 1;
    const GridPosition at = *views_[static_cast<std::size_t>(view)].grid;
    const auto own = maps_.Get(view);
    std::vector<std::shared_ptr<const DisparityMap>> keep;
    std::vector<GridNeighbour> neighbours;
    for (const int v : ChooseFusionViews(views_, view, options_.reach)) {
      const GridPosition other = *views_[static_cast<std::size_t>(v)].grid;
      keep.push_back(maps_.Get(v));
      neighbours.push_back({keep.back().get(), other.column - at.column, other.row - at.row});
    }
    const FusionTolerance tolerance{kAgreeSteps * labels_.step, kMergeSteps * labels_.step};
    return ToDepth(grid_, FuseGridView(*own, neighbours, tolerance));
  }

  DepthReport Report() const override {
    DepthReport report;
    report.summary = {{"method", "camera grid"},
                      {"labels", fmt::format("{}", labels_.count)},
                      {"disparity range px", fmt::format("{:.3f} to {:.3f}", labels_.first,
                                                         labels_.Disparity(labels_.count - 1))}};
    return report;
  }

 private:
  std::size_t Capacity(std::size_t bytes_per_pixel) const {
    const Camera& camera = views_.front().camera;
    return kGridCacheBytes / (bytes_per_pixel * static_cast<std::size_t>(camera.width) *
                              static_cast<std::size_t>(camera.height));
  }

  const std::vector<View>& views_;
  RegularGrid grid_;
  GridOptions options_;
  DepthStore& store_;
  Recent<Photo> photos_;
  int maps_pass_ = 0;
  Recent<DisparityMap> maps_;  // of maps_pass_
  MatchMemory match_memory_;
  DisparityLabels labels_;
};

}  // namespace

std::unique_ptr<DepthMethod> MakeGridMethod(const ViewSet& set, const RegularGrid& grid,
                                            const DepthOptions& options, DepthStore& store) {
  return std::make_unique<GridMethod>(set, grid, options, store);
}

}  // namespace lamella
