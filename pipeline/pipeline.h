// The pipeline: the six stages in order. Read pipeline.cc first.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lightfield/error.h"
#include "pipeline/stages.h"
#include "pipeline/workspace.h"

namespace lamella {

struct PipelineOptions {
  PipelineOptions();  // those of Quality::kBalanced
  CaptureOptions capture;
  PosesOptions poses;
  DepthOptions depth;
  RenderOptions render;
  LayersOptions layers;
  FramesOptions frames;
  PreviewOptions preview;
};
std::vector<OptionTable> Describe(PipelineOptions& options);
void ApplyQuality(Quality quality, PipelineOptions& options);

// capture, poses, depth, layers, frames, preview.
const std::vector<std::string>& StageNames();

// What can be found wrong before any work is done: the input named, the display readable, COLMAP
// there where it is needed.
void CheckBeforeWork(const PipelineOptions& options, const std::string& first,
                     const std::string& last);

enum class StageState { kMissing, kUnfinished, kStale, kDone };
struct StageStatus {
  std::string name;
  StageState state = StageState::kMissing;
  std::optional<StageRecord> record;
};
// Of every stage, with the options that the workspace keeps. Changes nothing.
std::vector<StageStatus> StatusOf(const Workspace& workspace);

// The options of the workspace's lamella.toml, or the defaults where there is none.
PipelineOptions OptionsOf(const Workspace& workspace);

// That of a stage which `reader` ("the stage layers") reads. InputError where it is not finished,
// saying what to run.
StageRecord FinishedStage(const Workspace& workspace, const std::string& stage,
                          const std::string& reader);

// Runs the stages from `first` to `last` that are not up to date; the stages before `first` must be
// finished. Returns kDone, or kGate where a stage (now or earlier) missed its gate.
ExitCode RunPipeline(const Workspace& workspace, PipelineOptions options, const std::string& first,
                     const std::string& last, Progress& progress);

}  // namespace lamella
