// Captures as files: a recipe of a user's own, what lies beside the photographs, and calls that
// follow each other.
#include "pipeline/synth_scene.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/atomic_file.h"
#include "lightfield/image_io.h"
#include "pipeline/capture/transforms_json.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

// A square of side 2 about the origin that faces the viewer, as a mesh with texture coordinates,
// and a picture: red, green / blue, white.
fs::path WriteRecipe(const fs::path& folder, const std::string& more = {}) {
  std::ofstream(folder / "square.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nproperty float u\nproperty float v\nelement face 2\n"
         "property list uchar int vertex_indices\nend_header\n"
         "-1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n-1 1 0 0 1\n3 0 1 2\n3 0 2 3\n";
  Image<Rgb> picture(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      picture(x, y) =
          y < 32 ? (x < 32 ? Rgb{1, 0, 0} : Rgb{0, 1, 0}) : (x < 32 ? Rgb{0, 0, 1} : Rgb{1, 1, 1});
    }
  }
  WriteSrgb8(folder / "picture.png", picture.span());
  std::ofstream(folder / "mine.toml") << R"(
[lighting]
lamp_strength = 0
ambient = 1
[cameras]
layout = "arc"
views = 3
angle_deg = 20
distance = 2
height = 0
width_px = 64
height_px = 64
focal_per_width = 0.75
[photographs]
format = "png"
[[surface]]
shape = "mesh"
file = "square.ply"
texture = { pattern = "image", file = "picture.png" }
)" << more;
  return folder / "mine.toml";
}

TEST(SynthScene, TakesAUsersMeshWithAPicture) {
  const fs::path scratch = ScratchFolder(), out = scratch / "out";
  EXPECT_EQ(SynthScene(ReadRecipe(WriteRecipe(scratch)), out, SilentProgress()), 3);

  // The square covers 48 of the 64 pixels, upright and not mirrored.
  const Image<Rgb8> image = ReadSrgb8(out / "images" / "view_002.png");
  EXPECT_EQ(image(20, 20), (Rgb8{255, 0, 0}));
  EXPECT_EQ(image(44, 20), (Rgb8{0, 255, 0}));
  EXPECT_EQ(image(20, 44), (Rgb8{0, 0, 255}));
  EXPECT_EQ(image(44, 44), (Rgb8{255, 255, 255}));
  EXPECT_EQ(image(2, 32), (Rgb8{0, 0, 0}));
  std::vector<Channel> channels = ReadExr(out / "depth" / "view_002.exr");
  const Image<float> depth = TakeChannel(channels, "Z", "depth");
  const Image<Rgb8> mask = ReadSrgb8(out / "masks" / "view_002.png");
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool on_square = x >= 8 && x < 56 && y >= 8 && y < 56;
      EXPECT_EQ(mask(x, y).g, on_square ? 255 : 0);
      if (on_square) {
        EXPECT_NEAR(static_cast<double>(depth(x, y)), 2, 2e-6);
      } else {
        EXPECT_TRUE(std::isinf(depth(x, y)));
      }
    }
  }
  const TransformsJson transforms = ReadTransformsJson(out / "transforms.json");
  ASSERT_EQ(transforms.views.size(), 3U);
  EXPECT_NEAR((Centre(transforms.views[1].camera_from_world) - Eigen::Vector3d(0, 0, 2)).norm(), 0,
              1e-12);
  EXPECT_EQ(transforms.views[1].image, out / "images" / "view_002.png");
}

// recipe.toml names the mesh and the picture wherever it is read, and gives the same bytes.
TEST(SynthScene, IsMadeAgainFromTheRecipeBesideIt) {
  const fs::path scratch = ScratchFolder();
  const fs::path mine =
      WriteRecipe(scratch, "[degradation]\nfull_well_e = 900\nexposure_ev = 0.2\nk1 = -0.1\n");
  SynthScene(ReadRecipe(mine), scratch / "a", SilentProgress());
  SynthScene(ReadRecipe(scratch / "a" / "recipe.toml"), scratch / "b", SilentProgress());
  for (const char* file : {"images/view_003.png", "depth/view_003.exr", "masks/view_001.png",
                           "transforms.json", "recipe.toml", "degradation.json"}) {
    EXPECT_EQ(ReadText(scratch / "a" / file), ReadText(scratch / "b" / file)) << file;
  }
}

TEST(SynthScene, WritesTheLensToTheCameras) {
  const fs::path scratch = ScratchFolder();
  const fs::path mine = WriteRecipe(scratch, "[degradation]\nk1 = -0.1\nk2 = 0.02\np1 = 0.001\n");
  SynthScene(ReadRecipe(mine), scratch / "out", SilentProgress());
  const Camera camera = ReadTransformsJson(scratch / "out").views[0].camera;
  EXPECT_EQ(camera.model, CameraModel::kBrown);
  EXPECT_EQ(camera.distortion, (std::array<double, 8>{-0.1, 0.02, 0.001}));
}

TEST(SynthScene, RemovesWhatAnEarlierCallLeftAndNothingElse) {
  const fs::path scratch = ScratchFolder(), out = scratch / "out";
  const fs::path mine = WriteRecipe(scratch);
  SynthScene(ReadRecipe(mine), out, SilentProgress());
  std::ofstream(out / "images" / "notes.txt") << "mine";
  Recipe fewer = ReadRecipe(mine);
  fewer.layout.views = 2;
  fewer.photographs.format = "exr";
  SynthScene(std::move(fewer), out, SilentProgress());
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(out / "images")) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("view_001.exr", "view_002.exr", "notes.txt"));
  EXPECT_FALSE(fs::exists(out / "masks" / "view_003.png"));
}

TEST(SynthScene, DroppedAndRepeatedViewsAreMissingAndTwice) {
  const fs::path scratch = ScratchFolder(), out = scratch / "out";
  Recipe recipe = ReadRecipe(WriteRecipe(scratch));
  recipe.layout.views = 6;
  recipe.degradation.dropped_views = 2;
  recipe.degradation.duplicated_views = 1;
  EXPECT_EQ(SynthScene(std::move(recipe), out, SilentProgress()), 5);
  const std::vector<View> views = ReadTransformsJson(out).views;
  ASSERT_EQ(views.size(), 5U);
  int again = 0;
  for (const View& view : views) again += view.name.ends_with("_again") ? 1 : 0;
  EXPECT_EQ(again, 1);
}

TEST(SynthScene, AGridIsRecordedAsOne) {
  const fs::path scratch = ScratchFolder(), out = scratch / "out";
  Recipe recipe = ReadRecipe(WriteRecipe(scratch));
  recipe.layout.layout = "grid";
  recipe.layout.views = 4;
  SynthScene(std::move(recipe), out, SilentProgress());
  EXPECT_TRUE(FindRegularGrid(ReadTransformsJson(out).views));
}

// Without background there is no mask.
TEST(SynthScene, MasksOnlyWhatEnds) {
  const fs::path scratch = ScratchFolder(), out = scratch / "out";
  Recipe recipe = ReadRecipe(WriteRecipe(scratch));
  recipe.layout.distance = 0.9;
  recipe.layout.angle_deg = 0;
  SynthScene(std::move(recipe), out, SilentProgress());
  EXPECT_FALSE(fs::exists(out / "masks"));
}

}  // namespace
}  // namespace lamella
