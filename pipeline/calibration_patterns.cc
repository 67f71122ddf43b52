#include "pipeline/calibration_patterns.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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
  static const std::map<Kind, std::string> names = {
      {Kind::kDark, "dark"},   {Kind::kWhite, "white"}, {Kind::kLeak, "leak"},
      {Kind::kBoard, "board"}, {Kind::kPhase, "phase"}, {Kind::kFlat, "flat"},
      {Kind::kMixed, "mixed"}, {Kind::kLines, "lines"}};
  return names;
}

const std::map<CalibrationMode, std::string>& ModeNames() {
  static const std::map<CalibrationMode, std::string> names = {
      {CalibrationMode::kQuick, "quick"},
      {CalibrationMode::kPrecise, "precise"},
      {CalibrationMode::kPhotometry, "photometry"}};
  return names;
}

// The key of a name; nothing where it is none of them.
template <class Key>
std::optional<Key> Named(const std::map<Key, std::string>& names, const std::string& name) {
  for (const auto& [key, known] : names) {
    if (known == name) return key;
  }
  return std::nullopt;
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
    Json json = {{"name", shot.name}, {"layers", layers}};
    if (shot.exposure != 1) json["exposure"] = shot.exposure;
    if (shot.first_position_only) json["cameras"] = 1;
    shots.push_back(json);
  }
  return {{"format_version", kFormatVersion}, {"shots", shots}};
}

bool HasRole(Kind kind) {
  return kind == Kind::kBoard || kind == Kind::kPhase || kind == Kind::kFlat;
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
    if (HasRole(shot.kind)) json["role"] = RoleName(shot.panel.role);
    if (shot.kind == Kind::kBoard || shot.kind == Kind::kPhase) json["again"] = shot.again;
    if (shot.kind == Kind::kFlat || shot.kind == Kind::kMixed) {
      json["code"] = {shot.pattern.color.r, shot.pattern.color.g, shot.pattern.color.b};
    }
    if (shot.kind == Kind::kLines) {
      json["period_px"] = shot.pattern.period_px;
      json["step"] = shot.pattern.step;
    }
    if (shot.exposure != 1) json["exposure"] = shot.exposure;
    if (shot.first_position_only) json["first_position_only"] = true;
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
               {"mode", ModeNames().at(list.mode)},
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
  const std::optional<Kind> known = Named(KindNames(), kind);
  if (!known) {
    throw json.Wrong("kind", "dark, white, leak, board, phase, flat, mixed or lines");
  }
  shot.kind = *known;
  if (json.Has("exposure")) shot.exposure = json.Whole("exposure", 1, 1 << 20);
  shot.first_position_only = json.HasTrue("first_position_only");
  if (shot.kind == Kind::kDark) return shot;
  shot.panel = ReadPanelId(json, list.num_layers);
  const CalibratedPanel* panel = FindPanel(list, shot.panel);
  if (panel == nullptr) throw json.Wrong("role", "a panel of the list");
  shot.again = json.HasTrue("again");
  if (shot.kind == Kind::kBoard) {
    if (!panel->board) throw json.Wrong("role", "a panel with a board");
    shot.pattern.kind = Pattern::Kind::kBoard;
  }
  if (shot.kind == Kind::kFlat || shot.kind == Kind::kMixed) {
    const std::vector<double> code = json.Numbers("code", 3);
    if (*std::min_element(code.begin(), code.end()) < 0 ||
        *std::max_element(code.begin(), code.end()) > 255) {
      throw json.Wrong("code", "three codes from 0 to 255");
    }
    shot.pattern.kind = Pattern::Kind::kFlat;
    shot.pattern.color = {static_cast<std::uint8_t>(code[0]), static_cast<std::uint8_t>(code[1]),
                          static_cast<std::uint8_t>(code[2])};
  }
  if (shot.kind == Kind::kLines) {
    shot.pattern.kind = Pattern::Kind::kColumns;
    shot.pattern.period_px = json.Whole("period_px", kLinesPeriodPx, kLinesPeriodPx);
    shot.pattern.step = json.Whole("step", 0, shot.pattern.period_px - 1);
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
  if (pattern.kind == Pattern::Kind::kFlat) {
    return {panel.size.width_px, panel.size.height_px, pattern.color};
  }
  if (pattern.kind == Pattern::Kind::kColumns) {
    Image<Rgb8> columns(panel.size.width_px, panel.size.height_px);
    for (int v = 0; v < columns.height(); ++v) {
      for (int u = pattern.step; u < columns.width(); u += pattern.period_px) {
        columns(u, v) = {255, 255, 255};
      }
    }
    return columns;
  }
  return DrawPhase(panel.size.width_px, panel.size.height_px, pattern.series, pattern.step);
}

// The patterns that shots show and that are no word, by the names of their files.
std::map<std::string, std::pair<const CalibratedPanel*, Pattern>> FilesOf(const ShotList& list) {
  std::map<std::string, std::pair<const CalibratedPanel*, Pattern>> files;
  for (const PatternShot& shot : list.shots) {
    if (shot.kind == Kind::kDark) continue;
    const LayerPatterns layer =
        ShownIn(shot, list.num_layers)[static_cast<std::size_t>(shot.panel.layer)];
    for (const auto& [role, pattern] : {std::pair{PanelId::kEmitter, layer.emitter},
                                        std::pair{PanelId::kModulator, layer.modulator}}) {
      const CalibratedPanel* panel = FindPanel(list, {shot.panel.layer, role});
      if (panel == nullptr || pattern.kind == Pattern::Kind::kBlack ||
          pattern.kind == Pattern::Kind::kWhite) {
        continue;
      }
      files[PatternFile(*panel, pattern)] = {panel, pattern};
    }
  }
  return files;
}

}  // namespace

void WritePatterns(const fs::path& folder, const ShotList& list, Progress& progress) {
  CreateFolder(folder);
  const std::map<std::string, std::pair<const CalibratedPanel*, Pattern>> files = FilesOf(list);
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
  const std::optional<CalibrationMode> known = Named(ModeNames(), mode);
  if (!known) throw json.Wrong("mode", "quick, precise or photometry");
  list.mode = *known;
  list.num_layers = json.Whole("num_layers", 1, 1024);
  list.planes_in_turn = json.HasTrue("planes_in_turn");
  for (const JsonObject& panel : json.Objects("panels")) {
    list.panels.push_back(ReadPanel(panel, list.num_layers));
  }
  for (const JsonObject& shot : json.Objects("shots")) list.shots.push_back(ReadShot(shot, list));
  if (list.shots.empty()) throw json.Wrong("shots", "one or more");
  if (list.panels.empty()) throw json.Wrong("panels", "one or more");
  return list;
}

}  // namespace lamella
