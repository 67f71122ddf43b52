#include "lightfield/panel_rays.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "lightfield/calibration.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

PanelCalibration Panel() {
  PanelCalibration panel;
  panel.width_px = 1920;
  panel.height_px = 1080;
  panel.pitch_mm = 0.3;
  return panel;
}

PanelCalibration Bent() {
  PanelCalibration panel = Panel();
  panel.scale = 0.013;
  panel.aspect = -0.004;
  panel.skew = 0.02;
  panel.bow_mm = 1.7;
  panel.pincushion = -0.05;
  panel.mirror_x = true;
  return panel;
}

TEST(PanelPoint, OfAPlainPanelCountsFromItsMiddle) {
  EXPECT_EQ(PanelPoint(Panel(), {960, 540}), Vector3d(0, 0, 0));
  EXPECT_LT((PanelPoint(Panel(), {0, 0}) - Vector3d(-288, 162, 0)).norm(), 1e-12);  // top left
  PanelCalibration mirrored = Panel();
  mirrored.mirror_x = true;
  EXPECT_LT((PanelPoint(mirrored, {0, 0}) - Vector3d(288, 162, 0)).norm(), 1e-12);
}

TEST(PanelPoint, FollowsTheFormulaOfScaleAspectSkewAndBow) {
  PanelCalibration panel = Bent();
  panel.pincushion = 0;
  panel.mirror_x = false;
  const long double y = 0.3L * (540 - 100) * 1.013L * 1.004L;
  const long double x = 0.3L * (1800 - 960) * 1.013L * 0.996L + 0.02L * y;
  const long double R2 = 0.15L * 0.15L * (1920.0L * 1920 + 1080.0L * 1080);
  const Vector3d point = PanelPoint(panel, {1800, 100});
  EXPECT_NEAR(point.x(), static_cast<double>(x), 1e-11);
  EXPECT_NEAR(point.y(), static_cast<double>(y), 1e-11);
  EXPECT_NEAR(point.z(), static_cast<double>(1.7L * (x * x + y * y) / R2), 1e-12);
  // The corner of a panel without other faults sags by b.
  PanelCalibration bowed = Panel();
  bowed.bow_mm = 0.4;
  EXPECT_NEAR(PanelPoint(bowed, {0, 1080}).z(), 0.4, 1e-14);
}

TEST(PanelPixel, IsTheInverseOfThePoint) {
  for (const double pincushion : {-0.19, -0.05, 0.0, 0.1, 0.2}) {
    PanelCalibration panel = Bent();
    panel.pincushion = pincushion;
    for (double u = -100; u <= 2020; u += 53) {
      for (double v = -60; v <= 1140; v += 47) {
        const auto back = PanelPixel(panel, PanelPoint(panel, {u, v}).head<2>());
        ASSERT_TRUE(back);
        EXPECT_LT((*back - Vector2d(u, v)).norm(), 1e-12 * 1920) << pincushion << " " << u;
      }
    }
  }
  PanelCalibration barrel = Panel();
  barrel.pincushion = -0.1;
  EXPECT_FALSE(PanelPixel(barrel, {5000, 0}));  // it never reaches there
}

TEST(MeetPanel, FindsThePointOfABowedPanelOnTheLine) {
  const PanelCalibration panel = Bent();
  const double R2 = panel.HalfDiagonalMm() * panel.HalfDiagonalMm();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 300; ++i) {
    const Vector3d from(300 * number(random), 200 * number(random), 600);
    const Vector3d towards(280 * number(random), 160 * number(random), 0);
    const auto point = MeetPanel(panel, from, towards - from);
    ASSERT_TRUE(point);
    EXPECT_NEAR(point->z(), 1.7 * point->head<2>().squaredNorm() / R2, 1e-12);
    EXPECT_LT((towards - from).cross(*point - from).norm(), 1e-9 * (towards - from).squaredNorm());
    EXPECT_LT((*point - towards).norm(), 4);  // the near crossing, not the far side of the bowl
  }
  EXPECT_FALSE(MeetPanel(Panel(), {0, 0, 5}, {1, 0, 0}));  // along a flat panel
}

TEST(Refract, ObeysSnellToTheLastDigits) {
  for (const double degrees : {0.0, 1.0, 20.0, 60.0, 89.9, 89.9999}) {
    for (const double n : {1.0, 1.49, 4.0}) {
      const double t = degrees * kDegree;
      const Vector3d in(3 * std::sin(t), 0, -3 * std::cos(t));
      const Vector3d out = Refract(in, n);
      EXPECT_NEAR(out.norm(), 1, 1e-15);
      EXPECT_NEAR(n * out.x(), std::sin(t), 1e-15);
      EXPECT_LT(out.z(), 0);
      EXPECT_TRUE(out.allFinite());
    }
  }
}

TEST(RefractionCrossing, SatisfiesSnellBetweenTwoPoints) {
  for (const double L : {0.0, 1e-9, 1.0, 200.0, 1e6}) {
    for (const double z : {0.0, 1e-6, 5.0, 100.0}) {
      for (const double n : {1.0, 1.49, 2.5}) {
        const double r = RefractionCrossing(600, z, L, n), w = L - r;
        ASSERT_TRUE(r >= 0 && r <= L) << L << " " << z;
        if (z == 0 || L == 0) {
          EXPECT_NEAR(r, L, 1e-9 * L);
          continue;
        }
        // w is a difference of numbers near L: what it can be known to.
        EXPECT_NEAR(r / std::hypot(r, 600), n * w / std::hypot(w, z), 4e-15 * L / z + 1e-12);
      }
    }
  }
}

TEST(LayerSights, AgreesWithTheTwoPointForm) {
  LayerCalibration layer;
  layer.emitter = Panel();
  layer.modulator = Panel();
  layer.gap_mm = 7.45;
  layer.index = 1.49;
  const Vector3d eye(30, -20, 600);
  for (const Vector2d& target : {Vector2d(100, 100), Vector2d(960, 540), Vector2d(1900, 1000)}) {
    // From the emitter's pixel to where its light leaves the spacer, and back by the line of sight.
    const Vector3d point = PanelPoint(layer.emitter, target);
    const Vector2d away = point.head<2>() - eye.head<2>();
    const double r = RefractionCrossing(eye.z(), layer.gap_mm, away.norm(), layer.index);
    const Vector2d crossing = eye.head<2>() + r / away.norm() * away;
    const auto hit = LayerSights(layer).Seen(eye, Vector3d(crossing.x(), crossing.y(), 0) - eye);
    ASSERT_TRUE(hit);
    EXPECT_LT((hit->emitter - target).norm(), 1e-9);
    EXPECT_LT((hit->modulator - *PanelPixel(*layer.modulator, crossing)).norm(), 1e-9);
  }
}

// x_e = x_m - g tan(asin(sin(t)/n)) for a slope tan(t), by hand in long double.
TEST(LayerSights, ShiftsTheEmitterBySnell) {
  LayerCalibration layer;
  layer.emitter = Panel();
  layer.modulator = Panel();
  layer.gap_mm = 7.45;
  layer.index = 1.49;
  for (const double slope : {-2.0, -0.3, 0.0, 0.05, 1.0, 40.0}) {
    const auto hit = LayerSights(layer).Seen({12 + slope * 500, 0, 500}, {-slope, 0, -1});
    ASSERT_TRUE(hit);
    const auto s = static_cast<long double>(slope), sine = s / std::sqrt(1 + s * s) / 1.49L;
    const long double x_e = 12 - 7.45L * sine / std::sqrt(1 - sine * sine);
    EXPECT_NEAR(hit->modulator.x(), 960 + 12 / 0.3, 1e-9);
    EXPECT_NEAR(hit->emitter.x(), static_cast<double>(960 + x_e / 0.3L), 1e-9);
    EXPECT_NEAR(hit->emitter.y(), 540, 1e-9);
  }
}

TEST(LayerSights, PutsAMisplacedEmitterWhereItsRelationSays) {
  LayerCalibration layer;
  layer.emitter = Bent();
  layer.modulator = Panel();
  layer.gap_mm = 5;
  layer.offset_mm = {0.7, -0.4};
  layer.rotation_rad = {0.004, -0.01, 0.02};
  layer.display_from_stack.rotation = Eigen::AngleAxisd(0.1, Vector3d(1, 2, 3).normalized());
  layer.display_from_stack.translation = {3, -5, 20};
  const Vector2d pixel(1500, 200);
  const Eigen::AngleAxisd turn(layer.rotation_rad.norm(), layer.rotation_rad.normalized());
  const Vector3d in_stack = turn * PanelPoint(layer.emitter, pixel) + Vector3d(0.7, -0.4, -5);
  const Vector3d point = layer.display_from_stack * in_stack, eye(40, 20, 600);
  const auto hit = LayerSights(layer).Seen(eye, point - eye);
  ASSERT_TRUE(hit);
  EXPECT_LT((hit->emitter - pixel).norm(), 1e-8);
}

TEST(LayerSights, SeesNothingFromBehindOrAlongThePanel) {
  LayerCalibration layer;
  layer.emitter = Panel();
  EXPECT_FALSE(LayerSights(layer).Seen({0, 0, -10}, {0, 0, 1}));
  EXPECT_FALSE(LayerSights(layer).Seen({0, 0, 10}, {0, 0, 1}));
  EXPECT_FALSE(LayerSights(layer).Seen({0, 0, 10}, {1, 0, 0}));
  EXPECT_FALSE(LayerSights(layer).Seen({0, 0, 10}, {0, 0, 0}));
  // Zero gap: both panels are one plane.
  layer.modulator = Panel();
  layer.index = 1.5;
  const auto hit = LayerSights(layer).Seen({0, 0, 10}, {20, 3, -1});
  ASSERT_TRUE(hit);
  EXPECT_LT((hit->emitter - hit->modulator).norm(), 1e-9);
}

// Sideways displacement t sin(a) (1 - cos(a)/sqrt(n^2 - sin^2(a))), text-book optics.
TEST(PlateShift, IsTheTextbookDisplacement) {
  for (const double degrees : {0.0, 10.0, 45.0, 80.0}) {
    const double a = degrees * kDegree, n = 1.52;
    const Vector3d d(std::sin(a), 0, -std::cos(a));
    const Vector3d shift = PlateShift({3, n, {0, 0, 1}}, 2 * d);
    const double sideways = (shift - shift.dot(d) * d).norm();
    EXPECT_NEAR(sideways,
                3 * std::sin(a) * (1 - std::cos(a) / std::sqrt(n * n - std::pow(std::sin(a), 2))),
                1e-14);
    EXPECT_LT((PlateShift({3, n, {0, 0, -1}}, d) - shift).norm(), 1e-15);
  }
  // 45 degrees, 3 mm, 1.52: 1.0 mm (calibration.md section 1).
  const Vector3d d(std::sin(45 * kDegree), 0, -std::cos(45 * kDegree));
  const Vector3d shift = PlateShift({3, 1.52, {0, 0, 1}}, d);
  EXPECT_NEAR((shift - shift.dot(d) * d).norm(), 1.0, 0.02);
}

TEST(NearestLens, IsNearestOfAllByBruteForce) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-40, 40);
  for (const auto type : {LensLattice::Type::kSquare, LensLattice::Type::kHexagonal}) {
    const bool hexagonal = type == LensLattice::Type::kHexagonal;
    LensLattice lattice{type, 4, 0.2, {0.3, 0.8}, 0};
    // Its basis vectors, from the geometry of the lattice: the neighbours of a lens.
    const double a = lattice.rotation_rad - (hexagonal ? 30 : 0) * kDegree;
    const double b = a + (hexagonal ? 60 : 90) * kDegree;
    const Vector2d e1 = 4 * Vector2d(std::cos(a), std::sin(a));
    const Vector2d e2 = 4 * Vector2d(std::cos(b), std::sin(b));
    const Vector2d start = NearestLens(lattice, {0, 0});
    for (int i = 0; i < 200; ++i) {
      const Vector2d point(number(random), number(random));
      double nearest = 1e9;
      for (int j = -40; j <= 40; ++j) {
        for (int k = -40; k <= 40; ++k) {
          nearest = std::min(nearest, (start + j * e1 + k * e2 - point).norm());
        }
      }
      EXPECT_NEAR((NearestLens(lattice, point) - point).norm(), nearest, 1e-9) << hexagonal;
    }
  }
  const LensLattice line{LensLattice::Type::kLine, 2, 0, {0.25, 0}, 0};
  EXPECT_LT((NearestLens(line, {2.6, 7}) - Vector2d(2.5, 7)).norm(), 1e-12);
  EXPECT_LT((NearestLens(line, {-0.6, 7}) - Vector2d(-1.5, 7)).norm(), 1e-12);
}

// A lens sends an emitter's light one way: seen through it with slope s is x_c - d0 s, wherever the
// line of sight passes the lens (displays.md section 1.2).
TEST(LayerSights, SeesTheEmitterOfASlopeThroughALens) {
  LayerCalibration layer;
  layer.emitter = Panel();
  layer.gap_mm = 3;
  layer.lattice = LensLattice{LensLattice::Type::kSquare, 4, 0, {0, 0}, 0};
  for (const double slope : {-0.2, 0.0, 0.15}) {
    for (const double at : {-1.9, -0.3, 0.0, 1.9}) {
      const double x = 8 + at;
      const auto hit = LayerSights(layer).Seen({x + 500 * slope, 0.5, 500}, {-slope, 0, -1});
      ASSERT_TRUE(hit);
      EXPECT_NEAR((hit->emitter.x() - 960) * 0.3, 8 - 3 * slope, 1e-9);
      EXPECT_NEAR((540 - hit->emitter.y()) * 0.3, 0, 1e-9);
    }
  }
  // Off its focus the pencil spreads: x_e = x_c - d0 s + (x - x_c)(1 - d0/f).
  layer.lattice->focal_mm = 4;
  const auto hit = LayerSights(layer).Seen({9.5 + 50, 0, 500}, {-0.1, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR((hit->emitter.x() - 960) * 0.3, 8 - 3 * 0.1 + 1.5 * (1 - 3.0 / 4), 1e-9);
}

}  // namespace
}  // namespace lamella
