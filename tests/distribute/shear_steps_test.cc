// Where the shear of the fans steps by an emitter, no eye may see a dark line.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"
#include "tests/reference/analytic_scene.h"

namespace lamella {
namespace {

class WhiteWall final : public RaySource {  // on z = 0
 public:
  void Query(const RayBundle& /*bundle*/, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    for (int y = 0; y < rectangle.height; ++y) {
      std::fill_n(samples.row(y), rectangle.width, RaySample{{1, 1, 1}, 0, 1, 1});
    }
  }
};

TEST(ShearSteps, LeaveNoDarkLinesWithinTheEyeBoxWidenedByHalfAStep) {
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 960;  // 300 mm: four steps to each side of the middle
  display.height_px = 60;
  const LayerImages layers = Distribute(WhiteWall(), display, {}, SilentProgress());
  Eye eye;
  eye.pixel_mm = 6 * display.pitch_mm;  // a period: each pixel has the display's mean brightness
  eye.width = 120;
  eye.height = 3;
  eye.left_mm = -eye.width * eye.pixel_mm / 2;
  eye.top_mm = eye.height * eye.pixel_mm / 2;
  const double half_step =
      0.5 * display.pitch_mm * display.viewing_distance_mm / display.layers[0].d0_mm;
  const double box = CleanEyeBox(display) + half_step;
  EXPECT_NEAR(box, 73.8, 0.1);
  for (int i = -16; i <= 16; ++i) {
    eye.position = {box * i / 16, 0, display.viewing_distance_mm};
    const EyePicture picture = SimulateEye(layers, display, eye);
    for (int x = 0; x < eye.width; ++x) {
      EXPECT_NEAR(picture.color(x, 1).g, 1, 1e-4) << "eye " << eye.position.x() << ", pixel " << x;
    }
  }
}

// What the middle eye sees of a smooth ramp before the display, less the ramp: mm by which the
// picture is displaced, along a row.
std::vector<double> DisplacementOfARamp(const char* directions) {
  constexpr double kZ = 40, kPerMm = 0.003;
  Display display = FindDisplay("paper-two-layer");
  display.width_px = 960;
  display.height_px = 36;
  AnalyticScene scene;
  scene.rectangles = {{kZ, -1e9, 1e9, -1e9, 1e9, [](double x, double) {
                         const float value = static_cast<float>(0.5 + kPerMm * x);
                         return Rgb{value, value, value};
                       }}};
  LayersOptions options;
  options.directions = directions;
  options.nodes_per_step = 4;
  const LayerImages layers = Distribute(scene, display, options, SilentProgress());
  Eye eye;
  eye.position = {0, 0, display.viewing_distance_mm};
  eye.pixel_mm = 6 * display.pitch_mm;  // a period: openings are not seen one by one
  eye.width = 130;
  eye.height = 1;
  eye.left_mm = -eye.width * eye.pixel_mm / 2;
  eye.top_mm = eye.pixel_mm / 2;
  const EyePicture picture = SimulateEye(layers, display, eye);
  std::vector<double> displacement;
  for (int i = 0; i < eye.width; ++i) {
    const double x = eye.left_mm + (i + 0.5) * eye.pixel_mm;
    const double at_plane = x * (1 - kZ / display.viewing_distance_mm);
    displacement.push_back((static_cast<double>(picture.color(i, 0).g) - 0.5) / kPerMm - at_plane);
  }
  return displacement;
}

// The paper renders what an unrounded window would send. Then the picture of something far from a
// layer is displaced by up to half an emitter's parallax, which jumps where the rounding steps.
TEST(ShearSteps, BandThePictureWhereTheirRoundingIsNotRendered) {
  const auto largest = [](const std::vector<double>& displacement) {
    double most = 0;
    for (const double d : displacement) most = std::max(most, std::abs(d));
    return most;
  };
  const auto largest_jump = [](const std::vector<double>& displacement) {
    double most = 0;
    for (std::size_t i = 1; i < displacement.size(); ++i) {
      most = std::max(most, std::abs(displacement[i] - displacement[i - 1]));
    }
    return most;
  };
  const std::vector<double> real = DisplacementOfARamp("true"),
                            ideal = DisplacementOfARamp("ideal");
  // 30 mm before the front layer, d0 = 5 mm: half an emitter is 0.934 mm.
  EXPECT_LT(largest(real), 0.2);
  EXPECT_NEAR(largest(ideal), 0.934, 0.2);
  EXPECT_LT(largest_jump(real), 0.15);
  EXPECT_GT(largest_jump(ideal), 1);
}

}  // namespace
}  // namespace lamella
