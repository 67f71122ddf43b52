#include "pipeline/capture/strecha_camera.h"

#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/capture/pose_check.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

bool IsCameraFile(const fs::directory_entry& entry) {
  return entry.is_regular_file() && entry.path().extension() == ".camera";
}

}  // namespace

bool IsStrechaFolder(const fs::path& folder) {
  if (!fs::is_directory(folder)) return false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (IsCameraFile(entry)) return true;
  }
  return false;
}

// 3 rows of K, a row of distortion, 3 rows of R, the centre C, width and height, with
// P = K [R^T, -R^T C]: R is world-from-camera.
View ReadStrechaCamera(const fs::path& file) {
  std::istringstream text(ReadText(file));
  double v[26];
  for (double& number : v) {
    if (!(text >> number) || !std::isfinite(number)) {
      throw InputError(file.string(),
                       "is no Strecha camera (26 numbers: K, distortion, R, C, size)",
                       "replace the file");
    }
  }
  if (v[9] != 0 || v[10] != 0 || v[11] != 0) {
    throw InputError(file.string(), "has distortion, whose meaning the format leaves open",
                     "give the cameras as a transforms.json");
  }
  View view;
  view.name = file.stem().stem().string();
  Camera& camera = view.camera;
  camera.fx = v[0];
  camera.fy = v[4];
  // The files count pixels from the first pixel's centre.
  camera.cx = v[2] + 0.5;
  camera.cy = v[5] + 0.5;
  camera.width = static_cast<int>(v[24]);
  camera.height = static_cast<int>(v[25]);
  CheckCamera(camera, file.string());
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(v + 12);
  const Rigid world_from_camera{CheckedRotation(rotation, file.string()), {v[21], v[22], v[23]}};
  view.camera_from_world = Inverse(world_from_camera);
  return view;
}

std::vector<View> ReadStrechaFolder(const fs::path& folder) {
  std::vector<View> views;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (IsCameraFile(entry)) views.push_back(ReadStrechaCamera(entry.path()));
  }
  return views;
}

}  // namespace lamella
