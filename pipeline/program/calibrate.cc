// lamella calibrate: the patterns that a display shows, and photographs of them.
#include "pipeline/program/calibrate.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/check_photos.h"
#include "pipeline/measure_photometry.h"
#include "pipeline/program/command_line.h"

namespace lamella {
namespace {

CalibrationMode ModeOf(const std::string& name) {
  if (name == "photometry") return CalibrationMode::kPhotometry;
  return name == "quick" ? CalibrationMode::kQuick : CalibrationMode::kPrecise;
}

bool HasLenses(const Calibration& design) {
  return std::any_of(design.layers.begin(), design.layers.end(),
                     [](const LayerCalibration& layer) { return layer.lattice.has_value(); });
}

// Lenses hide boards on panels.
bool NeedsPrintedBoard(const Calibration& design, CalibrationMode mode) {
  return mode == CalibrationMode::kPrecise &&
         std::all_of(design.layers.begin(), design.layers.end(),
                     [](const LayerCalibration& layer) { return layer.lattice.has_value(); });
}

void AddPatterns(CLI::App& calibrate, Invocation& invocation) {
  struct Arguments {
    std::string display, out, mode = "quick";
    bool no_board = false;
  };
  CLI::App& verb = *calibrate.add_subcommand(
      "patterns", "what the display shows while it is photographed, and the list of the shots");
  auto arguments = std::make_shared<Arguments>();
  verb.add_option("DISPLAY", arguments->display, "preset or file")->required();
  verb.add_option("--out", arguments->out, "folder to write to")->required();
  verb.add_option("--mode", arguments->mode,
                  "quick: a board of markers per panel; precise: sinusoids as well; photometry: "
                  "levels, colours and lines, for `calibrate photometry` [quick]")
      ->check(CLI::IsMember({"quick", "precise", "photometry"}));
  verb.add_flag("--no-board", arguments->no_board,
                "of displays with lenses: no printed board; --cameras is given to solve");
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Writes the panels' images (PNG), shots.txt (how to photograph them), shots.json (what "
      "every\n"
      "panel shows in every shot, also for `lamella synth photos`), patterns.json and "
      "display.toml.\nOf displays with lenses, which hide boards on panels, also "
      "printed_board.pdf: a board of markers to\nprint and to fix to the display's frame, by which "
      "the cameras are found.\n\n"
      "Examples: patterns, virtual photographs of them, and what these are worth\n"
      "  lamella calibrate patterns paper-two-layer --out patterns\n"
      "  lamella synth photos --display paper-two-layer --shots patterns/shots.json --views 12 \\\n"
      "      --out taken\n"
      "  lamella calibrate check patterns taken/images");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      const Display display = FindDisplay(arguments->display);
      const Calibration design = DesignCalibration(display);
      if (arguments->no_board && !HasLenses(design)) {
        throw UsageError("--no-board", "is of displays with lenses, which this one has none of",
                         "leave it out: where the camera stood is found from the panels' boards");
      }
      ShotList list = PlanShots(design, ModeOf(arguments->mode), display.varifocal.has_value());
      if (NeedsPrintedBoard(design, list.mode) && !arguments->no_board) {
        list = WithPrintedBoard(std::move(list));
      }
      WritePatterns(arguments->out, list, progress);
      WriteTextAtomically(std::filesystem::path(arguments->out) / kPatternsDisplay,
                          ToToml(display));
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
  int alone = 0;
  for (int view = 0; view < checked.num_views; ++view) {
    if (IsOfBoardAlone(checked.list, checked.photos, view)) ++alone;
  }
  fmt::print("{} positions of {} shots{}, {}\n", checked.num_views - alone,
             checked.list.shots.size(),
             alone > 0 ? fmt::format(" and {} of the printed board alone", alone) : "",
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

struct PhotometryArguments {
  MeasurePhotometryOptions options;
  std::string curve = "linear";
  std::filesystem::path out;
};

// What was not measured again stays as it was known; `of` tells what a number is of.
template <class Measured, class Of>
std::vector<Measured> Renewed(std::vector<Measured> known, const std::vector<Measured>& measured,
                              Of Measured::*of) {
  for (const Measured& now : measured) {
    const auto same = std::find_if(known.begin(), known.end(),
                                   [&](const Measured& old) { return old.*of == now.*of; });
    if (same == known.end()) {
      known.push_back(now);
    } else {
      *same = now;
    }
  }
  return known;
}

ExitCode RunPhotometry(PhotometryArguments arguments, Progress& progress) {
  const std::filesystem::path& out = arguments.out;
  std::filesystem::path text_file = out;
  text_file.replace_extension(".photometry.txt");
  for (const auto& file : {out, text_file}) CheckWritable(file);
  if (arguments.curve == "srgb") arguments.options.curve = PhotoCurve::kSrgb;
  if (arguments.curve == "estimate") arguments.options.curve = PhotoCurve::kEstimated;
  const MeasuredPhotometry measured = MeasurePhotometry(arguments.options, progress);
  std::string text;
  for (const std::string& line : measured.lines) text += line + "\n";
  for (const std::string& line : measured.warnings) text += "note: " + line + "\n";
  fmt::print("{}", text);
  WriteTextAtomically(text_file, text);
  const std::filesystem::path& given = arguments.options.calibration;
  if (given.empty()) {
    SaveCalibration(out, measured.calibration,
                    {std::nullopt, measured.deviations, measured.crosstalk});
  } else {
    SaveCalibration(
        out, measured.calibration,
        {LoadMeasurement(given),
         Renewed(LoadLightDeviations(given), measured.deviations, &ParameterDeviation::name),
         Renewed(LoadCrosstalk(given), measured.crosstalk, &MeasuredCrosstalk::layer)});
  }
  return ExitCode::kDone;
}

void AddPhotometry(CLI::App& calibrate, Invocation& invocation) {
  CLI::App& verb = *calibrate.add_subcommand(
      "photometry",
      "the panels' response, black, colours, fall-off and crosstalk from photographs");
  auto arguments = std::make_shared<PhotometryArguments>();
  MeasurePhotometryOptions& options = arguments->options;
  verb.add_option("DIR", options.patterns,
                  "folder that `calibrate patterns --mode photometry` wrote")
      ->required();
  verb.add_option("PHOTOS", options.photos,
                  "folder of the photographs, of one camera; their names sort as they were taken")
      ->required();
  verb.add_option("--calibration", options.calibration,
                  "calibration.json to take the geometry from [the display as designed]");
  verb.add_option("--out", arguments->out,
                  "calibration.json to write; FILE.photometry.txt lies beside it")
      ->required();
  verb.add_option("--curve", arguments->curve,
                  "of the numbers of integer files: linear, srgb, or estimate: from the exposures, "
                  "the only one for 8 bits [linear]; EXR is linear")
      ->check(CLI::IsMember({"linear", "srgb", "estimate"}));
  verb.add_option("--focal-px", options.focal_px, "the camera's focal length, roughly [found]")
      ->check(CLI::PositiveNumber);
  verb.add_option(
          "--pupil-mm", options.pupil_mm,
          "diameter of the camera's entrance pupil, its focal length by its f-number; it is "
          "taken out of the crosstalk [0]")
      ->check(CLI::NonNegativeNumber);
  verb.add_option(
          "--pupil-sd", options.pupil_sd,
          "how well that is known: a standard deviation, a share of it, of which the crosstalk's "
          "are made; f-numbers are rounded to about this [0.02]")
      ->check(CLI::Range(0.0, 1.0));
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Photographs are linear: raw files developed without a tone curve to 16-bit TIFF or PNG, or\n"
      "EXR; 8-bit files need --curve estimate. shots.txt of DIR says what to photograph.\n\n"
      "Example: a virtual display measured, its frames for what its panels really show\n"
      "  lamella calibrate patterns paper-two-layer --mode photometry --out light\n"
      "  lamella synth photos --misalignment true.json --shots light/shots.json --views 4 \\\n"
      "      --curve linear --bits 16 --exposure 1.6 --out lit\n"
      "  lamella calibrate photometry light lit/images --calibration calibration.json \\\n"
      "      --out lit.json\n"
      "  lamella run PHOTOS --display paper-two-layer --calibration lit.json");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      return RunPhotometry(*arguments, progress);
    };
  });
}

}  // namespace

void AddCalibrate(CLI::App& program, Invocation& invocation) {
  CLI::App& app = *program.add_subcommand(
      "calibrate", "aligns a display by photographs of patterns that it shows");
  app.require_subcommand(1);
  AddPatterns(app, invocation);
  AddCheck(app, invocation);
  AddCalibrateSolve(app, invocation);
  AddCalibrateReport(app, invocation);
  AddPhotometry(app, invocation);
  AddGrayCodePatterns(app, invocation);
  AddGrayCode(app, invocation);
  AddWarp(app, invocation);
}

}  // namespace lamella
