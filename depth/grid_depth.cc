#include "depth/grid_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "depth/refine.h"
#include "depth/sgm.h"

namespace lamella {
namespace {

// Costs are 6 times a sample (grid_cost.h): penalties of 8 and 60 of 254.
constexpr SgmPenalties kGridPenalties{.p1 = 6, .p2 = 45, .p2_contrast = 0};

constexpr int kCoarseFactor = 4;
constexpr int kMinCoarseSize = 32;        // px
constexpr double kCoarseStep = 1.5;       // of the full estimate's
constexpr int kSureGridUniqueness = 64;   // of 255
constexpr double kGridOutliers = 0.0005;  // share of sure pixels beyond either end of the range
constexpr double kMargin = 0.5;           // coarse labels by which the range is widened

Image<Rgb8> Shrunk(const Image<Rgb8>& image, int factor) {
  Image<Rgb8> small(image.width() / factor, image.height() / factor);
  const int area = factor * factor;
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      int r = 0, g = 0, b = 0;
      for (int i = 0; i < area; ++i) {
        const Rgb8 p = image(x * factor + i % factor, y * factor + i / factor);
        r += p.r;
        g += p.g;
        b += p.b;
      }
      const auto mean = [&](int sum) { return static_cast<std::uint8_t>((sum + area / 2) / area); };
      small(x, y) = {mean(r), mean(g), mean(b)};
    }
  }
  return small;
}

std::vector<GridArm> ArmsOfImages(
    const std::vector<View>& views, int reference, const GridArms& arms,
    const std::function<std::shared_ptr<const GridImage>(int)>& images,
    std::vector<std::shared_ptr<const GridImage>>& keep) {
  const GridPosition at = *views[static_cast<std::size_t>(reference)].grid;
  std::vector<GridArm> result;
  for (const std::vector<int>& arm : arms) {
    GridArm sources;
    for (const int v : arm) {
      const GridPosition other = *views[static_cast<std::size_t>(v)].grid;
      keep.push_back(images(v));
      sources.push_back({keep.back().get(), other.column - at.column, other.row - at.row});
    }
    result.push_back(std::move(sources));
  }
  return result;
}

LabelMap MatchView(const std::vector<View>& views, int reference, const GridArms& arms,
                   const std::function<std::shared_ptr<const GridImage>(int)>& images,
                   const DisparityLabels& labels, MatchMemory& memory) {
  std::vector<std::shared_ptr<const GridImage>> keep{images(reference)};
  const GridImage& image = *keep.front();
  const std::vector<GridArm> sources = ArmsOfImages(views, reference, arms, images, keep);
  CostVolume cost = GridCost(image, sources, labels, std::move(memory.costs));
  const Image<std::uint8_t> guide(image.width(), image.height());  // the jump penalty is constant
  LabelMap map = SemiGlobalMatch(cost, guide.span(), kGridPenalties, memory.paths);
  memory.costs = std::move(cost.costs);
  return map;
}

// The central view and the outermost ones.
std::vector<int> Probes(const std::vector<View>& views) {
  double row = 0, column = 0;
  for (const View& view : views) {
    row += view.grid->row / static_cast<double>(views.size());
    column += view.grid->column / static_cast<double>(views.size());
  }
  std::vector<int> probes;
  const auto add_smallest = [&](const std::function<double(double rows, double columns)>& value) {
    const auto key = [&](const View& v) {
      return value(v.grid->row - row, v.grid->column - column);
    };
    const auto best = std::min_element(
        views.begin(), views.end(), [&](const View& a, const View& b) { return key(a) < key(b); });
    const int index = static_cast<int>(best - views.begin());
    if (std::find(probes.begin(), probes.end(), index) == probes.end()) probes.push_back(index);
  };
  add_smallest([](double r, double c) { return r * r + c * c; });
  for (const int sr : {-1, 1}) {
    for (const int sc : {-1, 1}) add_smallest([&](double r, double c) { return sr * r + sc * c; });
  }
  return probes;
}

struct Span {
  double begin = 0, end = 0;
};

// The labels for a range, spaced as the options ask, or as many as there can be.
DisparityLabels LabelsOver(const Span& range, double step) {
  const double width = std::max(range.end - range.begin, 2 * step);
  const int count = std::clamp(static_cast<int>(std::ceil(width / step)) + 1, 3, kMaxLabels);
  return {range.begin, width / (count - 1), count};
}

// What one view, matched at the coarse size, is sure of; labels stay those of the coarse size.
std::vector<double> SureDisparities(const LabelMap& map, const DisparityLabels& labels) {
  std::vector<double> sure;
  for (std::size_t i = 0; i < map.label.size(); ++i) {
    if (map.uniqueness.data()[i] >= kSureGridUniqueness) {
      sure.push_back(labels.Disparity(static_cast<double>(map.label.data()[i]) / kSubLabels));
    }
  }
  return sure;
}

Span MeasureRange(const std::vector<View>& views, const LoadPhotograph& load,
                  const GridOptions& options, MatchMemory& memory) {
  const Camera& camera = views.front().camera;
  const int smaller = std::min(camera.width, camera.height);
  const int factor = std::clamp(smaller / kMinCoarseSize, 1, kCoarseFactor);
  std::map<int, std::shared_ptr<const GridImage>> images;
  const auto image = [&](int v) {
    auto& slot = images[v];
    if (!slot)
      slot = std::make_shared<const GridImage>(Shrunk(load(v), factor).span(), options.color);
    return slot;
  };
  std::vector<double> sure;
  double step = options.step_px;
  for (const int probe : Probes(views)) {
    const GridArms arms = ChooseGridArms(views, probe, options.reach, options.per_arm);
    const int reach = ReachOf(views, probe, arms);
    const double most = 0.5 * std::max(camera.width, camera.height) / factor / reach;
    step = kCoarseStep * options.step_px / reach;
    const DisparityLabels labels = LabelsOver({-most, most}, step);
    for (const double d :
         SureDisparities(MatchView(views, probe, arms, image, labels, memory), labels)) {
      sure.push_back(d * factor);
    }
  }
  const double margin = kMargin * step * factor;
  if (sure.empty()) return {-margin, margin};  // nothing to see: any depth is as good
  std::sort(sure.begin(), sure.end());
  const auto outliers = static_cast<std::size_t>(kGridOutliers * static_cast<double>(sure.size()));
  return {sure[outliers] - margin, sure[sure.size() - 1 - outliers] + margin};
}

}  // namespace

DisparityLabels ChooseGridLabels(const std::vector<View>& views, const LoadPhotograph& load,
                                 const GridOptions& options, MatchMemory& memory) {
  const bool given = options.disparity_min && options.disparity_max;
  Span range = given ? Span{} : MeasureRange(views, load, options, memory);
  range.begin = options.disparity_min.value_or(range.begin);
  range.end = options.disparity_max.value_or(range.end);
  const int centre = Probes(views).front();
  const int reach =
      ReachOf(views, centre, ChooseGridArms(views, centre, options.reach, options.per_arm));
  return LabelsOver(range, options.step_px / reach);
}

DisparityMap EstimateGridView(const std::vector<View>& views, int reference, const GridArms& arms,
                              const std::function<std::shared_ptr<const GridImage>(int)>& images,
                              ImageSpan<const Rgb8> photograph, const DisparityLabels& labels,
                              const GridOptions& options, MatchMemory& memory) {
  const LabelMap match = MatchView(views, reference, arms, images, labels, memory);
  const Image<SubLabel> label =
      WeightedMedian(match.label.span(), photograph, options.median_radius);
  DisparityMap map{Image<float>(photograph.width, photograph.height),
                   Image<float>(photograph.width, photograph.height)};
  for (std::size_t i = 0; i < label.size(); ++i) {
    map.disparity.data()[i] =
        static_cast<float>(labels.Disparity(static_cast<double>(label.data()[i]) / kSubLabels));
    map.confidence.data()[i] = static_cast<float>(match.uniqueness.data()[i]) / 255.0F;
  }
  return map;
}

}  // namespace lamella
