#include "pipeline/poses/reconstruct.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/poses/database.h"
#include "pipeline/poses/match.h"
#include "pipeline/poses/pair_selection.h"
#include "pipeline/poses/photo_folder.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// COLMAP's geometric verification asks for at least as many.
constexpr std::size_t kMinMatches = 15;

// Gone at the end, whatever ends it.
class Scratch {
 public:
  explicit Scratch(fs::path folder) : folder_(std::move(folder)) {}
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

 private:
  fs::path folder_;
};

// The views of a capture in COLMAP's hands.
struct Photos {
  const CaptureRecord& capture;
  std::vector<std::string> files;        // safe names, one a view
  std::vector<std::uint32_t> image_ids;  // COLMAP's, one a view
};

std::string PlaceOf(const CaptureRecord& capture) {
  return capture.views[0].file.parent_path().string();
}

std::vector<std::uint32_t> ImageIds(ColmapDatabase& database, const CaptureRecord& capture,
                                    const std::vector<std::string>& files) {
  const std::map<std::string, std::uint32_t> by_name = database.ImageIds();
  std::vector<std::uint32_t> ids;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto id = by_name.find(files[i]);
    if (id == by_name.end()) {  // it calls that a success
      throw InputError(capture.views[i].file.string(), "can't be read by COLMAP",
                       "convert it to an 8-bit PNG");
    }
    ids.push_back(id->second);
  }
  return ids;
}

// COLMAP's camera with one radial term: what photographs without calibration are refined with.
ColmapCamera SimpleRadial(const Camera& camera) {
  return {2, "SIMPLE_RADIAL", {camera.fx, camera.cx, camera.cy, 0}};
}

// A camera per view where cameras are known; else one per device, focal length and size.
std::vector<ColmapDatabase::CameraRow> CameraRows(const Photos& photos) {
  using Key = std::tuple<std::string, int, int, double, std::size_t>;
  std::map<Key, ColmapDatabase::CameraRow> rows;
  std::vector<Key> order;
  for (std::size_t i = 0; i < photos.image_ids.size(); ++i) {
    const CapturedView& view = photos.capture.views[i];
    const Camera& camera = view.camera;
    const bool known = view.camera_origin == CameraOrigin::kKnown;
    const Key key(view.device, camera.width, camera.height, camera.fx, known ? i + 1 : 0);
    if (!rows.contains(key)) {
      order.push_back(key);
      rows[key] = {known ? ToColmap(camera) : SimpleRadial(camera),
                   camera.width,
                   camera.height,
                   view.camera_origin != CameraOrigin::kGuess,
                   {}};
    }
    rows[key].image_ids.push_back(photos.image_ids[i]);
  }
  std::vector<ColmapDatabase::CameraRow> in_order;
  for (const Key& key : order) in_order.push_back(rows[key]);
  return in_order;
}

std::vector<ImageFeatures> ReadFeatures(ColmapDatabase& database, const Photos& photos) {
  std::vector<ImageFeatures> features;
  for (const std::uint32_t id : photos.image_ids) {
    features.push_back({database.ReadDescriptors(id), database.ReadFeatureSizes(id)});
  }
  return features;
}

struct PairMatches {
  int first, second;
  std::vector<FeatureMatch> matches;
};

// Of all pairs that are worth it, in order; pairs with too few matches are left out.
std::vector<PairMatches> MatchAll(const std::vector<ImageFeatures>& features, Progress& progress) {
  std::vector<PairMatches> pairs;
  for (const auto& [first, second] : SelectPairs(features, progress)) {
    pairs.push_back({first, second, {}});
  }
  std::vector<PackedDescriptors> packed;
  for (const ImageFeatures& image : features) packed.emplace_back(image.descriptors);
  progress.Start("match features", static_cast<std::int64_t>(pairs.size()), "pairs");
  ParallelForEach(0, static_cast<std::int64_t>(pairs.size()), [&](std::int64_t p) {
    PairMatches& pair = pairs[static_cast<std::size_t>(p)];
    pair.matches = MatchFeatures(packed[static_cast<std::size_t>(pair.first)],
                                 packed[static_cast<std::size_t>(pair.second)]);
    progress.Advance();
  });
  std::erase_if(pairs, [](const PairMatches& pair) { return pair.matches.size() < kMinMatches; });
  return pairs;
}

// In lists for COLMAP to verify side by side. Their number follows from the pairs alone, so that
// the threads do not matter; neighbouring pairs, alike in matches, go to different lists.
std::vector<fs::path> WriteMatchLists(const fs::path& folder, const std::vector<PairMatches>& pairs,
                                      const std::vector<std::string>& names) {
  constexpr std::size_t kPairsWorthAProcess = 12, kMostLists = 8;
  std::vector<std::string> texts(
      std::clamp(pairs.size() / kPairsWorthAProcess, std::size_t{1}, kMostLists));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PairMatches& pair = pairs[i];
    std::string& text = texts[i % texts.size()];
    text += fmt::format("{} {}\n", names[static_cast<std::size_t>(pair.first)],
                        names[static_cast<std::size_t>(pair.second)]);
    for (const FeatureMatch& match : pair.matches) {
      text += fmt::format("{} {}\n", match.first, match.second);
    }
    text += '\n';
  }
  std::vector<fs::path> lists;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    lists.push_back(folder / fmt::format("matches_{}.txt", i));
    WriteTextAtomically(lists.back(), texts[i]);
  }
  return lists;
}

struct Matching {
  int pairs = 0;  // verified
  std::int64_t matches = 0;
};

Matching Match(Colmap& colmap, const Photos& photos, const fs::path& scratch, Progress& progress) {
  std::vector<ImageFeatures> features;
  {
    ColmapDatabase database(colmap.Database());
    database.ReplaceCameras(CameraRows(photos));
    features = ReadFeatures(database, photos);
  }
  const std::vector<PairMatches> pairs = MatchAll(features, progress);
  colmap.ImportMatches(WriteMatchLists(scratch, pairs, photos.files),
                       static_cast<int>(pairs.size()));
  ColmapDatabase database(colmap.Database());
  const Matching matching{database.CountVerifiedPairs(), database.CountVerifiedMatches()};
  if (matching.pairs == 0) {
    throw InputError(PlaceOf(photos.capture),
                     "the photographs do not overlap: no two of them share enough features",
                     "take each so that it shares two thirds of its picture with the next");
  }
  return matching;
}

// ---- mapping ----

// COLMAP may find several models that do not hang together; the one with the most images counts.
std::optional<ColmapModel> LargestModel(const std::vector<fs::path>& folders) {
  std::optional<ColmapModel> largest;
  for (const fs::path& folder : folders) {
    if (!IsColmapModel(folder)) continue;
    ColmapModel model = ReadColmapModel(folder);
    const auto size = [](const ColmapModel& m) {
      return std::pair(m.images.size(), m.points.size());
    };
    if (!largest || size(model) > size(*largest)) largest = std::move(model);
  }
  return largest;
}

ColmapModel MapWithFallbacks(Colmap& colmap, const Photos& photos,
                             std::vector<std::string>& warnings) {
  const int count = static_cast<int>(photos.files.size());
  std::optional<ColmapModel> best;
  MapperEffort effort_of_best = MapperEffort::kUsual;
  for (const MapperEffort effort :
       {MapperEffort::kUsual, MapperEffort::kRelaxed, MapperEffort::kLast}) {
    // The last effort is for captures that do not start at all: it takes views that do not fit.
    if (best && effort == MapperEffort::kLast) break;
    std::optional<ColmapModel> model = LargestModel(colmap.Map(count, effort));
    if (model && model->images.size() < 2) model.reset();
    if (model && (!best || model->images.size() > best->images.size())) {
      best = std::move(model);
      effort_of_best = effort;
    }
    if (best && best->images.size() == photos.files.size()) break;
  }
  if (best && effort_of_best == MapperEffort::kLast) {
    warnings.push_back("the photographs share few features or little parallax: poses may be wrong");
  }
  if (best) return std::move(*best);
  throw InputError(PlaceOf(photos.capture),
                   "no two photographs overlap with enough parallax to start from",
                   "take them from places further apart, so that each shares two thirds of its "
                   "picture with the next");
}

double LargestShift(const ColmapModel& model) {
  double largest = 0;
  for (const auto& [id, camera] : model.cameras) {
    const Eigen::Vector2d shift(camera.cx - camera.width / 2.0, camera.cy - camera.height / 2.0);
    largest = std::max(largest, shift.norm() / std::max(camera.width, camera.height));
  }
  return largest;
}

std::int64_t CountObservations(const ColmapModel& model) {
  std::int64_t count = 0;
  for (const auto& [id, point] : model.points)
    count += static_cast<std::int64_t>(point.track.size());
  return count;
}

// Two more numbers a camera must pay for themselves: the Bayesian information criterion over the
// residuals of all observations (two each).
bool IsBetter(const ColmapModel& free, const ColmapModel& fixed) {
  constexpr double kMostShift = 0.03;  // of the longer side: beyond it the fit went astray
  if (free.images.size() < fixed.images.size() || LargestShift(free) > kMostShift) return false;
  const double residuals = 2.0 * static_cast<double>(CountObservations(free));
  const double gain =
      residuals * 2 * std::log(ReprojectionErrorPx(fixed) / ReprojectionErrorPx(free));
  return gain > 2.0 * static_cast<double>(free.cameras.size()) * std::log(residuals);
}

// The mapping with the principal point free. COLMAP maps on one thread: where there are more, it
// goes on beside the other mapping; else, or where it is not started yet, when its model is asked
// for.
class FreeMapping {
 public:
  explicit FreeMapping(Colmap& colmap)
      : models_(std::async(NumThreads() > 1 ? std::launch::async : std::launch::deferred,
                           [this, &colmap] { return colmap.MapWithFreePrincipalPoint(wanted_); })) {
  }
  FreeMapping(const FreeMapping&) = delete;
  FreeMapping& operator=(const FreeMapping&) = delete;
  ~FreeMapping() { wanted_ = false; }  // the future waits until it has ended

  std::optional<ColmapModel> Model() { return LargestModel(models_.get()); }

 private:
  std::atomic<bool> wanted_ = true;
  std::future<std::vector<fs::path>> models_;
};

ColmapModel Map(Colmap& colmap, const Photos& photos, const ReconstructionOptions& options,
                Reconstruction& result) {
  constexpr std::size_t kEnoughViews = 8;  // the principal point is weakly bound by fewer
  std::optional<FreeMapping> free_mapping;
  if (options.refine_principal_point && photos.files.size() >= kEnoughViews) {
    free_mapping.emplace(colmap);
  }
  ColmapModel model = MapWithFallbacks(colmap, photos, result.warnings);
  if (!free_mapping || model.images.size() < photos.files.size()) return model;
  std::optional<ColmapModel> free = free_mapping->Model();
  const bool taken = free && IsBetter(*free, model);
  result.summary.emplace_back("principal point",
                              taken ? fmt::format("refined, {:.1f} % of the image from its centre",
                                                  100 * LargestShift(*free))
                                    : "held at the image's centre: freeing it gains nothing");
  return taken ? std::move(*free) : std::move(model);
}

// ---- known cameras ----

ColmapModel ModelOfKnown(const Photos& photos) {
  ColmapModel model;
  for (std::size_t i = 0; i < photos.files.size(); ++i) {
    const CapturedView& view = photos.capture.views[i];
    const auto camera_id = static_cast<std::uint32_t>(i + 1);  // as CameraRows numbers them
    model.cameras[camera_id] = view.camera;
    model.images[photos.image_ids[i]] = {
        photos.image_ids[i], photos.files[i], camera_id, *view.camera_from_world, {}};
  }
  return model;
}

// The share of the verified matches that the points account for: a point that k views see stands
// for a match of each pair of them. Above 1 where points join matches that were never found.
double ExplainedShare(const ColmapModel& model, std::int64_t matches) {
  double explained = 0;
  for (const auto& [id, point] : model.points) {
    const auto views = static_cast<double>(point.track.size());
    explained += views * (views - 1) / 2;
  }
  return explained / static_cast<double>(matches);
}

// The given cameras with the points that COLMAP found for them.
ColmapModel Triangulate(Colmap& colmap, const Photos& photos, const fs::path& scratch,
                        std::int64_t matches, std::vector<std::string>& warnings) {
  const ColmapModel known = ModelOfKnown(photos);
  WriteColmapModel(scratch / "known", known);
  const std::optional<fs::path> found =
      colmap.Triangulate(scratch / "known", static_cast<int>(photos.files.size()));
  ColmapModel model = found ? ReadColmapModel(*found) : known;
  for (auto& [id, image] : model.images) {
    image.camera_from_world = known.images.at(id).camera_from_world;
  }
  model.cameras = known.cameras;
  // Right cameras explain nearly all, those of other photographs about 1 %.
  constexpr double kLeastExplained = 0.1, kUsuallyExplained = 0.5;
  const double share = ExplainedShare(model, matches);
  const std::string what =
      fmt::format("the given cameras fit only {:.0f} % of the photographs' matches", 100 * share);
  const std::string fix = "check the cameras' axes and that each belongs to its photograph";
  if (share < kLeastExplained) throw InputError(PlaceOf(photos.capture), what, fix);
  if (share < kUsuallyExplained) warnings.push_back(what + "; " + fix);
  return model;
}

// ---- result ----

// Names the images by their views again and lists the views that have none.
void NameImages(const Photos& photos, Reconstruction& result) {
  std::map<std::string, std::string> view_of_file;
  std::set<std::string> lost;
  for (std::size_t i = 0; i < photos.files.size(); ++i) {
    view_of_file[photos.files[i]] = photos.capture.views[i].name;
    lost.insert(photos.capture.views[i].name);
  }
  for (auto& [id, image] : result.model.images) {
    image.name = view_of_file.at(image.name);
    lost.erase(image.name);
  }
  result.lost.assign(lost.begin(), lost.end());
}

}  // namespace

Reconstruction Reconstruct(const CaptureRecord& capture, const ReconstructionOptions& options,
                           const fs::path& scratch, Progress& progress) {
  const Scratch cleaned(scratch);
  Colmap colmap(scratch, progress);
  Photos photos{capture, MakePhotoFolder(capture, colmap.Images(), progress), {}};
  colmap.ExtractFeatures(photos.files, options.extraction);
  photos.image_ids =
      ImageIds(*std::make_unique<ColmapDatabase>(colmap.Database()), capture, photos.files);
  const Matching matching = Match(colmap, photos, scratch, progress);

  Reconstruction result;
  result.summary.emplace_back("matches",
                              fmt::format("{} in {} pairs", matching.matches, matching.pairs));
  const bool known = KnownViews(capture).has_value();
  result.model = known ? Triangulate(colmap, photos, scratch, matching.matches, result.warnings)
                       : Map(colmap, photos, options, result);
  result.summary.emplace_back("points", fmt::format("{}", result.model.points.size()));
  result.summary.emplace_back("reprojection error",
                              fmt::format("{:.2f} px (RMS)", ReprojectionErrorPx(result.model)));
  NameImages(photos, result);
  return result;
}

}  // namespace lamella
