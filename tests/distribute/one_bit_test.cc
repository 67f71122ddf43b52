// One-bit planes: what each method promises of every emitter, and that no direction's bits depend
// on another direction. Directions are found by the formulas of displays.md section 3 (hex_centre)
// and a search over all lenses.
#include "distribute/one_bit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/direction_lattice.h"
#include "distribute/displays.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

double Double(float value) { return static_cast<double>(value); }

constexpr OneBitMethod kAll[] = {OneBitMethod::kSigmaDelta, OneBitMethod::kOrdered,
                                 OneBitMethod::kDiffusion};

Display SmallVarifocal(int planes, double depth_mm, int width = 200, int height = 150) {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = width;
  display.height_px = height;
  display.varifocal->planes = planes;
  display.varifocal->depth_mm = depth_mm;
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
  return display;
}

// The direction 6 b + a of an emitter of the preset's lattice, -1 for guard pixels and cut lenses.
int DirectionOf(const Display& display, int i, int j) {
  const double pitch = 13, row_pitch = 13 * std::sqrt(3.0) / 2;
  double nearest = 1e9, dx = 0, dy = 0;
  bool whole = false;
  for (int row = -1; row * row_pitch < display.height_px + 20; ++row) {
    for (int column = -2; column * pitch < display.width_px + 20; ++column) {
      const double x = pitch / 2 + pitch * column + (row % 2 != 0 ? pitch / 2 : 0);
      const double y = row_pitch * (row + 0.5);
      const double distance = std::hypot(i + 0.5 - x, j + 0.5 - y);
      if (distance >= nearest) continue;
      nearest = distance;
      dx = i + 0.5 - x;
      dy = j + 0.5 - y;
      whole = x >= pitch / 2 - 1e-6 && x <= display.width_px - pitch / 2 + 1e-6 &&
              y >= row_pitch / 2 - 1e-6 && y <= display.height_px - row_pitch / 2 + 1e-6;
    }
  }
  const double a = std::floor(dx + 3), b = std::floor(dy + 3);
  if (!whole || a < 0 || a >= 6 || b < 0 || b >= 6) return -1;
  return static_cast<int>(6 * b + a);
}

const Image<int>& Directions(const Display& display) {
  static std::map<int, Image<int>> made;  // by width, which tells the tests' sizes apart
  Image<int>& directions = made[display.width_px];
  if (!directions.empty()) return directions;
  directions = Image<int>(display.width_px, display.height_px);
  for (int j = 0; j < display.height_px; ++j) {
    for (int i = 0; i < display.width_px; ++i) directions(i, j) = DirectionOf(display, i, j);
  }
  return directions;
}

std::vector<Image<float>> RandomGrey(const Display& display, unsigned seed, float most = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, most);
  std::vector<Image<float>> grey;
  for (std::size_t k = 0; k < display.layers.size(); ++k) {
    Image<float> plane(display.width_px, display.height_px);
    std::generate(plane.data(), plane.data() + plane.size(), [&] { return uniform(random); });
    grey.push_back(std::move(plane));
  }
  return grey;
}

OneBitOptions Options(OneBitMethod method, int strokes = 16, bool couple = true) {
  return {method, strokes, couple};
}

TEST(DirectionLattice, HoldsEveryLitEmitterOnceAndNoGuardPixel) {
  const Display display = SmallVarifocal(1, 0);
  const DirectionLattice lattice = DirectionsOf(display, 0);
  ASSERT_EQ(lattice.directions(), 36);
  Image<int> found(display.width_px, display.height_px, -1);
  for (int direction = 0; direction < 36; ++direction) {
    const Image<int>& emitters = lattice.emitters[direction];
    for (const int* at = emitters.data(); at != emitters.data() + emitters.size(); ++at) {
      if (*at == DirectionLattice::kNone) continue;
      EXPECT_EQ(found.data()[*at], -1);
      found.data()[*at] = direction;
    }
  }
  const Image<int>& expected = Directions(display);
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found.data()[i], expected.data()[i]);
}

TEST(DirectionLattice, KnowsTheNearestLensesBelow) {
  for (const bool shift_odd_rows : {true, false}) {
    DirectionLattice lattice;
    lattice.lenses.shift_odd_rows = shift_odd_rows;
    for (const int row : {0, 1, 2, 3}) {
      // The preset's centres: of the row and of the next.
      const auto x = [&](int r, int column) {
        return 13 * (column + 0.5 + ((r % 2 != 0) == shift_odd_rows ? 0.5 : 0));
      };
      const auto below = lattice.BelowHexagonal(row);
      EXPECT_EQ(x(row + 1, 5 + below[0]) - x(row, 5), -6.5);
      EXPECT_EQ(x(row + 1, 5 + below[1]) - x(row, 5), 6.5);
    }
  }
}

TEST(OneBit, MeanOverStrokesIsRightToOneStroke) {
  const Display display = SmallVarifocal(3, 16);
  const Image<int>& directions = Directions(display);
  const auto grey = RandomGrey(display, 1);
  for (const auto& [method, strokes] : {std::pair{OneBitMethod::kSigmaDelta, 16},
                                        {OneBitMethod::kSigmaDelta, 7},
                                        {OneBitMethod::kSigmaDelta, 1},
                                        {OneBitMethod::kOrdered, 16},
                                        {OneBitMethod::kOrdered, 7},
                                        {OneBitMethod::kDiffusion, 16},
                                        {OneBitMethod::kDiffusion, 7}}) {
    const BitPlanes bits = OneBitPlanes(grey, display, Options(method, strokes));
    for (int plane = 0; plane < 3; ++plane) {
      const Image<float> mean = MeanOfStrokes(bits, plane);
      for (std::size_t i = 0; i < mean.size(); ++i) {
        const float wanted = directions.data()[i] < 0 ? 0 : grey[plane].data()[i];
        const float allowed = directions.data()[i] < 0 ? 0 : 1.0F / strokes + 1e-6F;
        ASSERT_NEAR(mean.data()[i], wanted, allowed) << plane << " " << i;
      }
    }
  }
}

TEST(OneBit, EveryStartOfASigmaDeltaIsRightToOneStroke) {
  const Display display = SmallVarifocal(1, 0);
  const auto grey = RandomGrey(display, 2);
  const BitPlanes bits = OneBitPlanes(grey, display, Options(OneBitMethod::kSigmaDelta));
  const Image<int>& directions = Directions(display);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (directions.data()[i] < 0) continue;
    double shown = 0;
    for (int t = 0; t < 16; ++t) {
      shown += bits.strokes[t].data()[i] & 1U;
      ASSERT_LT(std::abs(shown - Double(grey[0].data()[i]) * (t + 1)), 1 + 1e-9);
    }
  }
}

TEST(OneBit, BlackIsOffAndFullIsOnInAllStrokes) {
  const Display display = SmallVarifocal(2, 8);
  auto grey = RandomGrey(display, 3);
  for (Image<float>& plane : grey) {  // a third black, a third full, a third between
    for (std::size_t i = 0; i < plane.size(); ++i) {
      float& value = plane.data()[i];
      value = value < 0.33F ? 0.0F : value > 0.67F ? 1.0F : value;
    }
  }
  const Image<int>& directions = Directions(display);
  for (const OneBitMethod method : kAll) {
    const BitPlanes bits = OneBitPlanes(grey, display, Options(method));
    for (int plane = 0; plane < 2; ++plane) {
      const Image<float> mean = MeanOfStrokes(bits, plane);
      for (std::size_t i = 0; i < mean.size(); ++i) {
        const float wanted = grey[plane].data()[i];
        if (directions.data()[i] < 0) {
          ASSERT_EQ(mean.data()[i], 0);
        } else if (wanted == 0 || wanted == 1) {
          ASSERT_EQ(mean.data()[i], wanted);
        }
      }
    }
  }
}

TEST(OneBit, ContentOfOneDirectionLeavesTheBitsOfAllOthersAsTheyAre) {
  const Display display = SmallVarifocal(3, 16);
  const Image<int>& directions = Directions(display);
  const auto before = RandomGrey(display, 4), other = RandomGrey(display, 5);
  for (const OneBitMethod method : kAll) {
    const BitPlanes expected = OneBitPlanes(before, display, Options(method));
    for (const int changed : {-1, 0, 14, 15, 35}) {  // -1: guard pixels
      std::vector<Image<float>> after;
      for (std::size_t k = 0; k < before.size(); ++k) {
        after.push_back(before[k].Clone());
        for (std::size_t i = 0; i < after[k].size(); ++i) {
          if (directions.data()[i] == changed) after[k].data()[i] = other[k].data()[i];
        }
      }
      const BitPlanes bits = OneBitPlanes(after, display, Options(method));
      int changes = 0;
      for (std::size_t t = 0; t < bits.strokes.size(); ++t) {
        for (std::size_t i = 0; i < directions.size(); ++i) {
          const bool same = bits.strokes[t].data()[i] == expected.strokes[t].data()[i];
          if (directions.data()[i] == changed) {
            changes += same ? 0 : 1;
          } else {
            ASSERT_TRUE(same) << changed << " " << directions.data()[i];
          }
        }
      }
      EXPECT_EQ(changes > 0, changed >= 0);
    }
  }
}

TEST(OneBit, PlanesThatShowTheSameRayAreRightTogether) {
  // So near each other that a ray passes the same lens in all of them.
  const Display display = SmallVarifocal(3, 2);
  const Image<int>& directions = Directions(display);
  const auto grey = RandomGrey(display, 6, 0.33F);
  const auto worst = [&](bool couple) {
    const BitPlanes bits =
        OneBitPlanes(grey, display, Options(OneBitMethod::kSigmaDelta, 16, couple));
    double most = 0;
    const Image<float> a = MeanOfStrokes(bits, 0), b = MeanOfStrokes(bits, 1),
                       c = MeanOfStrokes(bits, 2);
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (directions.data()[i] < 0) continue;
      const double wanted =
          Double(grey[0].data()[i]) + Double(grey[1].data()[i]) + Double(grey[2].data()[i]);
      most = std::max(
          most, std::abs(Double(a.data()[i]) + Double(b.data()[i]) + Double(c.data()[i]) - wanted));
    }
    return most;
  };
  EXPECT_LE(worst(true), 1 / 16.0 + 1e-6);
  EXPECT_GT(worst(false), 1.5 / 16.0);
}

TEST(OneBit, DiffusionKeepsTheLightOfEveryDirection) {
  const Display display = SmallVarifocal(1, 0, 400, 300);
  const Image<int>& directions = Directions(display);
  const auto grey = RandomGrey(display, 7);
  const BitPlanes bits = OneBitPlanes(grey, display, Options(OneBitMethod::kDiffusion));
  std::map<int, double> wanted, count;
  std::map<int, std::map<int, double>> shown;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const int direction = directions.data()[i];
    wanted[direction] += Double(grey[0].data()[i]);
    ++count[direction];
    for (int t = 0; t < 16; ++t) shown[direction][t] += bits.strokes[t].data()[i];
  }
  // Roundings without diffusion would be off by sqrt(count / 12) / 16 = 0.5 in the mean. Strokes of
  // random grey are as even as chance has it, sqrt(count / 6) = 11 bits: no stroke flashes.
  for (int direction = 0; direction < 36; ++direction) {
    double all = 0;
    for (int t = 0; t < 16; ++t) {
      EXPECT_NEAR(shown[direction][t], wanted[direction], 55) << t;
      all += shown[direction][t] / 16;
    }
    EXPECT_NEAR(all, wanted[direction], 0.25);
  }
}

TEST(OneBit, IsTheSameForAnyNumberOfThreads) {
  const Display display = SmallVarifocal(3, 16);
  const auto grey = RandomGrey(display, 8);
  for (const OneBitMethod method : kAll) {
    const auto run = [&](int threads) {
      const ThreadLimit limit(threads);
      return OneBitPlanes(grey, display, Options(method));
    };
    const BitPlanes one = run(1), two = run(2);
    for (std::size_t t = 0; t < 16; ++t) {
      EXPECT_TRUE(std::equal(one.strokes[t].data(), one.strokes[t].data() + one.strokes[t].size(),
                             two.strokes[t].data()));
    }
  }
}

TEST(OneBit, WorksOnSquareAndShearedLattices) {
  Display display = SmallVarifocal(3, 16);
  for (Layer& layer : display.layers) {
    std::get<LensletArray>(layer.optics).lattice = LensletArray::Lattice::kSquare;
  }
  display.shear = true;
  const std::vector<Image<float>> grey = RandomGrey(display, 9);
  for (const OneBitMethod method : kAll) {
    const BitPlanes bits = OneBitPlanes(grey, display, Options(method));
    double lit = 0;
    for (int plane = 0; plane < 3; ++plane) {
      const Image<float> mean = MeanOfStrokes(bits, plane);
      for (std::size_t i = 0; i < mean.size(); ++i) lit += Double(mean.data()[i]);
    }
    // 36 of 169 emitters under whole lenses (15 x 11 of 13 px on 200 x 150), half as bright.
    EXPECT_NEAR(lit, 3 * 15 * 11 * 36 * 0.5, 0.02 * 3 * 15 * 11 * 36);
  }
}

TEST(OneBit, GreyIsLuminanceOfWhatIsKnown) {
  EmitterImage emitters{Image<Rgb>(6, 1), Image<float>(6, 1, 1)};
  emitters.color(0, 0) = {1, 0, 0};
  emitters.color(1, 0) = {0, 0.5F, 0};
  emitters.color(2, 0) = {0, 0, 1};
  emitters.color(3, 0) = {4, 4, 4};
  emitters.color(4, 0) = {std::numeric_limits<float>::quiet_NaN(), 1, 1};
  emitters.color(5, 0) = {1, 1, 1};
  emitters.coverage(5, 0) = 0;
  const Image<float> grey = GreyOf(emitters);
  const float expected[] = {0.2126F, 0.3576F, 0.0722F, 1, 0, 0};
  for (int x = 0; x < 6; ++x) EXPECT_FLOAT_EQ(grey(x, 0), expected[x]) << x;
}

TEST(OneBit, NamesAndMistakes) {
  for (const std::string& name : OneBitMethodNames()) {
    EXPECT_EQ(OneBitMethodNames()[static_cast<std::size_t>(OneBitMethodOf(name))], name);
  }
  EXPECT_THROW(OneBitMethodOf("sigma"), Error);
  const Display display = SmallVarifocal(2, 8);
  const auto grey = RandomGrey(display, 10);
  EXPECT_THROW(OneBitPlanes(grey, display, Options(OneBitMethod::kOrdered, 0)), Error);
  EXPECT_THROW(OneBitPlanes(grey, SmallVarifocal(3, 8), {}), Error);
  EXPECT_THROW(OneBitPlanes(grey, SmallVarifocal(2, 8, 300), {}), Error);
  EXPECT_THROW(OneBitPlanes(grey, SmallVarifocal(25, 188), {}), Error);
  const Display barriers = FindDisplay("paper-two-layer");
  EXPECT_THROW(OneBitPlanes(RandomGrey(barriers, 11), barriers, {}), Error);
}

}  // namespace
}  // namespace lamella
