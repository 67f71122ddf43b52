// The six stages. Each loads, calls one pure function, saves, and knows no other stage.
// A stage reads the finished folders of the stages before it and writes files only below
// run.folder(); pipeline.cc decides which of them run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "depth/estimate.h"
#include "depth/render.h"
#include "distribute/distribute.h"
#include "lightfield/options.h"
#include "lightfield/progress.h"
#include "pipeline/workspace.h"

namespace lamella {

struct CaptureOptions {
  std::string input;  // a folder of photographs, a grid's folder, a transforms.json
  std::string views;  // NAME|GLOB|!NAME,...; empty: all
  std::string
      cameras;  // known cameras of photographs: transforms.json or a folder of .camera files
};
OptionTable Describe(CaptureOptions& options);

struct PosesOptions {
  int image_size_px = 1000;     // longer side for feature extraction
  int features = 2000;          // per image
  int first_octave = 0;         // -1 doubles the image
  int undistorted_size_px = 0;  // longer side of the undistorted images; 0: as captured
  bool refine_principal_point = false;
};
OptionTable Describe(PosesOptions& options);
void ApplyQuality(Quality quality, PosesOptions& options);

struct FramesOptions {
  std::string response = "srgb";  // of the panels, or "gamma"
  double gamma = 2.2;
  // Of a varifocal display's planes: what its one-bit projector shows, or grey emitters.
  std::string planes = "one-bit";                    // or "grey"
  std::string one_bit_method = "sigma-delta";        // distribute/one_bit.h
  int strokes = 16;                                  // after which the frames repeat
  std::string channels = "BRG", bits = "lsb-first";  // distribute/encode_varifocal.h
  bool there_and_back = true;
};
OptionTable Describe(FramesOptions& options);

struct PreviewOptions {
  int positions = 7;                   // eyes per axis
  double eye_box_mm = 54.3;            // they span +- this at the viewing distance
  std::string eyes;                    // further eyes, "X,Y;X,Y" mm
  int width_px = 960;                  // of the eyes' pictures, at most
  std::optional<double> eye_pixel_mm;  // on z = 0; default: the panel's pitch, within width_px
  int border_px = 24;                  // of the pictures that metrics leave out
  int focus_planes = 0;                // on which the eye in the middle focuses by turns
  double pupil_mm = 4;                 // its diameter then
  std::string source = "frames";       // "layers": what frames was made from
  double memory_gib = 4;               // strip by strip where all needs more; changes no value
};
OptionTable Describe(PreviewOptions& options);
void ApplyQuality(Quality quality, PreviewOptions& options);

// The content hash of everything outside of the workspace that the stage reads.
std::string HashCaptureInput(const CaptureOptions& options);

StageReport RunCapture(const Workspace& workspace, const CaptureOptions& options, StageRun& run,
                       Progress& progress);
StageReport RunPoses(const Workspace& workspace, const PosesOptions& options, StageRun& run,
                     Progress& progress);
StageReport RunDepth(const Workspace& workspace, const DepthOptions& options, StageRun& run,
                     Progress& progress);
StageReport RunLayers(const Workspace& workspace, const LayersOptions& options,
                      const RenderOptions& render, StageRun& run, Progress& progress);
StageReport RunFrames(const Workspace& workspace, const FramesOptions& options, StageRun& run,
                      Progress& progress);
StageReport RunPreview(const Workspace& workspace, const PreviewOptions& options,
                       const RenderOptions& render, StageRun& run, Progress& progress);

}  // namespace lamella
