// The stage depth: W/depth/NAME.exr and points.ply from W/poses.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "depth/estimate.h"
#include "depth/warped_depth.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxPoints = 1'000'000;
constexpr float kPointConfidence = 0.25F;        // pixels that are less sure give no point
constexpr int kMostWarped = 8;                   // given maps that make the map of a view without
constexpr const char* kPassesFolder = "passes";  // maps before the last pass; removed at the end

class FileStore final : public DepthStore {
 public:
  FileStore(const ViewSet& set, const PhotographStore& photographs, const StageRun& run,
            int num_passes)
      : set_(set), photographs_(photographs), run_(run), num_passes_(num_passes) {
    for (int pass = 0; pass + 1 < num_passes; ++pass)
      CreateFolder((run.folder() / File(pass, 0)).parent_path());
  }
  Image<Rgb8> Photograph(int view) override { return photographs_.Codes(ViewAt(view).image); }
  bool Has(int pass, int view) const override { return run_.Finished(File(pass, view)); }
  DepthMap Load(int pass, int view) override {
    return LoadDepthMap(run_.folder() / File(pass, view));
  }
  void Save(int pass, int view, const DepthMap& map) override {
    SaveDepthMap(run_.folder() / File(pass, view), map);
  }
  DepthMap Result(int view) { return Load(num_passes_ - 1, view); }

 private:
  const View& ViewAt(int view) const { return set_.views[static_cast<std::size_t>(view)]; }
  std::string File(int pass, int view) const {
    const std::string name = ViewAt(view).name + ".exr";
    return pass + 1 == num_passes_ ? name : fmt::format("{}/{}/{}", kPassesFolder, pass, name);
  }
  const ViewSet& set_;
  const PhotographStore& photographs_;
  const StageRun& run_;
  int num_passes_;
};

// Depth that came with the capture: all of it is sure.
DepthMap GivenDepth(const View& view) {
  DepthMap map;
  map.depth = LoadDepth(view.depth);
  if (map.depth.width() != view.camera.width || map.depth.height() != view.camera.height) {
    throw InputError(view.depth.string(),
                     fmt::format("is {}x{} px, its photograph {}x{} px", map.depth.width(),
                                 map.depth.height(), view.camera.width, view.camera.height),
                     "give depth of the photograph's size");
  }
  map.confidence = Image<float>(map.depth.width(), map.depth.height());
  for (std::size_t i = 0; i < map.depth.size(); ++i)
    map.confidence.data()[i] = map.depth.data()[i] > 0 ? 1.0F : 0.0F;
  return map;
}

// The views that came with depth.
std::vector<int> GivenViews(const ViewSet& set) {
  std::vector<int> given;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    if (!set.views[v].depth.empty()) given.push_back(static_cast<int>(v));
  }
  if (given.empty()) {
    throw InputError(set.views.front().image.string(), "came without depth, as all others did",
                     "name depth of at least one view in transforms.json (depth_file_path, an EXR "
                     "with channel Z; for photographs without distortion) or leave --depth given "
                     "out");
  }
  return given;
}

DepthMap DepthFromOthers(const ViewSet& set, int view, const std::vector<int>& given,
                         FileStore& store) {
  WarpedDepth warped(set.views[static_cast<std::size_t>(view)]);
  for (const int v : NearestViews(set.views, view, given, kMostWarped)) {
    warped.Add(set.views[static_cast<std::size_t>(v)], store.Load(0, v));
  }
  return warped.Result();
}

// Views without depth get it from those that came with it.
DepthReport TakeGivenDepth(const ViewSet& set, FileStore& store, Progress& progress) {
  const std::vector<int> given = GivenViews(set);
  const auto count = static_cast<std::int64_t>(set.views.size());
  progress.Start("given depth", count, "views");
  for (const int v : given) {
    if (!store.Has(0, v)) store.Save(0, v, GivenDepth(set.views[static_cast<std::size_t>(v)]));
    progress.Advance();
  }
  ParallelForEach(0, count, [&](std::int64_t i) {
    const int v = static_cast<int>(i);
    if (std::binary_search(given.begin(), given.end(), v)) return;
    if (!store.Has(0, v)) store.Save(0, v, DepthFromOthers(set, v, given, store));
    progress.Advance();
  });
  DepthReport report{{{"method", "given with the capture"}}, {}};
  if (given.size() < set.views.size()) {
    report.summary.emplace_back("from other views' depth",
                                fmt::format("{} views, from the {} that came with depth",
                                            set.views.size() - given.size(), given.size()));
  }
  return report;
}

// What a finished map is counted for.
struct MapCounts {
  std::int64_t pixels = 0, known = 0, infinite = 0;
  double confidence = 0;  // sum over known pixels
  std::vector<ColoredPoint> points;
};

// Known pixels of finite depth, every n-th so that there are at most `most`.
std::vector<ColoredPoint> SamplePoints(const View& view, const DepthMap& map,
                                       const Image<Rgb8>& photo, std::size_t most) {
  const auto width = static_cast<std::size_t>(map.depth.width());
  const auto usable = [&](std::size_t i) {
    const float z = map.depth.data()[i];
    return z > 0 && std::isfinite(z) && map.confidence.data()[i] >= kPointConfidence;
  };
  std::size_t count = 0;
  for (std::size_t i = 0; i < map.depth.size(); ++i) count += usable(i);
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / most);
  const Rigid world_from_camera = Inverse(view.camera_from_world);
  const double sx = static_cast<double>(view.camera.width) / map.depth.width(),
               sy = static_cast<double>(view.camera.height) / map.depth.height();
  std::vector<ColoredPoint> points;
  std::size_t next = 0;
  for (std::size_t i = 0; i < map.depth.size(); ++i) {
    if (!usable(i) || next++ % step != 0) continue;
    const std::size_t column = i % width, row = i / width;
    const Eigen::Vector2d pixel((static_cast<double>(column) + 0.5) * sx,
                                (static_cast<double>(row) + 0.5) * sy);
    const std::optional<Eigen::Vector3d> ray = Unproject(view.camera, pixel);
    if (!ray) continue;
    const int u = std::min(static_cast<int>(pixel.x()), photo.width() - 1);
    const int v = std::min(static_cast<int>(pixel.y()), photo.height() - 1);
    points.push_back(
        {world_from_camera * (static_cast<double>(map.depth.data()[i]) * *ray), photo(u, v)});
  }
  return points;
}

std::vector<MapCounts> CountMaps(const ViewSet& set, FileStore& store) {
  std::vector<MapCounts> counts(set.views.size());
  const std::size_t most =
      std::max<std::size_t>(1, kMaxPoints / std::max<std::size_t>(1, counts.size()));
  ParallelForEach(0, static_cast<std::int64_t>(counts.size()), [&](std::int64_t v) {
    const int view = static_cast<int>(v);
    MapCounts& count = counts[static_cast<std::size_t>(v)];
    const DepthMap map = store.Result(view);
    for (std::size_t i = 0; i < map.depth.size(); ++i) {
      const float z = map.depth.data()[i];
      ++count.pixels;
      count.known += z > 0;
      count.infinite += std::isinf(z);
      count.confidence += static_cast<double>(map.confidence.data()[i]);
    }
    count.points =
        SamplePoints(set.views[static_cast<std::size_t>(v)], map, store.Photograph(view), most);
  });
  return counts;
}

StageReport Summarise(DepthReport depth, const ViewSet& set, const std::vector<MapCounts>& counts) {
  StageReport report{std::move(depth.summary), std::move(depth.warnings), ""};
  MapCounts total;
  for (std::size_t v = 0; v < counts.size(); ++v) {
    total.pixels += counts[v].pixels;
    total.known += counts[v].known;
    total.infinite += counts[v].infinite;
    total.confidence += counts[v].confidence;
    if (counts[v].known == 0) report.warnings.push_back(set.views[v].name + ": no depth was found");
  }
  const auto percent = [&](std::int64_t part, std::int64_t whole) {
    return fmt::format(
        "{:.2f} %",
        whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0);
  };
  report.summary.emplace_back("views", fmt::format("{}", counts.size()));
  report.summary.emplace_back("known", percent(total.known, total.pixels));
  report.summary.emplace_back("at infinity", percent(total.infinite, total.pixels));
  report.summary.emplace_back(
      "mean confidence",
      fmt::format("{:.3f}",
                  total.known > 0 ? total.confidence / static_cast<double>(total.known) : 0.0));
  return report;
}

}  // namespace

StageReport RunDepth(const Workspace& workspace, const DepthOptions& options, StageRun& run,
                     Progress& progress) {
  const ViewSet set = LoadViewSet(workspace);
  const bool given = options.source == "given";
  FileStore store(set, workspace.photographs(), run, given ? 1 : NumDepthPasses(set, options));
  DepthReport depth =
      given ? TakeGivenDepth(set, store, progress) : EstimateDepth(set, options, store, progress);
  const std::vector<MapCounts> counts = CountMaps(set, store);
  std::vector<ColoredPoint> points;
  for (const MapCounts& count : counts)
    points.insert(points.end(), count.points.begin(), count.points.end());
  SavePoints(run.folder() / "points.ply", points);
  std::error_code ignored;
  fs::remove_all(run.folder() / kPassesFolder, ignored);
  return Summarise(std::move(depth), set, counts);
}

}  // namespace lamella
