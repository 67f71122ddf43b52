#include "pipeline/synth_scene.h"

#include <algorithm>
#include <cmath>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets_synthetic/photograph.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/capture/transforms_json.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Value = nlohmann::json;

void WritePhotograph(const fs::path& file, const Recipe& recipe, const Image<Rgb>& linear) {
  if (recipe.photographs.format != "exr") {
    WriteCodes8(file, EncodeSrgb8(linear.span()).span(), recipe.degradation.jpeg_quality);
    return;
  }
  std::vector<Channel> channels;
  for (const auto& [name, colour] : {std::pair{"R", &Rgb::r}, {"G", &Rgb::g}, {"B", &Rgb::b}}) {
    Image<float> pixels(linear.width(), linear.height());
    for (std::size_t i = 0; i < linear.size(); ++i) pixels.data()[i] = linear.data()[i].*colour;
    channels.push_back({name, std::move(pixels)});
  }
  WriteExr(file, channels, ExrType::kFloat);
}

// Where the scene ends; nothing is written where it ends nowhere.
void WriteMask(const fs::path& file, const Image<float>& depth) {
  Image<std::uint8_t> mask(depth.width(), depth.height());
  std::transform(depth.data(), depth.data() + depth.size(), mask.data(), [](float z) {
    return static_cast<std::uint8_t>(std::isfinite(z) && z > 0 ? 255 : 0);
  });
  if (std::all_of(mask.data(), mask.data() + mask.size(), [](auto m) { return m == 255; })) return;
  CreateFolder(file.parent_path());
  WriteGrey8(file, mask.span());
}

Value Drawn(const View& view, const Exposure& exposure) {
  const Shutter& shutter = exposure.shutter;
  const auto numbers = [](const Eigen::Vector3d& v) { return Value{v.x(), v.y(), v.z()}; };
  return {{"name", view.name},
          {"exposure", exposure.exposure},
          {"red", exposure.red},
          {"blue", exposure.blue},
          {"motion", numbers(shutter.motion)},
          {"turn_rad", numbers(shutter.turn)},
          {"aperture", shutter.aperture},
          {"focus_distance", shutter.focus_distance}};
}

// Of an earlier call: files with names that are given here and that this call did not write.
void RemoveStale(const fs::path& out, const std::set<fs::path>& written) {
  static const std::regex ours(R"(view_\d{3,}(_again)?\.(jpg|png|exr))");
  for (const char* folder : {"images", "depth", "masks"}) {
    std::error_code error;
    std::vector<fs::path> stale;
    for (const auto& entry : fs::directory_iterator(out / folder, error)) {
      const bool is_ours = std::regex_match(entry.path().filename().string(), ours);
      if (is_ours && !written.contains(entry.path())) stale.push_back(entry.path());
    }
    for (const fs::path& file : stale) fs::remove(file, error);
  }
}

}  // namespace

int SynthScene(Recipe recipe, const fs::path& out, Progress& progress) {
  Check(recipe, {});
  const Degradation& degradation = recipe.degradation;
  const std::vector<View> cameras = CamerasOf(recipe.layout, recipe.seed);
  const std::vector<Exposure> exposures = ExposuresOf(degradation, static_cast<int>(cameras.size()),
                                                      recipe.seed, recipe.layout.distance);
  const std::string effective = ToToml(recipe);
  CreateFolder(out / "images");
  CreateFolder(out / "depth");
  progress.Start("photographs", static_cast<std::int64_t>(exposures.size()), "views");
  const SceneSource scene(std::move(recipe.scene));

  TransformsJson transforms;
  Value drawn = Value::array();
  std::set<fs::path> written;
  for (const Exposure& exposure : exposures) {
    View view = cameras[static_cast<std::size_t>(exposure.view)];
    if (exposure.again) view.name += "_again";
    view.camera = Distorted(view.camera, degradation);
    view.image = out / "images" / (view.name + "." + recipe.photographs.format);
    const fs::path depth = out / "depth" / (view.name + ".exr");
    const fs::path mask = out / "masks" / (view.name + ".png");
    Photograph photograph = TakePhotograph(scene, view.camera, view.camera_from_world,
                                           exposure.shutter, recipe.photographs.supersampling);
    Degrade(degradation, exposure, view.camera, photograph.color);
    WritePhotograph(view.image, recipe, photograph.color);
    std::error_code error;
    fs::remove(mask, error);  // an earlier call's
    WriteMask(mask, photograph.depth);
    std::vector<Channel> channels;
    channels.push_back({"Z", std::move(photograph.depth)});
    WriteExr(depth, channels, ExrType::kFloat);
    written.insert({view.image, depth, mask});
    if (view.camera.model == CameraModel::kPinhole) view.depth = depth;
    drawn.push_back(Drawn(view, exposure));
    transforms.views.push_back(std::move(view));
    progress.Advance();
  }
  RemoveStale(out, written);
  WriteTransformsJson(out / "transforms.json", transforms);
  WriteTextAtomically(out / "recipe.toml", effective);
  WriteTextAtomically(out / "degradation.json",
                      Value{{"format_version", 1}, {"views", std::move(drawn)}}.dump(1) + "\n");
  return static_cast<int>(exposures.size());
}

}  // namespace lamella
