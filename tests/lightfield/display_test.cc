#include "lightfield/display.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Display TwoLayers() {
  Display display{"two", 24, 12, 0.3, 1, 600, true, 4, -4, {}};
  display.layers = {{-10, 5, Barrier{6, 2, 3}, true}, {10, 5, Barrier{6, 2, 3}, false}};
  return display;
}

constexpr const char* kToml = R"(
name = "two"
viewing_distance_mm = 600
border_mm = 4
[panel]
width_px = 24
height_px = 12
pitch_mm = 0.3
[[layer]]
position_mm = -10
d0_mm = 5
mirror_x = true
[layer.barrier]
period_px = 6
aperture_px = 2
slots = 3
[[layer]]
position_mm = 10
gap_mm = 7.5
index = 1.5
[layer.barrier]
period_px = 6
aperture_px = 2
slots = 3
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string Refusal(const std::string& toml) {
  try {
    ParseDisplay(toml, "d.toml");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    EXPECT_THAT(error.what(), HasSubstr("d.toml"));
    return error.what();
  }
  return "accepted";
}

std::string Refusal(const Display& display) {
  try {
    Check(display, "here");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(DisplayToml, ReadsEveryField) { EXPECT_EQ(ParseDisplay(kToml, "d.toml"), TwoLayers()); }

TEST(DisplayToml, ReadsBackWhatItWrote) {
  Display display = TwoLayers();
  display.name = "a \"quoted\" \\ name\nof two lines";
  display.pitch_mm = 0.3113158871666749;
  display.layers[0].position_mm = -1.0 / 3;
  display.shear = false;
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
}

TEST(DisplayToml, TakesAFifthOfTheSpacingAsBorderWhereNoneIsGiven) {
  EXPECT_DOUBLE_EQ(ParseDisplay(Replaced(kToml, "border_mm = 4", ""), "d.toml").border_mm, 4);
  EXPECT_DOUBLE_EQ(
      ParseDisplay(Replaced(kToml, "border_mm", "border_offset_mm"), "d.toml").border_offset_mm, 4);
}

TEST(DisplayToml, OffersTheNearestKeyForAnUnknownOne) {
  EXPECT_THAT(
      Refusal(Replaced(kToml, "border_mm", "boarder_mm")),
      HasSubstr("d.toml:4: the display has no key \"boarder_mm\"; did you mean \"border_mm\""));
  EXPECT_THAT(Refusal(Replaced(kToml, "mirror_x", "mirorx")),
              HasSubstr("did you mean \"mirror_x\""));
  EXPECT_THAT(Refusal(Replaced(kToml, "slots", "slot")), HasSubstr("did you mean \"slots\""));
  EXPECT_THAT(Refusal(Replaced(kToml, "[panel]", "[pannel]")), HasSubstr("did you mean \"panel\""));
}

TEST(DisplayToml, SaysWhichKeyIsMissing) {
  EXPECT_THAT(Refusal(Replaced(kToml, "pitch_mm = 0.3", "")),
              HasSubstr("[panel] has no \"pitch_mm\""));
  EXPECT_THAT(Refusal(Replaced(kToml, "d0_mm = 5", "")), HasSubstr("layer 0 has no \"d0_mm\""));
  EXPECT_THAT(Refusal(Replaced(kToml, "[layer.barrier]", "[other]")),
              HasSubstr("no key \"other\""));
  EXPECT_THAT(Refusal(std::string("name = \"x\"")), HasSubstr("viewing_distance_mm"));
  EXPECT_THAT(Refusal(std::string()), HasSubstr("\"name\""));
}

TEST(DisplayToml, RefusesWrongTypesAndBrokenToml) {
  EXPECT_THAT(Refusal(Replaced(kToml, "pitch_mm = 0.3", "pitch_mm = \"0.3\"")),
              HasSubstr("pitch_mm has the wrong type; give a number"));
  EXPECT_THAT(Refusal(Replaced(kToml, "slots = 3", "slots = 3.5")), HasSubstr("whole number"));
  EXPECT_THAT(Refusal(Replaced(kToml, "mirror_x = true", "mirror_x = 1")),
              HasSubstr("true or false"));
  EXPECT_THAT(Refusal(Replaced(kToml, "[panel]", "[[panel]]")), HasSubstr("a table [panel]"));
  EXPECT_THAT(Refusal(std::string("name = ")), HasSubstr("d.toml:1"));
  EXPECT_THAT(Refusal(Replaced(kToml, "width_px = 24", "width_px = 10000000000")),
              HasSubstr("too large"));
  EXPECT_THAT(Refusal("format_version = 2\n" + std::string(kToml)), HasSubstr("reads version 1"));
  EXPECT_THAT(Refusal(Replaced(kToml, "index = 1.5", "index = 0.5")),
              HasSubstr("refractive index"));
  EXPECT_THAT(Refusal(Replaced(kToml, "d0_mm = 5", "d0_mm = 5\ngap_mm = 5")), HasSubstr("beside"));
}

TEST(DisplayToml, RefusesWhatIsNotFinite) {
  for (const char* value : {"nan", "inf", "-inf"}) {
    EXPECT_THAT(Refusal(Replaced(kToml, "pitch_mm = 0.3", std::string("pitch_mm = ") + value)),
                HasSubstr("pitch_mm"));
    EXPECT_THAT(
        Refusal(Replaced(kToml, "position_mm = -10", std::string("position_mm = ") + value)),
        HasSubstr("position_mm"));
    EXPECT_THAT(Refusal(Replaced(kToml, "border_mm = 4", std::string("border_mm = ") + value)),
                HasSubstr("border_mm"));
  }
}

TEST(ParseDisplay, PutsBordersWhereBarriersAreSharpestUnlessTold) {
  // d0 w_x^2 / (w_x^2 + w_u^2) behind the modulators: 5 mm and 2 emitters give 4 mm, 5 mm and 4
  // emitters 80/17.
  EXPECT_DOUBLE_EQ(ParseDisplay(kToml, "d.toml").border_offset_mm, -4);
  const Display unlike =
      ParseDisplay(Replaced(kToml, "aperture_px = 2", "aperture_px = 4"), "d.toml");
  EXPECT_DOUBLE_EQ(unlike.border_offset_mm, -(4 + 80.0 / 17) / 2);
}

TEST(CheckDisplay, AcceptsSoundDisplays) {
  EXPECT_EQ(Refusal(TwoLayers()), "accepted");
  Display display = TwoLayers();
  display.layers[0].position_mm = 10 - 1e-6;
  display.border_mm = 1e-7;
  EXPECT_EQ(Refusal(display), "accepted");
  display = TwoLayers();
  display.border_mm = 1;
  display.layers.assign(64, display.layers[0]);
  for (std::size_t i = 0; i < 64; ++i) display.layers[i].position_mm = static_cast<double>(i);
  EXPECT_EQ(Refusal(display), "accepted");
  display.layers.resize(1);
  display.layers[0].optics = Barrier{1, 1, 1};
  EXPECT_EQ(Refusal(display), "accepted");
}

struct Bad {
  const char* says;
  void (*spoil)(Display&);
};

class CheckDisplayRefuses : public ::testing::TestWithParam<Bad> {};

TEST_P(CheckDisplayRefuses, WithOneClearLine) {
  Display display = TwoLayers();
  GetParam().spoil(display);
  const std::string refusal = Refusal(display);
  EXPECT_THAT(refusal, HasSubstr(GetParam().says));
  EXPECT_THAT(refusal, Not(HasSubstr("\n")));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    Displays, CheckDisplayRefuses,
    ::testing::Values(
        Bad{"no layer", [](Display& d) { d.layers.clear(); }},
        Bad{"no two at one place", [](Display& d) { d.layers[1].position_mm = -10; }},
        Bad{"rising position_mm", [](Display& d) { d.layers[1].position_mm = -11; }},
        Bad{"gap d0_mm = -5", [](Display& d) { d.layers[0].d0_mm = -5; }},
        Bad{"gap d0_mm = 0", [](Display& d) { d.layers[0].d0_mm = 0; }},
        Bad{"gap d0_mm = nan", [](Display& d) { d.layers[0].d0_mm = kNan; }},
        Bad{"degrees", [](Display& d) { d.layers[0].d0_mm = 1e-6; }},
        Bad{"pitch_mm = 0", [](Display& d) { d.pitch_mm = 0; }},
        Bad{"pitch_mm = -0.3", [](Display& d) { d.pitch_mm = -0.3; }},
        Bad{"slots = 4",
            [](Display& d) {
              d.layers[0].optics = Barrier{6, 2, 4};
            }},
        Bad{"slots = 0",
            [](Display& d) {
              d.layers[0].optics = Barrier{6, 2, 0};
            }},
        Bad{"both even or both odd",
            [](Display& d) {
              d.layers[0].optics = Barrier{6, 1, 3};
            }},
        Bad{"aperture_px = 8",
            [](Display& d) {
              d.layers[0].optics = Barrier{6, 8, 3};
            }},
        Bad{"aperture_px = 0",
            [](Display& d) {
              d.layers[0].optics = Barrier{6, 0, 3};
            }},
        Bad{"period_px = 0",
            [](Display& d) {
              d.layers[0].optics = Barrier{0, 0, 1};
            }},
        Bad{"0 x 12 pixels", [](Display& d) { d.width_px = 0; }},
        Bad{"24 x -1 pixels", [](Display& d) { d.height_px = -1; }},
        Bad{"900000000 emitters", [](Display& d) { d.width_px = d.height_px = 30000; }},
        Bad{"does not divide", [](Display& d) { d.binning_px = 5; }},
        Bad{"does not divide", [](Display& d) { d.binning_px = 0; }},
        Bad{"fits the panel", [](Display& d) { d.width_px = 1; }},
        Bad{"in front of every layer", [](Display& d) { d.viewing_distance_mm = 10; }},
        Bad{"in front of every layer", [](Display& d) { d.viewing_distance_mm = 14; }},
        Bad{"viewing_distance_mm = -600", [](Display& d) { d.viewing_distance_mm = -600; }},
        Bad{"border_offset_mm = nan", [](Display& d) { d.border_offset_mm = NAN; }},
        Bad{"border_mm = -1", [](Display& d) { d.border_mm = -1; }},
        Bad{"border_mm = 21 is wider", [](Display& d) { d.border_mm = 21; }}));

}  // namespace
}  // namespace lamella
