#include "pipeline/capture/transforms_json.h"

#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/capture/pose_check.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr int kTransformsVersion = 1;
using Value = nlohmann::json;

// OpenGL's camera axes from ours: y and z change sign, x stays.
const Eigen::DiagonalMatrix<double, 3> kFlip(1, -1, -1);

fs::path FileOf(const fs::path& path) {
  return fs::is_directory(path) ? path / "transforms.json" : path;
}

// file_path is relative to the file and, in Blender's sets, lacks the extension.
fs::path ImagePath(const fs::path& file, const std::string& file_path) {
  fs::path image = (fs::absolute(file).parent_path() / file_path).lexically_normal();
  if (!fs::exists(image) && fs::exists(image.string() + ".png")) image += ".png";
  return image;
}

// A value that stands in the frame or, for all frames, at the top.
struct Scoped {
  const JsonObject& frame;
  const JsonObject& top;
  const JsonObject& Of(const std::string& key) const { return frame.Has(key) ? frame : top; }
  bool Has(const std::string& key) const { return frame.Has(key) || top.Has(key); }
  double Number(const std::string& key, double otherwise) const {
    return Of(key).NumberOr(key, otherwise);
  }
};

void ReadSize(const Scoped& values, const fs::path& image, Camera& camera) {
  if (values.Has("w") && values.Has("h")) {
    camera.width = values.Of("w").Whole("w", 1, 1 << 20);
    camera.height = values.Of("h").Whole("h", 1, 1 << 20);
    return;
  }
  const ImageInfo info = ReadImageInfo(image);
  camera.width = info.width;
  camera.height = info.height;
}

double FocalFromAngle(const Scoped& values, const std::string& key, int size) {
  return size / (2 * std::tan(values.Of(key).Number(key) / 2));
}

void ReadFocal(const Scoped& values, Camera& camera) {
  if (values.Has("fl_x")) {
    camera.fx = values.Number("fl_x", 0);
  } else if (values.Has("camera_angle_x")) {
    camera.fx = FocalFromAngle(values, "camera_angle_x", camera.width);
  } else {
    throw values.frame.Wrong("fl_x", "a focal length in px (or camera_angle_x)");
  }
  camera.fy = camera.fx;
  if (values.Has("fl_y")) {
    camera.fy = values.Number("fl_y", 0);
  } else if (values.Has("camera_angle_y") && !values.Has("fl_x")) {
    camera.fy = FocalFromAngle(values, "camera_angle_y", camera.height);
  }
}

void ReadDistortion(const Scoped& values, Camera& camera) {
  const std::string model = values.Of("camera_model").TextOr("camera_model", "OPENCV");
  auto& k = camera.distortion;
  if (model == "OPENCV_FISHEYE" || values.Of("is_fisheye").HasTrue("is_fisheye")) {
    camera.model = CameraModel::kFisheye;
    k = {values.Number("k1", 0), values.Number("k2", 0), values.Number("k3", 0),
         values.Number("k4", 0)};
    return;
  }
  if (model != "OPENCV" && model != "PINHOLE" && model != "SIMPLE_PINHOLE") {
    throw values.frame.Wrong("camera_model", "OPENCV, OPENCV_FISHEYE or PINHOLE");
  }
  if (values.Number("k4", 0) != 0)
    throw values.frame.Wrong("k4", "0 (k1, k2, p1, p2, k3 are known)");
  k = {values.Number("k1", 0), values.Number("k2", 0), values.Number("p1", 0),
       values.Number("p2", 0), values.Number("k3", 0)};
  const bool distorted = k != std::array<double, 8>{};
  camera.model = distorted ? CameraModel::kBrown : CameraModel::kPinhole;
}

Camera ReadCamera(const Scoped& values, const fs::path& image) {
  Camera camera;
  ReadSize(values, image, camera);
  ReadFocal(values, camera);
  camera.cx = values.Number("cx", camera.width / 2.0);
  camera.cy = values.Number("cy", camera.height / 2.0);
  ReadDistortion(values, camera);
  CheckCamera(camera, values.frame.where());
  return camera;
}

Rigid ReadCameraPose(const JsonObject& frame) {
  const std::vector<double> m = frame.Numbers("transform_matrix", 16);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> world_from_gl(m.data());
  const Eigen::Matrix3d rotation = world_from_gl.topLeftCorner<3, 3>() * kFlip;
  const Rigid world_from_camera{CheckedRotation(rotation, frame.where()),
                                world_from_gl.topRightCorner<3, 1>()};
  return Inverse(world_from_camera);
}

Value PoseJson(const Rigid& camera_from_world) {
  const Rigid world_from_camera = Inverse(camera_from_world);
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix() * kFlip;
  Value rows = Value::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back(
        {rotation(r, 0), rotation(r, 1), rotation(r, 2), world_from_camera.translation[r]});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

// Relative to the folder for what lies below it, absolute for the rest.
std::string PathFrom(const fs::path& file, const fs::path& folder) {
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const fs::path below = absolute.lexically_relative(fs::absolute(folder).lexically_normal());
  return (!below.empty() && *below.begin() != ".." ? below : absolute).string();
}

const char* ModelName(const Camera& camera) {
  return camera.model == CameraModel::kFisheye ? "OPENCV_FISHEYE"
         : camera.model == CameraModel::kBrown ? "OPENCV"
                                               : "PINHOLE";
}

// What the form calls the first numbers of Camera::distortion.
std::vector<const char*> DistortionNames(const Camera& camera) {
  if (camera.model == CameraModel::kFisheye) return {"k1", "k2", "k3", "k4"};
  if (camera.model == CameraModel::kBrown) return {"k1", "k2", "p1", "p2", "k3"};
  return {};
}

Value FrameJson(const View& view, const fs::path& folder) {
  const Camera& camera = view.camera;
  Value frame = {{"name", view.name},
                 {"file_path", PathFrom(view.image, folder)},
                 {"camera_model", ModelName(camera)},
                 {"w", camera.width},
                 {"h", camera.height},
                 {"fl_x", camera.fx},
                 {"fl_y", camera.fy},
                 {"cx", camera.cx},
                 {"cy", camera.cy},
                 {"transform_matrix", PoseJson(view.camera_from_world)}};
  for (std::size_t i = 0; i < DistortionNames(camera).size(); ++i) {
    frame[DistortionNames(camera)[i]] = camera.distortion[i];
  }
  if (!view.depth.empty()) frame["depth_file_path"] = PathFrom(view.depth, folder);
  if (view.grid) frame["grid"] = {{"row", view.grid->row}, {"column", view.grid->column}};
  return frame;
}

}  // namespace

bool IsTransformsJson(const fs::path& path) {
  if (fs::is_directory(path)) return fs::is_regular_file(path / "transforms.json");
  return path.extension() == ".json" && fs::is_regular_file(path);
}

TransformsJson ReadTransformsJson(const fs::path& path) {
  const fs::path file = FileOf(path);
  const JsonObject top(file);
  if (top.Has("format_version")) top.CheckFormatVersion(kTransformsVersion);
  TransformsJson transforms;
  if (top.Has("lost")) transforms.lost = top.Texts("lost");
  for (const JsonObject& frame : top.Objects("frames")) {
    View view;
    view.image = ImagePath(file, frame.Text("file_path"));
    view.name = frame.TextOr("name", view.image.stem().string());
    if (view.name.empty() || view.name.find('/') != std::string::npos) {
      throw frame.Wrong("name", "a file's stem");  // files are named by it
    }
    view.camera = ReadCamera({frame, top}, view.image);
    if (frame.Has("depth_file_path")) view.depth = ImagePath(file, frame.Text("depth_file_path"));
    view.camera_from_world = ReadCameraPose(frame);
    if (frame.Has("grid")) {
      const JsonObject grid = frame.Object("grid");
      view.grid = GridPosition{grid.Whole("row", -1000000, 1000000),
                               grid.Whole("column", -1000000, 1000000)};
    }
    transforms.views.push_back(std::move(view));
  }
  return transforms;
}

void WriteTransformsJson(const fs::path& file, const TransformsJson& transforms) {
  Value frames = Value::array();
  for (const View& view : transforms.views) frames.push_back(FrameJson(view, file.parent_path()));
  const Value document = {{"format_version", kTransformsVersion},
                          {"frames", std::move(frames)},
                          {"lost", transforms.lost}};
  WriteTextAtomically(file, document.dump(1) + "\n");
}

}  // namespace lamella
