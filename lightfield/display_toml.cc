// The display's TOML (docs/formats.md): read strictly, so that a misspelt key is never ignored.
#include <algorithm>
#include <array>
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
  // One of these words.
  std::optional<std::string> Word(const char* key, const std::vector<std::string>& words) const {
    std::optional<std::string> word = Text(key);
    if (!word || std::find(words.begin(), words.end(), *word) != words.end()) return word;
    throw UsageError(At(*table_.get(key)), fmt::format("{} = \"{}\" is not known", key, *word),
                     fmt::format("did you mean \"{}\"?", NearestName(*word, words)));
  }
  template <std::size_t N>
  std::optional<std::array<double, N>> Numbers(const char* key, const char* expected) const {
    const toml::node* node = table_.get(key);
    if (!node) return std::nullopt;
    const toml::array* given = node->as_array();
    if (!given || given->size() != N) throw WrongType(*node, key, expected);
    std::array<double, N> numbers{};
    for (std::size_t i = 0; i < N; ++i) {
      if (!(*given)[i].is_number()) throw WrongType(*node, key, expected);
      numbers[i] = *(*given)[i].value<double>();
    }
    return numbers;
  }
  // UsageError at the key, where it is given.
  void Refuse(const char* key, const std::string& what, const std::string& fix) const {
    if (const toml::node* node = table_.get(key)) throw UsageError(At(*node), what, fix);
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

// d0_mm or gap_mm, and the index of what fills the gap.
void ReadGap(const Reader& reader, const std::string& where, const std::string& name,
             Layer& layer) {
  const std::optional<double> d0 = reader.Number("d0_mm"), gap = reader.Number("gap_mm");
  layer.index = reader.Number("index").value_or(1);
  if (d0 && gap) {
    throw UsageError(where, name + " has d0_mm beside gap_mm", "give one of the two");
  }
  if (!(layer.index >= 1 && layer.index <= 4)) {
    throw UsageError(where, fmt::format("{}: index = {}", name, layer.index),
                     "give a refractive index from 1 to 4");
  }
  layer.d0_mm = gap ? *gap / layer.index : reader.Need(d0, "d0_mm");
  if (gap && !(std::isfinite(*gap) && *gap > 0)) {
    throw UsageError(where, fmt::format("{}: gap_mm = {}", name, *gap), "give millimetres above 0");
  }
}

Barrier ReadBarrier(const toml::table& table, const std::string& where, const std::string& layer) {
  const Reader reader(table, where, layer + "'s barrier",
                      {"period_px", "aperture_px", "slots", "contrast"});
  Barrier barrier;
  barrier.period_px = reader.Need(reader.Integer("period_px"), "period_px");
  barrier.aperture_px = reader.Need(reader.Integer("aperture_px"), "aperture_px");
  barrier.slots = reader.Need(reader.Integer("slots"), "slots");
  barrier.contrast = reader.Number("contrast").value_or(barrier.contrast);
  return barrier;
}

LensletArray ReadLenslets(const toml::table& table, const std::string& where,
                          const std::string& layer) {
  const Reader reader(table, where, layer + "'s lenslets",
                      {"lattice", "pitch_px", "rays", "offset_px", "shift_odd_rows", "focal_mm"});
  LensletArray lenses;
  const std::string lattice =
      reader.Need(reader.Word("lattice", {"square", "hexagonal"}), "lattice");
  lenses.lattice =
      lattice == "square" ? LensletArray::Lattice::kSquare : LensletArray::Lattice::kHexagonal;
  lenses.pitch_px = reader.Need(reader.Number("pitch_px"), "pitch_px");
  lenses.rays = reader.Need(reader.Integer("rays"), "rays");
  const std::array<double, 2> offset =
      reader.Numbers<2>("offset_px", "two numbers [right, down]").value_or(std::array{0.0, 0.0});
  lenses.offset_x_px = offset[0];
  lenses.offset_y_px = offset[1];
  lenses.shift_odd_rows = reader.Truth("shift_odd_rows").value_or(lenses.shift_odd_rows);
  lenses.focal_mm = reader.Number("focal_mm").value_or(lenses.focal_mm);
  return lenses;
}

Lenticular ReadLenticular(const toml::table& table, const std::string& where,
                          const std::string& layer) {
  const Reader reader(table, where, layer + "'s lenticular",
                      {"subpixels_per_lens", "slant", "views", "offset_subpx", "focal_mm"});
  Lenticular lenses;
  lenses.subpixels_per_lens =
      reader.Need(reader.Number("subpixels_per_lens"), "subpixels_per_lens");
  lenses.slant = reader.Need(reader.Number("slant"), "slant");
  lenses.views = reader.Need(reader.Integer("views"), "views");
  lenses.offset_subpx = reader.Number("offset_subpx").value_or(lenses.offset_subpx);
  lenses.focal_mm = reader.Number("focal_mm").value_or(lenses.focal_mm);
  return lenses;
}

BarePanel ReadBare(const toml::table& table, const std::string& where, const std::string& layer) {
  const Reader reader(table, where, layer + "'s bare panel", {"eye_box_mm", "views"});
  BarePanel bare;
  bare.eye_box_mm = reader.Number("eye_box_mm").value_or(bare.eye_box_mm);
  bare.views = reader.Integer("views").value_or(bare.views);
  return bare;
}

Optics ReadOptics(const Reader& layer, const std::string& where, const std::string& name) {
  constexpr std::array kKinds = {"barrier", "lenslets", "lenticular", "bare"};
  const char* given = nullptr;
  for (const char* kind : kKinds) {
    if (layer.Table(kind) == nullptr) continue;
    if (given != nullptr) {
      layer.Refuse(kind, fmt::format("{} has [layer.{}] beside [layer.{}]", name, kind, given),
                   "keep the one that the layer has");
    }
    given = kind;
  }
  if (given == nullptr) {
    throw UsageError(
        where, fmt::format("{} has none of [layer.{}]", name, fmt::join(kKinds, "], [layer.")),
        "add one, a barrier for instance with period_px, aperture_px and slots");
  }
  const std::string_view kind = given;
  const toml::table& table = *layer.Table(given);
  if (kind == "barrier") return ReadBarrier(table, where, name);
  if (kind == "lenslets") return ReadLenslets(table, where, name);
  if (kind == "lenticular") return ReadLenticular(table, where, name);
  return ReadBare(table, where, name);
}

GlassPlate ReadPlate(const toml::table& table, const std::string& where, const std::string& layer) {
  const Reader reader(table, where, layer + "'s plate", {"thickness_mm", "index", "normal"});
  GlassPlate plate;
  plate.thickness_mm = reader.Need(reader.Number("thickness_mm"), "thickness_mm");
  plate.index = reader.Number("index").value_or(plate.index);
  plate.normal = reader.Numbers<3>("normal", "three numbers [right, up, to the viewer]")
                     .value_or(plate.normal);
  return plate;
}

// A plane of [varifocal] has its position and magnification from there.
Layer ReadLayer(const toml::table& table, const std::string& where, std::size_t index,
                bool varifocal) {
  const std::string name = fmt::format("layer {}", index);
  const Reader reader(table, where, name,
                      {"position_mm", "d0_mm", "gap_mm", "index", "mirror_x", "magnification",
                       "barrier", "lenslets", "lenticular", "bare", "plate"});
  Layer layer;
  if (varifocal) {
    for (const char* key : {"position_mm", "magnification"}) {
      reader.Refuse(key, fmt::format("{} has {} beside [varifocal]", name, key),
                    "leave it out: it follows from [varifocal]");
    }
  } else {
    layer.position_mm = reader.Need(reader.Number("position_mm"), "position_mm");
    layer.magnification = reader.Number("magnification").value_or(1);
  }
  layer.optics = ReadOptics(reader, where, name);
  if (std::holds_alternative<BarePanel>(layer.optics)) {
    for (const char* key : {"d0_mm", "gap_mm", "index"}) {
      reader.Refuse(key, fmt::format("{} has {} beside [layer.bare]", name, key),
                    "leave it out: nothing stands before a bare panel");
    }
    layer.d0_mm = 0;
  } else {
    ReadGap(reader, where, name, layer);
  }
  layer.mirror_x = reader.Truth("mirror_x").value_or(false);
  if (const toml::table* plate = reader.Table("plate")) {
    layer.plate = ReadPlate(*plate, where, name);
  }
  return layer;
}

Varifocal ReadVarifocal(const toml::table& table, const std::string& where) {
  const Reader reader(table, where, "[varifocal]",
                      {"planes", "depth_mm", "spacing", "relay_focal_mm", "magnification0"});
  Varifocal varifocal;
  varifocal.planes = reader.Need(reader.Integer("planes"), "planes");
  varifocal.depth_mm = reader.Need(reader.Number("depth_mm"), "depth_mm");
  if (reader.Word("spacing", {"uniform", "sinusoidal"}) == "sinusoidal") {
    varifocal.spacing = Varifocal::Spacing::kSinusoidal;
  }
  varifocal.relay_focal_mm = reader.Number("relay_focal_mm").value_or(varifocal.relay_focal_mm);
  varifocal.magnification0 = reader.Number("magnification0").value_or(varifocal.magnification0);
  return varifocal;
}

void ReadLayers(const Reader& top, const std::string& where, Display& display) {
  if (const toml::table* varifocal = top.Table("varifocal")) {
    display.varifocal = ReadVarifocal(*varifocal, where);
  }
  const toml::array* tables = top.Tables("layer");
  for (std::size_t i = 0; tables != nullptr && i < tables->size(); ++i) {
    display.layers.push_back(
        ReadLayer(*(*tables)[i].as_table(), where, i, display.varifocal.has_value()));
  }
  if (!display.varifocal) return;
  if (display.layers.size() != 1) {
    throw UsageError(where,
                     fmt::format("[varifocal] and {} [[layer]] tables", display.layers.size()),
                     "give exactly one [[layer]]: all planes are images of it");
  }
  CheckVarifocal(*display.varifocal, where);
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
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
                    "border_offset_mm", "panel", "layer", "varifocal"});
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
  const Reader panel(
      *panel_table, where, "[panel]",
      {"width_px", "height_px", "pitch_mm", "binning_px", "contrast", "slot_crosstalk"});
  display.width_px = panel.Need(panel.Integer("width_px"), "width_px");
  display.height_px = panel.Need(panel.Integer("height_px"), "height_px");
  display.pitch_mm = panel.Need(panel.Number("pitch_mm"), "pitch_mm");
  display.binning_px = panel.Integer("binning_px").value_or(1);
  display.contrast = panel.Number("contrast").value_or(display.contrast);
  display.slot_crosstalk = panel.Number("slot_crosstalk").value_or(display.slot_crosstalk);
  ReadLayers(top, where, display);
  display.border_mm = top.Number("border_mm").value_or(DefaultBorder(display.layers));
  display.border_offset_mm =
      top.Number("border_offset_mm").value_or(MeanSharpestOffsetMm(display.layers));
  return display;
}

std::string TomlString(const std::string& text) {
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

std::string ContrastToToml(double contrast) {
  return std::isinf(contrast) ? "" : fmt::format("contrast = {}\n", contrast);
}

std::string FocalToToml(double focal_mm) {
  return focal_mm == 0 ? "" : fmt::format("focal_mm = {}\n", focal_mm);
}

std::string ToToml(const Optics& optics) {
  if (const Barrier* barrier = std::get_if<Barrier>(&optics)) {
    return fmt::format("[layer.barrier]\nperiod_px = {}\naperture_px = {}\nslots = {}\n",
                       barrier->period_px, barrier->aperture_px, barrier->slots) +
           ContrastToToml(barrier->contrast);
  }
  if (const LensletArray* lenses = std::get_if<LensletArray>(&optics)) {
    const bool square = lenses->lattice == LensletArray::Lattice::kSquare;
    return fmt::format(
               "[layer.lenslets]\nlattice = \"{}\"\npitch_px = {}\nrays = {}\n"
               "offset_px = [{}, {}]\nshift_odd_rows = {}\n",
               square ? "square" : "hexagonal", lenses->pitch_px, lenses->rays, lenses->offset_x_px,
               lenses->offset_y_px, lenses->shift_odd_rows) +
           FocalToToml(lenses->focal_mm);
  }
  if (const BarePanel* bare = std::get_if<BarePanel>(&optics)) {
    return fmt::format("[layer.bare]\neye_box_mm = {}\nviews = {}\n", bare->eye_box_mm,
                       bare->views);
  }
  const Lenticular& lenses = std::get<Lenticular>(optics);
  return fmt::format(
             "[layer.lenticular]\nsubpixels_per_lens = {}\nslant = {}\nviews = {}\n"
             "offset_subpx = {}\n",
             lenses.subpixels_per_lens, lenses.slant, lenses.views, lenses.offset_subpx) +
         FocalToToml(lenses.focal_mm);
}

std::string ToToml(const Varifocal& varifocal) {
  return fmt::format(
      "\n[varifocal]\nplanes = {}\ndepth_mm = {}\nspacing = \"{}\"\nrelay_focal_mm = {}\n"
      "magnification0 = {}\n",
      varifocal.planes, varifocal.depth_mm,
      varifocal.spacing == Varifocal::Spacing::kUniform ? "uniform" : "sinusoidal",
      varifocal.relay_focal_mm, varifocal.magnification0);
}

std::string ToToml(const Layer& layer, bool varifocal) {
  std::string text = "\n[[layer]]\n";
  if (!varifocal) text += fmt::format("position_mm = {}\n", layer.position_mm);
  if (!std::holds_alternative<BarePanel>(layer.optics)) {
    text += fmt::format("d0_mm = {}\n", layer.d0_mm);
  }
  text += fmt::format("mirror_x = {}\n", layer.mirror_x);
  if (layer.index != 1) text += fmt::format("index = {}\n", layer.index);
  if (!varifocal && layer.magnification != 1) {
    text += fmt::format("magnification = {}\n", layer.magnification);
  }
  text += ToToml(layer.optics);
  if (!layer.plate) return text;
  const auto& [x, y, z] = layer.plate->normal;
  return text + fmt::format("[layer.plate]\nthickness_mm = {}\nindex = {}\nnormal = [{}, {}, {}]\n",
                            layer.plate->thickness_mm, layer.plate->index, x, y, z);
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
      kFormatVersion, TomlString(display.name), display.viewing_distance_mm, display.shear,
      display.border_mm, display.border_offset_mm, display.width_px, display.height_px,
      display.pitch_mm, display.binning_px);
  text += ContrastToToml(display.contrast);
  if (display.slot_crosstalk != 0) {
    text += fmt::format("slot_crosstalk = {}\n", display.slot_crosstalk);
  }
  if (display.varifocal) {
    return text + ToToml(*display.varifocal) + ToToml(display.layers.front(), true);
  }
  for (const Layer& layer : display.layers) text += ToToml(layer, false);
  return text;
}

}  // namespace lamella
