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
#include "pipeline/printed_board.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;
using Kind = PatternShot::Kind;

constexpr int kPatternsVersion = 1;
constexpr const char* kRecord = "patterns.json";
constexpr const char* kPrintedPicture = "printed_board.png";  // in pixels
constexpr const char* kPrintedSheet = "printed_board.pdf";    // at its size, for the printer
constexpr int kMostPx = 1 << 28;

const std::map<Kind, std::string>& KindNames() {
  static const std::map<Kind, std::string> names = {
      {Kind::kDark, "dark"},   {Kind::kWhite, "white"}, {Kind::kLeak, "leak"},
      {Kind::kBoard, "board"}, {Kind::kPhase, "phase"}, {Kind::kFlat, "flat"},
      {Kind::kMixed, "mixed"}, {Kind::kLines, "lines"}, {Kind::kPrinted, "printed"}};
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
    if (shot.kind == Kind::kPrinted) {
      const PrintedBoard& printed = *list.printed;
      json["printed"] = {{"file", kPrintedPicture},
                         {"width_mm", printed.board.panel_width_px * printed.pitch_mm()}};
    }
    shots.push_back(json);
  }
  return {{"format_version", kPatternsVersion}, {"shots", shots}};
}

bool HasLayer(Kind kind) { return kind != Kind::kDark && kind != Kind::kPrinted; }

bool HasRole(Kind kind) {
  return kind == Kind::kBoard || kind == Kind::kPhase || kind == Kind::kFlat;
}

Json BoardJson(const CharucoBoard& board) {
  return {{"columns", board.columns}, {"rows", board.rows},     {"square_px", board.square_px},
          {"left_px", board.left_px}, {"top_px", board.top_px}, {"first_id", board.first_id}};
}

Json RecordJson(const ShotList& list) {
  Json panels = Json::array(), shots = Json::array();
  for (const CalibratedPanel& panel : list.panels) {
    Json json = {{"layer", panel.id.layer},
                 {"role", RoleName(panel.id.role)},
                 {"width_px", panel.size.width_px},
                 {"height_px", panel.size.height_px},
                 {"mirror_x", panel.mirrored}};
    if (panel.board) json["board"] = BoardJson(*panel.board);
    panels.push_back(json);
  }
  for (const PatternShot& shot : list.shots) {
    Json json = {{"name", shot.name}, {"kind", KindNames().at(shot.kind)}};
    if (HasLayer(shot.kind)) json["layer"] = shot.panel.layer;
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
  Json json = {{"format_version", kPatternsVersion},
               {"display", list.display},
               {"mode", ModeNames().at(list.mode)},
               {"num_layers", list.num_layers}};
  if (list.planes_in_turn) json["planes_in_turn"] = true;
  if (list.printed) {
    const CharucoBoard& board = list.printed->board;
    Json printed = {{"width_px", board.panel_width_px}, {"height_px", board.panel_height_px}};
    printed.update(BoardJson(board));
    printed["square_mm"] = list.printed->square_mm;
    json["printed"] = printed;
  }
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

CharucoBoard ReadBoard(const JsonObject& json, const PanelSize& size) {
  return {size.width_px,
          size.height_px,
          json.Whole("columns", 2, 10000),
          json.Whole("rows", 2, 10000),
          json.Whole("square_px", 1, kMostPx),
          json.Whole("left_px", 0, kMostPx),
          json.Whole("top_px", 0, kMostPx),
          json.Whole("first_id", 0, kMostPx)};
}

PanelSize ReadSize(const JsonObject& json) {
  return {json.Whole("width_px", 1, kMostPx), json.Whole("height_px", 1, kMostPx)};
}

PrintedBoard ReadPrinted(const JsonObject& json) {
  const PrintedBoard printed{ReadBoard(json, ReadSize(json)), json.Number("square_mm")};
  if (!(printed.square_mm > 0)) throw json.Wrong("square_mm", "millimetres above 0");
  return printed;
}

CalibratedPanel ReadPanel(const JsonObject& json, int num_layers) {
  CalibratedPanel panel{ReadPanelId(json, num_layers), ReadSize(json), json.HasTrue("mirror_x"),
                        std::nullopt};
  if (json.Has("board")) panel.board = ReadBoard(json.Object("board"), panel.size);
  return panel;
}

PatternShot ReadShot(const JsonObject& json, const ShotList& list) {
  PatternShot shot;
  shot.name = json.Text("name");
  const std::string kind = json.Text("kind");
  const std::optional<Kind> known = Named(KindNames(), kind);
  if (!known) {
    throw json.Wrong("kind", "dark, white, leak, board, phase, flat, mixed, lines or printed");
  }
  shot.kind = *known;
  if (json.Has("exposure")) shot.exposure = json.Whole("exposure", 1, 1 << 20);
  shot.first_position_only = json.HasTrue("first_position_only");
  if (shot.kind == Kind::kPrinted && !list.printed) throw json.Wrong("kind", "a shot without it");
  if (!HasLayer(shot.kind)) return shot;
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
    if (!HasLayer(shot.kind)) continue;
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
  if (list.printed) {
    WriteCodes8(folder / kPrintedPicture, DrawBoard(list.printed->board).span());
    WriteTextAtomically(folder / kPrintedSheet, PdfOf(*list.printed));
  }
  WriteTextAtomically(folder / "shots.json", ShotsJson(list).dump(1) + "\n");
  WriteTextAtomically(folder / "shots.txt", DescribeShots(list));
  WriteTextAtomically(folder / kRecord, RecordJson(list).dump(1) + "\n");
}

ShotList LoadShotList(const fs::path& folder) {
  const JsonObject json(folder / kRecord);
  json.CheckFormatVersion(kPatternsVersion);
  ShotList list;
  list.display = json.Text("display");
  const std::string mode = json.Text("mode");
  const std::optional<CalibrationMode> known = Named(ModeNames(), mode);
  if (!known) throw json.Wrong("mode", "quick, precise or photometry");
  list.mode = *known;
  list.num_layers = json.Whole("num_layers", 1, 1024);
  list.planes_in_turn = json.HasTrue("planes_in_turn");
  if (json.Has("printed")) list.printed = ReadPrinted(json.Object("printed"));
  for (const JsonObject& panel : json.Objects("panels")) {
    list.panels.push_back(ReadPanel(panel, list.num_layers));
  }
  for (const JsonObject& shot : json.Objects("shots")) list.shots.push_back(ReadShot(shot, list));
  if (list.shots.empty()) throw json.Wrong("shots", "one or more");
  if (list.panels.empty()) throw json.Wrong("panels", "one or more");
  return list;
}

}  // namespace lamella
