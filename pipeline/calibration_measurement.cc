#include "pipeline/calibration_measurement.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/minimise.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostMeasuredLayers = 1024, kMostMeasuredViews = 1024;
constexpr double kMostRowError = 1e-6;  // of a sum of shares

const char* RoleName(const PanelId& panel) {
  return panel.role == PanelId::kEmitter ? "emitter" : "modulator";
}

Json ToJson(const PanelId& panel) { return {{"layer", panel.layer}, {"role", RoleName(panel)}}; }

Json ToJson(const std::vector<ParameterDeviation>& deviations) {
  Json json = Json::array();
  for (const ParameterDeviation& deviation : deviations) {
    json.push_back({{"parameter", deviation.name}, {"unit", deviation.unit}, {"sd", deviation.sd}});
  }
  return json;
}

Json ToJson(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise()) {
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return rows;
}

PanelId ReadPanelId(const JsonObject& json) {
  const std::string role = json.Text("role");
  if (role != "emitter" && role != "modulator") throw json.Wrong("role", "emitter or modulator");
  return {json.Whole("layer", 0, kMostMeasuredLayers),
          role == "emitter" ? PanelId::kEmitter : PanelId::kModulator};
}

double ReadNotNegative(const JsonObject& json, const char* key) {
  const double value = json.Number(key);
  if (value < 0) throw json.Wrong(key, "0 or more");
  return value;
}

Eigen::MatrixXd ReadShares(const JsonObject& json, const char* key, int num_views) {
  const auto size = static_cast<std::size_t>(num_views);
  const std::vector<double> shares = json.Numbers(key, size * size);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::MatrixXd matrix = Eigen::Map<const Rows>(shares.data(), num_views, num_views);
  const Eigen::VectorXd sums = matrix.rowwise().sum();
  if (matrix.minCoeff() < 0 || (sums.array() - 1).abs().maxCoeff() > kMostRowError) {
    throw json.Wrong(key, "rows of shares whose sum is 1");
  }
  return matrix;
}

EyeBox ReadEyeBox(const JsonObject& json) {
  json.CheckKeys({"half_width_mm", "half_height_mm", "near_mm", "far_mm"});
  return {ReadNotNegative(json, "half_width_mm"), ReadNotNegative(json, "half_height_mm"),
          ReadNotNegative(json, "near_mm"), ReadNotNegative(json, "far_mm")};
}

ProbedRay ReadRay(const JsonObject& json) {
  json.CheckKeys({"layer", "role", "reference_px", "eye_mm"});
  const std::vector<double> pixel = json.Numbers("reference_px", 2);
  const std::vector<double> eye = json.Numbers("eye_mm", 3);
  return {ReadPanelId(json), {pixel[0], pixel[1]}, {eye[0], eye[1], eye[2]}};
}

// What all reports have.
template <class Solved>
CalibrationMeasurement CommonOf(const Solved& solved) {
  const auto& report = solved.report;
  CalibrationMeasurement m;
  m.program = std::string("lamella ") + ProgramVersion();
  m.solver = SolverVersion();
  m.eye_box = report.limits.eye_box;
  m.ray_rms_sd_px = report.rays.rms_sd_px;
  m.ray_max_sd_px = report.rays.max_sd_px;
  m.worst = report.rays.worst;
  m.chi2 = report.chi2;
  m.slip_px = report.slip_px;
  for (const GroupVerdict& verdict : report.groups) {
    m.groups.push_back({verdict.group, verdict.freed, verdict.reason});
  }
  m.photos = solved.photos;
  return m;
}

}  // namespace

CalibrationMeasurement MeasurementOf(const SolvedPhotos& solved) {
  CalibrationMeasurement m = CommonOf(solved);
  m.reference = solved.report.reference;
  m.deviations = solved.report.deviations;
  return m;
}

CalibrationMeasurement MeasurementOf(const SolvedVarifocal& solved) {
  CalibrationMeasurement m = CommonOf(solved);
  const std::vector<CalibratedPlane>& planes = solved.report.planes;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    Eigen::Index number = 0;
    for (const auto& [name, unit] : {std::pair{"rotation x", "rad"},
                                     {"rotation y", "rad"},
                                     {"rotation z", "rad"},
                                     {"position x", "mm"},
                                     {"position y", "mm"},
                                     {"depth", "mm"},
                                     {"magnification", ""}}) {
      m.deviations.push_back({fmt::format("plane {} {}", k, name), unit,
                              std::sqrt(planes[k].covariance(number, number))});
      ++number;
    }
  }
  return m;
}

std::string DeviationsText(const std::vector<ParameterDeviation>& deviations) {
  return ToJson(deviations).dump();
}

std::vector<ParameterDeviation> ReadDeviations(const JsonObject& json, const char* key) {
  std::vector<ParameterDeviation> deviations;
  for (const JsonObject& deviation : json.Objects(key)) {
    deviation.CheckKeys({"parameter", "unit", "sd"});
    deviations.push_back(
        {deviation.Text("parameter"), deviation.Text("unit"), ReadNotNegative(deviation, "sd")});
  }
  return deviations;
}

std::string CrosstalkText(const std::vector<MeasuredCrosstalk>& crosstalk) {
  Json json = Json::array();
  for (const MeasuredCrosstalk& layer : crosstalk) {
    json.push_back({{"layer", layer.layer},
                    {"views", layer.without_pupil.rows()},
                    {"pupil_px", layer.pupil_px},
                    {"without_pupil", ToJson(layer.without_pupil)},
                    {"with_pupil", ToJson(layer.with_pupil)}});
  }
  return json.dump();
}

std::vector<MeasuredCrosstalk> ReadCrosstalk(const JsonObject& json, const char* key) {
  std::vector<MeasuredCrosstalk> crosstalk;
  for (const JsonObject& layer : json.Objects(key)) {
    layer.CheckKeys({"layer", "views", "pupil_px", "without_pupil", "with_pupil"});
    const int num_views = layer.Whole("views", 1, kMostMeasuredViews);
    crosstalk.push_back({layer.Whole("layer", 0, kMostMeasuredLayers),
                         ReadNotNegative(layer, "pupil_px"),
                         ReadShares(layer, "without_pupil", num_views),
                         ReadShares(layer, "with_pupil", num_views)});
  }
  return crosstalk;
}

std::string MeasurementText(const CalibrationMeasurement& m) {
  Json worst = ToJson(m.worst.panel);
  worst["reference_px"] = {m.worst.reference_px.x(), m.worst.reference_px.y()};
  worst["eye_mm"] = {m.worst.eye_mm.x(), m.worst.eye_mm.y(), m.worst.eye_mm.z()};
  Json groups = Json::array(), photos = Json::array();
  for (const auto& group : m.groups) {
    groups.push_back({{"group", group.name}, {"freed", group.freed}, {"reason", group.reason}});
  }
  for (const auto& photo : m.photos) {
    photos.push_back({{"file", photo.file}, {"sha256", photo.sha256}});
  }
  Json json = {{"program", m.program}, {"solver", m.solver}};
  if (m.reference) json["reference"] = ToJson(*m.reference);
  json.update(Json{
      {"eye_box",
       {{"half_width_mm", m.eye_box.half_width_mm},
        {"half_height_mm", m.eye_box.half_height_mm},
        {"near_mm", m.eye_box.near_mm},
        {"far_mm", m.eye_box.far_mm}}},
      {"rays", {{"rms_sd_px", m.ray_rms_sd_px}, {"max_sd_px", m.ray_max_sd_px}, {"worst", worst}}},
      {"chi2", m.chi2},
      {"slip_px", m.slip_px},
      {"deviations", ToJson(m.deviations)},
      {"groups", groups},
      {"photos", photos}});
  // Names of files need not be UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

CalibrationMeasurement ReadMeasurement(const JsonObject& json) {
  json.CheckKeys({"program", "solver", "reference", "eye_box", "rays", "chi2", "slip_px",
                  "deviations", "groups", "photos"});
  CalibrationMeasurement m;
  m.program = json.Text("program");
  m.solver = json.Text("solver");
  if (json.Has("reference")) {
    const JsonObject reference = json.Object("reference");
    reference.CheckKeys({"layer", "role"});
    m.reference = ReadPanelId(reference);
  }
  m.eye_box = ReadEyeBox(json.Object("eye_box"));
  const JsonObject rays = json.Object("rays");
  rays.CheckKeys({"rms_sd_px", "max_sd_px", "worst"});
  m.ray_rms_sd_px = ReadNotNegative(rays, "rms_sd_px");
  m.ray_max_sd_px = ReadNotNegative(rays, "max_sd_px");
  m.worst = ReadRay(rays.Object("worst"));
  m.chi2 = ReadNotNegative(json, "chi2");
  m.slip_px = ReadNotNegative(json, "slip_px");
  m.deviations = ReadDeviations(json, "deviations");
  for (const JsonObject& group : json.Objects("groups")) {
    group.CheckKeys({"group", "freed", "reason"});
    m.groups.push_back({group.Text("group"), group.Truth("freed"), group.Text("reason")});
  }
  for (const JsonObject& photo : json.Objects("photos")) {
    photo.CheckKeys({"file", "sha256"});
    m.photos.push_back({photo.Text("file"), photo.Text("sha256")});
  }
  return m;
}

}  // namespace lamella
