#include "pipeline/pipeline.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/input.h"
#include "pipeline/make_layers.h"
#include "pipeline/peak_memory.h"
#include "pipeline/poses/colmap.h"

namespace lamella {
namespace {

// A stage: what it reads of earlier stages and of the outside, the options that it depends on, and
// the function.
struct Stage {
  std::string name;
  std::vector<std::string> reads;
  std::vector<OptionTable> options;
  std::function<std::string()> outside_hash;
  std::function<StageReport(StageRun&)> run;
};

// The data flow of the product, in one place.
std::vector<Stage> Stages(const Workspace& w, PipelineOptions& o, Progress& p) {
  const auto nothing = [] { return std::string(); };
  const auto input = [&o] { return HashCaptureInput(o.capture); };
  const auto display = [&o] {
    const Display of = FindDisplay(o.layers.display);
    const std::optional<Calibration> calibration = CalibrationFor(o.layers, of);
    return ContentHash(ToToml(of) + (calibration ? CalibrationText(*calibration) : ""));
  };
  return {
      {"capture",
       {},
       {Describe(o.capture)},
       input,
       [&](StageRun& run) { return RunCapture(w, o.capture, run, p); }},
      {"poses",
       {"capture"},
       {Describe(o.poses)},
       nothing,
       [&](StageRun& run) { return RunPoses(w, o.poses, run, p); }},
      {"depth",
       {"poses"},
       {Describe(o.depth)},
       nothing,
       [&](StageRun& run) { return RunDepth(w, o.depth, run, p); }},
      {"layers",
       {"poses", "depth"},
       {Describe(o.layers), Describe(o.render)},
       display,
       [&](StageRun& run) { return RunLayers(w, o.layers, o.render, run, p); }},
      {"frames",
       {"layers"},
       {Describe(o.frames)},
       nothing,
       [&](StageRun& run) { return RunFrames(w, o.frames, run, p); }},
      {"preview",
       {"capture", "poses", "depth", "layers", "frames"},
       {Describe(o.preview), Describe(o.render)},
       nothing,
       [&](StageRun& run) { return RunPreview(w, o.preview, o.render, run, p); }},
  };
}

std::string InputsHash(const Workspace& workspace, const Stage& stage) {
  std::string text = stage.outside_hash();
  for (const std::string& name : stage.reads) {
    const StageRecord record = FinishedStage(workspace, name, "the stage " + stage.name);
    text += fmt::format("\n{} {}", name, record.OutputsHash());
  }
  return ContentHash(text);
}

void RunStage(const Workspace& workspace, const Stage& stage, const std::string& inputs_hash,
              const std::string& options_hash) {
  const auto start = std::chrono::steady_clock::now();
  const PeakMemory memory;
  StageRun run(workspace, stage.name, inputs_hash, options_hash);
  StageReport report = stage.run(run);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  run.Commit(std::move(report), elapsed.count(), memory.Mib());
}

// The workspace keeps the options that its results were made with.
void SaveOptions(const Workspace& workspace, PipelineOptions& options) {
  const std::string text = ToToml(Describe(options));
  std::error_code error;
  if (std::filesystem::exists(workspace.Options(), error) && ReadText(workspace.Options()) == text)
    return;
  CreateFolder(workspace.root());
  WriteTextAtomically(workspace.Options(), text);
}

std::size_t IndexOf(const std::string& stage) {
  const auto& names = StageNames();
  const auto found = std::find(names.begin(), names.end(), stage);
  if (found == names.end()) {
    throw UsageError("--until", fmt::format("there is no stage \"{}\"", stage),
                     fmt::format("did you mean \"{}\"?", NearestName(stage, names)));
  }
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

PipelineOptions::PipelineOptions() { ApplyQuality(Quality::kBalanced, *this); }

std::vector<OptionTable> Describe(PipelineOptions& o) {
  return {Describe(o.capture), Describe(o.poses),  Describe(o.depth),  Describe(o.render),
          Describe(o.layers),  Describe(o.frames), Describe(o.preview)};
}

void ApplyQuality(Quality quality, PipelineOptions& o) {
  ApplyQuality(quality, o.poses);
  ApplyQuality(quality, o.depth);
  ApplyQuality(quality, o.render);
  ApplyQuality(quality, o.layers);
  ApplyQuality(quality, o.preview);
}

const std::vector<std::string>& StageNames() {
  static const std::vector<std::string> names = {"capture", "poses",  "depth",
                                                 "layers",  "frames", "preview"};
  return names;
}

void CheckBeforeWork(const PipelineOptions& options, const std::string& first,
                     const std::string& last) {
  const std::size_t from = IndexOf(first), to = IndexOf(last);
  if (from == 0 && options.capture.input.empty()) {
    throw UsageError("", "no input is named",
                     "give the folder of the photographs: lamella run FOLDER ...");
  }
  if (from <= IndexOf("layers") && IndexOf("layers") <= to) {
    CalibrationFor(options.layers, DisplayFor(options.layers));
  }
  if (from <= IndexOf("poses") && IndexOf("poses") <= to && NeedsColmap(options.capture))
    RequireColmap();
}

PipelineOptions OptionsOf(const Workspace& workspace) {
  PipelineOptions options;
  std::error_code error;
  if (std::filesystem::exists(workspace.Options(), error))
    ApplyToml(workspace.Options(), Describe(options));
  return options;
}

StageRecord FinishedStage(const Workspace& workspace, const std::string& stage,
                          const std::string& reader) {
  std::optional<StageRecord> record = LoadStageRecord(workspace, stage);
  if (record && record->finished) return *std::move(record);
  throw InputError(workspace.root().string(),
                   fmt::format("{} needs {}, which has not been run", reader, stage),
                   fmt::format("run `lamella {}` or `lamella run` first", stage));
}

std::vector<StageStatus> StatusOf(const Workspace& workspace) {
  PipelineOptions options = OptionsOf(workspace);
  std::vector<StageStatus> all;
  bool earlier_done = true;
  for (const Stage& stage : Stages(workspace, options, SilentProgress())) {
    StageStatus status{stage.name, StageState::kMissing, LoadStageRecord(workspace, stage.name)};
    if (status.record) {
      const bool done = earlier_done && status.record->finished &&
                        IsDone(workspace, stage.name, InputsHash(workspace, stage),
                               ContentHash(ToToml(stage.options)));
      status.state = done                      ? StageState::kDone
                     : status.record->finished ? StageState::kStale
                                               : StageState::kUnfinished;
    }
    earlier_done = earlier_done && status.state == StageState::kDone;
    all.push_back(std::move(status));
  }
  return all;
}

ExitCode RunPipeline(const Workspace& workspace, PipelineOptions options, const std::string& first,
                     const std::string& last, Progress& progress) {
  const std::size_t from = IndexOf(first), to = IndexOf(last);
  CheckBeforeWork(options, first, last);
  SaveOptions(workspace, options);
  ExitCode code = ExitCode::kDone;
  const std::vector<Stage> stages = Stages(workspace, options, progress);
  for (std::size_t i = from; i <= to && i < stages.size(); ++i) {
    const Stage& stage = stages[i];
    const std::string inputs_hash = InputsHash(workspace, stage);
    const std::string options_hash = ContentHash(ToToml(stage.options));
    if (!IsDone(workspace, stage.name, inputs_hash, options_hash)) {
      RunStage(workspace, stage, inputs_hash, options_hash);
    } else {
      progress.Note(stage.name + ": up to date");
    }
    const std::string missed = LoadStageRecord(workspace, stage.name)->report.missed_gate;
    if (!missed.empty()) {
      progress.Warn(fmt::format("{}: {}", stage.name, missed));
      code = ExitCode::kGate;
    }
  }
  return code;
}

}  // namespace lamella
