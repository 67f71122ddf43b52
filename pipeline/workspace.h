// The workspace of DESIGN section 7: a folder per stage, a stage.json where it is finished.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/photograph_store.h"

namespace lamella {

class Workspace {
 public:
  // Of undistorted photographs, `kept_bytes` are handed from stage to stage in memory, too.
  explicit Workspace(std::filesystem::path root, std::size_t kept_bytes = 0)
      : root_(std::move(root)), photographs_(std::make_shared<PhotographStore>(kept_bytes)) {}
  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path Stage(const std::string& stage) const { return root_ / stage; }
  std::filesystem::path Options() const { return root_ / "lamella.toml"; }
  PhotographStore& photographs() const { return *photographs_; }

 private:
  std::filesystem::path root_;
  std::shared_ptr<PhotographStore> photographs_;
};

// What a stage says of itself: it stands in stage.json, `status` and the page show it.
struct StageReport {
  std::vector<std::pair<std::string, std::string>> summary;
  std::vector<std::string> warnings;
  std::string missed_gate;  // why the exit code is 4; empty where all is well
};

struct OutputFile {
  std::string file;  // relative to the stage's folder
  std::uintmax_t size = 0;
  std::string hash;
};

// stage.json. Times and memory are the only fields that differ between equal runs.
struct StageRecord {
  std::string stage, version;
  std::string inputs_hash, options_hash;
  bool finished = false;  // false while the stage runs, and for good where it was killed
  std::vector<OutputFile> outputs;
  double seconds = 0, peak_memory_mib = 0;
  StageReport report;

  std::string OutputsHash() const;  // of all output files' names and contents
};

// Nothing where there is no stage.json. InputError where a newer version of the program wrote it.
std::optional<StageRecord> LoadStageRecord(const Workspace& workspace, const std::string& stage);

// A stage's run. Finished files of a run of the same key that died are kept (a stage looks for them
// with Finished); anything else in the folder is removed at the start.
class StageRun {
 public:
  // InputError where the folder holds files that no stage has written.
  StageRun(const Workspace& workspace, std::string stage, std::string inputs_hash,
           std::string options_hash);
  const std::filesystem::path& folder() const { return folder_; }
  // A file that an earlier, killed run of this very stage has finished: it need not be made again.
  bool Finished(const std::string& file) const;
  // Writes stage.json; the stage counts as done from here on.
  void Commit(StageReport report, double seconds, double peak_memory_mib);

 private:
  std::filesystem::path folder_;
  StageRecord record_;
  bool resumed_ = false;
};

// True where stage.json is of a finished run with these hashes and all of its files are there
// whole.
bool IsDone(const Workspace& workspace, const std::string& stage, const std::string& inputs_hash,
            const std::string& options_hash);

// The version that a stage.json carries: results of another version are made again.
const char* ProgramVersion();

}  // namespace lamella
