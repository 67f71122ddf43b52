#include "pipeline/workspace.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr int kStageVersion = 1;
constexpr const char* kStageFile = "stage.json";

Json ToJson(const StageRecord& record) {
  Json json = {{"format_version", kStageVersion},   {"stage", record.stage},
               {"version", record.version},         {"finished", record.finished},
               {"inputs_hash", record.inputs_hash}, {"options_hash", record.options_hash}};
  if (!record.finished) return json;
  json["seconds"] = std::round(record.seconds * 1000) / 1000;
  json["peak_memory_mib"] = std::round(record.peak_memory_mib);
  json["summary"] = Json::object();
  for (const auto& [key, value] : record.report.summary) json["summary"][key] = value;
  json["warnings"] = record.report.warnings;
  json["missed_gate"] = record.report.missed_gate;
  json["outputs"] = Json::array();
  for (const OutputFile& output : record.outputs) {
    json["outputs"].push_back(
        {{"file", output.file}, {"size", output.size}, {"hash", output.hash}});
  }
  return json;
}

StageRecord FromJson(const Json& json) {
  StageRecord record;
  record.stage = json.at("stage");
  record.version = json.at("version");
  record.finished = json.at("finished");
  record.inputs_hash = json.at("inputs_hash");
  record.options_hash = json.at("options_hash");
  if (!record.finished) return record;
  record.seconds = json.at("seconds");
  record.peak_memory_mib = json.at("peak_memory_mib");
  for (const auto& [key, value] : json.at("summary").items()) {
    record.report.summary.emplace_back(key, value);
  }
  record.report.warnings = json.at("warnings");
  record.report.missed_gate = json.at("missed_gate");
  for (const Json& output : json.at("outputs")) {
    record.outputs.push_back({output.at("file"), output.at("size"), output.at("hash")});
  }
  return record;
}

bool SameKey(const StageRecord& a, const StageRecord& b) {
  return a.version == b.version && a.inputs_hash == b.inputs_hash &&
         a.options_hash == b.options_hash;
}

// What a write that was killed has left: NAME.partial.EXT.
void RemovePartialFiles(const fs::path& folder) {
  std::vector<fs::path> partial;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().stem().extension() == ".partial") partial.push_back(entry.path());
  }
  for (const fs::path& path : partial) fs::remove_all(path);
}

// Of an earlier run. Its record stays until the next one takes its place: without it a run that is
// killed meanwhile would leave a folder that nobody knows as a stage's.
void RemoveOutputs(const fs::path& folder) {
  std::vector<fs::path> outputs;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != kStageFile) outputs.push_back(entry.path());
  }
  for (const fs::path& path : outputs) fs::remove_all(path);
}

std::vector<OutputFile> ListOutputs(const fs::path& folder) {
  std::vector<OutputFile> outputs;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string file = fs::relative(entry.path(), folder).generic_string();
    if (file == kStageFile) continue;
    outputs.push_back({file, entry.file_size(), ContentHashOfFile(entry.path())});
  }
  std::sort(outputs.begin(), outputs.end(),
            [](const OutputFile& a, const OutputFile& b) { return a.file < b.file; });
  return outputs;
}

}  // namespace

const char* ProgramVersion() { return LAMELLA_VERSION; }

std::string StageRecord::OutputsHash() const {
  std::string text;
  for (const OutputFile& output : outputs) text += output.file + " " + output.hash + "\n";
  return ContentHash(text);
}

std::optional<StageRecord> LoadStageRecord(const Workspace& workspace, const std::string& stage) {
  const fs::path path = workspace.Stage(stage) / kStageFile;
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  try {
    const Json json = Json::parse(ReadText(path));
    if (json.at("format_version").get<int>() > kStageVersion) {
      throw InputError(path.string(), "was written by a newer lamella",
                       "use that version or another --workspace");
    }
    return FromJson(json);
  } catch (const Json::exception&) {
    throw InputError(
        path.string(), "is damaged",
        "delete the folder " + path.parent_path().string() + " and run the same command again");
  }
}

bool IsDone(const Workspace& workspace, const std::string& stage, const std::string& inputs_hash,
            const std::string& options_hash) {
  const std::optional<StageRecord> record = LoadStageRecord(workspace, stage);
  if (!record || !record->finished || record->version != ProgramVersion() ||
      record->inputs_hash != inputs_hash || record->options_hash != options_hash) {
    return false;
  }
  return std::all_of(record->outputs.begin(), record->outputs.end(), [&](const OutputFile& output) {
    std::error_code error;
    return fs::file_size(workspace.Stage(stage) / output.file, error) == output.size && !error;
  });
}

StageRun::StageRun(const Workspace& workspace, std::string stage, std::string inputs_hash,
                   std::string options_hash)
    : folder_(workspace.Stage(stage)) {
  record_.stage = stage;
  record_.version = ProgramVersion();
  record_.inputs_hash = std::move(inputs_hash);
  record_.options_hash = std::move(options_hash);
  const std::optional<StageRecord> earlier = LoadStageRecord(workspace, stage);
  resumed_ = earlier && !earlier->finished && SameKey(*earlier, record_);
  std::error_code error;
  // A run may have been killed while it wrote its record.
  if (!earlier) fs::remove(AtomicFile(folder_ / kStageFile).temporary(), error);
  if (!earlier && fs::exists(folder_, error) && !fs::is_empty(folder_, error)) {
    throw InputError(folder_.string(), "holds files that lamella has not written",
                     "choose another --workspace or empty that folder");
  }
  if (!resumed_ && earlier) {
    try {
      RemoveOutputs(folder_);
    } catch (const fs::filesystem_error& failed) {
      throw MachineError(folder_.string(), "can't be emptied (" + failed.code().message() + ")",
                         "check its permissions, then run the same command again");
    }
  }
  CreateFolder(folder_);
  if (resumed_) {
    RemovePartialFiles(folder_);
  } else {
    WriteTextAtomically(folder_ / kStageFile, ToJson(record_).dump(1) + "\n");
  }
}

bool StageRun::Finished(const std::string& file) const {
  std::error_code error;
  return resumed_ && fs::is_regular_file(folder_ / file, error);
}

void StageRun::Commit(StageReport report, double seconds, double peak_memory_mib) {
  record_.report = std::move(report);
  record_.seconds = seconds;
  record_.peak_memory_mib = peak_memory_mib;
  record_.outputs = ListOutputs(folder_);
  record_.finished = true;
  WriteTextAtomically(folder_ / kStageFile, ToJson(record_).dump(1) + "\n");
}

}  // namespace lamella
