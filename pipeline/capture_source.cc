#include "pipeline/capture_source.h"

#include <utility>
#include <vector>

#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"

namespace lamella {

std::unique_ptr<RaySource> LoadCaptureSource(
    const Workspace& workspace, const RenderOptions& options, Progress& progress,
    const std::function<void(std::size_t index, const DepthView&)>& look) {
  ViewSet set = LoadViewSet(workspace);
  const auto count = static_cast<std::int64_t>(set.views.size());
  progress.Start("load views", count, "views");
  std::vector<DepthView> views(set.views.size());
  ParallelForEach(0, count, [&](std::int64_t i) {
    DepthView& view = views[static_cast<std::size_t>(i)];
    view.view = std::move(set.views[static_cast<std::size_t>(i)]);
    view.color = workspace.photographs().Linear(view.view.image);
    view.depth = LoadDepthMap(workspace.Stage("depth") / (view.view.name + ".exr"));
    if (look) look(static_cast<std::size_t>(i), view);
    progress.Advance();
  });
  return CaptureSource(std::move(views), options);
}

}  // namespace lamella
