// What the stage poses leaves: poses/transforms.json (cameras, poses, images, lost views) and
// poses/colmap/{cameras,images,points3D}.txt (the same model for COLMAP, with the sparse points).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lightfield/image.h"
#include "lightfield/view.h"
#include "pipeline/workspace.h"

namespace lamella {

// What is known of a sparse point beside its place; runs parallel to ViewSet::points.
struct PointDetail {
  Rgb8 color{128, 128, 128};
  double error_px = 0;  // mean reprojection error
  std::vector<Eigen::Vector2d>
      pixels;  // where SparsePoint::views see it, in the undistorted images
};

// `set` holds pinhole cameras, sorted by name; `lost` are the names of views without a pose.
// Without details, points are said to be seen where they project to. Called inside the stage.
void SaveViewSet(const std::filesystem::path& poses_folder, const ViewSet& set,
                 const std::vector<std::string>& lost,
                 const std::vector<PointDetail>& details = {});

// Views sorted by name, with the absolute path of the undistorted image, pinhole cameras and grid
// positions; points with the views that see them. InputError where the files are broken or absent.
ViewSet LoadViewSet(const Workspace& workspace);
std::vector<std::string> LoadLostViews(const Workspace& workspace);

}  // namespace lamella
