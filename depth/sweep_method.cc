// Depth of photographs, pass by pass.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "depth/consistency.h"
#include "depth/method.h"
#include "depth/neighbours.h"
#include "depth/recent.h"
#include "depth/sweep_depth.h"

namespace lamella {
namespace {

constexpr std::size_t kCacheBytes = std::size_t{384} << 20;
constexpr std::size_t kBytesPerPixel = 8;  // of a SweepView and of an InverseDepthMap
constexpr double kNearMargin = 1 / 0.88, kFarMargin = 1 / 1.2;  // of the inverse depths of points
constexpr int kRangeSizeFactor = 4;    // photographs are so much smaller where a range is measured
constexpr double kCheckAngleDeg = 40;  // views farther around share little surface
constexpr double kReturnSteps = 1.25;  // of a label: how well a pixel must be led back to
constexpr int kComponentPx = 100;      // at 1536 px

class SweepMethod final : public DepthMethod {
 public:
  SweepMethod(const ViewSet& set, const DepthOptions& options, DepthStore& store)
      : set_(set),
        options_(options),
        store_(store),
        neighbourhood_(set),
        photos_(Capacity(), [this](int v) { return Prepare(v, options_.sweep_size_px); }),
        maps_(Capacity(), [this](int v) { return ToInverseDepth(store_.Load(maps_pass_, v)); }) {
    for (int v = 0; v < NumViews(); ++v) neighbours_.push_back(neighbourhood_.Of(v));
  }

  DepthMap Match(int view) override {
    const Plan& plan = PlanOf(view);
    if (plan.sources.empty()) return Unknown(SmallCamera(view));
    std::vector<int> all = plan.sources;
    all.push_back(view);
    const std::vector<std::shared_ptr<const SweepView>> photos = photos_.Get(all);
    const SweepView& reference = *photos.back();
    Inputs inputs;
    for (std::size_t i = 0; i < plan.sources.size(); ++i) {
      inputs.sources.push_back(photos[i].get());
      inputs.maps.push_back(
          MapPictures(reference.camera, PoseOf(view), photos[i]->camera, PoseOf(plan.sources[i])));
    }
    return ToDepth(EstimateSweepView(reference, inputs.sources, inputs.maps, plan.labels, Options(),
                                     match_memory_));
  }

  DepthMap Refine(int pass, int view) override {
    match_memory_ = {};
    if (maps_pass_ != pass - 1) maps_.Clear();
    maps_pass_ = pass - 1;
    const Plan& plan = PlanOf(view);
    const Camera camera = SmallCamera(view);
    const std::vector<int> checks =
        ChooseSources(NeighboursOf(view), kCheckAngleDeg, options_.check_views);
    if (plan.sources.empty() || checks.empty()) return Unknown(camera);
    std::vector<int> all = checks;
    all.push_back(view);
    const std::vector<std::shared_ptr<const InverseDepthMap>> maps = maps_.Get(all);
    std::vector<NeighbourMap> neighbours;
    for (std::size_t i = 0; i < checks.size(); ++i) {
      const int v = checks[i];
      const Camera other = SmallCamera(v);
      neighbours.push_back({maps[i].get(), MapPictures(camera, PoseOf(view), other, PoseOf(v)),
                            MapPictures(other, PoseOf(v), camera, PoseOf(view))});
    }
    const double scale = std::max(camera.width, camera.height) / 1536.0;
    ConsistencyOptions options;
    options.tolerance = options_.check_tolerance;
    options.step = plan.labels.w.back() - plan.labels.w[plan.labels.w.size() - 2];
    options.return_px = std::max(1.0, kReturnSteps * options_.sweep_step_px);
    options.agreeing = options_.check_agreeing;
    options.min_component = static_cast<int>(std::lround(kComponentPx * scale * scale));
    return ToDepth(MakeConsistent(*maps.back(), neighbours, options));
  }

  DepthReport Report() const override {
    DepthReport report;
    std::size_t most = 0, least = SIZE_MAX;
    for (int v = 0; v < NumViews(); ++v) {
      const std::vector<int> sources = SourcesOf(v);
      most = std::max(most, sources.size());
      least = std::min(least, sources.size());
      if (sources.empty()) {
        report.warnings.push_back(fmt::format(
            "{}: no other view shows the same surfaces from another place, so its depth is unknown",
            ViewAt(v).name));
      }
    }
    report.summary = {
        {"method", "plane sweep"},
        {"size px", fmt::format("{}", options_.sweep_size_px)},
        {"sources per view", NumViews() > 0 ? fmt::format("{} to {}", least, most) : "0"}};
    return report;
  }

 private:
  struct Plan {
    std::vector<int> sources;
    InverseDepthLabels labels;
  };
  struct Inputs {
    std::vector<const SweepView*> sources;
    std::vector<PictureMap> maps;
  };

  int NumViews() const { return static_cast<int>(set_.views.size()); }
  const View& ViewAt(int v) const { return set_.views[static_cast<std::size_t>(v)]; }
  const Rigid& PoseOf(int v) const { return ViewAt(v).camera_from_world; }
  const std::vector<Neighbour>& NeighboursOf(int v) const {
    return neighbours_[static_cast<std::size_t>(v)];
  }
  std::vector<int> SourcesOf(int v) const {
    return ChooseSources(NeighboursOf(v), options_.sweep_angle_deg, options_.sweep_sources);
  }
  SweepOptions Options() const {
    return {options_.sweep_labels, options_.sweep_step_px, options_.median_radius};
  }
  SweepView Prepare(int v, int size_px) {
    return SweepView(store_.Photograph(v), ViewAt(v).camera, size_px);
  }
  Camera SmallCamera(int v) const { return SweepCamera(ViewAt(v).camera, options_.sweep_size_px); }

  std::size_t Capacity() const {
    std::size_t largest = 1;
    for (int v = 0; v < NumViews(); ++v) {
      const Camera camera = SmallCamera(v);
      largest = std::max(largest, static_cast<std::size_t>(camera.width) *
                                      static_cast<std::size_t>(camera.height));
    }
    return kCacheBytes / (kBytesPerPixel * largest);
  }

  static DepthMap Unknown(const Camera& camera) {
    return {Image<float>(camera.width, camera.height), Image<float>(camera.width, camera.height)};
  }

  // Of the capture's points, or measured in small photographs; nothing where nothing is sure.
  std::optional<InverseDepthRange> RangeOf(int view, const std::vector<int>& sources) {
    if (const auto measured = neighbourhood_.MeasuredRange(view)) {
      return InverseDepthRange{1 / measured->far, 1 / measured->near};
    }
    const int size = std::max(1, options_.sweep_size_px / kRangeSizeFactor);
    const SweepView reference = Prepare(view, size);
    std::vector<SweepView> views;
    views.reserve(sources.size());
    Inputs inputs;
    for (const int v : sources) {
      views.push_back(Prepare(v, size));
      inputs.sources.push_back(&views.back());
      inputs.maps.push_back(
          MapPictures(reference.camera, PoseOf(view), views.back().camera, PoseOf(v)));
    }
    return MeasureRange(reference, inputs.sources, inputs.maps, match_memory_);
  }

  const Plan& PlanOf(int view) {
    const auto found = plans_.find(view);
    if (found != plans_.end()) return found->second;
    Plan plan{SourcesOf(view), {}};
    if (!plan.sources.empty()) {
      if (const std::optional<InverseDepthRange> range = RangeOf(view, plan.sources)) {
        const Camera camera = SmallCamera(view);
        std::vector<PictureMap> maps;
        for (const int v : plan.sources)
          maps.push_back(MapPictures(camera, PoseOf(view), SmallCamera(v), PoseOf(v)));
        plan.labels = ChooseSweepLabels(
            camera, maps, {range->far * kFarMargin, range->near * kNearMargin}, Options());
      } else {
        plan.sources.clear();
      }
    }
    return plans_.emplace(view, std::move(plan)).first->second;
  }

  const ViewSet& set_;
  const DepthOptions& options_;
  DepthStore& store_;
  Neighbourhood neighbourhood_;
  std::vector<std::vector<Neighbour>> neighbours_;  // by view
  Recent<SweepView> photos_;
  int maps_pass_ = 0;
  Recent<InverseDepthMap> maps_;  // of maps_pass_
  std::map<int, Plan> plans_;
  MatchMemory match_memory_;
};

}  // namespace

std::unique_ptr<DepthMethod> MakeSweepMethod(const ViewSet& set, const DepthOptions& options,
                                             DepthStore& store) {
  return std::make_unique<SweepMethod>(set, options, store);
}

}  // namespace lamella
