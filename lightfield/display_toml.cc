// The display's TOML (docs/formats.md): read strictly, so that a misspelt key is never ignored.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "lightfield/atomic_file.h"
#include "lightfield/display.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr int kFormatVersion = 1;

// One TOML table whose keys are all known; asks for its values by name.
class Reader {
 public:
  Reader(const toml::table& table, std::string where, std::string table_name,
         std::initializer_list<const char*> known)
      : table_(table), file_(std::move(where)), name_(std::move(table_name)) {
    const std::vector<std::string> names(known.begin(), known.end());
    for (const auto& [key, node] : table) {
      if (std::find(names.begin(), names.end(), key.str()) != names.end()) continue;
      throw UsageError(At(node), fmt::format("{} has no key \"{}\"", name_, key.str()),
                       fmt::format("did you mean \"{}\"?", NearestName(key.str(), names)));
    }
  }

  std::optional<double> Number(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (const auto* real = node->as_floating_point()) return real->get();
    if (const auto* whole = node->as_integer()) return static_cast<double>(whole->get());
    throw WrongType(*node, key, "a number");
  }
  std::optional<int> Integer(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    const auto* whole = node->as_integer();
    if (!whole) throw WrongType(*node, key, "a whole number");
    if (std::abs(whole->get()) > std::numeric_limits<int>::max()) {
      throw UsageError(At(*node), fmt::format("{} = {} is too large", key, whole->get()),
                       "give at most 2147483647");
    }
    return static_cast<int>(whole->get());
  }
  std::optional<bool> Truth(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (const auto* truth = node->as_boolean()) return truth->get();
    throw WrongType(*node, key, "true or false");
  }
  std::optional<std::string> Text(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    if (const auto* text = node->as_string()) return text->get();
    throw WrongType(*node, key, "a string in quotes");
  }
  const toml::table* Table(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return nullptr;
    if (!node->is_table()) throw WrongType(*node, key, fmt::format("a table [{}]", key));
    return node->as_table();
  }
  const toml::array* Tables(const char* key) const {
    const toml::node* node = table_.get(key);
    if (!node) return nullptr;
    if (!node->is_array_of_tables()) throw WrongType(*node, key, fmt::format("tables [[{}]]", key));
    return node->as_array();
  }
  template <class T>
  T Need(const std::optional<T>& value, const char* key) const {
    if (value) return *value;
    throw UsageError(file_, fmt::format("{} has no \"{}\"", name_, key),
                     fmt::format("add {} = ... to {}", key, name_));
  }

 private:
  std::string At(const toml::node& node) const {
    return fmt::format("{}:{}", file_, node.source().begin.line);
  }
  Error WrongType(const toml::node& node, const char* key, std::string_view expected) const {
    return UsageError(At(node), fmt::format("{} has the wrong type", key),
                      fmt::format("give {}", expected));
  }

  const toml::table& table_;
  std::string file_, name_;
};

// d0_mm, or gap_mm and the index of what fills the gap.
double ReadGap(const Reader& layer, const std::string& where, const std::string& name) {
  const std::optional<double> d0 = layer.Number("d0_mm"), gap = layer.Number("gap_mm");
  const std::optional<double> index = layer.Number("index");
  if (d0 && (gap || index)) {
    throw UsageError(where, name + " has d0_mm beside gap_mm or index",
                     "give d0_mm, or gap_mm with index");
  }
  if (!gap) return layer.Need(d0, "d0_mm");
  const double n = index.value_or(1);
  if (!(n >= 1 && n <= 4)) {
    throw UsageError(where, fmt::format("{}: index = {}", name, n),
                     "give a refractive index from 1 to 4");
  }
  return *gap / n;
}

Layer ReadLayer(const toml::table& table, const std::string& where, std::size_t index) {
  const std::string name = fmt::format("layer {}", index);
  const Reader reader(table, where, name,
                      {"position_mm", "d0_mm", "gap_mm", "index", "mirror_x", "barrier"});
  Layer layer;
  layer.position_mm = reader.Need(reader.Number("position_mm"), "position_mm");
  layer.d0_mm = ReadGap(reader, where, name);
  layer.mirror_x = reader.Truth("mirror_x").value_or(false);
  const toml::table* barrier = reader.Table("barrier");
  if (!barrier) {
    throw UsageError(where, name + " has no [layer.barrier]",
                     "add it with period_px, aperture_px and slots");
  }
  const Reader b(*barrier, where, name + "'s barrier", {"period_px", "aperture_px", "slots"});
  layer.barrier.period_px = b.Need(b.Integer("period_px"), "period_px");
  layer.barrier.aperture_px = b.Need(b.Integer("aperture_px"), "aperture_px");
  layer.barrier.slots = b.Need(b.Integer("slots"), "slots");
  return layer;
}

// Without border_mm: a fifth of the narrowest spacing (ranieri2012.md section 6).
double DefaultBorder(const std::vector<Layer>& layers) {
  double spacing = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < layers.size(); ++i) {
    spacing = std::min(spacing, layers[i].position_mm - layers[i - 1].position_mm);
  }
  return std::isfinite(spacing) ? 0.2 * std::max(spacing, 0.0) : 0.0;
}

Display ToDisplay(const toml::table& document, const std::string& where) {
  const Reader top(document, where, "the display",
                   {"format_version", "name", "viewing_distance_mm", "shear", "border_mm",
                    "border_offset_mm", "panel", "layer"});
  const int version = top.Integer("format_version").value_or(kFormatVersion);
  if (version < 1 || version > kFormatVersion) {
    throw UsageError(where, fmt::format("format_version = {} is not known here", version),
                     fmt::format("this program reads version {}", kFormatVersion));
  }
  Display display;
  display.name = top.Need(top.Text("name"), "name");
  display.viewing_distance_mm = top.Need(top.Number("viewing_distance_mm"), "viewing_distance_mm");
  display.shear = top.Truth("shear").value_or(true);
  const toml::table* panel_table = top.Table("panel");
  if (!panel_table) {
    throw UsageError(where, "the display has no [panel]",
                     "add it with width_px, height_px and pitch_mm");
  }
  const Reader panel(*panel_table, where, "[panel]",
                     {"width_px", "height_px", "pitch_mm", "binning_px"});
  display.width_px = panel.Need(panel.Integer("width_px"), "width_px");
  display.height_px = panel.Need(panel.Integer("height_px"), "height_px");
  display.pitch_mm = panel.Need(panel.Number("pitch_mm"), "pitch_mm");
  display.binning_px = panel.Integer("binning_px").value_or(1);
  if (const toml::array* layers = top.Tables("layer")) {
    for (const toml::node& layer : *layers) {
      display.layers.push_back(ReadLayer(*layer.as_table(), where, display.layers.size()));
    }
  }
  display.border_mm = top.Number("border_mm").value_or(DefaultBorder(display.layers));
  display.border_offset_mm =
      top.Number("border_offset_mm").value_or(MeanSharpestOffsetMm(display.layers));
  return display;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

Display ParseDisplay(const std::string& toml, const std::string& where) {
  toml::table document;
  try {
    document = toml::parse(toml, where);
  } catch (const toml::parse_error& error) {
    throw UsageError(fmt::format("{}:{}", where, error.source().begin.line), error.description(),
                     "mend the TOML");
  }
  Display display = ToDisplay(document, where);
  Check(display, where);
  return display;
}

Display ReadDisplay(const std::filesystem::path& path) {
  return ParseDisplay(ReadText(path), path.string());
}

std::string ToToml(const Display& display) {
  std::string text = fmt::format(
      "format_version = {}\nname = {}\nviewing_distance_mm = {}\nshear = {}\nborder_mm = {}\n"
      "border_offset_mm = {}\n\n"
      "[panel]\nwidth_px = {}\nheight_px = {}\npitch_mm = {}\nbinning_px = {}\n",
      kFormatVersion, Quoted(display.name), display.viewing_distance_mm, display.shear,
      display.border_mm, display.border_offset_mm, display.width_px, display.height_px,
      display.pitch_mm, display.binning_px);
  for (const Layer& layer : display.layers) {
    text += fmt::format(
        "\n[[layer]]\nposition_mm = {}\nd0_mm = {}\nmirror_x = {}\n"
        "[layer.barrier]\nperiod_px = {}\naperture_px = {}\nslots = {}\n",
        layer.position_mm, layer.d0_mm, layer.mirror_x, layer.barrier.period_px,
        layer.barrier.aperture_px, layer.barrier.slots);
  }
  return text;
}

}  // namespace lamella
