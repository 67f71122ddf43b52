// Where the shear of the fans steps by an emitter, no eye may see a dark line.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/simulate_eye.h"

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
  EXPECT_NEAR(box, 74.7, 0.1);
  for (int i = -16; i <= 16; ++i) {
    eye.position = {box * i / 16, 0, display.viewing_distance_mm};
    const EyePicture picture = SimulateEye(layers, display, eye);
    for (int x = 0; x < eye.width; ++x) {
      EXPECT_NEAR(picture.color(x, 1).g, 1, 1e-4) << "eye " << eye.position.x() << ", pixel " << x;
    }
  }
}

}  // namespace
}  // namespace lamella
