// The ray map of misaligned layers against lines of sight traced the other way (LayerSights), and
// of layers as designed against the maps that are written for those.
#include "lightfield/calibrated_map.h"

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/layer_map.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

Display With(const Optics& optics, bool mirror_x = false) {
  Display display;
  display.name = "two";
  display.width_px = 120;
  display.height_px = 90;
  display.pitch_mm = 0.4;
  display.viewing_distance_mm = 500;
  display.layers.resize(2);
  for (Layer& layer : display.layers) {
    layer.optics = optics;
    layer.d0_mm = 3;
    layer.mirror_x = mirror_x;
  }
  display.layers[0].position_mm = -15;
  display.layers[1].position_mm = 12;
  return display;
}

// Everything that a calibration can say is otherwise than designed.
Calibration Misaligned(const Display& display, std::uint32_t seed) {
  Calibration calibration = DesignCalibration(display);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&](double size) -> Vector3d {
    return size * Vector3d(number(random), number(random), number(random));
  };
  for (LayerCalibration& layer : calibration.layers) {
    const Vector3d turn = vector(0.08);
    layer.display_from_stack.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    layer.display_from_stack.translation += vector(8);
    layer.index = 1.49;
    layer.gap_mm = 4.5 + 1.5 * number(random);
    layer.offset_mm = vector(3).head<2>();
    layer.rotation_rad = {0.004 * number(random), 0.004 * number(random), 0.05 * number(random)};
    layer.plate = Plate{3, 1.52, Vector3d(std::sqrt(0.5), 0, std::sqrt(0.5))};
    for (PanelCalibration* panel :
         {&layer.emitter, layer.modulator ? &*layer.modulator : nullptr}) {
      if (panel == nullptr) continue;
      panel->scale += 0.005 * number(random);
      panel->aspect = 0.003 * number(random);
      panel->skew = 0.003 * number(random);
      panel->bow_mm = 0.3 * number(random);
      panel->pincushion = 0.01 * number(random);
    }
  }
  return calibration;
}

struct Traced {
  Vector3d at, direction;  // of the light towards the viewer
};
Traced CentralLine(const CalibratedBeam& beam) {
  return {{beam.beam.x.element_mm, beam.beam.y.element_mm, beam.z_mm},
          {beam.beam.x.slope(), beam.beam.y.slope(), 1}};
}

// What the viewer meets who looks along the beam, in emitters from its top left.
SightHit Met(const LayerSights& sights, const CalibratedBeam& beam) {
  const Traced line = CentralLine(beam);
  const auto hit = sights.Seen(line.at + 450 * line.direction, -line.direction);
  EXPECT_TRUE(hit);
  return hit.value_or(SightHit());
}

Vector2d FromLeft(const PanelCalibration& panel, const Vector2d& pixel) {
  return {panel.mirror_x ? panel.width_px - pixel.x() : pixel.x(), pixel.y()};
}

TEST(CalibratedMap, SendsALineThatMeetsItsEmitterThroughItsOpening) {
  for (const bool mirror_x : {false, true}) {
    const Display display = With(Barrier{6, 2, 3}, mirror_x);
    const Calibration calibration = Misaligned(display, 5);
    int lit = 0;
    for (int l = 0; l < 2; ++l) {
      const CalibratedMap map(display, calibration, l);
      const LayerCalibration& layer = calibration.layers[static_cast<std::size_t>(l)];
      const LayerSights sights(layer);
      for (int i = 0; i < 9 * 120 * 90; i += 37) {
        const int slot = i % 9, column = i / 9 % 120, row = i / 9 / 120;
        const auto beam = map.BeamOf(slot, 0, column, row);
        if (!beam) continue;
        ++lit;
        const SightHit hit = Met(sights, *beam);
        const Vector2d emitter = FromLeft(layer.emitter, hit.emitter);
        const Vector2d modulator = FromLeft(*layer.modulator, hit.modulator);
        ASSERT_LT((emitter - Vector2d(column + 0.5, row + 0.5)).norm(), 1e-9);
        const Vector2d opening(6 * beam->beam.x.opening + 2 * (slot % 3) + 1,
                               6 * beam->beam.y.opening + 2 * (slot / 3) + 1);
        ASSERT_LT((modulator - opening).norm(), 1e-9);
      }
    }
    EXPECT_GT(lit, 3000);
  }
}

// The opening is the one beside which the viewer at (0, 0, D) sees the emitter.
TEST(CalibratedMap, ChoosesTheOpeningThatTheViewerSeesNearestToTheEmitter) {
  const Display display = With(Barrier{6, 2, 3}, true);
  const Calibration calibration = Misaligned(display, 8);
  const CalibratedMap map(display, calibration, 1);
  const LayerCalibration& layer = calibration.layers[1];
  const LayerSights sights(layer);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  int seen = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d viewer(0, 0, 500), place(20 * number(random), 15 * number(random), 0);
    const auto hit = sights.Seen(viewer, place - viewer);
    ASSERT_TRUE(hit);
    const Vector2d emitter = FromLeft(layer.emitter, hit->emitter);
    const Vector2d modulator = FromLeft(*layer.modulator, hit->modulator);
    const auto beam = map.BeamOf(4, 0, static_cast<int>(std::floor(emitter.x())),
                                 static_cast<int>(std::floor(emitter.y())));
    if (!beam) continue;
    ++seen;
    const Vector2d opening(6 * beam->beam.x.opening + 3, 6 * beam->beam.y.opening + 3);
    // Half a period, and what the sight may be beside the emitter's centre.
    EXPECT_LT((modulator - opening).cwiseAbs().maxCoeff(), 3.51);
  }
  EXPECT_GT(seen, 2000);
}

void ExpectSameBeam(const AxisBeam& a, const AxisBeam& b) {
  EXPECT_NEAR(a.element_mm, b.element_mm, 1e-9);
  EXPECT_NEAR(a.emitter_mm, b.emitter_mm, 1e-9);
  EXPECT_NEAR(a.aperture_mm, b.aperture_mm, 1e-9);
  EXPECT_NEAR(a.emitter_width_mm, b.emitter_width_mm, 1e-9);
  EXPECT_NEAR(a.d0_mm, b.d0_mm, 1e-9);
  EXPECT_NEAR(a.power_per_mm, b.power_per_mm, 1e-9);
}

// Unrounded windows differ from rounded ones in emitters that lie on a border of two.
void ExpectAsDesigned(const Display& display, double least_share) {
  const CalibratedMap map(display, DesignCalibration(display), 1);
  const LayerMap design(display, 1);
  const int slots = map.slots_per_axis() * map.slots_per_axis();
  int same = 0, all = 0;
  for (int slot = 0; slot < slots; ++slot) {
    for (int row = 0; row < display.emitter_rows(); ++row) {
      for (int column = 0; column < display.emitter_columns(); ++column) {
        const auto beam = map.BeamOf(slot, 1, column, row);
        const auto expected = design.BeamOf(slot, 1, column, row);
        ++all;
        if (!beam || !expected) {
          same += !beam && !expected ? 1 : 0;
          continue;
        }
        if (std::abs(beam->beam.x.element_mm - expected->x.element_mm) > 0.1 ||
            std::abs(beam->beam.y.element_mm - expected->y.element_mm) > 0.1) {
          continue;
        }
        ++same;
        ExpectSameBeam(beam->beam.x, expected->x);
        ExpectSameBeam(beam->beam.y, expected->y);
        EXPECT_NEAR(beam->z_mm, design.position_mm(), 1e-12);
      }
    }
  }
  EXPECT_GE(same, least_share * all) << same << " of " << all;
}

TEST(CalibratedMap, AsDesignedIsTheMapOfTheDesign) {
  for (const bool mirror_x : {false, true}) {
    ExpectAsDesigned(With(Barrier{6, 2, 3}, mirror_x), 0.999);
    // Towards the panel's sides the lens through which the viewer sees an emitter is beside the one
    // that lies over it, which the design's map takes.
    ExpectAsDesigned(With(Lenticular{4.5, 1.0 / 6, 9, 0, 0}, mirror_x), 0.85);
  }
  Display parallel = With(Barrier{6, 2, 3});
  parallel.shear = false;
  ExpectAsDesigned(parallel, 1);
  parallel = With(Lenticular{4.5, 1.0 / 6, 9, 0, 0});
  parallel.shear = false;
  ExpectAsDesigned(parallel, 1);
  Display binned = With(Barrier{5, 1, 5});
  binned.binning_px = 2;
  ExpectAsDesigned(binned, 0.999);
  for (const auto lattice : {LensletArray::Lattice::kSquare, LensletArray::Lattice::kHexagonal}) {
    ExpectAsDesigned(With(LensletArray{lattice, 13, 6, 0, 0, true, 0}), 0.94);
    ExpectAsDesigned(With(LensletArray{lattice, 12.7, 6, 0.3, 0.2, false, 4}), 0.94);
  }
}

TEST(CalibratedMap, SendsALensesLineThatMeetsItsEmitter) {
  for (const Optics& optics :
       {Optics(LensletArray{LensletArray::Lattice::kHexagonal, 13, 6, 0, 0, true, 0}),
        Optics(LensletArray{LensletArray::Lattice::kSquare, 13, 6, 0, 0, true, 0}),
        Optics(Lenticular{4.5, 1.0 / 6, 9, 0, 0})}) {
    const Display display = With(optics, true);
    const Calibration calibration = Misaligned(display, 21);
    const CalibratedMap map(display, calibration, 0);
    const LayerSights sights(calibration.layers[0]);
    const bool striped = std::holds_alternative<Lenticular>(optics);
    int lit = 0;
    for (int i = 0; i < 3 * 120 * 90; i += 11) {
      const int channel = i % 3, column = i / 3 % 120, row = i / 3 / 120;
      const auto beam = map.BeamOf(0, channel, column, row);
      if (!beam) continue;
      ++lit;
      const Vector2d emitter = FromLeft(calibration.layers[0].emitter, Met(sights, *beam).emitter);
      const double place = striped ? (2 - channel + 0.5) / 3 : 0.5;
      ASSERT_LT((emitter - Vector2d(column + place, row + 0.5)).norm(), 1e-6);
    }
    EXPECT_GT(lit, striped ? 2500 : 300);
  }
}

// The whole world in another frame: the pixels along a line of sight stay what they are.
TEST(LayerSights, DoNotDependOnTheFrameOfTheWorld) {
  const Display display = With(Barrier{6, 2, 3}, true);
  const Calibration calibration = Misaligned(display, 13);
  const Vector3d axis = Vector3d(0.3, -0.5, 0.8).normalized();
  const Rigid moved{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, axis)), {250, -120, 75}};
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const LayerCalibration& layer : calibration.layers) {
    LayerCalibration other = layer;
    other.display_from_stack = moved * layer.display_from_stack;
    other.plate->normal = moved.rotation * layer.plate->normal;
    const LayerSights sights(layer), others(other);
    for (int i = 0; i < 500; ++i) {
      const Vector3d eye(200 * number(random), 80 * number(random), 500);
      const Vector3d direction = Vector3d(20 * number(random), 15 * number(random), 0) - eye;
      const auto hit = sights.Seen(eye, direction);
      const auto same = others.Seen(moved * eye, moved.rotation * direction);
      ASSERT_TRUE(hit && same);
      EXPECT_LT((hit->emitter - same->emitter).norm(), 1e-9);
      EXPECT_LT((hit->modulator - same->modulator).norm(), 1e-9);
    }
  }
}

TEST(CheckCalibrates, SaysWhatIsOfAnotherDisplay) {
  const Display display = With(Barrier{6, 2, 3});
  const auto refusal = [&](const std::function<void(Calibration&)>& change) {
    Calibration calibration = DesignCalibration(display);
    change(calibration);
    try {
      CheckCalibrates(calibration, display, "its file");
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("its file"));
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal([](auto&) {}), "accepted");
  EXPECT_THAT(refusal([](auto& c) { c.display = "one"; }), HasSubstr("\"one\", not of \"two\""));
  EXPECT_THAT(refusal([](auto& c) { c.layers.pop_back(); }), HasSubstr("1 layers"));
  EXPECT_THAT(refusal([](auto& c) { c.layers[1].emitter.width_px = 119; }),
              HasSubstr("layer 1 has a panel of 119 x 90 px"));
  EXPECT_THAT(refusal([](auto& c) { c.layers[0].modulator->pitch_mm = 0.2; }),
              HasSubstr("pixels of 0.2 mm"));
  EXPECT_THAT(refusal([](auto& c) { c.layers[0].emitter.mirror_x = true; }), HasSubstr("mirrored"));
  EXPECT_THAT(refusal([](auto& c) { c.layers[0].modulator.reset(); }), HasSubstr("no modulator"));
  EXPECT_THAT(refusal([](auto& c) { std::swap(c.layers[0], c.layers[1]); }),
              HasSubstr("does not stand in front"));
  EXPECT_THAT(refusal([](auto& c) { c.layers[1].display_from_stack.translation.z() = 900; }),
              HasSubstr("behind the viewer"));
}

}  // namespace
}  // namespace lamella
