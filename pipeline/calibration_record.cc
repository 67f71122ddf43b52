#include "pipeline/calibration_record.h"

#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kCalibrationVersion = 1;

Json ToJson(const ToneCurve& curve) {
  switch (curve.kind) {
    case ToneCurve::Kind::kSrgb:
      return {{"curve", "srgb"}};
    case ToneCurve::Kind::kGamma:
      return {{"curve", "gamma"}, {"gamma", curve.gamma}};
    case ToneCurve::Kind::kTable:
      break;
  }
  return {{"curve", "table"}, {"table", curve.table}};
}

Json ToJson(const PanelCalibration& panel) {
  const Photometry& light = panel.photometry;
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back({light.primaries(r, 0), light.primaries(r, 1), light.primaries(r, 2)});
  }
  return {{"width_px", panel.width_px},
          {"height_px", panel.height_px},
          {"pitch_mm", panel.pitch_mm},
          {"scale", panel.scale},
          {"aspect", panel.aspect},
          {"skew", panel.skew},
          {"bow_mm", panel.bow_mm},
          {"pincushion", panel.pincushion},
          {"mirror_x", panel.mirror_x},
          {"rgb_stripes", panel.rgb_stripes},
          {"response", ToJson(light.curve)},
          {"black", light.black},
          {"primaries", rows},
          {"falloff", light.falloff},
          {"crosstalk", {{"size", light.crosstalk.size}, {"weights", light.crosstalk.weights}}},
          {"evenness",
           {{"columns", light.evenness.columns},
            {"rows", light.evenness.rows},
            {"gains", light.evenness.gains}}}};
}

const char* NameOf(LensLattice::Type type) {
  switch (type) {
    case LensLattice::Type::kLine:
      return "line";
    case LensLattice::Type::kSquare:
      return "square";
    case LensLattice::Type::kHexagonal:
      break;
  }
  return "hexagonal";
}

Json ToJson(const LayerCalibration& layer) {
  const Rigid& pose = layer.display_from_stack;
  const auto vector = [](const auto& v) { return std::vector<double>(v.begin(), v.end()); };
  Json json = {{"display_from_reference",
                {{"rotation_wxyz",
                  {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()}},
                 {"translation_mm", vector(pose.translation)}}},
               {"emitter_offset_mm", vector(layer.offset_mm)},
               {"gap_mm", layer.gap_mm},
               {"emitter_rotation_rad", vector(layer.rotation_rad)},
               {"index", layer.index},
               {"gain", layer.gain},
               {"emitter", ToJson(layer.emitter)}};
  if (layer.modulator) json["modulator"] = ToJson(*layer.modulator);
  if (layer.lattice) {
    json["lattice"] = {{"type", NameOf(layer.lattice->type)},
                       {"pitch_mm", layer.lattice->pitch_mm},
                       {"rotation_rad", layer.lattice->rotation_rad},
                       {"phase", vector(layer.lattice->phase)},
                       {"focal_mm", layer.lattice->focal_mm}};
  }
  if (layer.plate) {
    json["plate"] = {{"thickness_mm", layer.plate->thickness_mm},
                     {"index", layer.plate->index},
                     {"normal", vector(layer.plate->normal)}};
  }
  return json;
}

// `count` numbers, or what they are by default.
template <class Vector>
void ReadVector(const JsonObject& json, const char* key, Vector& vector) {
  if (!json.Has(key)) return;
  const std::vector<double> numbers = json.Numbers(key, static_cast<std::size_t>(vector.size()));
  std::copy(numbers.begin(), numbers.end(), vector.begin());
}

void ReadFlag(const JsonObject& json, const char* key, bool& flag) {
  if (!json.Has(key)) return;
  flag = json.Truth(key);
}

ToneCurve ReadCurve(const JsonObject& json) {
  json.CheckKeys({"curve", "gamma", "table"});
  ToneCurve curve;
  const std::string name = json.Text("curve");
  if (name == "gamma") {
    curve.kind = ToneCurve::Kind::kGamma;
    curve.gamma = json.Number("gamma");
  } else if (name == "table") {
    curve.kind = ToneCurve::Kind::kTable;
    curve.table = json.Numbers("table");
  } else if (name != "srgb") {
    throw json.Wrong("curve", "srgb, gamma or table");
  }
  return curve;
}

Photometry ReadPhotometry(const JsonObject& json) {
  Photometry light;
  if (json.Has("response")) light.curve = ReadCurve(json.Object("response"));
  light.black = json.NumberOr("black", light.black);
  light.falloff = json.NumberOr("falloff", light.falloff);
  if (json.Has("primaries")) {
    const std::vector<double> rows = json.Numbers("primaries", 9);
    light.primaries = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
  }
  if (json.Has("crosstalk")) {
    const JsonObject kernel = json.Object("crosstalk");
    kernel.CheckKeys({"size", "weights"});
    light.crosstalk = {kernel.Whole("size", 1, 99), kernel.Numbers("weights")};
  }
  if (json.Has("evenness")) {
    const JsonObject map = json.Object("evenness");
    map.CheckKeys({"columns", "rows", "gains"});
    light.evenness = {map.Whole("columns", 1, 1000), map.Whole("rows", 1, 1000),
                      map.Numbers("gains")};
  }
  return light;
}

PanelCalibration ReadPanel(const JsonObject& json) {
  json.CheckKeys({"width_px", "height_px", "pitch_mm", "scale", "aspect", "skew", "bow_mm",
                  "pincushion", "mirror_x", "rgb_stripes", "response", "black", "primaries",
                  "falloff", "crosstalk", "evenness"});
  PanelCalibration panel;
  panel.width_px = json.Whole("width_px", 1, 1 << 20);
  panel.height_px = json.Whole("height_px", 1, 1 << 20);
  panel.pitch_mm = json.Number("pitch_mm");
  panel.scale = json.NumberOr("scale", 0);
  panel.aspect = json.NumberOr("aspect", 0);
  panel.skew = json.NumberOr("skew", 0);
  panel.bow_mm = json.NumberOr("bow_mm", 0);
  panel.pincushion = json.NumberOr("pincushion", 0);
  ReadFlag(json, "mirror_x", panel.mirror_x);
  ReadFlag(json, "rgb_stripes", panel.rgb_stripes);
  panel.photometry = ReadPhotometry(json);
  return panel;
}

LensLattice ReadLattice(const JsonObject& json) {
  json.CheckKeys({"type", "pitch_mm", "rotation_rad", "phase", "focal_mm"});
  LensLattice lattice;
  const std::string type = json.Text("type");
  if (type == "line") {
    lattice.type = LensLattice::Type::kLine;
  } else if (type == "hexagonal") {
    lattice.type = LensLattice::Type::kHexagonal;
  } else if (type != "square") {
    throw json.Wrong("type", "line, square or hexagonal");
  }
  lattice.pitch_mm = json.Number("pitch_mm");
  lattice.rotation_rad = json.NumberOr("rotation_rad", 0);
  ReadVector(json, "phase", lattice.phase);
  lattice.focal_mm = json.NumberOr("focal_mm", 0);
  return lattice;
}

Rigid ReadPose(const JsonObject& json) {
  json.CheckKeys({"rotation_wxyz", "translation_mm"});
  Eigen::Vector4d q(1, 0, 0, 0);
  Rigid pose;
  ReadVector(json, "rotation_wxyz", q);
  ReadVector(json, "translation_mm", pose.translation);
  pose.rotation = Eigen::Quaterniond(q(0), q(1), q(2), q(3));
  return pose;
}

LayerCalibration ReadLayerCalibration(const JsonObject& json) {
  if (json.Has("display_from_stack")) {
    throw InputError(json.where(), "has display_from_stack, which is display_from_reference now",
                     "rename it; its numbers stay");
  }
  json.CheckKeys({"display_from_reference", "emitter_offset_mm", "gap_mm", "emitter_rotation_rad",
                  "index", "gain", "emitter", "modulator", "lattice", "plate"});
  LayerCalibration layer;
  layer.display_from_stack = ReadPose(json.Object("display_from_reference"));
  ReadVector(json, "emitter_offset_mm", layer.offset_mm);
  layer.gap_mm = json.NumberOr("gap_mm", 0);
  ReadVector(json, "emitter_rotation_rad", layer.rotation_rad);
  layer.index = json.NumberOr("index", 1);
  layer.gain = json.NumberOr("gain", 1);
  layer.emitter = ReadPanel(json.Object("emitter"));
  if (json.Has("modulator")) layer.modulator = ReadPanel(json.Object("modulator"));
  if (json.Has("lattice")) layer.lattice = ReadLattice(json.Object("lattice"));
  if (json.Has("plate")) {
    const JsonObject plate = json.Object("plate");
    plate.CheckKeys({"thickness_mm", "index", "normal"});
    layer.plate = Plate{plate.Number("thickness_mm"), plate.Number("index"), {0, 0, 1}};
    ReadVector(plate, "normal", layer.plate->normal);
  }
  return layer;
}

}  // namespace

std::string CalibrationText(const Calibration& calibration, const MeasuredNumbers& measured) {
  Json layers = Json::array();
  for (const LayerCalibration& layer : calibration.layers) layers.push_back(ToJson(layer));
  Json json = {{"format_version", kCalibrationVersion},
               {"display", calibration.display},
               {"layers", layers}};
  if (measured.geometry) json["measured"] = Json::parse(MeasurementText(*measured.geometry));
  if (!measured.light.empty()) json["measured_light"] = Json::parse(DeviationsText(measured.light));
  if (!measured.crosstalk.empty()) {
    json["measured_crosstalk"] = Json::parse(CrosstalkText(measured.crosstalk));
  }
  return json.dump(1) + "\n";
}

void SaveCalibration(const std::filesystem::path& file, const Calibration& calibration,
                     const MeasuredNumbers& measured) {
  WriteTextAtomically(file, CalibrationText(calibration, measured));
}

std::optional<CalibrationMeasurement> LoadMeasurement(const std::filesystem::path& file) {
  const JsonObject json(file);
  json.CheckFormatVersion(kCalibrationVersion);
  if (!json.Has("measured")) return std::nullopt;
  return ReadMeasurement(json.Object("measured"));
}

std::vector<ParameterDeviation> LoadLightDeviations(const std::filesystem::path& file) {
  const JsonObject json(file);
  json.CheckFormatVersion(kCalibrationVersion);
  if (!json.Has("measured_light")) return {};
  return ReadDeviations(json, "measured_light");
}

std::vector<MeasuredCrosstalk> LoadCrosstalk(const std::filesystem::path& file) {
  const JsonObject json(file);
  json.CheckFormatVersion(kCalibrationVersion);
  if (!json.Has("measured_crosstalk")) return {};
  return ReadCrosstalk(json, "measured_crosstalk");
}

Calibration LoadCalibration(const std::filesystem::path& file) {
  const JsonObject json(file);
  json.CheckFormatVersion(kCalibrationVersion);
  json.CheckKeys(
      {"format_version", "display", "layers", "measured", "measured_light", "measured_crosstalk"});
  if (json.Has("measured")) ReadMeasurement(json.Object("measured"));
  if (json.Has("measured_light")) ReadDeviations(json, "measured_light");
  if (json.Has("measured_crosstalk")) ReadCrosstalk(json, "measured_crosstalk");
  Calibration calibration;
  calibration.display = json.Text("display");
  for (const JsonObject& layer : json.Objects("layers")) {
    calibration.layers.push_back(ReadLayerCalibration(layer));
  }
  try {
    Check(calibration, file.string());
  } catch (const Error& error) {  // the same line, but it is the input that can't be used
    throw InputError("", error.what(), "");
  }
  return calibration;
}

}  // namespace lamella
