// COLMAP's camera models as ours and back.
#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/capture/pose_check.h"
#include "pipeline/poses/model.h"

namespace lamella {
namespace {

// Which of COLMAP's parameters is which of ours, by position: 'f' both focal lengths, 'x' fx,
// 'y' fy, 'u' cx, 'v' cy, a digit the index in Camera::distortion.
struct ModelRow {
  int id;
  const char* name;
  CameraModel model;
  const char* parameters;
};

constexpr ModelRow kModels[] = {
    {0, "SIMPLE_PINHOLE", CameraModel::kPinhole, "fuv"},
    {1, "PINHOLE", CameraModel::kPinhole, "xyuv"},
    {2, "SIMPLE_RADIAL", CameraModel::kBrown, "fuv0"},
    {3, "RADIAL", CameraModel::kBrown, "fuv01"},
    {4, "OPENCV", CameraModel::kBrown, "xyuv0123"},
    {5, "OPENCV_FISHEYE", CameraModel::kFisheye, "xyuv0123"},
    {6, "FULL_OPENCV", CameraModel::kBrown, "xyuv01234567"},
    {8, "SIMPLE_RADIAL_FISHEYE", CameraModel::kFisheye, "fuv0"},
    {9, "RADIAL_FISHEYE", CameraModel::kFisheye, "fuv01"},
};

void Set(Camera& camera, char role, double value) {
  switch (role) {
    case 'f':
      camera.fx = camera.fy = value;
      break;
    case 'x':
      camera.fx = value;
      break;
    case 'y':
      camera.fy = value;
      break;
    case 'u':
      camera.cx = value;
      break;
    case 'v':
      camera.cy = value;
      break;
    default:
      camera.distortion[static_cast<std::size_t>(role - '0')] = value;
  }
}

}  // namespace

int ColmapModelId(const std::string& name) {
  for (const ModelRow& row : kModels) {
    if (name == row.name) return row.id;
  }
  return -1;
}

ColmapCamera ToColmap(const Camera& camera) {
  ColmapCamera colmap{1, "PINHOLE", {camera.fx, camera.fy, camera.cx, camera.cy}};
  std::size_t terms = 0;
  if (camera.model == CameraModel::kBrown) {
    colmap.model_id = 6;
    colmap.model = "FULL_OPENCV";
    terms = 8;
  } else if (camera.model == CameraModel::kFisheye) {
    colmap.model_id = 5;
    colmap.model = "OPENCV_FISHEYE";
    terms = 4;
  }
  colmap.parameters.insert(colmap.parameters.end(), camera.distortion.begin(),
                           camera.distortion.begin() + static_cast<std::ptrdiff_t>(terms));
  return colmap;
}

Camera FromColmap(int model_id, int width, int height, const std::vector<double>& parameters,
                  const std::string& where) {
  for (const ModelRow& row : kModels) {
    if (row.id != model_id) continue;
    const std::string roles = row.parameters;
    if (roles.size() != parameters.size()) {
      throw InputError(where,
                       fmt::format("a {} camera has {} parameters, not {}", row.name, roles.size(),
                                   parameters.size()),
                       "replace the model");
    }
    Camera camera;
    camera.model = row.model;
    camera.width = width;
    camera.height = height;
    for (std::size_t i = 0; i < roles.size(); ++i) Set(camera, roles[i], parameters[i]);
    CheckCamera(camera, where);
    return camera;
  }
  throw InputError(
      where, fmt::format("has a camera of COLMAP's model {}, which is not known here", model_id),
      "use PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV or a radial fisheye");
}

}  // namespace lamella
