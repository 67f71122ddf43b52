#include "pipeline/synth_scene.h"

#include <vector>

#include <fmt/format.h>

#include "datasets_synthetic/photograph.h"
#include "datasets_synthetic/room.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/capture/transforms_json.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// A moderate telephoto, as a photographer would take: 51 degrees across.
constexpr double kFocalPerWidth = 1.05;

Camera CameraOf(const SynthSceneOptions& options) {
  Camera camera;
  camera.width = options.width_px;
  camera.height = (options.width_px * 3 + 2) / 4;
  camera.fx = camera.fy = kFocalPerWidth * camera.width;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  return camera;
}

Image<Rgb8> Encoded(const Image<Rgb>& linear) {
  Image<Rgb8> codes(linear.width(), linear.height());
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const Rgb& c = linear.data()[i];
    codes.data()[i] = {LinearToSrgb8(c.r), LinearToSrgb8(c.g), LinearToSrgb8(c.b)};
  }
  return codes;
}

}  // namespace

OptionTable Describe(SynthSceneOptions& options) {
  return {
      "synth",
      {{"views", "number of photographs", &options.views, 1, 1000, {}, "--views"},
       {"width_px", "width of the photographs, px", &options.width_px, 16, 16384, {}, "--width-px"},
       {"seed",
        "of textures and of the camera's unsteadiness",
        &options.seed,
        0,
        1e9,
        {},
        "--seed"},
       {"supersampling",
        "rays per pixel and axis where surfaces meet",
        &options.supersampling,
        1,
        32,
        {},
        "--supersampling"},
       {"jpeg_quality",
        "of the photographs",
        &options.jpeg_quality,
        1,
        100,
        {},
        "--jpeg-quality"}}};
}

void SynthScene(const SynthSceneOptions& options, const fs::path& out, Progress& progress) {
  const std::vector<std::string> known = {"room"};
  if (options.name != "room") {
    throw UsageError("", fmt::format("there is no scene \"{}\"", options.name),
                     fmt::format("use {}", NearestName(options.name, known)));
  }
  const auto seed = static_cast<std::uint32_t>(options.seed);
  const SceneSource scene(Room(seed));
  const Camera camera = CameraOf(options);
  const std::vector<Rigid> poses = CamerasOnArc(ArcBeforeRoom(), options.views, seed);

  CreateFolder(out / "images");
  CreateFolder(out / "depth");
  progress.Start("photographs", options.views, "views");
  TransformsJson transforms;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string name = fmt::format("view_{:03}", i + 1);
    const fs::path file = out / "images" / (name + ".jpg");
    Photograph photograph = TakePhotograph(scene, camera, poses[i], options.supersampling);
    WriteCodes8(file, Encoded(photograph.color).span(), options.jpeg_quality);
    std::vector<Channel> channels;
    channels.push_back({"Z", std::move(photograph.depth)});
    WriteExr(out / "depth" / (name + ".exr"), channels, ExrType::kFloat);
    View view;
    view.name = name;
    view.image = file;
    view.camera = camera;
    view.camera_from_world = poses[i];
    transforms.views.push_back(std::move(view));
    progress.Advance();
  }
  WriteTransformsJson(out / "transforms.json", transforms);
}

}  // namespace lamella
