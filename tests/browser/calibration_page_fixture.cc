// Writes the pages of calibrations whose truth is known: calibration_page_fixture FOLDER
//
//   panels-good, -open      12 views; 4 frontal ones, which leave much open
//   sheets-good, -open      two positions far apart and a printed board; one position
//   varifocal-good, -open   24 planes from 12 positions; from 3 that are near one another
#include <filesystem>
#include <string>
#include <vector>

#include "lightfield/atomic_file.h"
#include "pipeline/report/calibration_page.h"
#include "pipeline/report/sheets_page.h"
#include "pipeline/report/varifocal_page.h"
#include "tests/calibration/sheet_scene.h"
#include "tests/calibration/standard_scene.h"
#include "tests/calibration/varifocal_scene.h"

namespace lamella {
namespace {

constexpr const char* kLeftOut = "<i>7.png</i>: take again: no board is seen";

SolvedPhotos PanelsOfScene(const SceneOptions& options) {
  const StandardScene scene = MakeStandardScene(options);
  SolvedPhotos solved;
  solved.display.name = "standard <b>display</b>";
  const Observations observations = Noisy(scene.exact, 0.05, 4);
  solved.report = Calibrate(observations, scene.design);
  solved.left_out = {kLeftOut};
  for (const PanelPhoto& photo : observations.photos) solved.photos.push_back({photo.photo, ""});
  return solved;
}

Display SheetDisplay() {
  Display display;
  display.name = "a <b>sheet</b>";
  display.width_px = kSheetWidth;
  display.height_px = kSheetHeight;
  display.pitch_mm = kSheetPixel;
  Layer layer;
  layer.d0_mm = 0.9;
  layer.optics = Lenticular{17, 0.14, 8};
  display.layers = {layer};
  return display;
}

SolvedSheets SheetOfScene(const std::vector<Eigen::Vector3d>& eyes, bool by_board) {
  const Sheet sheet;
  const LatticeOptions options = SheetViewers();
  SolvedSheets solved;
  solved.display = SheetDisplay();
  solved.eye_box = options.eye_box;
  SolvedSheet of;
  of.num_views = static_cast<int>(eyes.size());
  of.eyes_mm = eyes;
  for (int i = 0; i < of.num_views; ++i) of.positions.push_back(2 * i);
  of.report = EstimateLattice(PhotographSheet(sheet, eyes, 30000, {0.4, 0, 0.1, 0.02}, 3),
                              WrongDesign(sheet, 1), options);
  solved.sheets = {of};
  if (by_board) {
    BoardOfSheets board;
    board.cameras.views = {0, 1, 2, 3};
    board.cameras.num_corners = 960;
    board.cameras.num_used = 953;
    board.cameras.rms_px = 0.11;
    board.cameras.found.camera.fx = 3301.4;
    board.cameras.focal_sd_px = 2.3;
    for (const Eigen::Vector3d& at :
         {eyes[0], Eigen::Vector3d(-300, 40, 420), eyes[1], Eigen::Vector3d(60, 320, 400)}) {
      board.cameras.found.camera_from_board.push_back({Eigen::Quaterniond::Identity(), -at});
    }
    solved.board = board;
  }
  solved.left_out = {kLeftOut};
  solved.photos.resize(27 * eyes.size());
  return solved;
}

SolvedVarifocal PlanesOfScene(int num_views, double angle_deg) {
  VarifocalSceneOptions options;
  options.num_views = num_views;
  options.angle_deg = angle_deg;
  options.num_sheet_views = 2;
  const VarifocalScene scene = MakeVarifocalScene(options);
  SolvedVarifocal solved;
  solved.display = scene.display;
  CalibrateVarifocalOptions calibrate;
  calibrate.display_from_frame = scene.display_from_frame;
  solved.report = CalibrateVarifocal(scene.observations, scene.display, calibrate);
  solved.left_out = {kLeftOut};
  solved.photos.resize(scene.observations.photos.size());
  return solved;
}

}  // namespace
}  // namespace lamella

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  const auto write = [&](const char* name, const std::string& page) {
    lamella::WriteTextAtomically(folder / name, page);
  };
  lamella::SceneOptions options;
  options.bow_mm = 0.1;
  write("panels-good.html", lamella::CalibrationPage(lamella::PanelsOfScene(options)));
  options.num_views = 4;
  options.yaw_deg = options.pitch_deg = 0;
  write("panels-open.html", lamella::CalibrationPage(lamella::PanelsOfScene(options)));
  write("sheets-good.html", lamella::SheetsPage(lamella::SheetOfScene(lamella::TwoEyes(), true)));
  write("sheets-open.html", lamella::SheetsPage(lamella::SheetOfScene({{90, 60, 500}}, false)));
  write("varifocal-good.html", lamella::VarifocalPage(lamella::PlanesOfScene(12, 9)));
  write("varifocal-open.html", lamella::VarifocalPage(lamella::PlanesOfScene(3, 2)));
}
