// Recipes: what is wrong with one is said with file and line.
#include "datasets_synthetic/recipe.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets_synthetic/photograph.h"
#include "datasets_synthetic/room.h"
#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kBall = R"(
[[surface]]
shape = "sphere"
centre = [0, 0, 0]
radius = 1
texture = { pattern = "plain" }
)";

struct Bad {
  const char* what;
  std::string toml;  // line 1 is the first character's
  std::vector<std::string> words;
  ExitCode code = ExitCode::kUsage;
};

void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.what; }

class BadRecipe : public testing::TestWithParam<Bad> {};

TEST_P(BadRecipe, IsRefusedWithFileAndLine) {
  try {
    ParseRecipe(GetParam().toml, "/nowhere/mine.toml");
    FAIL() << "was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), GetParam().code);
    for (const std::string& word : GetParam().words) EXPECT_THAT(error.what(), HasSubstr(word));
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BadRecipe,
    testing::Values(
        Bad{"broken TOML", "seed = 1\nname = \"x", {"mine.toml:2"}},
        Bad{"unknown key", "seeds = 1" + kBall, {"mine.toml:1", "\"seeds\"", "\"seed\""}},
        Bad{"unknown table", kBall + "[camera]\nviews = 3", {"mine.toml:7", "\"cameras\""}},
        Bad{"unknown key of the cameras",
            kBall + "[cameras]\nveiws = 3",
            {"mine.toml:8", "\"views\""}},
        Bad{"unknown layout", kBall + "[cameras]\nlayout = \"gird\"", {"mine.toml:8", "\"grid\""}},
        Bad{"unknown key of a surface",
            "[[surface]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1",
            {"mine.toml:3", "center", "\"centre\""}},
        Bad{"key of another shape",
            "[[surface]]\nshape = \"box\"\ncentre = [0, 0, 0]\nradius = 1",
            {"mine.toml:4", "box", "radius"}},
        Bad{"unknown shape", "[[surface]]\nshape = \"spere\"", {"mine.toml:2", "\"sphere\""}},
        Bad{"unknown pattern",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\n"
            "[surface.texture]\npattern = \"nois\"",
            {"mine.toml:6", "\"noise\""}},
        Bad{"unknown texture",
            "[[texture]]\nname = \"wood\"\npattern = \"noise\"\n"
            "[[surface]]\nshape = \"sphere\"\ntexture = \"woot\"",
            {"mine.toml:6", "\"wood\""}},
        Bad{"unknown builtin", "builtin = \"rom\"", {"mine.toml:1", "\"room\""}},
        Bad{"negative size",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = -1\n"
            "texture = { pattern = \"plain\" }",
            {"mine.toml:4", "radius = -1", "above 0"}},
        Bad{"flat box",
            "[[surface]]\nshape = \"box\"\ncentre = [0, 0, 0]\nsize = [1, 0, 1]\n"
            "texture = { pattern = \"plain\" }",
            {"mine.toml:4", "above 0"}},
        Bad{"NaN",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, nan, 0]\nradius = 1\n"
            "texture = { pattern = \"plain\" }",
            {"mine.toml:3", "nan", "finite"}},
        Bad{"NaN of an option",
            kBall + "[cameras]\ndistance = nan",
            {"mine.toml:8", "distance", "finite"}},
        Bad{"infinite lamp",
            kBall + "[lighting]\nlamp_strength = inf",
            {"mine.toml:8", "lamp_strength", "finite"}},
        Bad{"zero views", kBall + "[cameras]\nviews = 0", {"mine.toml:8", "views"}},
        Bad{"views that fill no grid",
            kBall + "[cameras]\nlayout = \"grid\"\nviews = 12",
            {"mine.toml:7", "12 views", "9"}},
        Bad{"wrong type", kBall + "[cameras]\nviews = \"many\"", {"mine.toml:8", "a number"}},
        Bad{"two numbers for three",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, 0]\nradius = 1\n"
            "texture = { pattern = \"plain\" }",
            {"mine.toml:3", "three numbers"}},
        Bad{"missing value",
            "[[surface]]\nshape = \"sphere\"\ntexture = { pattern = \"plain\" }",
            {"mine.toml:1", "\"centre\""}},
        Bad{"no texture",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1",
            {"mine.toml:1", "texture"}},
        Bad{"colour beyond white",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\n"
            "texture = { pattern = \"plain\", light = [2, 0, 0] }",
            {"mine.toml:5", "light", "0 to 1"}},
        Bad{"no surface", "seed = 3\n", {"mine.toml:1", "surface"}},
        Bad{"copies at one place", kBall + "count = 3", {"mine.toml:7", "step"}},
        Bad{"read noise without a full well",
            kBall + "[degradation]\nread_noise_e = 3",
            {"mine.toml:7", "full_well_e"}},
        Bad{"all views dropped",
            kBall + "[cameras]\nviews = 3\n[degradation]\ndropped_views = 3",
            {"mine.toml:9", "dropped_views"}},
        Bad{"a lens that folds the picture",
            kBall + "[degradation]\nk1 = -2",
            {"mine.toml:7", "folds"}},
        Bad{"a newer format", "format_version = 9" + kBall, {"mine.toml:1", "version 1"}},
        Bad{"missing mesh",
            "[[surface]]\nshape = \"mesh\"\nfile = \"cow.ply\"\ntexture = { pattern = \"plain\" }",
            {"mine.toml:3", "/nowhere/cow.ply", "relative"},
            ExitCode::kInput},
        Bad{"missing picture",
            "[[surface]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\n"
            "texture = { pattern = \"image\", file = \"a.png\" }",
            {"mine.toml:5", "/nowhere/a.png"},
            ExitCode::kInput}),
    [](const auto& test) {
      std::string name = test.param.what;
      for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
      return name;
    });

TEST(Recipe, ABrokenMeshIsNamedWithTheRecipesLineAndItsOwn) {
  const std::filesystem::path scratch = ScratchFolder();
  std::ofstream(scratch / "cow.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 zero\nf 1 2 3\n";
  std::ofstream(scratch / "mine.toml")
      << "[[surface]]\nshape = \"mesh\"\nfile = \"cow.obj\"\ntexture = { pattern = \"plain\" }\n";
  try {
    ReadRecipe(scratch / "mine.toml");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("mine.toml:3"), HasSubstr("cow.obj:3")));
  }
}

TEST(Recipe, AnUnknownNameOffersTheNearestOne) {
  try {
    FindRecipe("romo");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("\"romo\""), HasSubstr("\"room\""), HasSubstr("slanted-plane")));
  }
  EXPECT_THROW(FindRecipe("nowhere/mine.toml"), Error);
}

class NamedRecipe : public testing::TestWithParam<std::string> {};

TEST_P(NamedRecipe, ReadsAndWritesEveryValue) {
  const Recipe recipe = FindRecipe(GetParam());
  EXPECT_EQ(recipe.name, GetParam());
  EXPECT_FALSE(RecipeDescription(GetParam()).empty());
  EXPECT_GT(recipe.scene.surfaces.size(), 0U);
  const std::string toml = ToToml(recipe);
  const Recipe again = ParseRecipe(toml, "/tmp/recipe.toml");
  EXPECT_EQ(ToToml(again), toml);
  EXPECT_EQ(again.scene.surfaces.size(), recipe.scene.surfaces.size());
  EXPECT_EQ(again.layout.target, recipe.layout.target);
  EXPECT_EQ(again.layout.layout, recipe.layout.layout);
}
INSTANTIATE_TEST_SUITE_P(All, NamedRecipe, testing::ValuesIn(RecipeNames()), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Recipe, TheRoomIsTheBuiltInOneFromItsArc) {
  const Recipe recipe = FindRecipe("room", 5);
  EXPECT_EQ(recipe.seed, 5U);
  const Scene room = Room(5);
  ASSERT_EQ(recipe.scene.surfaces.size(), room.surfaces.size());
  for (std::size_t i = 0; i < room.surfaces.size(); ++i) {
    EXPECT_EQ(std::get<Texture>(recipe.scene.surfaces[i].texture).seed,
              std::get<Texture>(room.surfaces[i].texture).seed);
  }
  EXPECT_EQ(recipe.scene.lighting.lamp, room.lighting.lamp);
  const std::vector<View> views = CamerasOf(recipe.layout, 5);
  const std::vector<Rigid> poses = CamerasOnArc(ArcBeforeRoom(), 14, 5);
  ASSERT_EQ(views.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(views[i].camera_from_world.translation, poses[i].translation);
  }
}

// What the charts are for: known depths, and stripes of known periods in the middle camera.
TEST(Recipe, ChartsStandAtTheirDepthsWithTheirFrequencies) {
  Recipe recipe = FindRecipe("charts");
  recipe.layout.views = 1;
  const View view = CamerasOf(recipe.layout, 1).front();
  const SceneSource scene(std::move(recipe.scene));
  const Photograph photograph = TakePhotograph(scene, view.camera, view.camera_from_world, 1);
  const std::array<double, 4> depths = {3, 3.5, 4.25, 5};
  const std::array<double, 3> periods = {32, 16, 8};
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      // The chart's middle; its left half has upright stripes.
      const int x0 = 480 + 228 * column - 342, y0 = 360 + 228 * (row - 1);
      const auto at = [](auto& list, int i) { return list[static_cast<std::size_t>(i)]; };
      EXPECT_NEAR(static_cast<double>(photograph.depth(x0 - 48, y0)), at(depths, column), 1e-5);
      const double period = at(periods, row), half = std::numbers::pi / period;
      // A pixel is the mean over its width: the contrast is 0.8 sinc(1 / period).
      const double contrast = 0.4 * std::sin(half) / half;
      double sum = 0, along = 0, across = 0;
      for (int x = x0 - 80; x < x0 - 16; ++x) {  // whole periods
        const double value = static_cast<double>(photograph.color(x, y0).g);
        const double phase = 2 * std::numbers::pi * (x + 0.5) / period;
        sum += value / 64;
        along += value * std::cos(phase) / 32;
        across += value * std::sin(phase) / 32;
      }
      // The light falls on the charts head on: 0.5 + 0.5.
      EXPECT_NEAR(sum, 0.5, 0.01) << column << row;
      EXPECT_NEAR(std::hypot(along, across), contrast, 0.01) << column << row;
    }
  }
}

TEST(Recipe, CopiesAreMovedAndHaveNoiseOfTheirOwn) {
  const Recipe recipe = ParseRecipe(kBall + "count = 3\nstep = [2, 0, 1]", "mine.toml");
  ASSERT_EQ(recipe.scene.surfaces.size(), 3U);
  const Surface& last = recipe.scene.surfaces[2];
  EXPECT_EQ(std::get<Sphere>(last.shape).centre, Eigen::Vector3d(4, 0, 2));
  EXPECT_NE(std::get<Texture>(last.texture).seed,
            std::get<Texture>(recipe.scene.surfaces[0].texture).seed);
}

}  // namespace
}  // namespace lamella
