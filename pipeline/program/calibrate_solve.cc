// lamella calibrate solve and report: a display's calibration from photographs, and what these are
// worth.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/calibration_measurement.h"
#include "pipeline/calibration_record.h"
#include "pipeline/calibration_report.h"
#include "pipeline/calibration_set_up.h"
#include "pipeline/program/calibrate.h"
#include "pipeline/report/calibration_page.h"
#include "pipeline/report/sheets_page.h"
#include "pipeline/report/varifocal_page.h"
#include "pipeline/solve_photos.h"
#include "pipeline/solve_sheets.h"
#include "pipeline/solve_varifocal.h"

namespace lamella {
namespace {

struct SolveArguments {
  SolvePhotosOptions options;
  std::filesystem::path out;
  std::filesystem::path cameras;  // of lens sheets and varifocal displays
  std::optional<double> camera_sd_mm;
  double board_square_mm = 0;
};

// What the photographs give, of any kind of display.
struct SolvedDisplay {
  std::string text, page;
  std::vector<Weakness> failures;  // where not empty the calibration is not to be used
  Calibration calibration;
  CalibrationMeasurement measurement;
};

void AddSolveOptions(CLI::App& verb, SolveArguments& arguments) {
  verb.add_option("DIR", arguments.options.patterns, "folder that `calibrate patterns` wrote")
      ->required();
  verb.add_option("PHOTOS", arguments.options.photos,
                  "folder of the photographs, of one camera; their names sort as they were taken")
      ->required();
  verb.add_option("--display", arguments.options.display,
                  "preset or file of the display as designed [the patterns' own]");
  verb.add_option("--focal-px", arguments.options.focal_px, "the camera's, roughly [found]")
      ->check(CLI::PositiveNumber);
  verb.add_option(
      "--cameras", arguments.cameras,
      "of lens sheets and varifocal displays: transforms.json in the display's frame (mm), a "
      "frame for every position, named as one of its photographs [the printed board tells]");
  verb.add_option("--camera-sd-mm", arguments.camera_sd_mm,
                  "of lens sheets: how well each coordinate of a camera's position is known [0.3]")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--board-square-mm", arguments.board_square_mm,
                  "side of the printed board's squares, as measured [as drawn]")
      ->check(CLI::PositiveNumber);
}

// Options of cameras that the printed board tells, where --cameras has them, and the reverse.
void CheckCameraOptions(const SolveArguments& arguments) {
  if (arguments.cameras.empty()) {
    if (!arguments.camera_sd_mm) return;
    throw UsageError("--camera-sd-mm", "has no use here: it is of --cameras, which is not given",
                     "leave it out");
  }
  if (arguments.options.focal_px <= 0 && arguments.board_square_mm <= 0) return;
  throw UsageError(arguments.options.focal_px > 0 ? "--focal-px" : "--board-square-mm",
                   "has no use here: the lenses' cameras are those of --cameras", "leave it out");
}

void RefuseCameras(const SolveArguments& arguments) {
  const char* given = !arguments.cameras.empty()      ? "--cameras"
                      : arguments.camera_sd_mm        ? "--camera-sd-mm"
                      : arguments.board_square_mm > 0 ? "--board-square-mm"
                                                      : nullptr;
  if (given == nullptr) return;
  throw UsageError(given, "is of displays with lenses, which this one has none of",
                   "leave it out: where the camera stood is found from the panels' boards");
}

SolvedDisplay SolveDisplayOfPanels(const SolveArguments& arguments, Progress& progress) {
  RefuseCameras(arguments);
  const SolvedPhotos solved = SolvePhotos(arguments.options, progress);
  return {DescribeCalibration(solved), CalibrationPage(solved), solved.report.failures,
          solved.report.calibration, MeasurementOf(solved)};
}

SolvedDisplay SolveDisplayOfSheets(const SolveArguments& arguments, Progress& progress) {
  CheckCameraOptions(arguments);
  SolveSheetsOptions options{arguments.options.patterns, arguments.options.photos,
                             arguments.options.display, arguments.cameras};
  options.camera_sd_mm = arguments.camera_sd_mm.value_or(options.camera_sd_mm);
  options.board_square_mm = arguments.board_square_mm;
  options.focal_px = arguments.options.focal_px;
  const SolvedSheets solved = SolveSheets(options, progress);
  return {DescribeSheets(solved), SheetsPage(solved), solved.failures(), solved.calibration,
          MeasurementOf(solved)};
}

SolvedDisplay SolveVarifocalDisplay(const SolveArguments& arguments, Progress& progress) {
  CheckCameraOptions(arguments);
  if (arguments.camera_sd_mm) {
    throw UsageError("--camera-sd-mm", "is of lens sheets: here --cameras are taken as exact",
                     "leave it out");
  }
  const SolvedVarifocal solved = SolveVarifocalPhotos(
      {arguments.options, arguments.cameras, arguments.board_square_mm}, progress);
  return {DescribeVarifocal(solved), VarifocalPage(solved), solved.report.failures,
          solved.report.calibration, MeasurementOf(solved)};
}

SolvedDisplay SolveAnyDisplay(const SolveArguments& arguments, Progress& progress) {
  const SolvePhotosOptions& options = arguments.options;
  if (LoadCalibrationSetUp(options.patterns, options.display).display.varifocal) {
    return SolveVarifocalDisplay(arguments, progress);
  }
  return HasLensSheets(options.patterns, options.display)
             ? SolveDisplayOfSheets(arguments, progress)
             : SolveDisplayOfPanels(arguments, progress);
}

ExitCode CodeOf(const std::vector<Weakness>& failures, const std::string& not_written) {
  if (failures.empty()) return ExitCode::kDone;
  const Weakness& first = failures.front();
  fmt::print(stderr, "lamella: {}: {}; {}\n", not_written, first.lost, first.cure);
  return ExitCode::kGate;
}

// The calibration is written where it is certain enough, its reports in any case.
ExitCode RunSolve(const SolveArguments& arguments, Progress& progress) {
  const std::filesystem::path& out = arguments.out;
  std::filesystem::path text_file = out, page_file = out;
  text_file.replace_extension(".report.txt");
  page_file.replace_extension(".report.html");
  for (const auto& file : {out, text_file, page_file}) CheckWritable(file);
  const SolvedDisplay solved = SolveAnyDisplay(arguments, progress);
  fmt::print("{}", solved.text);
  WriteTextAtomically(text_file, solved.text);
  WriteTextAtomically(page_file, solved.page);
  if (solved.failures.empty()) {
    SaveCalibration(out, solved.calibration, {solved.measurement, {}});
  }
  return CodeOf(solved.failures, out.string() + " was not written");
}

ExitCode RunReport(const SolveArguments& arguments, Progress& progress) {
  CheckWritable(arguments.out);
  const SolvedDisplay solved = SolveAnyDisplay(arguments, progress);
  WriteTextAtomically(arguments.out, solved.page);
  fmt::print("{}\n", arguments.out.string());
  return CodeOf(solved.failures, arguments.options.photos.string());
}

}  // namespace

void AddCalibrateSolve(CLI::App& calibrate, Invocation& invocation) {
  CLI::App& verb = *calibrate.add_subcommand(
      "solve", "the display's calibration from the photographs, and how certain it is");
  auto arguments = std::make_shared<SolveArguments>();
  AddSolveOptions(verb, *arguments);
  verb.add_option("--out", arguments->out, "calibration.json to write; its reports lie beside it")
      ->required();
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Beside FILE.json lie FILE.report.txt and FILE.report.html: what is known how well, what was "
      "left\nout, and which photographs would help. The exit code is 4 where rays are not known to "
      "0.03 px RMS\nand 0.1 px at worst, or something is lost: then only the reports are "
      "written.\n"
      "Lens sheets must be known to 0.02 px at the panel's edges, a varifocal display's planes to "
      "0.03 mm\nin depth and 1e-4 in magnification, as two standard deviations; the printed "
      "board\ntells where the cameras stood, or --cameras does.\n\n"
      "Example\n"
      "  lamella calibrate solve patterns taken/images --out calibration.json\n"
      "  lamella calibrate solve patterns photos --board-square-mm 19.96 --out calibration.json\n"
      "      a display with a lens sheet, a printed board beside it");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) { return RunSolve(*arguments, progress); };
  });
}

void AddCalibrateReport(CLI::App& calibrate, Invocation& invocation) {
  CLI::App& verb = *calibrate.add_subcommand(
      "report", "a page of what the photographs are worth and what to photograph next");
  auto arguments = std::make_shared<SolveArguments>();
  AddSolveOptions(verb, *arguments);
  verb.add_option("--out", arguments->out, "page (HTML) to write")->required();
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "The page that `calibrate solve` writes beside its calibration, of any kind of display, "
      "alone; the\nsame options and exit codes.\n\n"
      "Example\n"
      "  lamella calibrate report patterns taken/images --out report.html\n"
      "  lamella calibrate report patterns photos --board-square-mm 19.96 --out report.html");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) { return RunReport(*arguments, progress); };
  });
}

}  // namespace lamella
