#include "pipeline/synth_layers.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "datasets_synthetic/recipe.h"
#include "datasets_synthetic/scene.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "lightfield/parallel.h"
#include "pipeline/calibration_record.h"
#include "pipeline/make_layers.h"
#include "pipeline/peak_memory.h"

namespace lamella {
namespace {

constexpr double kRangeSamplesPerView = 40000;  // rays that tell where near and far are

// What the reference camera sees, as depths along its axis.
DepthRange DepthRangeOfScene(const SceneSource& scene, const View& reference) {
  const double shrink = std::max(1.0, std::sqrt(double{1} * reference.camera.width *
                                                reference.camera.height / kRangeSamplesPerView));
  const Camera camera = Resized(reference.camera, 1 / shrink);
  const RayBundle bundle = BundleOfCamera(camera, reference.camera_from_world);
  Image<float> depths(bundle.width, bundle.height);
  scene.QueryDepth(bundle, {0, 0, bundle.width, bundle.height}, depths.span());
  std::vector<double> inverse_depths;  // 0 at infinity
  for (std::size_t i = 0; i < depths.size(); ++i) {
    inverse_depths.push_back(1 / static_cast<double>(depths.data()[i]));
  }
  return DepthRangeOf(std::move(inverse_depths));
}

LayersRecord PlaceScene(const SynthLayersOptions& options, const SceneSource& scene,
                        const std::vector<View>& views, std::string* note) {
  LayersRecord record;
  if (!options.like.empty()) {
    const LayersRecord like = LoadLayersRecord(Workspace(options.like));
    record.display = like.display;
    record.calibration = like.calibration;
    record.placement = like.placement;
    return record;
  }
  const PlacementOptions& placement = options.layers.placement;
  record.display = DisplayFor(options.layers);
  record.calibration = CalibrationFor(options.layers, record.display);
  const View& reference = ReferenceView(views, placement.reference_view);
  const DepthRange range = ChooseDepthRange(placement, FindRegularGrid(views),
                                            [&] { return DepthRangeOfScene(scene, reference); });
  record.placement = Place(reference, range.near, range.far, record.display, placement, note);
  return record;
}

}  // namespace

std::vector<OptionTable> Describe(SynthLayersOptions& options) {
  return {Describe(options.layers),
          {"synth",
           {{.name = "like",
             .help = "a workspace whose display and placement are used, so that its layers can be "
                     "compared with these",
             .value = &options.like,
             .flag = "--like"}}}};
}

StageReport SynthLayers(SynthLayersOptions options, const Workspace& workspace,
                        Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const PeakMemory memory;
  Recipe recipe = FindRecipe(options.scene);
  const std::string inputs = ToToml(recipe);
  auto scene = std::make_unique<SceneSource>(std::move(recipe.scene));
  std::string note;
  LayersRecord record =
      PlaceScene(options, *scene, CamerasOf(recipe.layout, recipe.seed, options.scene), &note);
  StageRun run(workspace, "layers",
               ContentHash(inputs + ToToml(record.display) +
                           (record.calibration ? CalibrationText(*record.calibration) : "")),
               ContentHash(ToToml(Describe(options))));
  StageReport report =
      MakeLayers(std::move(scene), std::move(record), options.layers, note, run, progress);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  run.Commit(report, elapsed.count(), memory.Mib());
  return report;
}

}  // namespace lamella
