#include "lightfield/display.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Display BarrierAndLenses() {
  Display display{"two", 24, 12, 0.3, 1, 600, true, 4, -4, {}};
  display.layers = {{-10, 5, Barrier{6, 2, 3}, true}, {10, 5, Barrier{6, 2, 3}, false, 1, 1.5}};
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

TEST(DisplayToml, ReadsEveryField) { EXPECT_EQ(ParseDisplay(kToml, "d.toml"), BarrierAndLenses()); }

TEST(DisplayToml, ReadsBackWhatItWrote) {
  Display display = BarrierAndLenses();
  display.name = "a \"quoted\" \\ name\nof two lines";
  display.pitch_mm = 0.3113158871666749;
  display.layers[0].position_mm = -1.0 / 3;
  display.shear = false;
  display.contrast = 1000;
  display.slot_crosstalk = 0.125;
  std::get<Barrier>(display.layers[1].optics).contrast = 300;
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
}

TEST(DisplayToml, ReadsThePlateThatALayerIsSeenThrough) {
  const std::string toml =
      std::string(kToml) + "[layer.plate]\nthickness_mm = 3\nindex = 1.52\nnormal = [1, 0, 1]\n";
  const Display display = ParseDisplay(toml, "d.toml");
  EXPECT_FALSE(display.layers[0].plate);
  EXPECT_EQ(display.layers[1].plate, (GlassPlate{3, 1.52, {1, 0, 1}}));
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
  EXPECT_THAT(Refusal(Replaced(toml, "thickness_mm = 3", "")),
              HasSubstr("layer 1's plate has no \"thickness_mm\""));
  EXPECT_THAT(Refusal(Replaced(toml, "[1, 0, 1]", "[1, 1]")),
              HasSubstr("give three numbers [right, up, to the viewer]"));
  EXPECT_THAT(Refusal(Replaced(toml, "[1, 0, 1]", "[1, 0, 0]")),
              HasSubstr("layer 1: the plate's normal = [1, 0, 0]"));
  EXPECT_THAT(Refusal(Replaced(toml, "1.52", "0.5")), HasSubstr("layer 1: the plate's index"));
}

TEST(DisplayToml, SaysNothingOfPanelsThatDoNotLeak) {
  EXPECT_THAT(ToToml(BarrierAndLenses()), Not(HasSubstr("contrast")));
  EXPECT_THAT(ToToml(BarrierAndLenses()), Not(HasSubstr("crosstalk")));
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
  EXPECT_EQ(Refusal(BarrierAndLenses()), "accepted");
  Display display = BarrierAndLenses();
  display.layers[0].position_mm = 10 - 1e-6;
  display.border_mm = 1e-7;
  EXPECT_EQ(Refusal(display), "accepted");
  display = BarrierAndLenses();
  display.border_mm = 1;
  display.layers.assign(64, display.layers[0]);
  for (std::size_t i = 0; i < 64; ++i) display.layers[i].position_mm = static_cast<double>(i);
  EXPECT_EQ(Refusal(display), "accepted");
  display.layers.resize(1);
  display.layers[0].optics = Barrier{1, 1, 1};
  EXPECT_EQ(Refusal(display), "accepted");
}

constexpr const char* kLenslets = R"(
name = "lenses"
viewing_distance_mm = 500
[panel]
width_px = 100
height_px = 80
pitch_mm = 0.2
[[layer]]
position_mm = -2
d0_mm = 3
[layer.lenslets]
lattice = "hexagonal"
pitch_px = 13.5
rays = 6
offset_px = [1.5, -2]
shift_odd_rows = false
focal_mm = 2.8
[[layer]]
position_mm = 5
d0_mm = 3
magnification = 1.25
[layer.lenticular]
subpixels_per_lens = 4.5
slant = -0.2
views = 9
offset_subpx = 0.25
)";

constexpr const char* kVarifocal = R"(
name = "planes"
viewing_distance_mm = 500
[panel]
width_px = 100
height_px = 80
pitch_mm = 0.2
[varifocal]
planes = 3
depth_mm = 60
spacing = "sinusoidal"
relay_focal_mm = 300
magnification0 = 0.9
[[layer]]
d0_mm = 3
[layer.lenslets]
lattice = "square"
pitch_px = 8
rays = 4
)";

TEST(DisplayToml, ReadsLenses) {
  const Display display = ParseDisplay(kLenslets, "d.toml");
  LensletArray lenslets{LensletArray::Lattice::kHexagonal, 13.5, 6, 1.5, -2, false, 2.8};
  EXPECT_EQ(display.layers.at(0), (Layer{-2, 3, lenslets, false, 1}));
  EXPECT_EQ(display.layers.at(1), (Layer{5, 3, Lenticular{4.5, -0.2, 9, 0.25, 0}, false, 1.25}));
  EXPECT_FALSE(display.varifocal);
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
  lenslets = std::get<LensletArray>(
      ParseDisplay(Replaced(kLenslets, "offset_px = [1.5, -2]", ""), "d.toml").layers[0].optics);
  EXPECT_EQ(lenslets.offset_x_px, 0);
}

TEST(DisplayToml, ReadsVarifocalPlanes) {
  const Display display = ParseDisplay(kVarifocal, "d.toml");
  ASSERT_EQ(display.layers.size(), 3U);
  EXPECT_DOUBLE_EQ(display.layers[0].position_mm, -30);
  EXPECT_DOUBLE_EQ(display.layers[1].position_mm, 0);
  EXPECT_DOUBLE_EQ(display.layers[2].magnification, 1.0);
  EXPECT_DOUBLE_EQ(display.layers[0].magnification, 0.8);
  EXPECT_EQ(ParseDisplay(ToToml(display), "again"), display);
  const Display ideal = ParseDisplay(
      Replaced(kVarifocal, "relay_focal_mm = 300\nmagnification0 = 0.9", ""), "d.toml");
  EXPECT_EQ(ideal.layers[0].magnification, 1);
  EXPECT_EQ(ParseDisplay(ToToml(ideal), "again"), ideal);
}

TEST(DisplayToml, RefusesWrongLensesWithTheLine) {
  EXPECT_THAT(Refusal(Replaced(kLenslets, "pitch_px", "pitch")),
              HasSubstr("d.toml:13: layer 0's lenslets has no key \"pitch\"; did you mean "
                        "\"pitch_px\"?"));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "\"hexagonal\"", "\"hexagon\"")),
              HasSubstr("d.toml:12: lattice = \"hexagon\" is not known; did you mean "
                        "\"hexagonal\"?"));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "[1.5, -2]", "[1.5]")),
              HasSubstr("d.toml:15: offset_px has the wrong type; give two numbers"));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "[1.5, -2]", "[1.5, \"a\"]")), HasSubstr("d.toml:15"));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "rays = 6", "")), HasSubstr("has no \"rays\""));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "rays = 6", "rays = 6.5")), HasSubstr("whole number"));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "views", "view")), HasSubstr("did you mean \"views\""));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "[layer.lenslets]", "[layer.lenses]")),
              HasSubstr("did you mean \"lenslets\""));
  EXPECT_THAT(Refusal(Replaced(kLenslets, "[layer.lenslets]",
                               "[layer.barrier]\nperiod_px = 6\naperture_px = 2\nslots = 3\n"
                               "[layer.lenslets]")),
              HasSubstr("layer 0 has [layer.lenslets] beside [layer.barrier]"));
  for (const char* value : {"nan", "inf", "-1", "0", "1e9"}) {
    EXPECT_THAT(Refusal(Replaced(kLenslets, "pitch_px = 13.5", std::string("pitch_px = ") + value)),
                HasSubstr("layer 0: pitch_px"));
  }
  for (const char* value : {"nan", "inf", "-2.8"}) {
    EXPECT_THAT(Refusal(Replaced(kLenslets, "focal_mm = 2.8", std::string("focal_mm = ") + value)),
                HasSubstr("layer 0: focal_mm"));
  }
}

TEST(DisplayToml, RefusesWrongVarifocals) {
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "d0_mm = 3", "d0_mm = 3\nposition_mm = 4")),
              HasSubstr("d.toml:16: layer 0 has position_mm beside [varifocal]; leave it out"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "d0_mm = 3", "d0_mm = 3\nmagnification = 4")),
              HasSubstr("layer 0 has magnification beside [varifocal]"));
  EXPECT_THAT(Refusal(kVarifocal + std::string("[[layer]]\nd0_mm = 3\n[layer.barrier]\n"
                                               "period_px = 6\naperture_px = 2\nslots = 3\n")),
              HasSubstr("[varifocal] and 2 [[layer]] tables; give exactly one"));
  EXPECT_THAT(Refusal(std::string(kVarifocal).substr(0, std::string(kVarifocal).find("[[layer]]"))),
              HasSubstr("[varifocal] and 0 [[layer]] tables"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "planes = 3", "plains = 3")),
              HasSubstr("d.toml:9: [varifocal] has no key \"plains\"; did you mean \"planes\"?"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "planes = 3", "planes = 0")), HasSubstr("planes = 0"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "planes = 3", "planes = 100000")),
              HasSubstr("planes = 100000"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "depth_mm = 60", "depth_mm = -60")),
              HasSubstr("depth_mm = -60"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "depth_mm = 60", "depth_mm = nan")),
              HasSubstr("depth_mm = nan"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "relay_focal_mm = 300", "relay_focal_mm = 0")),
              HasSubstr("relay_focal_mm = 0"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "relay_focal_mm = 300", "relay_focal_mm = 20")),
              HasSubstr("the magnification at -30 mm = -0.6"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "magnification0 = 0.9", "magnification0 = nan")),
              HasSubstr("the magnification at -30 mm = nan"));
  EXPECT_THAT(Refusal(Replaced(kVarifocal, "\"sinusoidal\"", "\"sinus\"")),
              HasSubstr("d.toml:11: spacing = \"sinus\" is not known"));
  EXPECT_THAT(
      Refusal(Replaced(kVarifocal, "viewing_distance_mm = 500", "viewing_distance_mm = 31")),
      HasSubstr("in front of every layer"));
}

TEST(FieldOfView, NarrowsByTheMagnificationOfARelay) {
  Display display = BarrierAndLenses();
  const double plain = FieldOfViewDeg(display, display.layers[0]);
  display.layers[0].magnification = 2;
  const auto tangent = [](double degrees) { return std::tan(degrees * std::numbers::pi / 360); };
  EXPECT_NEAR(tangent(FieldOfViewDeg(display, display.layers[0])), tangent(plain) / 2, 1e-12);
  EXPECT_DOUBLE_EQ(LatticePitchMm(display, display.layers[0]), 2 * 0.6);
}

TEST(SharpestOffset, IsWhereABeamIsNarrowest) {
  LensletArray lenses{LensletArray::Lattice::kSquare, 6, 4};
  EXPECT_EQ(SharpestOffsetMm({0, 5, lenses}), 0);
  for (const double focal : {2.0, 4.0, 7.0}) {
    lenses.focal_mm = focal;
    // By search over the widths of displays.md section 1.3.
    double narrowest = 1e9, expected = 0;
    for (double offset = -30; offset <= 30; offset += 1e-3) {
      const double element = 6 * (1 + offset * (1 / 5.0 - 1 / focal)), emitter = offset / 5;
      const double width = element * element + emitter * emitter;
      if (width < narrowest) {
        narrowest = width;
        expected = offset;
      }
    }
    EXPECT_NEAR(SharpestOffsetMm({0, 5, lenses}), expected, 2e-3);
  }
}

struct Bad {
  const char* says;
  void (*spoil)(Display&);
};

class CheckDisplayRefuses : public ::testing::TestWithParam<Bad> {};

TEST_P(CheckDisplayRefuses, WithOneClearLine) {
  Display display = BarrierAndLenses();
  GetParam().spoil(display);
  const std::string refusal = Refusal(display);
  EXPECT_THAT(refusal, HasSubstr(GetParam().says));
  EXPECT_THAT(refusal, Not(HasSubstr("\n")));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

LensletArray Lenslets(double pitch, int rays) {
  return {LensletArray::Lattice::kHexagonal, pitch, rays};
}

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
        Bad{"900000000 pixels", [](Display& d) { d.width_px = d.height_px = 30000; }},
        Bad{"1000000000 pixels", [](Display& d) { d.width_px = 1000000000, d.height_px = 1; }},
        Bad{"1000000000000000000 pixels",
            [](Display& d) {
              d.width_px = d.height_px = 1000000000;
              d.binning_px = 1000000;
            }},
        Bad{"does not divide", [](Display& d) { d.binning_px = 5; }},
        Bad{"does not divide", [](Display& d) { d.binning_px = 0; }},
        Bad{"fits the panel", [](Display& d) { d.width_px = 1; }},
        Bad{"in front of every layer", [](Display& d) { d.viewing_distance_mm = 10; }},
        Bad{"in front of every layer", [](Display& d) { d.viewing_distance_mm = 14; }},
        Bad{"viewing_distance_mm = -600", [](Display& d) { d.viewing_distance_mm = -600; }},
        Bad{"border_offset_mm = nan", [](Display& d) { d.border_offset_mm = kNan; }},
        Bad{"border_mm = -1", [](Display& d) { d.border_mm = -1; }},
        Bad{"rays = 7 under", [](Display& d) { d.layers[0].optics = Lenslets(6.5, 7); }},
        Bad{"rays = 0 under", [](Display& d) { d.layers[0].optics = Lenslets(6.5, 0); }},
        Bad{"pitch_px = nan", [](Display& d) { d.layers[0].optics = Lenslets(kNan, 1); }},
        Bad{"no lens of 13 emitters fits",
            [](Display& d) {
              d.layers[0].optics = Lenslets(13, 1);
              d.height_px = 11;
            }},
        Bad{"offset_px right = inf",
            [](Display& d) {
              LensletArray lenses = Lenslets(6, 3);
              lenses.offset_x_px = std::numeric_limits<double>::infinity();
              d.layers[0].optics = lenses;
            }},
        Bad{"degrees",
            [](Display& d) {
              d.layers[0].optics = Lenslets(6, 3);
              d.layers[0].d0_mm = 1e-6;
            }},
        Bad{"subpixels_per_lens = 0", [](Display& d) { d.layers[0].optics = Lenticular{0}; }},
        Bad{"no lens of 100 sub-pixels",
            [](Display& d) { d.layers[0].optics = Lenticular{100}; }},
        Bad{"slant = nan", [](Display& d) { d.layers[0].optics = Lenticular{4.5, kNan}; }},
        Bad{"slant = -1001", [](Display& d) { d.layers[0].optics = Lenticular{4.5, -1001}; }},
        Bad{"views = 0", [](Display& d) { d.layers[0].optics = Lenticular{4.5, 0, 0}; }},
        Bad{"over binning_px = 2",
            [](Display& d) {
              d.layers[0].optics = Lenticular{};
              d.binning_px = 2;
            }},
        Bad{"magnification = 0", [](Display& d) { d.layers[0].magnification = 0; }},
        Bad{"magnification = -1", [](Display& d) { d.layers[0].magnification = -1; }},
        Bad{"magnification = nan", [](Display& d) { d.layers[0].magnification = kNan; }},
        Bad{"not the planes of [varifocal]", [](Display& d) { d.varifocal = Varifocal{}; }},
        Bad{"the panel's contrast = 1;", [](Display& d) { d.contrast = 1; }},
        Bad{"the panel's contrast = nan", [](Display& d) { d.contrast = kNan; }},
        Bad{"the modulator's contrast = 0.5",
            [](Display& d) { std::get<Barrier>(d.layers[0].optics).contrast = 0.5; }},
        Bad{"slot_crosstalk = 1.5", [](Display& d) { d.slot_crosstalk = 1.5; }},
        Bad{"slot_crosstalk = nan", [](Display& d) { d.slot_crosstalk = kNan; }},
        Bad{"border_mm = 21 is wider", [](Display& d) { d.border_mm = 21; }}));

}  // namespace
}  // namespace lamella
