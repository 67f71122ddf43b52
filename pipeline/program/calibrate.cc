// lamella calibrate: the patterns that a display shows, and photographs of them.
#include "calibration/calibrate.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/calibration_report.h"
#include "pipeline/check_photos.h"
#include "pipeline/observe_photos.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

void AddPatterns(CLI::App& calibrate, Invocation& invocation) {
  struct Arguments {
    std::string display, out, mode = "quick";
  };
  CLI::App& verb = *calibrate.add_subcommand(
      "patterns", "what the display shows while it is photographed, and the list of the shots");
  auto arguments = std::make_shared<Arguments>();
  verb.add_option("DISPLAY", arguments->display, "preset or file")->required();
  verb.add_option("--out", arguments->out, "folder to write to")->required();
  verb.add_option("--mode", arguments->mode,
                  "quick: a board of markers per panel; precise: sinusoids as well [quick]")
      ->check(CLI::IsMember({"quick", "precise"}));
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Writes the panels' images (PNG), shots.txt (how to photograph them), shots.json (what "
      "every\n"
      "panel shows in every shot, also for `lamella synth photos`) and patterns.json.\n\n"
      "Examples: patterns, virtual photographs of them, and what these are worth\n"
      "  lamella calibrate patterns paper-two-layer --out patterns\n"
      "  lamella synth photos --display paper-two-layer --shots patterns/shots.json --views 12 \\\n"
      "      --out taken\n"
      "  lamella calibrate check patterns taken/images");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      const ShotList list = PlanShots(
          DesignCalibration(FindDisplay(arguments->display)),
          arguments->mode == "quick" ? CalibrationMode::kQuick : CalibrationMode::kPrecise);
      WritePatterns(arguments->out, list, progress);
      fmt::print("{} shots of {} panels; read {}/shots.txt\n", list.shots.size(),
                 list.panels.size(), arguments->out);
      return ExitCode::kDone;
    };
  });
}

ExitCode RunCheck(const std::string& patterns, const std::string& photos, Progress& progress) {
  const CheckedPhotos checked = CheckPhotos(
      patterns, photos,
      [](const CheckedPhoto& photo, const std::string& shot) {
        fmt::print("{}: position {}, {}: {}\n", photo.photo, photo.view + 1,
                   shot.empty() ? "unknown" : shot, photo.verdict);
        std::fflush(stdout);
      },
      progress);
  for (const std::string& line : checked.missing) fmt::print("{}\n", line);
  if (!checked.missing.empty()) return ExitCode::kInput;
  const bool all_good = std::all_of(checked.photos.begin(), checked.photos.end(),
                                    [](const CheckedPhoto& photo) { return photo.good; });
  fmt::print("{} positions of {} shots, {}\n", checked.num_views, checked.list.shots.size(),
             all_good ? "all good" : "complete; leave out what is no shot of the list");
  return all_good ? ExitCode::kDone : ExitCode::kInput;
}

void AddCheck(CLI::App& calibrate, Invocation& invocation) {
  struct Arguments {
    std::string patterns, photos;
  };
  CLI::App& verb = *calibrate.add_subcommand(
      "check", "are the photographs good? one line for each says which shot it is and what to do");
  auto arguments = std::make_shared<Arguments>();
  verb.add_option("DIR", arguments->patterns, "folder that `calibrate patterns` wrote")->required();
  verb.add_option("PHOTOS", arguments->photos,
                  "folder of the photographs so far; their names sort as they were taken")
      ->required();
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "The exit code is 0 where every shot of every camera position is there and good, else 3.\n"
      "A shot that has to be taken again may follow at any time before the camera is moved.");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      return RunCheck(arguments->patterns, arguments->photos, progress);
    };
  });
}

struct SolveArguments {
  std::string patterns, photos, display, out;
  double focal_px = 0;
};

// The calibration is written where it is certain enough, its report in any case.
ExitCode RunSolve(const SolveArguments& arguments, Progress& progress) {
  const std::filesystem::path out = arguments.out;
  const CheckedPhotos checked = CheckPhotos(
      arguments.patterns, arguments.photos, [](const CheckedPhoto&, const std::string&) {},
      progress);
  Observations observations = ObservePhotos(checked, arguments.photos, progress);
  for (PhotoCamera& camera : observations.cameras) camera.focal_px = arguments.focal_px;
  const std::string& display = arguments.display.empty() ? checked.list.display : arguments.display;
  const CalibrationReport report = Calibrate(observations, DesignCalibration(FindDisplay(display)));
  const std::string text = DescribeCalibration(report);
  fmt::print("{}", text);
  std::filesystem::path report_file = out;
  WriteTextAtomically(report_file.replace_extension(".report.txt"), text);
  if (!report.accepted()) {
    fmt::print(stderr, "lamella: {}: not written, {}; {}\n", out.string(),
               report.failures.front().lost, report.failures.front().cure);
    return ExitCode::kGate;
  }
  SaveCalibration(out, report.calibration);
  return ExitCode::kDone;
}

void AddSolve(CLI::App& calibrate, Invocation& invocation) {
  CLI::App& verb = *calibrate.add_subcommand(
      "solve", "the display's calibration from the photographs, and how certain it is");
  auto arguments = std::make_shared<SolveArguments>();
  verb.add_option("DIR", arguments->patterns, "folder that `calibrate patterns` wrote")->required();
  verb.add_option("PHOTOS", arguments->photos, "folder of the photographs, of one camera")
      ->required();
  verb.add_option("--out", arguments->out, "calibration.json to write; its report lies beside it")
      ->required();
  verb.add_option("--display", arguments->display,
                  "preset or file of the display as designed [the patterns' own]");
  verb.add_option("--focal-px", arguments->focal_px, "the camera's, roughly [found]")
      ->check(CLI::PositiveNumber);
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "The exit code is 4 where rays are not known to 0.03 px RMS and 0.1 px at worst, or "
      "something "
      "is\nlost: then only the report is written. It names the photographs that would help.\n\n"
      "Example\n"
      "  lamella calibrate solve patterns taken/images --out calibration.json");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) { return RunSolve(*arguments, progress); };
  });
}

}  // namespace

void AddCalibrate(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "calibrate", "aligns a display by photographs of patterns that it shows");
  app.require_subcommand(1);
  AddPatterns(app, invocation);
  AddCheck(app, invocation);
  AddSolve(app, invocation);
}

}  // namespace lamella
