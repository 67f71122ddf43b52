// A display as designed, traced through its calibration's lattice, meets the emitters that the ray
// maps give: two derivations of displays.md section 3.
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "lightfield/layer_map.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

Display Magnified(const Optics& optics, double magnification) {
  Display display;
  display.name = "one";
  display.width_px = 120;
  display.height_px = 90;
  display.pitch_mm = 0.4;
  display.viewing_distance_mm = 500;
  display.layers.resize(1);
  display.layers[0].position_mm = 12;
  display.layers[0].d0_mm = 3;
  display.layers[0].optics = optics;
  display.layers[0].magnification = magnification;
  return display;
}

void ExpectSameEmitters(const Display& display) {
  const LayerMap map(display, 0);
  const LayerSights sights(DesignCalibration(display).layers[0]);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  int met = 0;
  for (int i = 0; i < 4000; ++i) {
    const double x = 20 * number(random), y = 15 * number(random);
    const double slope_x = 0.2 * number(random), slope_y = 0.2 * number(random);
    const auto sight = map.See(x, y, slope_x, slope_y);
    if (!sight) continue;
    ++met;
    const Eigen::Vector3d direction(-slope_x, -slope_y, -1);
    const auto hit = sights.Seen(Eigen::Vector3d(x, y, 12) - 400 * direction, direction);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->emitter.x(), sight->column, 1e-9);
    EXPECT_NEAR(hit->emitter.y(), sight->row, 1e-9);
  }
  EXPECT_GT(met, 300);
}

TEST(LayerSightsAsDesigned, MeetTheEmittersOfABarrier) {
  ExpectSameEmitters(Magnified(Barrier{6, 2, 3}, 1));
  ExpectSameEmitters(Magnified(Barrier{6, 2, 3}, 1.3));
}

TEST(LayerSightsAsDesigned, MeetTheEmittersOfLenslets) {
  for (const auto lattice : {LensletArray::Lattice::kSquare, LensletArray::Lattice::kHexagonal}) {
    for (const bool odd : {true, false}) {
      for (const double focal_mm : {0.0, 4.0}) {
        for (const double magnification : {1.0, 0.8}) {
          SCOPED_TRACE(std::to_string(static_cast<int>(lattice)) + " " + std::to_string(odd) + " " +
                       std::to_string(focal_mm) + " " + std::to_string(magnification));
          ExpectSameEmitters(
              Magnified(LensletArray{lattice, 12.7, 6, 1.3, -2.1, odd, focal_mm}, magnification));
        }
      }
    }
  }
}

TEST(LayerSightsAsDesigned, MeetTheEmittersOfSlantedLenses) {
  for (const double slant : {1.0 / 6, -0.3, 0.0}) {
    for (const double focal_mm : {0.0, 4.0}) {
      SCOPED_TRACE(std::to_string(slant) + " " + std::to_string(focal_mm));
      ExpectSameEmitters(Magnified(Lenticular{4.7, slant, 9, 0.6, focal_mm}, 1));
    }
  }
}

}  // namespace
}  // namespace lamella
