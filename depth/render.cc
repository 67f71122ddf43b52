// A query, in order:
//   1. the nearness of every ray of the bundle: the nearest depth maps warped forward
//   (target_depth.h)
//   2. tile by tile, the views that know most of its rays (sight.h)
//   3. their colours, weighted by direction, resolution and whether they see the point (blend.h)
#include "depth/render.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "depth/blend.h"
#include "depth/exposure.h"
#include "depth/sight.h"
#include "depth/target_depth.h"
#include "lightfield/error.h"
#include "lightfield/median.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Neighbouring depths are one surface up to this many softnesses of the visibility test.
constexpr double kSurfaceSoftness = 2.0;
// Depth of photographs is matched between views that see a surface about this much apart (or
// between neighbours, where these are farther apart). A grid's step is a quarter of what is matched
// there.
constexpr double kMatchingAngle = 0.17;
constexpr double kStepsMatched = 4;
constexpr double kRelativeSoftness = 0.002;  // of inverse depth: poses are not perfect either
constexpr int kFurtherViews = 4, kFurtherMaps = 3;
constexpr int kSamplesPerCapture = 4096;

void CheckViews(const std::vector<DepthView>& views) {
  if (views.empty()) throw UsageError("render", "no view to render from", "give at least one view");
  for (const DepthView& v : views) {
    const Camera& camera = v.view.camera;
    const bool sizes_agree = v.color.width() == camera.width && v.color.height() == camera.height &&
                             v.depth.depth.width() == v.depth.confidence.width() &&
                             v.depth.depth.height() == v.depth.confidence.height();
    if (!sizes_agree || v.color.empty() || v.depth.depth.empty()) {
      throw UsageError(v.view.name, "its picture, camera and depth differ in size or are empty",
                       "run the stages poses and depth again");
    }
    if (camera.model != CameraModel::kPinhole) {
      throw UsageError(v.view.name, "its camera is no pinhole",
                       "run the stage poses: it undistorts");
    }
  }
}

Eigen::Vector3d MeanCentre(const std::vector<DepthView>& views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const DepthView& v : views) sum += Centre(v.view.camera_from_world);
  return sum / static_cast<double>(views.size());
}

// The median finite depth of a view; nothing known: 1.
double TypicalDepth(const DepthMap& map) {
  std::vector<double> depths;
  const std::size_t step = std::max<std::size_t>(1, map.depth.size() / 1000);
  for (std::size_t i = 0; i < map.depth.size(); i += step) {
    const float depth = map.depth.data()[i];
    if (depth > 0 && std::isfinite(depth)) depths.push_back(static_cast<double>(depth));
  }
  return depths.empty() ? 1 : Median(std::move(depths));
}

// The median distance of a view from its nearest neighbour. Where all views are at one place any
// small share of the scene's size does: directions then don't tell them apart.
double NeighbourSpacing(const std::vector<DepthView>& views) {
  std::vector<double> nearest;
  for (const DepthView& a : views) {
    double best = std::numeric_limits<double>::infinity();
    for (const DepthView& b : views) {
      const double d = (Centre(a.view.camera_from_world) - Centre(b.view.camera_from_world)).norm();
      if (&a != &b && d > 0) best = std::min(best, d);
    }
    if (std::isfinite(best)) nearest.push_back(best);
  }
  return nearest.empty() ? 0.05 * TypicalDepth(views[0].depth) : Median(std::move(nearest));
}

// The baseline over which depth was presumably matched.
double MatchingBaseline(const std::vector<DepthView>& views, double neighbour) {
  double largest = 0;
  std::vector<double> depths;
  for (const DepthView& v : views) {
    depths.push_back(TypicalDepth(v.depth));
    largest = std::max(
        largest,
        (Centre(v.view.camera_from_world) - Centre(views[0].view.camera_from_world)).norm());
  }
  const double wanted = kMatchingAngle * Median(std::move(depths));
  return std::max(neighbour, std::min(wanted, largest));
}

// Where nearness is best counted from: 0, where infinity is, unless the scene is thin beside its
// distance from the viewer.
double ZeroFor(const RayBundle& bundle, const NearnessRange& range) {
  const bool thin = range.near - range.far < 0.5 * range.middle;
  return bundle.centre.w() == 0 || thin ? range.middle : 0;
}

std::vector<View> ViewsOf(const std::vector<DepthView>& views) {
  std::vector<View> plain;
  for (const DepthView& v : views) plain.push_back(v.view);
  return plain;
}

float LargestColor(const std::vector<const Image<Rgb>*>& colors, const std::vector<Rgb>& gains) {
  float largest = 0;
  for (std::size_t k = 0; k < colors.size(); ++k) {
    for (std::size_t i = 0; i < colors[k]->size(); ++i) {
      const Rgb c = colors[k]->data()[i];
      largest = std::max({largest, gains[k].r * c.r, gains[k].g * c.g, gains[k].b * c.b});
    }
  }
  return largest;
}

class CapturedScene : public RaySource {
 public:
  CapturedScene(std::vector<DepthView> views, const RenderOptions& options)
      : blend_{options.views, kFurtherViews, options.filter != "bilinear", options.guess_unseen, 1},
        target_{options.maps, kFurtherMaps} {
    CheckViews(views);
    centre_ = MeanCentre(views);
    neighbour_ = NeighbourSpacing(views);
    matching_baseline_ = MatchingBaseline(views, neighbour_);
    const std::optional<RegularGrid> grid = FindRegularGrid(ViewsOf(views));
    views_.resize(views.size());
    ParallelForEach(0, static_cast<std::int64_t>(views.size()), [&](std::int64_t k) {
      const auto i = static_cast<std::size_t>(k);
      views_[i] = Prepare(views[i], grid, options.visibility_px, views.size());
      views[i].depth = {};
    });
    const bool equalise =
        options.exposure == "on" || (options.exposure == "auto" && !grid && views.size() > 1);
    std::vector<const Image<Rgb>*> colors;
    for (const DepthView& v : views) colors.push_back(&v.color);
    const std::vector<Rgb> gains =
        equalise ? ExposureGains(views_, colors) : std::vector<Rgb>(views.size(), Rgb{1, 1, 1});
    const int exponent = ColorExponent(LargestColor(colors, gains));
    blend_.color_scale = std::ldexp(1.0F, exponent);
    const std::vector<double> spacings = LeastSpacings(options.rays);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const std::size_t finest = ColorLevelForSpacing(spacings[i], 64);
      views_[i].color = ColorPyramid(views[i].color, gains[i], exponent, finest);
      views[i].color = {};
    }
  }

  void Query(const RayBundle& world_bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    if (rectangle.width <= 0 || rectangle.height <= 0) return;
    const RayBundle bundle = AroundCapture(world_bundle);
    const BundleGeometry plain(bundle);
    if (!plain.valid()) {
      for (int y = 0; y < rectangle.height; ++y) {
        std::fill_n(samples.row(y), rectangle.width, RaySample());
      }
      return;
    }
    NearnessRange range;
    const BundleGeometry geometry = Counted(plain, &range);
    const ViewRanking ranking(geometry, views_, neighbour_);
    const int first_x = rectangle.x / kTile, last_x = (rectangle.x + rectangle.width - 1) / kTile;
    const int first_y = rectangle.y / kTile, last_y = (rectangle.y + rectangle.height - 1) / kTile;
    const int first_row = first_y * kTile;
    const Image<float> nearness = TargetDepth(geometry, views_, range, ranking, target_, first_row,
                                              std::min((last_y + 1) * kTile, bundle.height));
    const int columns = last_x - first_x + 1;
    ParallelForEach(
        0, static_cast<std::int64_t>(columns) * (last_y - first_y + 1), [&](std::int64_t i) {
          const int tile_x = first_x + static_cast<int>(i % columns);
          const int tile_y = first_y + static_cast<int>(i / columns);
          RenderTile(geometry, ranking, nearness, first_row,
                     {tile_x * kTile, tile_y * kTile, kTile, kTile}, rectangle, samples);
        });
  }

  double QueryBytes(int width, int height) const override {
    double kept = 0, meanwhile = 0;
    for (const SourceView& view : views_) {
      const ColorPyramid::Bytes level = view.color.BytesToCome();
      kept += level.kept;
      meanwhile = std::max(meanwhile, level.meanwhile);
    }
    return TargetDepthBytes(width, height) + kept + NumThreads() * meanwhile;
  }

 private:
  // Coordinates of 1e7 would cost digits.
  RayBundle AroundCapture(RayBundle bundle) const {
    bundle.origin -= centre_;
    if (bundle.centre.w() != 0) {
      bundle.centre = {bundle.centre.x() / bundle.centre.w() - centre_.x(),
                       bundle.centre.y() / bundle.centre.w() - centre_.y(),
                       bundle.centre.z() / bundle.centre.w() - centre_.z(), 1};
    }
    return bundle;
  }

  // With nearness counted from where that is best.
  BundleGeometry Counted(const BundleGeometry& plain, NearnessRange* range) const {
    *range = RangeInBundle(plain, views_);
    const double zero = ZeroFor(plain.bundle(), *range);
    *range = {range->far - zero, range->middle - zero, range->near - zero};
    return BundleGeometry(plain.bundle(), zero);
  }

  // By view: pixels between neighbouring rays, where they are fewest; 0 where that is not known.
  std::vector<double> LeastSpacings(const std::optional<RayBundle>& world_rays) const {
    std::vector<double> least(views_.size(), 0);
    if (!world_rays) return least;
    const BundleGeometry plain(AroundCapture(*world_rays));
    if (!plain.valid()) return least;
    NearnessRange range;
    const BundleGeometry geometry = Counted(plain, &range);
    const ViewRanking ranking(geometry, views_, neighbour_);
    const RayBundle& bundle = geometry.bundle();
    for (int y = 0; y < bundle.height; y += kTile) {
      for (int x = 0; x < bundle.width; x += kTile) {
        for (const Sight& sight :
             ranking.Best(x + 0.5 * kTile, y + 0.5 * kTile, {range.middle, range.far, range.near},
                          static_cast<int>(views_.size()))) {
          const double spacing = sight.spacing * bundle.footprint;
          double& of_view = least[static_cast<std::size_t>(sight.view)];
          if (of_view == 0 || spacing < of_view) of_view = spacing;
        }
      }
    }
    return least;
  }

  SourceView Prepare(const DepthView& from, const std::optional<RegularGrid>& grid,
                     double visibility_px, std::size_t count) const {
    const Camera& camera = from.view.camera;
    SourceView view;
    view.width = camera.width;
    view.height = camera.height;
    Rigid camera_from_centre = from.view.camera_from_world;
    camera_from_centre.translation += camera_from_centre.rotation * centre_;
    view.view_from_world = ViewFromWorld(camera, camera_from_centre);
    view.centre = Centre(camera_from_centre);
    if (grid) {
      view.softness_absolute = visibility_px / grid->disparity_per_inverse_depth;
    } else {
      view.softness_absolute = visibility_px * kStepsMatched / (camera.fx * matching_baseline_);
      view.softness_relative = kRelativeSoftness;
    }
    const SurfaceRule rule{kSurfaceSoftness * view.softness_absolute,
                           kSurfaceSoftness * view.softness_relative};
    view.depth = DepthPyramid(from.depth, camera.width, camera.height, rule);
    view.samples = SurfaceSamples(view, kSamplesPerCapture / static_cast<int>(count) + 1);
    return view;
  }

  static std::vector<Eigen::Vector4d> SurfaceSamples(const SourceView& view, int count) {
    const DepthLevel& level = view.depth[0];
    const double step =
        std::max(1.0, std::sqrt(static_cast<double>(level.width) * level.height / count));
    const Eigen::Matrix4d world_from_view = view.view_from_world.inverse();
    std::vector<Eigen::Vector4d> samples;
    for (double y = 0.5 * step; y < level.height; y += step) {
      for (double x = 0.5 * step; x < level.width; x += step) {
        const int px = static_cast<int>(x), py = static_cast<int>(y);
        const float w = level.Known(px, py);
        if (w < 0) continue;
        samples.emplace_back(world_from_view * Eigen::Vector4d((px + 0.5) / level.per_color_x,
                                                               (py + 0.5) / level.per_color_y, 1,
                                                               static_cast<double>(w)));
      }
    }
    return samples;
  }

  // `nearness` has the bundle's rows from first_row on.
  void RenderTile(const BundleGeometry& geometry, const ViewRanking& ranking,
                  const Image<float>& nearness, int first_row, const Rect& tile_rays,
                  const Rect& rectangle, ImageSpan<RaySample> samples) const {
    const int x = tile_rays.x, y = tile_rays.y;
    const Rect whole{x, y, std::min(kTile, geometry.bundle().width - x),
                     std::min(kTile, geometry.bundle().height - y)};
    const int x0 = std::max(x, rectangle.x), y0 = std::max(y, rectangle.y);
    const int x1 = std::min(x + whole.width, rectangle.x + rectangle.width);
    const int y1 = std::min(y + whole.height, rectangle.y + rectangle.height);
    if (x0 >= x1 || y0 >= y1) return;
    const ImageSpan<const float> of_tile =
        nearness.span().Sub({x, y - first_row, whole.width, whole.height});
    TileSights tile;
    tile.nearness = of_tile(whole.width / 2, whole.height / 2);
    tile.far = tile.near = tile.nearness;
    for (int v = 0; v < whole.height; ++v) {
      const auto [low, high] = std::minmax_element(of_tile.row(v), of_tile.row(v) + whole.width);
      tile.far = std::min(tile.far, *low);
      tile.near = std::max(tile.near, *high);
    }
    tile.sights = ranking.Best(x + 0.5 * whole.width, y + 0.5 * whole.height,
                               {static_cast<double>(tile.nearness), static_cast<double>(tile.far),
                                static_cast<double>(tile.near)},
                               blend_.views + blend_.further);
    const Rect rays{x0, y0, x1 - x0, y1 - y0};
    BlendTile(geometry, views_, tile, neighbour_, blend_, rays,
              of_tile.Sub({x0 - x, y0 - y, rays.width, rays.height}),
              samples.Sub({x0 - rectangle.x, y0 - rectangle.y, rays.width, rays.height}));
  }

  BlendOptions blend_;
  TargetDepthOptions target_;
  Eigen::Vector3d centre_;  // of the capture; geometry is relative to it
  double neighbour_ = 1;    // distance between neighbouring views
  double matching_baseline_ = 1;
  std::vector<SourceView> views_;
};

}  // namespace

OptionTable Describe(RenderOptions& options) {
  return {
      "render",
      {{"views", "views that are blended for a ray", &options.views, 1, 32},
       {"maps", "depth maps that are merged to find a ray's depth", &options.maps, 1, 32},
       {"visibility_px",
        "softness of the visibility test, px of disparity per grid step (photographs: per quarter "
        "of the baseline of matching, 10 degrees or the next view)",
        &options.visibility_px, 1e-3, 100},
       {.name = "filter",
        .help = "interpolation of colours",
        .value = &options.filter,
        .choices = {"catmull_rom", "bilinear"}},
       {.name = "exposure",
        .help = "equalise the views' exposures; auto: photographs only",
        .value = &options.exposure,
        .choices = {"auto", "on", "off"}}}};
}

// Views left out, antinous (72 from 9) and fountain-P11 (view 0005), dB: 4 views and 3 maps 49.42
// and 28.62, 3 and 2 49.28 and 28.55, 2 and 2 49.04 and 28.44.
void ApplyQuality(Quality quality, RenderOptions& options) {
  const bool draft = quality == Quality::kDraft;
  options.views = draft ? 2 : quality == Quality::kBalanced ? 3 : 4;
  options.maps = quality == Quality::kBest ? 3 : 2;
  options.filter = draft ? "bilinear" : "catmull_rom";
}

std::unique_ptr<RaySource> CaptureSource(std::vector<DepthView> views,
                                         const RenderOptions& options) {
  return std::make_unique<CapturedScene>(std::move(views), options);
}

}  // namespace lamella
