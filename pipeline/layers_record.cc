#include "pipeline/layers_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/calibration_record.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLayersVersion = 2;
constexpr const char* kLayersFile = "layers.json";
constexpr const char* kCalibrationFile = "calibration.json";
constexpr const char* kRunLayers = "run `lamella layers` again";
constexpr float kLargestHalf = 65504;
constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};

// JSON has no infinity.
Json Number(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

double Number(const Json& json) {
  if (!json.is_string()) return json.get<double>();
  return json == "inf" ? std::numeric_limits<double>::infinity()
                       : -std::numeric_limits<double>::infinity();
}

Json ToJson(const Placement& p) {
  const Eigen::Quaterniond& q = p.camera_from_world.rotation;
  const Eigen::Vector3d& t = p.camera_from_world.translation;
  Json matrix = Json::array();
  for (int row = 0; row < 4; ++row) {
    const auto r = p.display_from_world.row(row);
    matrix.push_back({r(0), r(1), r(2), r(3)});
  }
  return {
      {"reference_view", p.reference_view},
      {"viewing_distance_mm", p.viewing_distance_mm},
      {"a", p.a},
      {"b", p.b},
      {"mm_per_view_px", p.mm_per_view_px},
      {"focal_px", p.focal_px},
      {"middle", {p.middle.x(), p.middle.y()}},
      {"picture_width_mm", p.picture_width_mm},
      {"picture_height_mm", p.picture_height_mm},
      {"near", p.near},
      {"far", Number(p.far)},
      {"near_mm", p.near_mm},
      {"far_mm", p.far_mm},
      {"camera_from_world",
       {{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}}, {"translation", {t.x(), t.y(), t.z()}}}},
      {"display_from_world", matrix}};
}

Placement PlacementFromJson(const Json& json) {
  Placement p;
  p.reference_view = json.at("reference_view");
  p.viewing_distance_mm = json.at("viewing_distance_mm");
  p.a = json.at("a");
  p.b = json.at("b");
  p.mm_per_view_px = json.at("mm_per_view_px");
  p.focal_px = json.at("focal_px");
  p.middle = {json.at("middle").at(0).get<double>(), json.at("middle").at(1).get<double>()};
  p.picture_width_mm = json.at("picture_width_mm");
  p.picture_height_mm = json.at("picture_height_mm");
  p.near = json.at("near");
  p.far = Number(json.at("far"));
  p.near_mm = json.at("near_mm");
  p.far_mm = json.at("far_mm");
  const Json& q = json.at("camera_from_world").at("rotation_wxyz");
  const Json& t = json.at("camera_from_world").at("translation");
  p.camera_from_world.rotation = Eigen::Quaterniond(q.at(0), q.at(1), q.at(2), q.at(3));
  p.camera_from_world.translation = {t.at(0).get<double>(), t.at(1).get<double>(),
                                     t.at(2).get<double>()};
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      p.display_from_world(row, column) = json.at("display_from_world")
                                              .at(static_cast<std::size_t>(row))
                                              .at(static_cast<std::size_t>(column));
    }
  }
  return p;
}

}  // namespace

void SaveLayersRecord(const fs::path& folder, const LayersRecord& record) {
  Json files = Json::array();
  for (std::size_t layer = 0; layer < record.display.layers.size(); ++layer) {
    const int k = SlotsPerAxis(record.display.layers[layer]);
    for (int slot = 0; slot < k * k; ++slot) {
      files.push_back({{"file", EmitterFile(static_cast<int>(layer), slot)},
                       {"layer", layer},
                       {"slot", slot},
                       {"slot_x", slot % k},
                       {"slot_y", slot / k}});
    }
  }
  Json json = {{"format_version", kLayersVersion},
               {"display", ToToml(record.display)},
               {"placement", ToJson(record.placement)},
               {"seen_share", record.seen_share},
               {"seen_share_in_picture", record.seen_share_in_picture},
               {"emitters", files}};
  if (record.calibration) {
    json["calibration"] = kCalibrationFile;
    SaveCalibration(folder / kCalibrationFile, *record.calibration);
  }
  WriteTextAtomically(folder / kLayersFile, json.dump(1) + "\n");
}

LayersRecord LoadLayersRecord(const Workspace& workspace) {
  const fs::path path = workspace.Stage("layers") / kLayersFile;
  try {
    const Json json = Json::parse(ReadText(path));
    if (json.at("format_version").get<int>() > kLayersVersion) {
      throw InputError(path.string(), "was written by a newer lamella",
                       "use that version or another --workspace");
    }
    if (json.at("format_version").get<int>() < kLayersVersion) {
      throw InputError(path.string(), "was written by an older lamella", kRunLayers);
    }
    LayersRecord record;
    record.display = ParseDisplay(json.at("display").get<std::string>(), path.string());
    record.placement = PlacementFromJson(json.at("placement"));
    record.seen_share = json.at("seen_share");
    record.seen_share_in_picture = json.at("seen_share_in_picture");
    if (json.contains("calibration")) {
      const fs::path file = path.parent_path() / json.at("calibration").get<std::string>();
      record.calibration = LoadCalibration(file);
      CheckCalibrates(*record.calibration, record.display, file.string());
    }
    return record;
  } catch (const Json::exception&) {
    throw InputError(path.string(), "is damaged", kRunLayers);
  }
}

std::string EmitterFile(int layer, int slot) {
  return fmt::format("layer_{}_slot_{}.exr", layer, slot);
}

std::vector<Channel> ChannelsOf(const EmitterImage& image) {
  const int width = image.color.width(), height = image.color.height();
  std::vector<Channel> channels;
  for (const char* name : kChannels) channels.push_back({name, {width, height}});
  for (std::size_t i = 0; i < image.color.size(); ++i) {
    const Rgb& color = image.color.data()[i];
    channels[0].pixels.data()[i] = std::min(color.r, kLargestHalf);
    channels[1].pixels.data()[i] = std::min(color.g, kLargestHalf);
    channels[2].pixels.data()[i] = std::min(color.b, kLargestHalf);
    channels[3].pixels.data()[i] = image.coverage.data()[i];
  }
  return channels;
}

ExrRowsWriter EmitterWriter(const fs::path& folder, int layer, int slot, int width, int height) {
  return {folder / EmitterFile(layer, slot),
          {kChannels.begin(), kChannels.end()},
          width,
          height,
          ExrType::kHalf,
          ExrCompression::kPiz};
}

void SaveEmitterImage(const fs::path& folder, int layer, int slot, const EmitterImage& image) {
  ExrRowsWriter file =
      EmitterWriter(folder, layer, slot, image.color.width(), image.color.height());
  file.Write(ChannelsOf(image));
  file.Close();
}

EmitterReader::EmitterReader(const Workspace& workspace, const Display& display, int layer,
                             int slot)
    : path_(workspace.Stage("layers") / EmitterFile(layer, slot)), file_(path_) {
  if (file_.width() != display.emitter_columns() || file_.height() != display.emitter_rows()) {
    throw InputError(path_.string(), "has not the size of the display in layers.json", kRunLayers);
  }
}

EmitterImage EmitterReader::Read(int first_row, int end_row) {
  std::vector<Channel> channels = file_.Read(first_row, end_row);
  const Image<float> r = TakeChannel(channels, "R", path_), g = TakeChannel(channels, "G", path_),
                     b = TakeChannel(channels, "B", path_);
  EmitterImage image{Image<Rgb>(r.width(), r.height()), TakeChannel(channels, "A", path_)};
  for (std::size_t i = 0; i < r.size(); ++i) {
    image.color.data()[i] = {r.data()[i], g.data()[i], b.data()[i]};
  }
  return image;
}

EmitterImage LoadEmitterImage(const Workspace& workspace, const Display& display, int layer,
                              int slot) {
  return EmitterReader(workspace, display, layer, slot).Read(0, display.emitter_rows());
}

LayerImages LoadLayerImages(const Workspace& workspace, const LayersRecord& record) {
  LayerImages images;
  images.seen_share = record.seen_share;
  for (std::size_t layer = 0; layer < record.display.layers.size(); ++layer) {
    const int k = SlotsPerAxis(record.display.layers[layer]);
    std::vector<EmitterImage> slots(static_cast<std::size_t>(k * k));
    ParallelForEach(0, k * k, [&](std::int64_t slot) {
      slots[static_cast<std::size_t>(slot)] = LoadEmitterImage(
          workspace, record.display, static_cast<int>(layer), static_cast<int>(slot));
    });
    images.slots.push_back(std::move(slots));
  }
  return images;
}

}  // namespace lamella
