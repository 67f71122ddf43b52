// The stage layers: the capture placed in the display's volume and distributed to its layers.
#include "pipeline/capture_source.h"
#include "pipeline/make_layers.h"
#include "pipeline/place_capture.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"

namespace lamella {

StageReport RunLayers(const Workspace& workspace, const LayersOptions& options,
                      const RenderOptions& render, StageRun& run, Progress& progress) {
  LayersRecord record;
  record.display = DisplayFor(options);
  record.calibration = CalibrationFor(options, record.display);
  std::string note;
  record.placement = PlaceCapture(workspace, LoadViewSet(workspace).views, record.display,
                                  options.placement, &note);

  RenderOptions seen_only = render;  // layers take nothing else
  seen_only.guess_unseen = false;
  seen_only.rays = InWorld(MiddleRays(record.display, options), record.placement);
  return MakeLayers(LoadCaptureSource(workspace, seen_only, progress), std::move(record), options,
                    note, run, progress);
}

}  // namespace lamella
