// The capture of a workspace, with its depth, as a RaySource.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "depth/render.h"
#include "lightfield/progress.h"
#include "lightfield/ray_source.h"
#include "pipeline/workspace.h"

namespace lamella {

// Reads the undistorted images and depth maps that the stages poses and depth left. InputError
// where a file is absent or broken.
// `look` sees every view when it is loaded, with its index in the workspace's views, from many
// threads: photographs take long to decode.
std::unique_ptr<RaySource> LoadCaptureSource(
    const Workspace& workspace, const RenderOptions& options, Progress& progress,
    const std::function<void(std::size_t index, const DepthView&)>& look = {});

}  // namespace lamella
