#include "pipeline/calibration_patterns.h"

#include <algorithm>
#include <map>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/image_io.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;
using Kind = PatternShot::Kind;

constexpr int kFormatVersion = 1;
constexpr const char* kRecord = "patterns.json";
constexpr int kMostPx = 1 << 28;

const std::map<Kind, std::string>& KindNames() {
  static const std::map<Kind, std::string> names = {{Kind::kDark, "dark"},
                                                    {Kind::kWhite, "white"},
                                                    {Kind::kLeak, "leak"},
                                                    {Kind::kBoard, "board"},
                                                    {Kind::kPhase, "phase"}};
  return names;
}

std::string RoleName(PanelId::Role role) {
  return role == PanelId::kEmitter ? "emitter" : "modulator";
}

const CalibratedPanel* FindPanel(const ShotList& list, const PanelId& id) {
  const auto found = std::find_if(list.panels.begin(), list.panels.end(),
                                  [&](const CalibratedPanel& panel) { return panel.id == id; });
  return found == list.panels.end() ? nullptr : &*found;
}

// shots.json of docs/formats.md.
Json ShotsJson(const ShotList& list) {
  Json shots = Json::array();
  for (const PatternShot& shot : list.shots) {
    Json layers = Json::array();
    const std::vector<LayerPatterns> shown = ShownIn(shot, list.num_layers);
    for (int l = 0; l < list.num_layers; ++l) {
      const LayerPatterns& patterns = shown[static_cast<std::size_t>(l)];
      Json layer = Json::object();
      for (const auto& [role, pattern] : {std::pair{PanelId::kEmitter, &patterns.emitter},
                                          std::pair{PanelId::kModulator, &patterns.modulator}}) {
        const CalibratedPanel* panel = FindPanel(list, {l, role});
        if (panel != nullptr) layer[RoleName(role)] = {PatternFile(*panel, *pattern)};
      }
      layers.push_back(layer);
    }
    shots.push_back({{"name", shot.name}, {"layers", layers}});
  }
  return {{"format_version", kFormatVersion}, {"shots", shots}};
}

Json RecordJson(const ShotList& list) {
  Json panels = Json::array(), shots = Json::array();
  for (const CalibratedPanel& panel : list.panels) {
    Json json = {{"layer", panel.id.layer},
                 {"role", RoleName(panel.id.role)},
                 {"width_px", panel.size.width_px},
                 {"height_px", panel.size.height_px},
                 {"mirror_x", panel.mirrored}};
    if (const auto& board = panel.board) {
      json["board"] = {{"columns", board->columns},     {"rows", board->rows},
                       {"square_px", board->square_px}, {"left_px", board->left_px},
                       {"top_px", board->top_px},       {"first_id", board->first_id}};
    }
    panels.push_back(json);
  }
  for (const PatternShot& shot : list.shots) {
    Json json = {{"name", shot.name}, {"kind", KindNames().at(shot.kind)}};
    if (shot.kind != Kind::kDark) json["layer"] = shot.panel.layer;
    if (shot.kind == Kind::kBoard || shot.kind == Kind::kPhase) {
      json["role"] = RoleName(shot.panel.role);
      json["again"] = shot.again;
    }
    if (shot.kind == Kind::kPhase) {
      json["axis"] = shot.pattern.series.axis == PanelAxis::kU ? "u" : "v";
      json["period_px"] = shot.pattern.series.period_px;
      json["steps"] = shot.pattern.series.steps;
      json["step"] = shot.pattern.step;
    }
    shots.push_back(json);
  }
  Json json = {{"format_version", kFormatVersion},
               {"display", list.display},
               {"mode", list.mode == CalibrationMode::kQuick ? "quick" : "precise"},
               {"num_layers", list.num_layers}};
  if (list.planes_in_turn) json["planes_in_turn"] = true;
  json["panels"] = panels;
  json["shots"] = shots;
  return json;
}

PanelId ReadPanelId(const JsonObject& json, int num_layers) {
  const int layer = json.Whole("layer", 0, num_layers - 1);
  const std::string role = json.TextOr("role", "emitter");
  if (role != "emitter" && role != "modulator") throw json.Wrong("role", "emitter or modulator");
  return {layer, role == "emitter" ? PanelId::kEmitter : PanelId::kModulator};
}

CalibratedPanel ReadPanel(const JsonObject& json, int num_layers) {
  CalibratedPanel panel{ReadPanelId(json, num_layers),
                        {json.Whole("width_px", 1, kMostPx), json.Whole("height_px", 1, kMostPx)},
                        json.HasTrue("mirror_x"),
                        std::nullopt};
  if (!json.Has("board")) return panel;
  const JsonObject board = json.Object("board");
  panel.board = CharucoBoard{panel.size.width_px,
                             panel.size.height_px,
                             board.Whole("columns", 2, 10000),
                             board.Whole("rows", 2, 10000),
                             board.Whole("square_px", 1, kMostPx),
                             board.Whole("left_px", 0, kMostPx),
                             board.Whole("top_px", 0, kMostPx),
                             board.Whole("first_id", 0, kMostPx)};
  return panel;
}

PatternShot ReadShot(const JsonObject& json, const ShotList& list) {
  PatternShot shot;
  shot.name = json.Text("name");
  const std::string kind = json.Text("kind");
  const auto known = std::find_if(KindNames().begin(), KindNames().end(),
                                  [&](const auto& entry) { return entry.second == kind; });
  if (known == KindNames().end()) throw json.Wrong("kind", "dark, white, leak, board or phase");
  shot.kind = known->first;
  if (shot.kind == Kind::kDark) return shot;
  shot.panel = ReadPanelId(json, list.num_layers);
  const CalibratedPanel* panel = FindPanel(list, shot.panel);
  if (panel == nullptr) throw json.Wrong("role", "a panel of the list");
  shot.again = json.HasTrue("again");
  if (shot.kind == Kind::kBoard) {
    if (!panel->board) throw json.Wrong("role", "a panel with a board");
    shot.pattern.kind = Pattern::Kind::kBoard;
  }
  if (shot.kind == Kind::kPhase) {
    const std::string axis = json.Text("axis");
    if (axis != "u" && axis != "v") throw json.Wrong("axis", "u or v");
    const int steps = json.Whole("steps", 3, 1000);
    shot.pattern = {
        Pattern::Kind::kPhase,
        {axis == "u" ? PanelAxis::kU : PanelAxis::kV, json.Whole("period_px", 2, kMostPx), steps},
        json.Whole("step", 0, steps - 1)};
  }
  return shot;
}

Image<Rgb8> Draw(const CalibratedPanel& panel, const Pattern& pattern) {
  if (pattern.kind == Pattern::Kind::kBoard) return DrawBoard(*panel.board);
  return DrawPhase(panel.size.width_px, panel.size.height_px, pattern.series, pattern.step);
}

}  // namespace

void WritePatterns(const fs::path& folder, const ShotList& list, Progress& progress) {
  CreateFolder(folder);
  std::map<std::string, std::pair<const CalibratedPanel*, Pattern>> files;
  for (const PatternShot& shot : list.shots) {
    if (shot.kind != Kind::kBoard && shot.kind != Kind::kPhase) continue;
    const CalibratedPanel* panel = FindPanel(list, shot.panel);
    files[PatternFile(*panel, shot.pattern)] = {panel, shot.pattern};
  }
  progress.Start("patterns", static_cast<std::int64_t>(files.size()), "images");
  for (const auto& [name, drawn] : files) {
    WriteCodes8(folder / name, Draw(*drawn.first, drawn.second).span());
    progress.Advance();
  }
  WriteTextAtomically(folder / "shots.json", ShotsJson(list).dump(1) + "\n");
  WriteTextAtomically(folder / "shots.txt", DescribeShots(list));
  WriteTextAtomically(folder / kRecord, RecordJson(list).dump(1) + "\n");
}

ShotList LoadShotList(const fs::path& folder) {
  const JsonObject json(folder / kRecord);
  json.CheckFormatVersion(kFormatVersion);
  ShotList list;
  list.display = json.Text("display");
  const std::string mode = json.Text("mode");
  if (mode != "quick" && mode != "precise") throw json.Wrong("mode", "quick or precise");
  list.mode = mode == "quick" ? CalibrationMode::kQuick : CalibrationMode::kPrecise;
  list.num_layers = json.Whole("num_layers", 1, 1024);
  list.planes_in_turn = json.HasTrue("planes_in_turn");
  for (const JsonObject& panel : json.Objects("panels")) {
    list.panels.push_back(ReadPanel(panel, list.num_layers));
  }
  for (const JsonObject& shot : json.Objects("shots")) list.shots.push_back(ReadShot(shot, list));
  if (list.shots.empty()) throw json.Wrong("shots", "one or more");
  return list;
}

}  // namespace lamella
