// Packing of one-bit planes against tables written by hand and the published vectors, the order of
// strokes against the motion of the mirror, and the numerals against drawings.
#include "distribute/encode_varifocal.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/displays.h"
#include "distribute/stroke_order.h"
#include "lightfield/error.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

using Words = Image<std::uint32_t>;

Rgb8 Packed(std::uint32_t word, int planes, int stroke, const PlanePacking& packing) {
  return PackedFrame(Words(1, 1, word), planes, stroke, packing)(0, 0);
}

TEST(PlanePacking, FollowsTheTable) {
  using enum ChannelOrder;
  using enum BitOrder;
  struct Case {
    int plane, stroke;
    PlanePacking packing;
    Rgb8 codes;
  };
  // Written down, not computed: which code the one lit plane makes.
  const std::vector<Case> table{{0, 0, {kRgb, kLsbFirst}, {1, 0, 0}},
                                {7, 0, {kRgb, kLsbFirst}, {128, 0, 0}},
                                {8, 0, {kRgb, kLsbFirst}, {0, 1, 0}},
                                {17, 0, {kRgb, kLsbFirst}, {0, 0, 2}},
                                {0, 0, {kRgb, kMsbFirst}, {128, 0, 0}},
                                {2, 0, {kRgb, kMsbFirst}, {32, 0, 0}},
                                {23, 0, {kRgb, kMsbFirst}, {0, 0, 1}},
                                {0, 0, {kBrg, kLsbFirst}, {0, 0, 1}},
                                {8, 0, {kBrg, kLsbFirst}, {1, 0, 0}},
                                {16, 0, {kBrg, kLsbFirst}, {0, 1, 0}},
                                {0, 0, {kGrb, kLsbFirst}, {0, 1, 0}},
                                {9, 0, {kGrb, kLsbFirst}, {2, 0, 0}},
                                {23, 0, {kGrb, kLsbFirst}, {0, 0, 128}},
                                {4, 0, {kGbr, kLsbFirst}, {0, 16, 0}},
                                {12, 0, {kGbr, kLsbFirst}, {0, 0, 16}},
                                {20, 0, {kGbr, kMsbFirst}, {8, 0, 0}},
                                {1, 0, {kRbg, kLsbFirst}, {2, 0, 0}},
                                {9, 0, {kRbg, kLsbFirst}, {0, 0, 2}},
                                {17, 0, {kRbg, kLsbFirst}, {0, 2, 0}},
                                {1, 0, {kBgr, kLsbFirst}, {0, 0, 2}},
                                {9, 0, {kBgr, kMsbFirst}, {0, 64, 0}},
                                {17, 0, {kBgr, kLsbFirst}, {2, 0, 0}},
                                // Odd strokes: the plane in front comes first.
                                {23, 1, {kRgb, kLsbFirst}, {1, 0, 0}},
                                {0, 1, {kRgb, kLsbFirst}, {0, 0, 128}},
                                {22, 3, {kBrg, kMsbFirst}, {0, 0, 64}},
                                {0, 1, {kRgb, kLsbFirst, false}, {1, 0, 0}},
                                {0, 2, {kRgb, kLsbFirst}, {1, 0, 0}}};
  for (const Case& one : table) {
    EXPECT_EQ(Packed(1U << one.plane, 24, one.stroke, one.packing), one.codes)
        << one.plane << NameOf(one.packing.channels) << NameOf(one.packing.bits);
  }
  // Five planes: 0 comes fifth in a stroke that falls.
  EXPECT_EQ(Packed(1, 5, 1, {kRgb, kLsbFirst}), (Rgb8{16, 0, 0}));
}

TEST(PlanePacking, MeetsThePublishedVectors) {
  std::ifstream file(LAMELLA_DISPLAY_VECTORS);
  const nlohmann::json document = nlohmann::json::parse(file);
  int met = 0;
  for (const nlohmann::json& vector : document.at("cases")) {
    if (vector.at("fn") != "bitplanes") continue;
    std::uint32_t word = 0;
    for (const int plane : vector.at("input").at("planes")) word |= 1U << plane;
    const ChannelOrder order = ChannelOrderOf(vector.at("input").at("order").get<std::string>());
    const Rgb8 codes = Packed(word, 24, 0, {order, BitOrder::kLsbFirst});
    const std::vector<double> got{double(codes.r), double(codes.g), double(codes.b)};
    EXPECT_EQ(got, vector.at("expect").get<std::vector<double>>()) << vector;
    ++met;
  }
  EXPECT_GT(met, 1);
}

TEST(PlanePacking, UnpacksToTheSameBits) {
  std::mt19937 random(1);
  for (const int planes : {1, 5, 23, 24}) {
    Words bits(31, 17);
    std::generate(bits.data(), bits.data() + bits.size(),
                  [&] { return static_cast<std::uint32_t>(random() & ((1U << planes) - 1)); });
    for (const std::string& channels : ChannelOrderNames()) {
      for (const std::string& order : BitOrderNames()) {
        for (const int stroke : {0, 1}) {
          const PlanePacking packing{ChannelOrderOf(channels), BitOrderOf(order)};
          const Image<Rgb8> frame = PackedFrame(bits, planes, stroke, packing);
          const Words back = UnpackedFrame(frame.span(), planes, stroke, packing);
          EXPECT_TRUE(std::equal(bits.data(), bits.data() + bits.size(), back.data()));
        }
      }
    }
  }
}

TEST(PlanePacking, NamesAndMistakes) {
  EXPECT_EQ(ChannelOrderNames(),
            (std::vector<std::string>{"RGB", "RBG", "GRB", "GBR", "BRG", "BGR"}));
  EXPECT_EQ(NameOf(ChannelOrder::kGbr), "GBR");
  EXPECT_EQ(NameOf(BitOrderOf("msb-first")), "msb-first");
  EXPECT_THROW(ChannelOrderOf("RGG"), Error);
  EXPECT_THROW(BitOrderOf("first"), Error);
  EXPECT_THROW(PackedFrame(Words(1, 1), 25, 0, {}), Error);
  // Eight planes packed into blue are not in red.
  const Image<Rgb8> frame = PackedFrame(Words(2, 2, 5), 8, 0, {ChannelOrder::kBrg});
  EXPECT_THROW(UnpackedFrame(frame.span(), 8, 0, {ChannelOrder::kRgb}), Error);
}

TEST(PackedStroke, SpreadAndMirrorEmittersAndReverseOddStrokes) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = 6;
  display.height_px = 2;
  display.binning_px = 2;
  for (Layer& layer : display.layers) layer.mirror_x = true;
  BitPlanes bits{24, {}};
  for (int t = 0; t < 2; ++t) {
    Words words(3, 1);
    words(0, 0) = 1;        // the back plane, left
    words(2, 0) = 1U << 9;  // plane 9, right
    bits.strokes.push_back(std::move(words));
  }
  const PlanePacking packing{ChannelOrder::kRgb, BitOrder::kLsbFirst};
  const Image<Rgb8> frames[] = {PackedStroke(bits, 0, display, packing),
                                PackedStroke(bits, 1, display, packing)};
  const Rgb8 ninth{0, 2, 0}, dark{}, back{1, 0, 0}, falling_ninth{0, 64, 0}, last{0, 0, 128};
  const Rgb8 even[] = {ninth, ninth, dark, dark, back, back};
  const Rgb8 odd[] = {falling_ninth, falling_ninth, dark, dark, last, last};
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 6; ++x) {
      EXPECT_EQ(frames[0](x, y), even[x]) << x;
      EXPECT_EQ(frames[1](x, y), odd[x]) << x;
    }
  }
  EXPECT_THROW(CheckStrokes(1, packing), Error);
  CheckStrokes(1, {ChannelOrder::kRgb, BitOrder::kLsbFirst, false});
}

TEST(StrokeOrder, GoesThereAndBack) {
  EXPECT_EQ(StrokeOrder(4, 0), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(StrokeOrder(4, 1), (std::vector<int>{3, 2, 1, 0}));
  EXPECT_EQ(StrokeOrder(4, 6), (std::vector<int>{0, 1, 2, 3}));
}

// The focus moves as the sweep says: at its phase every plane is where the mirror is.
TEST(StrokeOrder, ShowsPlanesWhenTheMirrorIsThere) {
  for (const auto spacing : {Varifocal::Spacing::kUniform, Varifocal::Spacing::kSinusoidal}) {
    for (const FocusSweep sweep : {FocusSweep::kUniform, FocusSweep::kSinusoidal}) {
      Varifocal varifocal;
      varifocal.spacing = spacing;
      const std::vector<double> depths = PlaneDepthsMm(varifocal);
      for (const int stroke : {0, 1, 2, 3}) {
        const std::vector<ShownPlane> shown = StrokeSchedule(varifocal, sweep, stroke);
        ASSERT_EQ(shown.size(), 24U);
        EXPECT_EQ(shown.front().plane, stroke % 2 == 0 ? 0 : 23);
        double before = 0;
        for (const ShownPlane& one : shown) {
          EXPECT_GT(one.phase, before);
          before = one.phase;
          // The mirror's position in [-1, 1] at the time stroke + phase, in strokes.
          const double time = stroke + one.phase, pi = std::numbers::pi;
          const double at = sweep == FocusSweep::kUniform
                                ? std::acos(std::cos(pi * time)) / pi * 2 - 1
                                : -std::cos(pi * time);
          // 94 mm at the middle of the first of 24 shares of time.
          const double reach = 94 / (sweep == FocusSweep::kUniform ? 23.0 / 24 : std::cos(pi / 48));
          EXPECT_NEAR(at * reach, depths[one.plane], 1e-9);
        }
        EXPECT_NEAR(shown.front().phase, 0.5 / 24, 1e-12);
        EXPECT_NEAR(shown.back().phase, 23.5 / 24, 1e-12);
        if (static_cast<int>(spacing) != static_cast<int>(sweep)) continue;
        for (int i = 0; i < 24; ++i) EXPECT_NEAR(shown[i].phase, (i + 0.5) / 24, 1e-12);
      }
    }
  }
  Varifocal one;
  one.planes = 1;
  EXPECT_EQ(StrokeSchedule(one, FocusSweep::kSinusoidal, 1).at(0).phase, 0.5);
}

TEST(NumeralPlanes, ShowEachPlanesNumber) {
  const Display display = FindDisplay("paper-varifocal");
  const Words bits = NumeralPlanes(display);
  // 24 numbers stand six in a row; 170.67 x 192 emitters each, nine squares of 18.96 across.
  const double cell_width = 1024 / 6.0, cell_height = 192, square = cell_width / 9;
  const LensletArray& lenses = std::get<LensletArray>(display.layers[0].optics);
  const auto lit = [&](int plane, int column, int row) {
    const int cell_column = plane % 6, cell_row = plane / 6;
    const double x = cell_column * cell_width + (column + 1.5) * square;
    const double y = cell_row * cell_height + (row + 1.5) * square;
    const Lens lens = NearestLens(lenses, x, y);
    const int i = static_cast<int>(lens.x_px), j = static_cast<int>(lens.y_px);
    return bits(i, j) == 1U << plane;
  };
  const auto drawn = [&](int plane) {
    std::string drawing;
    for (int row = 0; row < 5; ++row) {
      for (int column = 0; column < 7; ++column) drawing += lit(plane, column, row) ? '#' : '.';
      drawing += '\n';
    }
    return drawing;
  };
  EXPECT_EQ(drawn(7),
            "###....\n"
            "..#....\n"
            "..#....\n"
            "..#....\n"
            "..#....\n");
  EXPECT_EQ(drawn(20),
            "###.###\n"
            "..#.#.#\n"
            "###.#.#\n"
            "#...#.#\n"
            "###.###\n");
  EXPECT_EQ(drawn(16),
            ".#..###\n"
            "##..#..\n"
            ".#..###\n"
            ".#..#.#\n"
            "###.###\n");
  const LensletMap map(display, 0);
  std::uint32_t all = 0;
  for (int j = 0; j < 768; ++j) {
    for (int i = 0; i < 1024; ++i) {
      if (bits(i, j) == 0) continue;
      EXPECT_TRUE(map.Pixel(i, j)) << "a guard pixel";
      all |= bits(i, j);
    }
  }
  EXPECT_EQ(all, (1U << 24) - 1);
  Display small = display;
  small.width_px = 256;
  small.height_px = 192;
  EXPECT_THROW(NumeralPlanes(small), Error);
}

}  // namespace
}  // namespace lamella
