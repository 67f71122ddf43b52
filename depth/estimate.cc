#include "depth/estimate.h"

#include <memory>
#include <optional>
#include <utility>

#include "depth/method.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

bool HasAll(const DepthStore& store, int pass, int num_views) {
  for (int v = 0; v < num_views; ++v) {
    if (!store.Has(pass, v)) return false;
  }
  return true;
}

// A map is saved while the next one is made.
void RunPass(int pass, int num_views, DepthMethod& method, DepthStore& store, Progress& progress) {
  std::optional<DepthMap> made;
  for (int view = 0; view <= num_views; ++view) {
    std::optional<DepthMap> next;
    ParallelForEach(0, 2, [&](std::int64_t task) {
      if (task == 0 && view < num_views && !store.Has(pass, view)) {
        next = pass == 0 ? method.Match(view) : method.Refine(pass, view);
      } else if (task == 1 && view > 0) {
        if (made) store.Save(pass, view - 1, *made);
        progress.Advance();
      }
    });
    made = std::move(next);
  }
}

}  // namespace

OptionTable Describe(DepthOptions& o) {
  return {
      "depth",
      {
          {.name = "source",
           .help =
               "estimate: from the photographs; given: what came with the capture "
               "(depth_file_path of transforms.json, an HCI grid's true disparity); views without "
               "any get it from those that have it",
           .value = &o.source,
           .choices = {"estimate", "given"},
           .flag = "--depth"},
          {"median_radius", "of the colour-weighted median of labels, px; 0: none",
           &o.median_radius, 0, 5},
          {"fusion_passes", "camera grids: times that the views' maps are made to agree",
           &o.fusion_passes, 0, 4},
          {"grid_reach", "camera grids: sources are at most so many steps away", &o.grid_reach, 1,
           64},
          {"grid_views_per_side", "camera grids: sources on each side of a view",
           &o.grid_views_per_side, 1, 8},
          {"grid_color", "camera grids: match colour and gradient, else the gradient alone",
           &o.grid_color},
          {"grid_step_px", "camera grids: between two labels at the farthest source, px",
           &o.grid_step_px, 0.02, 4},
          {"disparity_min", "camera grids: smallest disparity, px per step; unset: measured",
           &o.disparity_min},
          {"disparity_max", "camera grids: largest disparity, px per step; unset: measured",
           &o.disparity_max},
          {"sweep_size_px", "photographs: longer side at which they are matched, px",
           &o.sweep_size_px, 16, 16384},
          {"sweep_labels", "photographs: depth hypotheses at most", &o.sweep_labels, 16, 510},
          {"sweep_step_px", "photographs: between two hypotheses in the widest source, px",
           &o.sweep_step_px, 0.1, 16},
          {"sweep_sources", "photographs: neighbours that a view is matched with, at most",
           &o.sweep_sources, 1, 8},
          {"sweep_angle_deg",
           "photographs: angle between the lines of sight of a view and its sources, at most "
           "(the two best are taken in any case)",
           &o.sweep_angle_deg, 0.1, 90},
          {"check_passes",
           "photographs: times that the views' maps are checked against each other and averaged",
           &o.check_passes, 1, 4},
          {"check_views", "photographs: neighbours whose maps a pixel is checked against, at most",
           &o.check_views, 1, 32},
          {"check_agreeing",
           "photographs: neighbours that must confirm a pixel (half of those there are, where that "
           "is less)",
           &o.check_agreeing, 1, 32},
          {"check_tolerance", "photographs: relative difference of depth that still agrees",
           &o.check_tolerance, 1e-5, 0.5},
      }};
}

void ApplyQuality(Quality quality, DepthOptions& o) {
  const bool draft = quality == Quality::kDraft, best = quality == Quality::kBest;
  o.median_radius = draft ? 2 : 3;
  o.fusion_passes = draft ? 0 : best ? 2 : 1;
  o.grid_views_per_side = draft ? 2 : 4;
  o.grid_color = !draft;
  o.grid_step_px = draft ? 0.4 : 0.26;
  o.sweep_size_px = draft ? 768 : best ? 1536 : 1024;
  o.sweep_labels = draft ? 128 : 256;
  o.sweep_step_px = draft ? 2.0 : 2.4;
  o.sweep_sources = draft ? 2 : best ? 6 : 4;
  o.check_passes = draft ? 1 : best ? 3 : 2;
  o.check_views = draft ? 4 : best ? 8 : 6;
  o.check_agreeing = draft ? 1 : 2;
  o.check_tolerance = draft ? 0.02 : 0.01;
}

int NumDepthPasses(const ViewSet& set, const DepthOptions& options) {
  return 1 + (FindRegularGrid(set.views) ? options.fusion_passes : options.check_passes);
}

DepthReport EstimateDepth(const ViewSet& set, const DepthOptions& options, DepthStore& store,
                          Progress& progress) {
  const int num_views = static_cast<int>(set.views.size());
  const int passes = NumDepthPasses(set, options);
  const std::optional<RegularGrid> grid = FindRegularGrid(set.views);
  const std::unique_ptr<DepthMethod> method =
      grid ? MakeGridMethod(set, *grid, options, store) : MakeSweepMethod(set, options, store);
  progress.Start("depth", static_cast<std::int64_t>(num_views) * passes, "maps");
  const bool finished = HasAll(store, passes - 1, num_views);
  for (int pass = 0; pass < passes && !finished; ++pass) {
    RunPass(pass, num_views, *method, store, progress);
  }
  return method->Report();
}

}  // namespace lamella
