#include <map>
#include <memory>
#include <numbers>

#include "datasets_synthetic/mesh.h"
#include "datasets_synthetic/mesh_of_cylinder.h"
#include "datasets_synthetic/recipe_scene-inl.h"
#include "datasets_synthetic/room.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Eigen::Vector3d;
using AnyTexture = std::variant<Texture, ImageTexture>;

const std::vector<std::string> kPatterns = {"noise",   "spots",   "tiles", "plain",
                                            "grating", "checker", "image"};
const std::vector<std::string> kTextureKeys = {"name",      "pattern",   "seed",  "scale",
                                               "octaves",   "dark",      "light", "accent",
                                               "direction", "frequency", "file",  "repeat"};

const std::map<std::string, std::vector<std::string>>& ShapeKeys() {
  static const std::map<std::string, std::vector<std::string>> keys = {
      {"sphere", {"centre", "radius"}},
      {"rectangle", {"corner", "centre", "u", "v"}},
      {"box", {"centre", "size", "turn_deg"}},
      {"cylinder", {"from", "to", "radius"}},
      {"torus", {"centre", "radius", "tube_radius", "turn_deg"}},
      {"waves", {"centre", "width", "height", "amplitude", "wavelength", "turn_deg"}},
      {"mesh", {"file", "centre", "scale", "fit", "turn_deg"}}};
  return keys;
}

std::vector<std::string> ShapeNames() {
  std::vector<std::string> names;
  for (const auto& [name, keys] : ShapeKeys()) names.push_back(name);
  return names;
}

// Degrees about x, then y, then z.
Eigen::Quaterniond Turn(const StrictTable& table) {
  const Vector3d angles =
      table.Vector("turn_deg").value_or(Vector3d::Zero()) * (std::numbers::pi / 180);
  return Eigen::AngleAxisd(angles.z(), Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angles.y(), Vector3d::UnitY()) *
         Eigen::AngleAxisd(angles.x(), Vector3d::UnitX());
}

Rgb Color(const StrictTable& table, const char* key, Rgb otherwise, double most) {
  const std::optional<Vector3d> color = table.Vector(key);
  if (!color) return otherwise;
  if (!(color->minCoeff() >= 0 && color->maxCoeff() <= most)) {
    throw table.Wrong(key, fmt::format("{} is no colour", key),
                      fmt::format("give red, green and blue from 0 to {:g}, linear light", most));
  }
  const Eigen::Vector3f c = color->cast<float>();
  return {c.x(), c.y(), c.z()};
}

Shape Moved(const Shape& shape, const Vector3d& way) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    return Sphere{sphere->centre + way, sphere->radius};
  }
  if (const auto* p = std::get_if<Parallelogram>(&shape)) {
    return Parallelogram{p->corner + way, p->u, p->v};
  }
  const auto& mesh = *std::get<std::shared_ptr<const Mesh>>(shape);
  return std::make_shared<const Mesh>(
      Transformed(mesh, Eigen::Affine3d(Eigen::Translation3d(way))));
}

std::shared_ptr<const Mesh> Placed(const Mesh& mesh, const Vector3d& centre,
                                   const Eigen::Quaterniond& turn, double scale = 1) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  map.translate(centre).rotate(turn).scale(scale);
  return std::make_shared<const Mesh>(Transformed(mesh, map));
}

Parallelogram ReadRectangle(const StrictTable& table) {
  Parallelogram p;
  p.u = table.Need(table.Vector("u"), "u");
  p.v = table.Need(table.Vector("v"), "v");
  if (!(p.u.cross(p.v).norm() > 0)) {
    throw table.Wrong("u", "u and v span no area", "give two directions that differ");
  }
  if (table.Has("corner") == table.Has("centre")) {
    throw table.Wrong("corner", table.name() + " needs a corner or a centre", "give one of them");
  }
  p.corner =
      table.Has("corner") ? *table.Vector("corner") : *table.Vector("centre") - 0.5 * (p.u + p.v);
  return p;
}

std::vector<Shape> ReadBox(const StrictTable& table) {
  const Vector3d size = table.Need(table.Vector("size"), "size");
  if (!(size.minCoeff() > 0)) {
    throw table.Wrong("size", "a side of the box is not above 0", "give three numbers above 0");
  }
  return Box(table.Need(table.Vector("centre"), "centre"), size, Turn(table));
}

Shape ReadCylinder(const StrictTable& table) {
  const Vector3d from = table.Need(table.Vector("from"), "from");
  const Vector3d to = table.Need(table.Vector("to"), "to");
  const double radius = table.Need(table.Length("radius"), "radius");
  if (from == to) throw table.Wrong("to", "the cylinder has no length", "move its other end");
  return std::make_shared<const Mesh>(MeshOfCylinder(from, to, radius, 32));
}

Shape ReadTorus(const StrictTable& table) {
  const double radius = table.Need(table.Length("radius"), "radius");
  const double tube = table.Need(table.Length("tube_radius"), "tube_radius");
  if (tube >= radius) {
    throw table.Wrong("tube_radius", "the tube is thicker than the ring is wide",
                      "give a tube_radius below radius");
  }
  return Placed(MeshOfTorus(Vector3d::Zero(), radius, tube, 96),
                table.Need(table.Vector("centre"), "centre"), Turn(table));
}

// z = amplitude sin(kx) sin(ky), with the normals of the formula.
Shape ReadWaves(const StrictTable& table) {
  const double width = table.Need(table.Length("width"), "width");
  const double height = table.Need(table.Length("height"), "height");
  const double amplitude = table.Need(table.Number("amplitude"), "amplitude");
  const double wavelength = table.Need(table.Length("wavelength"), "wavelength");
  const double k = 2 * std::numbers::pi / wavelength;
  constexpr double kCellsPerWave = 64;
  const auto cells = [&](double length) {
    return static_cast<int>(std::clamp(kCellsPerWave * length / wavelength, 4.0, 1024.0));
  };
  Mesh mesh = MeshOfHeightField(
      {-0.5 * width, -0.5 * height, width, height, cells(width), cells(height)},
      [&](double x, double y) { return amplitude * std::sin(k * x) * std::sin(k * y); });
  mesh.normals.clear();
  for (const Vector3d& p : mesh.vertices) {
    const double dx = amplitude * k * std::cos(k * p.x()) * std::sin(k * p.y());
    const double dy = amplitude * k * std::sin(k * p.x()) * std::cos(k * p.y());
    mesh.normals.push_back(Vector3d(-dx, -dy, 1).normalized());
  }
  return Placed(mesh, table.Need(table.Vector("centre"), "centre"), Turn(table));
}

// The path of a file that a recipe names; InputError where there is none.
fs::path FileOf(const StrictTable& table, const fs::path& folder) {
  const std::string name = table.Need(table.Text("file"), "file");
  fs::path path = (folder / name).lexically_normal();
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    throw InputError(table.Where("file"), fmt::format("there is no file \"{}\"", path.string()),
                     "paths are relative to the recipe's folder");
  }
  return path;
}

// What is wrong with a file, with the recipe's line before it.
template <class Read>
auto ReadFor(const StrictTable& table, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    if (error.code() != ExitCode::kInput) throw;
    const std::string line = error.what();
    throw InputError(table.Where("file"), line.substr(0, line.find("; ")), "mend or replace it");
  }
}

Shape ReadMeshShape(const StrictTable& table, const fs::path& folder) {
  const fs::path path = FileOf(table, folder);
  const Mesh mesh = ReadFor(table, [&] { return ReadMesh(path); });
  const std::optional<double> fit = table.Length("fit"), scale = table.Length("scale");
  const Vector3d centre = table.Vector("centre").value_or(Vector3d::Zero());
  if (!fit) return Placed(mesh, centre, Turn(table), scale.value_or(1));
  if (scale) throw table.Wrong("fit", "a mesh has fit beside scale", "give one of them");
  const Eigen::AlignedBox3d bounds = BoundsOf(mesh);
  const double longest = bounds.isEmpty() ? 0 : bounds.sizes().maxCoeff();
  if (!(longest > 0)) throw table.Wrong("fit", "the mesh has no size", "leave fit out");
  const Mesh about_middle =
      Transformed(mesh, Eigen::Affine3d(Eigen::Translation3d(-bounds.center())));
  return Placed(about_middle, centre, Turn(table), *fit / longest);
}

class SceneReader {
 public:
  SceneReader(const StrictTable& recipe, fs::path folder, std::uint32_t seed)
      : recipe_(recipe), folder_(std::move(folder)), seed_(seed) {}

  Scene Read() {
    if (recipe_.OneOf("builtin", {"room"})) scene_ = Room(seed_);
    if (const toml::table* table = recipe_.Table("lighting")) ReadLighting(*table);
    if (const toml::array* textures = recipe_.Tables("texture")) {
      for (const toml::node& node : *textures) ReadNamedTexture(*node.as_table());
    }
    if (const toml::array* surfaces = recipe_.Tables("surface")) {
      for (std::size_t i = 0; i < surfaces->size(); ++i) {
        ReadSurface(*surfaces->get(i)->as_table(), fmt::format("surface {}", i + 1));
      }
    }
    if (scene_.surfaces.empty()) {
      throw recipe_.Wrong("", "the recipe has no surface", "add a [[surface]]");
    }
    return std::move(scene_);
  }

 private:
  void ReadLighting(const toml::table& node) {
    const StrictTable table(node, recipe_.file(), "[lighting]",
                            {"lamp", "lamp_strength", "ambient", "background"});
    Lighting& light = scene_.lighting;
    light.lamp = table.Vector("lamp").value_or(light.lamp);
    constexpr double kBrightest = 1e8;
    const auto strength = [&](const char* key, float otherwise) {
      const std::optional<double> value = table.Within(key, 0, kBrightest);
      return value ? static_cast<float>(*value) : otherwise;
    };
    light.lamp_strength = strength("lamp_strength", light.lamp_strength);
    light.ambient = strength("ambient", light.ambient);
    scene_.background = Color(table, "background", scene_.background, kBrightest);
  }

  AnyTexture ReadTexture(const StrictTable& table) {
    ++num_textures_;
    const std::string pattern = table.Need(table.OneOf("pattern", kPatterns), "pattern");
    if (pattern == "image") return ReadPicture(table);
    if (table.Has("file")) {
      throw table.Wrong("file", "only the pattern \"image\" has a file", "leave it out");
    }
    Texture texture;
    const auto index = std::find(kPatterns.begin(), kPatterns.end(), pattern) - kPatterns.begin();
    texture.pattern = static_cast<Texture::Pattern>(index);
    // Each texture has noise of its own.
    const int own = table.Whole("seed", 0, 1000000).value_or(num_textures_);
    texture.seed = seed_ * 1000 + static_cast<std::uint32_t>(own);
    texture.scale = table.Length("scale").value_or(texture.scale);
    texture.octaves = table.Whole("octaves", 1, 16).value_or(8);
    texture.dark = Color(table, "dark", texture.dark, 1);
    texture.light = Color(table, "light", texture.light, 1);
    texture.accent = Color(table, "accent", texture.accent, 1);
    texture.frequency = table.Length("frequency").value_or(texture.frequency);
    texture.direction = table.Vector("direction").value_or(texture.direction);
    if (texture.direction.isZero(0)) {
      throw table.Wrong("direction", "the direction is 0", "give the grating a direction");
    }
    return texture;
  }

  ImageTexture ReadPicture(const StrictTable& table) {
    const fs::path path = FileOf(table, folder_);
    auto known = pictures_.find(path.string());
    if (known == pictures_.end()) {
      ImageTexture picture = ReadFor(table, [&] { return ReadImageTexture(path); });
      known = pictures_.emplace(path.string(), std::move(picture)).first;
    }
    ImageTexture texture = known->second;
    texture.repeat = table.Truth("repeat").value_or(texture.repeat);
    return texture;
  }

  void ReadNamedTexture(const toml::table& node) {
    const StrictTable table(node, recipe_.file(), "[[texture]]", kTextureKeys);
    const std::string name = table.Need(table.Text("name"), "name");
    if (!textures_.emplace(name, ReadTexture(table)).second) {
      throw table.Wrong("name", fmt::format("two textures are called \"{}\"", name),
                        "rename one of them");
    }
  }

  AnyTexture TextureOf(const StrictTable& surface, const toml::table& node) {
    if (!surface.Has("texture")) {
      throw surface.Wrong("", surface.name() + " has no texture",
                          "give the name of a [[texture]], or a table [surface.texture]");
    }
    if (node.get("texture")->is_table()) {
      return ReadTexture(StrictTable(*surface.Table("texture"), recipe_.file(),
                                     surface.name() + "'s texture", kTextureKeys));
    }
    const std::string name = *surface.Text("texture");
    const auto known = textures_.find(name);
    if (known != textures_.end()) return known->second;
    std::vector<std::string> names;
    for (const auto& [known_name, texture] : textures_) names.push_back(known_name);
    throw surface.Wrong("texture", fmt::format("no [[texture]] is called \"{}\"", name),
                        names.empty()
                            ? std::string("add one with that name")
                            : fmt::format("did you mean \"{}\"?", NearestName(name, names)));
  }

  std::vector<Shape> ReadShapes(const StrictTable& table, const std::string& shape) {
    if (shape == "sphere") {
      return {Sphere{table.Need(table.Vector("centre"), "centre"),
                     table.Need(table.Length("radius"), "radius")}};
    }
    if (shape == "rectangle") return {ReadRectangle(table)};
    if (shape == "box") return ReadBox(table);
    if (shape == "cylinder") return {ReadCylinder(table)};
    if (shape == "torus") return {ReadTorus(table)};
    if (shape == "waves") return {ReadWaves(table)};
    return {ReadMeshShape(table, folder_)};
  }

  void ReadSurface(const toml::table& node, const std::string& name) {
    const std::string shape = ShapeOf(node, name);
    std::vector<std::string> keys = {"shape",          "texture", "gloss",
                                     "gloss_exponent", "count",   "step"};
    const std::vector<std::string>& own = ShapeKeys().at(shape);
    keys.insert(keys.end(), own.begin(), own.end());
    const StrictTable table(node, recipe_.file(), fmt::format("{} ({})", name, shape), keys);
    const AnyTexture texture = TextureOf(table, node);
    Gloss gloss;
    gloss.strength = table.Within("gloss", 0, 1e6).value_or(gloss.strength);
    gloss.exponent = table.Within("gloss_exponent", 1, 1e5).value_or(gloss.exponent);
    const int count = table.Whole("count", 1, 100000).value_or(1);
    const Vector3d step = table.Vector("step").value_or(Vector3d::Zero());
    if (count > 1 && step.isZero(0)) {
      throw table.Wrong("count", "copies at one place",
                        "add step = [x, y, z], from one to the next");
    }
    const std::vector<Shape> shapes = ReadShapes(table, shape);
    for (int i = 0; i < count; ++i) {
      AnyTexture copy = texture;
      // The texture moves with its surface: copies would be told apart by nothing.
      if (auto* noise = std::get_if<Texture>(&copy)) {
        noise->seed += 7919 * static_cast<std::uint32_t>(i);
      }
      for (const Shape& s : shapes) {
        scene_.surfaces.push_back({i == 0 ? s : Moved(s, i * step), copy, gloss});
      }
    }
  }

  std::string ShapeOf(const toml::table& node, const std::string& name) const {
    std::vector<std::string> any;
    for (const auto& [key, value] : node) any.emplace_back(key.str());
    const StrictTable table(node, recipe_.file(), name, any);
    return table.Need(table.OneOf("shape", ShapeNames()), "shape");
  }

  const StrictTable& recipe_;
  fs::path folder_;
  std::uint32_t seed_;
  int num_textures_ = 0;
  std::map<std::string, AnyTexture> textures_;
  std::map<std::string, ImageTexture> pictures_;
  Scene scene_;
};

}  // namespace

const std::vector<std::string>& RecipeSceneKeys() {
  static const std::vector<std::string> keys = {"builtin", "lighting", "texture", "surface"};
  return keys;
}

Scene ReadRecipeScene(const StrictTable& recipe, const fs::path& folder, std::uint32_t seed) {
  return SceneReader(recipe, folder, seed).Read();
}

}  // namespace lamella
