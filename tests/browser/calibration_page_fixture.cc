// Writes the pages of two calibrations of a known display: calibration_page_fixture GOOD.html
// OPEN.html
//
// The first is of 12 views and certain; the second of 4 frontal ones, which leave much open.
#include <string>

#include "lightfield/atomic_file.h"
#include "pipeline/report/calibration_page.h"
#include "tests/calibration/standard_scene.h"

namespace lamella {
namespace {

SolvedPhotos Solved(const SceneOptions& options) {
  const StandardScene scene = MakeStandardScene(options);
  SolvedPhotos solved;
  solved.display.name = "standard <b>display</b>";
  const Observations observations = Noisy(scene.exact, 0.05, 4);
  solved.report = Calibrate(observations, scene.design);
  solved.left_out = {"<i>7.png</i>: take again: no board is seen"};
  for (const PanelPhoto& photo : observations.photos) solved.photos.push_back({photo.photo, ""});
  return solved;
}

}  // namespace
}  // namespace lamella

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  lamella::SceneOptions options;
  options.bow_mm = 0.1;
  lamella::WriteTextAtomically(argv[1], lamella::CalibrationPage(lamella::Solved(options)));
  options.num_views = 4;
  options.yaw_deg = options.pitch_deg = 0;
  lamella::WriteTextAtomically(argv[2], lamella::CalibrationPage(lamella::Solved(options)));
}
