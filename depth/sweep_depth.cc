#include "depth/sweep_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/LU>

#include "depth/refine.h"
#include "depth/sgm.h"
#include "depth/shrink.h"

namespace lamella {
namespace {

// Costs are 8 times a census distance of 0..24.
constexpr SgmPenalties kPenalties{.p1 = 8, .p2 = SgmPenalties::kMaxPenalty, .p2_contrast = 8};

constexpr int kMinLabels = 16;
constexpr int kSureUniqueness = 128;  // of 255
constexpr double kOutliers = 0.005;
constexpr double kGrowth = 1.1, kMaxGrowth = 2.5;  // of the step beyond the far end

Eigen::Matrix3d Intrinsics(const Camera& camera) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return k;
}

// How far the picture's centre moves in a source between infinity and w, px; 0 where the point is
// behind the source.
double Parallax(const Camera& reference, const PictureMap& map, double w) {
  const Eigen::Vector3d centre(reference.width / 2.0, reference.height / 2.0, 1);
  const Eigen::Vector3d far = map.m * centre, near = far + w * map.b;
  if (!(far.z() > 0) || !(near.z() > 0)) return 0;
  return (near.hnormalized() - far.hnormalized()).norm();
}

LabelMap Match(const SweepView& reference, const std::vector<const SweepView*>& sources,
               const std::vector<PictureMap>& maps, const InverseDepthLabels& labels,
               MatchMemory& memory) {
  std::vector<SweepSource> inputs;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    inputs.push_back({&sources[i]->image, maps[i].m, maps[i].b});
  }
  CostVolume cost = SweepCost(reference.image, inputs, labels, std::move(memory.costs));
  LabelMap map = SemiGlobalMatch(cost, reference.image.luma().span(), kPenalties, memory.paths);
  memory.costs = std::move(cost.costs);
  return map;
}

// From `near` down: steps of `step` to `far`, then growing ones to beyond 0. Rising.
std::vector<double> SpreadLabels(const InverseDepthRange& range, double step) {
  std::vector<double> w{range.near};
  for (double s = step; w.back() >= 0 && w.size() <= 4 * static_cast<std::size_t>(kMaxLabels);) {
    if (w.back() <= range.far) s = std::min(s * kGrowth, step * kMaxGrowth);
    w.push_back(w.back() - s);
  }
  std::reverse(w.begin(), w.end());
  return w;
}

}  // namespace

DepthMap ToDepth(const InverseDepthMap& map) {
  DepthMap depth{Image<float>(map.w.width(), map.w.height()), map.confidence.Clone()};
  for (std::size_t i = 0; i < map.w.size(); ++i) {
    const float w = map.w.data()[i];
    // Below 1/FLT_MAX it is infinity, too.
    depth.depth.data()[i] = w < 0 ? 0 : 1 / w;
  }
  return depth;
}

InverseDepthMap ToInverseDepth(const DepthMap& map) {
  InverseDepthMap inverse{Image<float>(map.depth.width(), map.depth.height()),
                          map.confidence.Clone()};
  for (std::size_t i = 0; i < map.depth.size(); ++i) {
    const float z = map.depth.data()[i];
    inverse.w.data()[i] = z > 0 ? 1 / z : InverseDepthMap::kUnknown;
  }
  return inverse;
}

Camera SweepCamera(const Camera& full, int size_px) {
  return Resized(full,
                 std::min(1.0, static_cast<double>(size_px) / std::max(full.width, full.height)));
}

SweepView::SweepView(const Image<Rgb8>& photograph, const Camera& full, int size_px)
    : camera(SweepCamera(full, size_px)),
      pixels(ShrinkTo(photograph.span(), camera.width, camera.height)),
      image(LumaOf(pixels.span())) {}

PictureMap MapPictures(const Camera& from, const Rigid& from_from_world, const Camera& to,
                       const Rigid& to_from_world) {
  const Rigid to_from_from = to_from_world * Inverse(from_from_world);
  const Eigen::Matrix3d k = Intrinsics(to);
  return {k * to_from_from.rotation.toRotationMatrix() * Intrinsics(from).inverse(),
          k * to_from_from.translation};
}

InverseDepthLabels ChooseSweepLabels(const Camera& reference,
                                     const std::vector<PictureMap>& sources,
                                     const InverseDepthRange& range, const SweepOptions& options) {
  double parallax = 0;
  for (const PictureMap& map : sources)
    parallax = std::max(parallax, Parallax(reference, map, range.near));
  const auto most = static_cast<std::size_t>(std::min(options.labels, kMaxLabels));
  // Never coarser than kMinLabels over everything, never more than `most`.
  double step = range.near / kMinLabels;
  if (parallax > 0) step = std::min(step, range.near * options.step_px / parallax);
  std::vector<double> w = SpreadLabels(range, step);
  while (w.size() > most) {
    step *= std::max(1.01, static_cast<double>(w.size()) / static_cast<double>(most));
    w = SpreadLabels(range, step);
  }
  return {std::move(w)};
}

std::optional<InverseDepthRange> MeasureRange(const SweepView& reference,
                                              const std::vector<const SweepView*>& sources,
                                              const std::vector<PictureMap>& maps,
                                              MatchMemory& memory) {
  // Parallax is nearly linear in w: a small step tells the scale.
  double most = 0;
  for (const PictureMap& map : maps) {
    const double scale = map.b.norm();
    if (!(scale > 0)) continue;
    const double w = 1e-3 * reference.camera.width / scale;
    const double parallax = Parallax(reference.camera, map, w);
    if (parallax > 0) most = std::max(most, 0.5 * reference.camera.width / parallax * w);
  }
  if (!(most > 0)) return std::nullopt;
  const SweepOptions options{.labels = kMaxLabels, .step_px = 1, .median_radius = 0};
  const InverseDepthLabels labels = ChooseSweepLabels(reference.camera, maps, {0, most}, options);
  const LabelMap match = Match(reference, sources, maps, labels, memory);
  std::vector<double> sure;
  for (std::size_t i = 0; i < match.label.size(); ++i) {
    if (match.uniqueness.data()[i] >= kSureUniqueness)
      sure.push_back(labels.InverseDepth(match.label.data()[i]));
  }
  if (sure.empty()) return std::nullopt;
  std::sort(sure.begin(), sure.end());
  const auto outliers = static_cast<std::size_t>(kOutliers * static_cast<double>(sure.size()));
  return InverseDepthRange{
      std::max(0.0, sure[outliers]),
      std::max(labels.w.back() / labels.count(), sure[sure.size() - 1 - outliers])};
}

InverseDepthMap EstimateSweepView(const SweepView& reference,
                                  const std::vector<const SweepView*>& sources,
                                  const std::vector<PictureMap>& maps,
                                  const InverseDepthLabels& labels, const SweepOptions& options,
                                  MatchMemory& memory) {
  const LabelMap match = Match(reference, sources, maps, labels, memory);
  const Image<SubLabel> label =
      WeightedMedian(match.label.span(), reference.pixels.span(), options.median_radius);
  InverseDepthMap map{Image<float>(label.width(), label.height()),
                      Image<float>(label.width(), label.height())};
  for (std::size_t i = 0; i < label.size(); ++i) {
    map.w.data()[i] = static_cast<float>(std::max(0.0, labels.InverseDepth(label.data()[i])));
    map.confidence.data()[i] = static_cast<float>(match.uniqueness.data()[i]) / 255.0F;
  }
  return map;
}

}  // namespace lamella
