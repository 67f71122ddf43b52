#include "pipeline/visual_json.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kNewestVersion = 3;
constexpr int kMaxSide = 1 << 15;
constexpr std::size_t kMaxCells = 10;  // of the device's own shader
constexpr int kCellPatterns = 5;

double NumberOf(const JsonObject& file, const std::string& key) {
  return file.HasObject(key) ? file.Object(key).Number("value") : file.Number(key);
}

double NumberOr(const JsonObject& file, const std::string& key, double otherwise) {
  return file.Has(key) ? NumberOf(file, key) : otherwise;
}

double Positive(const JsonObject& file, const std::string& key) {
  const double number = NumberOf(file, key);
  if (!(number > 0)) throw file.Wrong(key, "a number above 0");
  return number;
}

int Whole(const JsonObject& file, const std::string& key, double number, int min, int max) {
  if (number != std::floor(number) || number < min || number > max) {
    throw file.Wrong(key, fmt::format("a whole number from {} to {}", min, max));
  }
  return static_cast<int>(number);
}

// Truths are numbers here, as shaders take them.
bool Flag(const JsonObject& file, const std::string& key, bool otherwise) {
  return NumberOr(file, key, otherwise ? 1 : 0) >= 0.5;
}

double Angle(const JsonObject& file, const std::string& key) {
  const double angle = NumberOf(file, key);
  if (!(angle > 0 && angle < 180)) throw file.Wrong(key, "an angle between 0 and 180 degrees");
  return angle;
}

std::string VersionOf(const JsonObject& file) {
  std::string version = file.Text("configVersion");
  char* end = nullptr;
  const double number = std::strtod(version.c_str(), &end);
  if (end == version.c_str() || *end != '\0' || !(number >= 1)) {
    throw file.Wrong("configVersion", "a version like \"3.0\"");
  }
  if (number >= kNewestVersion + 1) {
    throw InputError(file.where(), fmt::format("\"configVersion\" is {}, newer than 3.0", version),
                     "use a newer lamella");
  }
  return version;
}

std::vector<LookingGlass::Cell> CellsOf(const JsonObject& file) {
  std::vector<LookingGlass::Cell> cells;
  if (!file.Has("subpixelCells")) return cells;
  constexpr std::array<std::array<const char*, 2>, 3> kNames{
      {{"ROffsetX", "ROffsetY"}, {"GOffsetX", "GOffsetY"}, {"BOffsetX", "BOffsetY"}}};
  for (const JsonObject& object : file.Objects("subpixelCells")) {
    LookingGlass::Cell cell{};
    for (std::size_t c = 0; c < kNames.size(); ++c) {
      cell[c] = {NumberOf(object, kNames[c][0]), NumberOf(object, kNames[c][1])};
    }
    cells.push_back(cell);
  }
  if (cells.size() > kMaxCells) throw file.Wrong("subpixelCells", "a list of at most 10 cells");
  return cells;
}

int PatternOf(const JsonObject& file) {
  const std::string key = file.Has("cellPatternMode") ? "cellPatternMode" : "CellPatternMode";
  return Whole(file, key, NumberOr(file, key, 0), 0, kCellPatterns - 1);
}

}  // namespace

VisualJson ReadVisualJson(const std::filesystem::path& path) {
  const JsonObject file(path);
  VisualJson visual;
  visual.version = VersionOf(file);
  visual.serial = file.Text("serial");
  LookingGlass& panel = visual.panel;
  panel.pitch_per_in = Positive(file, "pitch");
  panel.slope = NumberOf(file, "slope");
  if (panel.slope == 0) throw file.Wrong("slope", "a number other than 0");
  panel.center = NumberOf(file, "center");
  panel.dpi = Positive(file, "DPI");
  panel.width_px = Whole(file, "screenW", NumberOf(file, "screenW"), 1, kMaxSide);
  panel.height_px = Whole(file, "screenH", NumberOf(file, "screenH"), 1, kMaxSide);
  panel.flip_x = Flag(file, "flipImageX", false);
  panel.flip_y = Flag(file, "flipImageY", false);
  panel.flip_subpixels = Flag(file, "flipSubp", false);
  panel.cell_pattern = PatternOf(file);
  panel.cells = CellsOf(file);
  visual.view_cone_deg = Angle(file, "viewCone");
  visual.vertical_deg = NumberOr(file, "verticalAngle", 0);
  visual.fringe = NumberOr(file, "fringe", 0);
  visual.invert_views = Flag(file, "invView", true);
  // Renderers of later versions always invert, and their devices say 0.
  panel.invert_views = visual.invert_views || std::strtod(visual.version.c_str(), nullptr) >= 2;
  return visual;
}

void WriteVisualJson(const std::filesystem::path& path, const VisualJson& visual) {
  const auto number = [](double value) { return Json{{"value", value}}; };
  const LookingGlass& panel = visual.panel;
  Json json = {{"configVersion", "3.0"},
               {"serial", visual.serial},
               {"pitch", number(panel.pitch_per_in)},
               {"slope", number(panel.slope)},
               {"center", number(panel.center)},
               {"fringe", number(visual.fringe)},
               {"viewCone", number(visual.view_cone_deg)},
               {"invView", number(visual.invert_views ? 1 : 0)},
               {"verticalAngle", number(visual.vertical_deg)},
               {"DPI", number(panel.dpi)},
               {"screenW", number(panel.width_px)},
               {"screenH", number(panel.height_px)},
               {"flipImageX", number(panel.flip_x ? 1 : 0)},
               {"flipImageY", number(panel.flip_y ? 1 : 0)},
               {"flipSubp", number(panel.flip_subpixels ? 1 : 0)}};
  if (!panel.cells.empty()) {
    json["CellPatternMode"] = number(panel.cell_pattern);
    json["subpixelCells"] = Json::array();
    for (const LookingGlass::Cell& cell : panel.cells) {
      json["subpixelCells"].push_back({{"ROffsetX", cell[0][0]},
                                       {"ROffsetY", cell[0][1]},
                                       {"GOffsetX", cell[1][0]},
                                       {"GOffsetY", cell[1][1]},
                                       {"BOffsetX", cell[2][0]},
                                       {"BOffsetY", cell[2][1]}});
    }
  }
  WriteTextAtomically(path, json.dump(1) + "\n");
}

}  // namespace lamella
