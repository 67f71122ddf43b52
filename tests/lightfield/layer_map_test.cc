// Layers of any optics: the section of a beam against rays that are drawn through its element and
// its emitter, a relay against a thin lens that is traced, and the barrier's map in two dimensions.
#include "lightfield/layer_map.h"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/varifocal.h"

namespace lamella {
namespace {

Display OneLayer(const Optics& optics, double magnification = 1) {
  Display display{"one", 120, 96, 0.3, 1, 600, false, 0, 0, {}};
  display.layers = {{10, 5, optics, false, magnification}};
  Check(display, "test");
  return display;
}

LensletArray Lenslets(double focal_mm) {
  LensletArray lenses{LensletArray::Lattice::kSquare, 6, 4};
  lenses.focal_mm = focal_mm;
  return lenses;
}

// Rays from all points of the emitter through all points of the element: how far they are spread on
// the plane `offset_mm` in front.
struct Section {
  double mean = 0, variance = 0, least = 1e9, most = -1e9;
};

Section Trace(const AxisBeam& beam, double power_per_mm, double offset_mm) {
  constexpr int kSteps = 256;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> jitter(0, 1);
  Section section;
  double sum = 0, squares = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double a = ((i + jitter(random)) / kSteps - 0.5) * beam.aperture_mm;
      const double b = ((j + jitter(random)) / kSteps - 0.5) * beam.emitter_width_mm;
      const double x = beam.element_mm + a, emitter = beam.emitter_mm + b;
      const double slope = (x - emitter) / beam.d0_mm - a * power_per_mm;
      const double there = x + offset_mm * slope;
      sum += there;
      squares += there * there;
      section.least = std::min(section.least, there);
      section.most = std::max(section.most, there);
    }
  }
  section.mean = sum / (kSteps * kSteps);
  section.variance = squares / (kSteps * kSteps) - section.mean * section.mean;
  return section;
}

void ExpectSection(const Optics& optics, double power_per_mm) {
  const LayerMap map(OneLayer(optics), 0);
  const std::optional<Beam> beam = map.BeamOf(0, 0, 62, 45);
  ASSERT_TRUE(beam);
  for (const AxisBeam& axis : {beam->x, beam->y}) {
    for (const double offset : {-20.0, -5.0, -1.0, 0.0, 3.0, 15.0, 40.0}) {
      const Section section = Trace(axis, power_per_mm, offset);
      const double element = axis.OpeningBlurMm(offset), emitter = axis.EmitterBlurMm(offset);
      const double base = element + emitter;
      EXPECT_NEAR(section.mean, axis.At(offset), 1e-3 * base) << offset;
      EXPECT_NEAR(section.variance, (element * element + emitter * emitter) / 12,
                  2e-3 * base * base)
          << offset;
      EXPECT_NEAR(section.most - section.least, base, 0.02 * base + 1e-12) << offset;
    }
  }
}

TEST(Beam, IsAsWideAsTheRaysThroughItsElementAndEmitter) {
  ExpectSection(Barrier{6, 2, 3}, 0);
  ExpectSection(Lenslets(0), 1 / 5.0);
  ExpectSection(Lenslets(4), 1 / 4.0);
  ExpectSection(Lenslets(50), 1 / 50.0);
}

TEST(LayerMap, SeesThroughABarrierWhatItsAxesSee) {
  const Display display = OneLayer(Barrier{6, 2, 6});
  const LayerMap map(display, 0);
  const RayMap axes(display, 0);
  int seen = 0;
  for (int slot = 0; slot < 36; ++slot) {
    for (int row = 3; row < 96; row += 11) {
      for (int column = 1; column < 120; column += 7) {
        const std::optional<Beam> beam = map.BeamOf(slot, 0, column, row);
        EXPECT_EQ(beam.has_value(), axes.Column(slot % 6, column) && axes.Row(slot / 6, row));
        if (!beam) continue;
        const std::optional<Sight> sight =
            map.See(beam->x.element_mm + 0.01, beam->y.element_mm - 0.01,
                    beam->x.slope() + 0.01 / 5, beam->y.slope() - 0.01 / 5);
        ASSERT_TRUE(sight);
        ++seen;
        EXPECT_NEAR(sight->column, column + 0.5, 1e-9);
        EXPECT_NEAR(sight->row, row + 0.5, 1e-9);
        EXPECT_TRUE(sight->slots_x >> (slot % 6) & 1U);
        EXPECT_TRUE(sight->slots_y >> (slot / 6) & 1U);
        EXPECT_TRUE(axes.ColumnOpen(slot % 6, sight->element_column));
        EXPECT_TRUE(axes.RowOpen(slot / 6, sight->element_row));
      }
    }
  }
  EXPECT_GT(seen, 4000);
}

TEST(LayerMap, SeesNothingThroughClosedElements) {
  const LayerMap map(OneLayer(Barrier{6, 2, 1}), 0);  // columns 0-1 of 6 are open, once
  EXPECT_TRUE(map.See(0.3, -0.3, 0, 0));
  EXPECT_FALSE(map.See(0.9, -0.3, 0, 0));
  EXPECT_FALSE(map.See(0.3, -0.9, 0, 0));
}

TEST(LayerMap, IsTheSameThroughARelayThatMagnifies) {
  for (const Optics& optics :
       {Optics(Barrier{6, 2, 3}), Optics(Lenslets(0)), Optics(Lenslets(4)), Optics(Lenticular{})}) {
    constexpr double kM = 1.3;
    const LayerMap plain(OneLayer(optics), 0), magnified(OneLayer(optics, kM), 0);
    int beams = 0;
    for (int row = 0; row < 96; row += 5) {
      for (int column = 0; column < 120; ++column) {
        const std::optional<Beam> a = plain.BeamOf(0, 1, column, row);
        const std::optional<Beam> b = magnified.BeamOf(0, 1, column, row);
        ASSERT_EQ(a.has_value(), b.has_value());
        if (!a) continue;
        ++beams;
        EXPECT_NEAR(b->x.element_mm, kM * a->x.element_mm, 1e-9);
        EXPECT_NEAR(b->y.emitter_mm, kM * a->y.emitter_mm, 1e-9);
        EXPECT_NEAR(b->x.slope(), a->x.slope() / kM, 1e-12);
        EXPECT_NEAR(b->y.slope(), a->y.slope() / kM, 1e-12);
        EXPECT_NEAR(b->x.aperture_mm, kM * a->x.aperture_mm, 1e-12);
        EXPECT_NEAR(b->x.kappa_per_mm(), a->x.kappa_per_mm() / (kM * kM), 1e-12);
        const double x = a->x.element_mm + 0.1, y = a->y.element_mm;
        const double slope_x = a->x.slope(), slope_y = a->y.slope();
        const auto before = plain.See(x, y, slope_x, slope_y);
        const auto after = magnified.See(kM * x, kM * y, slope_x / kM, slope_y / kM);
        ASSERT_EQ(before.has_value(), after.has_value());
        if (!before) continue;
        EXPECT_NEAR(before->column, after->column, 1e-9);
        EXPECT_NEAR(before->row, after->row, 1e-9);
      }
    }
    EXPECT_GT(beams, 300);
  }
}

// A thin lens images the plane of the lenslets: rays are traced through it from one object distance
// after the other.
TEST(Varifocal, MagnifiesAsAThinLensDoes) {
  constexpr double kFocal = 300;
  const auto trace = [&](double x, double slope, double object) {
    const double image = 1 / (1 / kFocal - 1 / object);
    const double height = x + object * slope, bent = slope - height / kFocal;
    return std::array{height + image * bent, bent, image};
  };
  const double reference = trace(0, 0, 600)[2];  // where M0 = 1
  for (const double object : {480.0, 560.0, 600.0, 660.0, 800.0}) {
    const double z = trace(0, 0, object)[2] - reference;
    Varifocal varifocal;
    varifocal.relay_focal_mm = kFocal;
    const double m = PlaneMagnification(varifocal, z);
    // Upside down and back to front in x and slope; sizes as M and 1/M.
    const auto origin = trace(0, 0, object), aside = trace(1, 0, object);
    EXPECT_NEAR(origin[0] - aside[0], m, 1e-9);
    const auto one_way = trace(1, -0.02, object), other = trace(1, 0.03, object);
    EXPECT_NEAR(one_way[0], other[0], 1e-9);  // of one point
    EXPECT_NEAR(one_way[1] - other[1], 0.05 / m, 1e-12);
  }
}

TEST(Varifocal, HasItsPlanesAsLayers) {
  Varifocal varifocal;
  varifocal.planes = 64;
  varifocal.spacing = Varifocal::Spacing::kSinusoidal;
  varifocal.relay_focal_mm = 300;
  varifocal.magnification0 = 0.9;
  Display display{"v", 120, 96, 0.3, 1, 600, true, 0, 0, {}};
  display.layers = PlanesOf(varifocal, {0, 3, Lenslets(0), true});
  display.varifocal = varifocal;
  Check(display, "test");
  ASSERT_EQ(display.layers.size(), 64U);
  for (std::size_t k = 0; k < 64; ++k) {
    const Layer& layer = display.layers[k];
    EXPECT_DOUBLE_EQ(layer.magnification, 0.9 + layer.position_mm / 300);
    EXPECT_DOUBLE_EQ(layer.position_mm, -display.layers[63 - k].position_mm);
    EXPECT_TRUE(layer.mirror_x);
    const LayerMap map(display, static_cast<int>(k));
    const std::optional<Beam> beam = map.BeamOf(0, 0, 61, 50);
    ASSERT_TRUE(beam);
    EXPECT_NEAR(beam->x.emitter_width_mm, 0.3 * layer.magnification, 1e-12);
  }
}

TEST(PlaneDepths, OfOnePlaneAreTheMiddle) {
  Varifocal varifocal;
  varifocal.planes = 1;
  EXPECT_EQ(PlaneDepthsMm(varifocal), std::vector<double>{0});
}

TEST(SigmaDelta, NeverOwesMoreThanOne) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  double accumulator = 0.7, asked = 0, shown = 0;
  for (int t = 0; t < 10000; ++t) {
    const double grey = t % 100 < 10 ? 0 : unit(random);
    asked += grey;
    const bool bit = SigmaDelta(grey, accumulator);
    shown += bit ? 1 : 0;
    if (grey == 0) {
      EXPECT_FALSE(bit);  // black stays black
    }
    EXPECT_LE(std::abs(asked - shown), 1);
  }
}

}  // namespace
}  // namespace lamella
