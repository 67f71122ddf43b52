// The workspace of DESIGN section 7: a folder per stage, a stage.json where it is finished.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lamella {

class Workspace {
 public:
  explicit Workspace(std::filesystem::path root) : root_(std::move(root)) {}
  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path Stage(const std::string& stage) const { return root_ / stage; }
  std::filesystem::path Options() const { return root_ / "lamella.toml"; }

 private:
  std::filesystem::path root_;
};

// What a stage says of itself: it stands in stage.json, `status` and the page show it.
struct StageReport {
  std::vector<std::pair<std::string, std::string>> summary;
  std::vector<std::string> warnings;
  std::string missed_gate;  // why the exit code is 4; empty where all is well
};

// stage.json.
struct StageRecord {
  std::string stage, version;
  std::string inputs_hash, options_hash;
  std::vector<std::pair<std::string, std::string>> outputs;  // file (relative), content hash
  double seconds = 0, peak_memory_mib = 0;
  StageReport report;
  std::string OutputsHash() const;  // of all output files' names and contents
};
std::optional<StageRecord> LoadStageRecord(const Workspace& workspace, const std::string& stage);

// A stage's run. Finished files of a run of the same key that died are kept (a stage looks for them
// with Finished); anything else in the folder is removed at the start.
class StageRun {
 public:
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
};

// True where stage.json has these hashes and all of its files are there.
bool IsDone(const Workspace& workspace, const std::string& stage, const std::string& inputs_hash,
            const std::string& options_hash);

}  // namespace lamella
