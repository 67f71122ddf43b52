// What the preview's eyes see of the emitters: of all of them in memory, or strip by strip where
// that is not room enough.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "distribute/emitter_strip.h"
#include "distribute/simulate_strips.h"
#include "lightfield/progress.h"
#include "pipeline/layers_record.h"
#include "pipeline/preview_measure.h"
#include "pipeline/stages.h"
#include "pipeline/workspace.h"

namespace lamella {

struct PreviewEmitters {
  OpenEmitters open;  // of `whole`, where that is
  bool grey = false;  // the display has no colours
  std::unique_ptr<const LayerImages> whole;
  std::vector<EmitterStripPlan> strips;  // where it is not
};

// Of options.source, within options.memory_gib beside what is held by now and, later, the
// `page_bytes` that the page takes of the capture. Where that can't be it
// warns and takes as little as it can; a calibrated display's emitters are always whole, since the
// virtual prototype traces lines of sight to anywhere on its panels. Refers to workspace and
// record.
PreviewEmitters PrepareEmitters(const Workspace& workspace, const LayersRecord& record,
                                const PreviewOptions& options, const std::vector<Viewer>& viewers,
                                double page_bytes, std::vector<std::string>& warnings,
                                Progress& progress);

// Every viewer's picture, the same for any memory. `take` is called by one thread.
void SimulateViewers(const PreviewEmitters& emitters, const LayersRecord& record,
                     const std::vector<Viewer>& viewers, const TakePictureRows& take,
                     Progress& progress);

}  // namespace lamella
