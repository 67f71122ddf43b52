#include "pipeline/poses_record.h"

#include <algorithm>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/poses/model.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr const char* kTransforms = "transforms.json";
constexpr const char* kModel = "colmap";
constexpr const char* kAgain = "run the stage poses again";

std::uint32_t ImageId(std::size_t view) { return static_cast<std::uint32_t>(view + 1); }

// A camera for each view with one of its own, shared by views with equal ones.
std::uint32_t CameraId(const Camera& camera, ColmapModel& model) {
  const std::vector<double> parameters = ToColmap(camera).parameters;
  for (const auto& [id, known] : model.cameras) {
    if (known.width == camera.width && known.height == camera.height &&
        ToColmap(known).parameters == parameters) {
      return id;
    }
  }
  const auto id = static_cast<std::uint32_t>(model.cameras.size() + 1);
  model.cameras[id] = camera;
  return id;
}

// The pixel at which a view sees a point.
Eigen::Vector2d SeenAt(const View& view, const Eigen::Vector3d& position) {
  return Project(view.camera, view.camera_from_world * position).value_or(Eigen::Vector2d(0, 0));
}

ColmapModel ModelOf(const ViewSet& set, const std::vector<PointDetail>& details) {
  ColmapModel model;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const View& view = set.views[v];
    model.images[ImageId(v)] = {ImageId(v),
                                view.image.filename().string(),
                                CameraId(view.camera, model),
                                view.camera_from_world,
                                {}};
  }
  for (std::size_t p = 0; p < set.points.size(); ++p) {
    const auto id = static_cast<std::int64_t>(p + 1);
    ColmapPoint point{set.points[p].position, {128, 128, 128}, 0, {}};
    if (!details.empty()) {
      point.color = details[p].color;
      point.error_px = details[p].error_px;
    }
    for (std::size_t k = 0; k < set.points[p].views.size(); ++k) {
      const auto v = static_cast<std::size_t>(set.points[p].views[k]);
      auto& observations = model.images[ImageId(v)].observations;
      point.track.push_back({ImageId(v), static_cast<std::uint32_t>(observations.size())});
      observations.push_back(
          {details.empty() ? SeenAt(set.views[v], point.position) : details[p].pixels[k], id});
    }
    model.points[id] = std::move(point);
  }
  return model;
}

}  // namespace

void SaveViewSet(const fs::path& poses_folder, const ViewSet& set,
                 const std::vector<std::string>& lost, const std::vector<PointDetail>& details) {
  WriteColmapModel(poses_folder / kModel, ModelOf(set, details));
  WriteTransformsJson(poses_folder / kTransforms, {set.views, lost});
}

ViewSet LoadViewSet(const Workspace& workspace) {
  const fs::path folder = workspace.Stage("poses");
  ViewSet set;
  set.views = ReadTransformsJson(folder / kTransforms).views;
  const ColmapModel model = ReadColmapModel(folder / kModel);
  for (const View& view : set.views) {
    if (view.camera.model != CameraModel::kPinhole) {
      throw InputError((folder / kTransforms).string(), view.name + " is no pinhole camera",
                       kAgain);
    }
  }
  for (const auto& [id, point] : model.points) {
    SparsePoint sparse{point.position, {}};
    for (const ColmapTrackElement& element : point.track) {
      if (element.image_id < 1 || element.image_id > set.views.size()) {
        throw InputError((folder / kModel).string(), "does not belong to transforms.json", kAgain);
      }
      sparse.views.push_back(static_cast<int>(element.image_id) - 1);
    }
    set.points.push_back(std::move(sparse));
  }
  return set;
}

std::vector<std::string> LoadLostViews(const Workspace& workspace) {
  return ReadTransformsJson(workspace.Stage("poses") / kTransforms).lost;
}

}  // namespace lamella
