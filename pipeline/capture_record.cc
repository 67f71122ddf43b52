#include "pipeline/capture_record.h"

#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/capture/pose_check.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr int kCaptureVersion = 1;
constexpr const char* kFile = "capture.json";

template <class T>
struct Name {
  T value;
  const char* name;
};
constexpr Name<CameraOrigin> kOrigins[] = {{CameraOrigin::kKnown, "known"},
                                           {CameraOrigin::kExif, "exif"},
                                           {CameraOrigin::kGuess, "guess"}};
constexpr Name<CameraModel> kModelNames[] = {{CameraModel::kPinhole, "pinhole"},
                                             {CameraModel::kBrown, "brown"},
                                             {CameraModel::kFisheye, "fisheye"}};

template <class T, std::size_t N>
const char* NameOf(const Name<T> (&names)[N], T value) {
  for (const Name<T>& entry : names) {
    if (entry.value == value) return entry.name;
  }
  return "";
}

template <class T, std::size_t N>
T ValueOf(const Name<T> (&names)[N], const JsonObject& object, const std::string& key) {
  const std::string text = object.Text(key);
  for (const Name<T>& entry : names) {
    if (text == entry.name) return entry.value;
  }
  throw object.Wrong(key, "a known name");
}

Json CameraJson(const CapturedView& view) {
  const Camera& c = view.camera;
  return {{"origin", NameOf(kOrigins, view.camera_origin)},
          {"model", NameOf(kModelNames, c.model)},
          {"fx_px", c.fx},
          {"fy_px", c.fy},
          {"cx_px", c.cx},
          {"cy_px", c.cy},
          {"distortion", c.distortion}};
}

Json ViewJson(const CapturedView& view) {
  Json json = {{"name", view.name},
               {"file", view.file.string()},
               {"sha256", view.sha256},
               {"width_px", view.camera.width},
               {"height_px", view.camera.height},
               {"orientation", view.orientation},
               {"plain", view.is_plain},
               {"device", view.device},
               {"camera", CameraJson(view)}};
  if (view.camera_from_world) {
    const Eigen::Quaterniond& q = view.camera_from_world->rotation;
    const Eigen::Vector3d& t = view.camera_from_world->translation;
    json["camera_from_world"] = {{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                                 {"translation", {t.x(), t.y(), t.z()}}};
  }
  if (!view.depth.empty())
    json["depth"] = {{"file", view.depth.string()}, {"sha256", view.depth_sha256}};
  if (view.grid) json["grid"] = {{"row", view.grid->row}, {"column", view.grid->column}};
  return json;
}

Camera ReadCamera(const JsonObject& view) {
  const JsonObject json = view.Object("camera");
  Camera camera{.model = ValueOf(kModelNames, json, "model"),
                .width = view.Whole("width_px", 1, 1 << 20),
                .height = view.Whole("height_px", 1, 1 << 20),
                .fx = json.Number("fx_px"),
                .fy = json.Number("fy_px"),
                .cx = json.Number("cx_px"),
                .cy = json.Number("cy_px")};
  const std::vector<double> k = json.Numbers("distortion", camera.distortion.size());
  std::copy(k.begin(), k.end(), camera.distortion.begin());
  CheckCamera(camera, json.where());
  return camera;
}

CapturedView ReadView(const JsonObject& json) {
  CapturedView view;
  view.name = json.Text("name");
  view.file = json.Text("file");
  view.sha256 = json.Text("sha256");
  view.orientation = json.Whole("orientation", 1, 8);
  view.is_plain = json.HasTrue("plain");
  view.device = json.Text("device");
  view.camera_origin = ValueOf(kOrigins, json.Object("camera"), "origin");
  view.camera = ReadCamera(json);
  if (json.Has("camera_from_world")) {
    const JsonObject pose = json.Object("camera_from_world");
    const std::vector<double> q = pose.Numbers("rotation_wxyz", 4);
    const std::vector<double> t = pose.Numbers("translation", 3);
    view.camera_from_world =
        Rigid{Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), {t[0], t[1], t[2]}};
  }
  if (json.Has("grid")) {
    const JsonObject grid = json.Object("grid");
    constexpr int kMost = 1000000;
    view.grid = GridPosition{grid.Whole("row", -kMost, kMost), grid.Whole("column", -kMost, kMost)};
  }
  if (json.Has("depth")) {
    view.depth = json.Object("depth").Text("file");
    view.depth_sha256 = json.Object("depth").Text("sha256");
  }
  return view;
}

}  // namespace

void SaveCapture(const fs::path& capture_folder, const CaptureRecord& record) {
  Json views = Json::array();
  for (const CapturedView& view : record.views) views.push_back(ViewJson(view));
  const Json document = {{"format_version", kCaptureVersion}, {"views", std::move(views)}};
  WriteTextAtomically(capture_folder / kFile, document.dump(1) + "\n");
}

CaptureRecord LoadCapture(const Workspace& workspace) {
  const JsonObject document(workspace.Stage("capture") / kFile);
  document.CheckFormatVersion(kCaptureVersion);
  CaptureRecord record;
  for (const JsonObject& view : document.Objects("views")) record.views.push_back(ReadView(view));
  return record;
}

std::optional<std::vector<View>> KnownViews(const CaptureRecord& record) {
  std::vector<View> views;
  for (const CapturedView& view : record.views) {
    if (!view.camera_from_world) return std::nullopt;
    views.push_back(
        {view.name, view.file, view.camera, *view.camera_from_world, view.grid, view.depth});
  }
  return views;
}

}  // namespace lamella
