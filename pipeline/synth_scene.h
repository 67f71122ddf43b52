// A generated capture: photographs of a named scene, with exact poses and depth beside them.
#pragma once

#include <filesystem>
#include <string>

#include "lightfield/options.h"
#include "lightfield/progress.h"

namespace lamella {

struct SynthSceneOptions {
  std::string name = "room";
  int views = 14;
  int width_px = 960;     // of the photographs; their height is 3/4 of it
  int seed = 1;           // of textures and of the camera's unsteadiness
  int supersampling = 4;  // rays per pixel and axis where surfaces meet
  int jpeg_quality = 95;
};
OptionTable Describe(SynthSceneOptions& options);

// Writes into `out`:
//   images/NAME.jpg    the photographs, without EXIF
//   depth/NAME.exr     channel Z: depth along the optical axis, exact; +inf where there is no
//   surface transforms.json    exact cameras and poses (nerfstudio form)
// A file's bytes depend on the options alone. UsageError where the scene is unknown.
void SynthScene(const SynthSceneOptions& options, const std::filesystem::path& out,
                Progress& progress);

}  // namespace lamella
