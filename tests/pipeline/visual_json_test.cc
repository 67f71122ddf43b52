// Calibrations of Looking Glass displays. Two devices' own files are read where LAMELLA_DATA names
// the folder of test data; the same forms are written here with numbers of no device.
#include "pipeline/visual_json.h"

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lightfield/error.h"
#include "tests/reference/weave_reference.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

Json Wrapped(double value) { return {{"value", value}}; }

Json FirstVersion() {
  return {
      {"configVersion", "1.0"},   {"serial", "LKG-X-1"},       {"pitch", Wrapped(50.5)},
      {"slope", Wrapped(-7.25)},  {"center", Wrapped(0.375)},  {"fringe", Wrapped(0.125)},
      {"viewCone", Wrapped(40)},  {"invView", {{"value", 1}}}, {"verticalAngle", {{"value", 2}}},
      {"DPI", Wrapped(300)},      {"screenW", Wrapped(1200)},  {"screenH", {{"value", 1600}}},
      {"flipImageX", Wrapped(0)}, {"flipImageY", Wrapped(0)},  {"flipSubp", Wrapped(0)}};
}

Json ThirdVersion() {
  Json file = FirstVersion();
  file["configVersion"] = "3.0";
  file["invView"] = Wrapped(0);
  file["CellPatternMode"] = Wrapped(4);
  file["subpixelCells"] = Json::array();
  for (const double sign : {1.0, -1.0}) {
    file["subpixelCells"].push_back({{"ROffsetX", -0.3},
                                     {"ROffsetY", 0.2 * sign},
                                     {"GOffsetX", 0.25},
                                     {"GOffsetY", 0.1 * sign},
                                     {"BOffsetX", 0.05},
                                     {"BOffsetY", -0.4 * sign}});
  }
  return file;
}

VisualJson Read(const Json& json) {
  const fs::path path = ScratchFolder() / "visual.json";
  std::ofstream(path) << json.dump(1);
  return ReadVisualJson(path);
}

std::string ErrorOf(const Json& json) {
  try {
    Read(json);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    const std::string what = error.what();
    EXPECT_EQ(what.find('\n'), std::string::npos);
    EXPECT_NE(what.find("visual.json"), std::string::npos) << what;
    return what.substr(what.find("visual.json"));
  }
  return "no error";
}

TEST(VisualJson, OfTheFirstVersionIsRead) {
  const VisualJson visual = Read(FirstVersion());
  EXPECT_EQ(visual.version, "1.0");
  EXPECT_EQ(visual.serial, "LKG-X-1");
  EXPECT_EQ(visual.panel.pitch_per_in, 50.5);
  EXPECT_EQ(visual.panel.slope, -7.25);
  EXPECT_EQ(visual.panel.center, 0.375);
  EXPECT_EQ(visual.panel.dpi, 300);
  EXPECT_EQ(visual.panel.width_px, 1200);
  EXPECT_EQ(visual.panel.height_px, 1600);
  EXPECT_FALSE(visual.panel.flip_x || visual.panel.flip_y || visual.panel.flip_subpixels);
  EXPECT_TRUE(visual.panel.cells.empty());
  EXPECT_TRUE(visual.invert_views && visual.panel.invert_views);
  EXPECT_EQ(visual.view_cone_deg, 40);
  EXPECT_EQ(visual.vertical_deg, 2);
  EXPECT_EQ(visual.fringe, 0.125);
}

TEST(VisualJson, OfTheThirdVersionHasCellsAndAlwaysInvertsViews) {
  const VisualJson visual = Read(ThirdVersion());
  EXPECT_EQ(visual.version, "3.0");
  EXPECT_EQ(visual.panel.cell_pattern, 4);
  ASSERT_EQ(visual.panel.cells.size(), 2U);
  const LookingGlass::Cell expected{{{-0.3, -0.2}, {0.25, -0.1}, {0.05, 0.4}}};
  EXPECT_EQ(visual.panel.cells[1], expected);
  EXPECT_FALSE(visual.invert_views);
  EXPECT_TRUE(visual.panel.invert_views);
}

TEST(VisualJson, FlipsAreReadOneByOne) {
  for (const char* key : {"flipImageX", "flipImageY", "flipSubp", "invView"}) {
    SCOPED_TRACE(key);
    Json file = FirstVersion();
    file["invView"] = 1;
    const bool inverts = std::string(key) != "invView";
    file[key] = inverts ? 1 : 0;  // bare, too
    const LookingGlass panel = Read(file).panel;
    EXPECT_EQ(panel.flip_x, std::string(key) == "flipImageX");
    EXPECT_EQ(panel.flip_y, std::string(key) == "flipImageY");
    EXPECT_EQ(panel.flip_subpixels, std::string(key) == "flipSubp");
    EXPECT_EQ(panel.invert_views, inverts);
  }
}

TEST(VisualJson, MayBeBareMayLackWhatOldFilesLackAndMayHoldMore) {
  Json file = FirstVersion();
  for (auto& [key, value] : file.items()) {
    if (value.is_object()) value = value.at("value");
  }
  for (const char* key :
       {"fringe", "invView", "verticalAngle", "flipImageX", "flipImageY", "flipSubp"}) {
    file.erase(key);
  }
  file["rawLabel"] = {{"anything", nullptr}};
  file["cellPatternMode"] = 3;
  const VisualJson visual = Read(file);
  EXPECT_EQ(visual.panel.pitch_per_in, 50.5);
  EXPECT_EQ(visual.panel.cell_pattern, 3);
  EXPECT_TRUE(visual.panel.invert_views);
  EXPECT_FALSE(visual.panel.flip_x || visual.panel.flip_y || visual.panel.flip_subpixels);
  EXPECT_EQ(visual.fringe, 0);
}

TEST(VisualJson, IsWrittenAsItWasRead) {
  const VisualJson visual = Read(ThirdVersion());
  const fs::path path = ScratchFolder() / "visual.json";
  WriteVisualJson(path, visual);
  const VisualJson again = ReadVisualJson(path);
  for (int row = 0; row < 4; ++row) {
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_EQ(LookingGlassView(again.panel, 17 * row, row, channel),
                LookingGlassView(visual.panel, 17 * row, row, channel));
    }
  }
  EXPECT_EQ(again.serial, visual.serial);
  EXPECT_EQ(again.view_cone_deg, visual.view_cone_deg);
  EXPECT_EQ(again.invert_views, visual.invert_views);
}

TEST(VisualJson, MistakesNameFileAndField) {
  const auto with = [](const char* key, const Json& value) {
    Json file = ThirdVersion();
    file[key] = value;
    return ErrorOf(file);
  };
  const auto without = [](const char* key) {
    Json file = ThirdVersion();
    file.erase(key);
    return ErrorOf(file);
  };
  EXPECT_EQ(with("pitch", Wrapped(0)),
            "visual.json: \"pitch\" is not a number above 0; mend the file");
  EXPECT_EQ(with("pitch", {{"value", "50"}}),
            "visual.json: pitch: \"value\" is not a finite number; mend the file");
  EXPECT_EQ(with("pitch", Json::object()),
            "visual.json: pitch: \"value\" is missing: there should be a number; mend the file");
  EXPECT_EQ(with("slope", 0), "visual.json: \"slope\" is not a number other than 0; mend the file");
  EXPECT_EQ(with("DPI", -1), "visual.json: \"DPI\" is not a number above 0; mend the file");
  EXPECT_EQ(with("screenW", 10.5),
            "visual.json: \"screenW\" is not a whole number from 1 to 32768; mend the file");
  EXPECT_EQ(with("screenH", 1e9),
            "visual.json: \"screenH\" is not a whole number from 1 to 32768; mend the file");
  EXPECT_EQ(with("viewCone", 180),
            "visual.json: \"viewCone\" is not an angle between 0 and 180 degrees; mend the file");
  EXPECT_EQ(with("CellPatternMode", 5),
            "visual.json: \"CellPatternMode\" is not a whole number from 0 to 4; mend the file");
  EXPECT_EQ(with("configVersion", "4.0"),
            "visual.json: \"configVersion\" is 4.0, newer than 3.0; use a newer lamella");
  EXPECT_EQ(with("configVersion", "new"),
            "visual.json: \"configVersion\" is not a version like \"3.0\"; mend the file");
  EXPECT_EQ(with("subpixelCells", Json::array({Json::object()})),
            "visual.json: subpixelCells[0]: \"ROffsetX\" is missing: there should be a number; "
            "mend the file");
  Json many = ThirdVersion();
  for (int i = 0; i < 9; ++i) many["subpixelCells"].push_back(many["subpixelCells"][0]);
  EXPECT_EQ(ErrorOf(many),
            "visual.json: \"subpixelCells\" is not a list of at most 10 cells; mend the file");
  for (const char* key : {"configVersion", "serial", "pitch", "slope", "center", "DPI", "screenW",
                          "screenH", "viewCone"}) {
    EXPECT_NE(without(key).find(std::string("\"") + key + "\" is missing"), std::string::npos)
        << without(key);
  }
}

fs::path RealFolder() {
  const char* place = std::getenv("LAMELLA_DATA");
  return place == nullptr || *place == '\0' ? fs::path() : fs::path(place) / "formats/lookingglass";
}

// Every sub-pixel of a panel against geometry in long double.
void ExpectEveryViewOfReference(const LookingGlass& c, int views) {
  const LookingGlassWeave weave = WeaveOf(c);
  int wrong = 0;
  for (int row = 0; row < c.height_px; ++row) {
    for (int column = 0; column < c.width_px; ++column) {
      for (int channel = 0; channel < 3; ++channel) {
        const int index = ViewIndex(LookingGlassView(c, weave, column, row, channel), views);
        const long double view = ReferenceView(c, column, c.height_px - 1 - row, channel);
        wrong += IsViewOfReference(view, index, views) ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(VisualJson, OfAPortraitIsReadInEveryField) {
  if (RealFolder().empty()) GTEST_SKIP() << "LAMELLA_DATA is not set";
  const VisualJson visual = ReadVisualJson(RealFolder() / "visual_LKG-PORT-05935.json");
  EXPECT_EQ(visual.version, "1.0");
  EXPECT_EQ(visual.serial, "LKG-PORT-05935");
  EXPECT_EQ(visual.panel.pitch_per_in, 52.56046553048362);
  EXPECT_EQ(visual.panel.slope, -7.1423088016812);
  EXPECT_EQ(visual.panel.center, 0.47345216539737284);
  EXPECT_EQ(visual.fringe, 0);
  EXPECT_EQ(visual.view_cone_deg, 40);
  EXPECT_TRUE(visual.invert_views);
  EXPECT_TRUE(visual.panel.invert_views);
  EXPECT_EQ(visual.vertical_deg, 0);
  EXPECT_EQ(visual.panel.dpi, 324);
  EXPECT_EQ(visual.panel.width_px, 1536);
  EXPECT_EQ(visual.panel.height_px, 2048);
  EXPECT_FALSE(visual.panel.flip_x);
  EXPECT_FALSE(visual.panel.flip_y);
  EXPECT_FALSE(visual.panel.flip_subpixels);
  EXPECT_EQ(visual.panel.cell_pattern, 0);
  EXPECT_TRUE(visual.panel.cells.empty());
  ExpectEveryViewOfReference(visual.panel, 48);
}

TEST(VisualJson, OfALandscapeDisplayWithCellsIsReadInEveryField) {
  if (RealFolder().empty()) GTEST_SKIP() << "LAMELLA_DATA is not set";
  const VisualJson visual = ReadVisualJson(RealFolder() / "visual_LKG-J00133.json");
  EXPECT_EQ(visual.version, "3.0");
  EXPECT_EQ(visual.serial, "LKG-J00133");
  EXPECT_EQ(visual.panel.pitch_per_in, 44.74761962890625);
  EXPECT_EQ(visual.panel.slope, -6.855094909667969);
  EXPECT_EQ(visual.panel.center, -0.26516956090927126);
  EXPECT_EQ(visual.fringe, 0);
  EXPECT_EQ(visual.view_cone_deg, 50);
  EXPECT_FALSE(visual.invert_views);
  EXPECT_TRUE(visual.panel.invert_views);
  EXPECT_EQ(visual.vertical_deg, 0);
  EXPECT_EQ(visual.panel.dpi, 283);
  EXPECT_EQ(visual.panel.width_px, 3840);
  EXPECT_EQ(visual.panel.height_px, 2160);
  EXPECT_FALSE(visual.panel.flip_x);
  EXPECT_FALSE(visual.panel.flip_y);
  EXPECT_FALSE(visual.panel.flip_subpixels);
  EXPECT_EQ(visual.panel.cell_pattern, 2);
  constexpr double kRedX = -0.3100000023841858, kGreenX = 0.2800000011920929;
  ASSERT_EQ(visual.panel.cells.size(), 2U);
  EXPECT_EQ(visual.panel.cells[0],
            (LookingGlass::Cell{{{kRedX, 0.25}, {kGreenX, 0.25}, {0, -0.25}}}));
  EXPECT_EQ(visual.panel.cells[1],
            (LookingGlass::Cell{{{kRedX, -0.25}, {kGreenX, -0.25}, {0, 0.25}}}));
  ExpectEveryViewOfReference(visual.panel, 49);
}

}  // namespace
}  // namespace lamella
