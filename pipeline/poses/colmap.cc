#include "pipeline/poses/colmap.h"

#include <algorithm>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "pipeline/poses/database.h"
#include "pipeline/poses/process.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

bool StartsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

bool TellsAnError(std::string_view line) {
  return StartsWith(line, "ERROR:") || line.find("Check failed") != std::string_view::npos ||
         StartsWith(line, "terminate called") || StartsWith(line, "  what():");
}

// glog puts time, process and place before a message: "F20240229 12:00:00.123456 4711 file.cc:12]
// ".
std::string WithoutLogPrefix(std::string_view line) {
  const std::size_t end = line.find("] ");
  return std::string(end == std::string_view::npos ? line : line.substr(end + 2));
}

// A line with this text counts as a unit of progress.
std::function<void(std::string_view)> Counter(Progress& progress, std::string text) {
  return [&progress, text = std::move(text)](std::string_view line) {
    if (line.find(text) != std::string_view::npos) progress.Advance();
  };
}

// On top of COLMAP's own thresholds; an option may be given only once.
std::map<std::string, std::string> MapperOptions(MapperEffort effort) {
  switch (effort) {
    case MapperEffort::kUsual:
      return {};
    case MapperEffort::kRelaxed:
      return {{"init_min_tri_angle", "4"},
              {"init_min_num_inliers", "50"},
              {"abs_pose_min_num_inliers", "20"}};
    case MapperEffort::kLast:
      return {{"init_min_tri_angle", "1"},           {"init_min_num_inliers", "15"},
              {"init_max_reg_trials", "5"},          {"abs_pose_min_num_inliers", "12"},
              {"abs_pose_min_inlier_ratio", "0.15"}, {"tri_min_angle", "0.5"},
              {"filter_min_tri_angle", "0.5"},       {"tri_ignore_two_view_tracks", "0"}};
  }
  return {};
}

}  // namespace

std::optional<std::string> FindColmap() {
  const std::optional<fs::path> program = FindProgram("colmap");
  return program ? std::optional<std::string>(program->string()) : std::nullopt;
}

std::optional<std::string> ColmapVersion() {
  const std::optional<std::string> program = FindColmap();
  if (!program) return std::nullopt;
  std::string version;
  RunProcess({*program, {"help"}, {{"QT_QPA_PLATFORM", "offscreen"}}}, [&](std::string_view line) {
    if (version.empty() && StartsWith(line, "COLMAP")) version = line;
  });
  return version;
}

std::string RequireColmap() {
  if (const std::optional<std::string> program = FindColmap()) return *program;
  throw MachineError("", "COLMAP is not installed (no program \"colmap\" in PATH)",
                     "install it with: sudo apt-get install colmap");
}

Colmap::Colmap(fs::path folder, Progress& progress)
    : program_(RequireColmap()), folder_(std::move(folder)), progress_(progress) {
  std::error_code error;
  fs::remove_all(folder_, error);
  CreateFolder(Images());
}

Colmap::Outcome Colmap::Run(const std::string& verb, const std::vector<std::string>& arguments,
                            const std::function<void(std::string_view)>& on_line) {
  Command command{program_, {verb}, {}};
  command.arguments.insert(command.arguments.end(), arguments.begin(), arguments.end());
  // Its logs would go to /tmp under the time's name.
  command.environment = {{"QT_QPA_PLATFORM", "offscreen"},
                         {"LC_ALL", "C"},
                         {"OMP_NUM_THREADS", "1"},
                         {"OPENBLAS_NUM_THREADS", "1"},
                         {"GLOG_log_dir", folder_.string()}};
  Outcome outcome;
  const ProcessResult result = RunProcess(command, [&](std::string_view line) {
    progress_.Note(fmt::format("colmap {}: {}", verb, line));
    if (TellsAnError(line)) outcome.reason = WithoutLogPrefix(line);
    on_line(line);
  });
  outcome.succeeded = result.Succeeded();
  if (!outcome.succeeded && outcome.reason.empty()) {
    outcome.reason = result.signal != 0 ? fmt::format("ended by signal {}", result.signal)
                                        : fmt::format("exit code {}", result.exit_code);
  }
  return outcome;
}

void Colmap::Require(const std::string& verb, const Outcome& outcome) const {
  if (outcome.succeeded) return;
  std::error_code error;
  if (const fs::space_info space = fs::space(folder_, error); !error && space.available < 1 << 20) {
    throw MachineError(folder_.string(), "no space left on the disk",
                       "free some, then run the same command again");
  }
  throw MachineError("", fmt::format("COLMAP's {} failed ({})", verb, outcome.reason),
                     "run again with --verbose to see its output");
}

void Colmap::CopyDatabase(const fs::path& to) const {
  std::error_code error;
  fs::copy_file(Database(), to, fs::copy_options::overwrite_existing, error);
  if (!error) return;
  throw MachineError(to.string(), "can't be written (" + error.message() + ")",
                     "check free space and permissions, then run the same command again");
}

fs::path Colmap::FreshFolder(const std::string& name) {
  fs::path folder = folder_ / fmt::format("{}_{}", name, ++attempts_);
  CreateFolder(folder);
  return folder;
}

void Colmap::ExtractFeatures(const std::vector<std::string>& names,
                             const ExtractionOptions& options) {
  progress_.Start("find features", static_cast<std::int64_t>(names.size()), "views");
  const std::vector<std::string> arguments = {"--database_path",
                                              Database().string(),
                                              "--image_path",
                                              Images().string(),
                                              "--SiftExtraction.use_gpu",
                                              "0",
                                              "--SiftExtraction.num_threads",
                                              std::to_string(NumThreads()),
                                              "--SiftExtraction.max_image_size",
                                              std::to_string(options.image_size_px),
                                              "--SiftExtraction.max_num_features",
                                              std::to_string(options.features),
                                              "--SiftExtraction.first_octave",
                                              std::to_string(options.first_octave)};
  Require("feature_extractor",
          Run("feature_extractor", arguments, Counter(progress_, "Processed file")));
  // The features of an image are the same whichever thread finds them; the numbers of the images
  // follow the order in which they were finished.
  ColmapDatabase(Database()).NumberImages(names);
}

void Colmap::ImportMatchesInto(const fs::path& database, const fs::path& list) {
  const std::vector<std::string> arguments = {"--database_path",
                                              database.string(),
                                              "--match_list_path",
                                              list.string(),
                                              "--match_type",
                                              "raw",
                                              "--SiftMatching.use_gpu",
                                              "0",
                                              "--SiftMatching.num_threads",
                                              "1"};
  Require("matches_importer", Run("matches_importer", arguments, Counter(progress_, " - ")));
}

void Colmap::ImportMatches(const std::vector<fs::path>& lists, int num_pairs) {
  progress_.Start("verify matches", num_pairs, "pairs");
  std::vector<fs::path> databases = {Database()};
  for (std::size_t i = 1; i < lists.size(); ++i) {
    databases.push_back(folder_ / fmt::format("database_{}.db", i));
    CopyDatabase(databases.back());
  }
  ParallelForEach(0, static_cast<std::int64_t>(lists.size()), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    ImportMatchesInto(databases[k], lists[k]);
  });
  ColmapDatabase whole(Database());
  for (std::size_t i = 1; i < databases.size(); ++i) {
    whole.TakeMatches(databases[i]);
    std::error_code error;
    fs::remove(databases[i], error);  // else with the folder
  }
}

std::vector<fs::path> Colmap::MapInto(const fs::path& output, const fs::path& database,
                                      std::map<std::string, std::string> options,
                                      const std::function<void(std::string_view)>& on_line) {
  options["num_threads"] = "1";
  // All cameras and points are adjusted together when a model has grown by 40 % (COLMAP: 10 %) and
  // at its end: fountain-P11 has the same errors, for 5 % less of the stage's processor time
  // (Sceaux castle: 8 %).
  options["ba_global_images_ratio"] = "1.4";
  options["ba_global_points_ratio"] = "1.4";
  std::vector<std::string> arguments = {"--database_path", database.string(), "--image_path",
                                        Images().string(), "--output_path",   output.string()};
  for (const auto& [name, value] : options) {
    arguments.insert(arguments.end(), {"--Mapper." + name, value});
  }
  const Outcome outcome = Run("mapper", arguments, on_line);
  std::vector<fs::path> models;
  for (const auto& entry : fs::directory_iterator(output)) {
    if (entry.is_directory()) models.push_back(entry.path());
  }
  std::sort(models.begin(), models.end());
  const bool started = outcome.reason.find("failed to create sparse model") == std::string::npos;
  if (models.empty() && started) Require("mapper", outcome);
  return models;
}

std::vector<fs::path> Colmap::Map(int num_images, MapperEffort effort) {
  progress_.Start("find camera positions", num_images, "views");
  return MapInto(FreshFolder("sparse"), Database(), MapperOptions(effort),
                 Counter(progress_, "Registering image"));
}

std::vector<fs::path> Colmap::MapWithFreePrincipalPoint(const std::atomic<bool>& wanted) {
  struct Unwanted {};
  const fs::path output = FreshFolder("sparse_free"), database = folder_ / "database_free.db";
  // Opening the database writes to it, so each of two programs has its own.
  CopyDatabase(database);
  std::map<std::string, std::string> options = MapperOptions(MapperEffort::kUsual);
  options["ba_refine_principal_point"] = "1";
  try {
    return MapInto(output, database, std::move(options), [&](std::string_view) {
      if (!wanted) throw Unwanted();
    });
  } catch (const Unwanted&) {
    return {};
  }
}

std::optional<fs::path> Colmap::Triangulate(const fs::path& input, int num_images) {
  progress_.Start("triangulate points", num_images, "views");
  const fs::path output = FreshFolder("triangulated");
  // Known cameras are exact: little parallax is enough for a point, and two views where there are
  // no more to confirm it.
  const Outcome outcome =
      Run("point_triangulator",
          {"--database_path", Database().string(), "--image_path", Images().string(),
           "--input_path", input.string(), "--output_path", output.string(), "--Mapper.num_threads",
           "1", "--Mapper.tri_min_angle", "0.3", "--Mapper.filter_min_tri_angle", "0.3",
           "--Mapper.tri_ignore_two_view_tracks", num_images < 4 ? "0" : "1"},
          Counter(progress_, "Triangulating image"));
  // It adjusts the points that it found, and dies where there are none.
  if (outcome.reason.find("bundle_adjuster.Solve") != std::string::npos) return std::nullopt;
  Require("point_triangulator", outcome);
  return output;
}

}  // namespace lamella
