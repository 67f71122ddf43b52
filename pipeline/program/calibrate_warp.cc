// lamella calibrate warp: a ready picture for a bare panel, for where the panel really stands.
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "distribute/displays.h"
#include "distribute/emitter_frame.h"
#include "distribute/warp_frame.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/calibration_record.h"
#include "pipeline/program/calibrate.h"

namespace lamella {
namespace {

struct WarpArguments {
  std::filesystem::path picture, calibration, out;
  std::string display;
  int layer = 0;
  std::optional<std::array<double, 3>> eye_mm;
};

ExitCode RunWarp(const WarpArguments& arguments) {
  if (arguments.out.extension() != ".png") {
    throw UsageError(arguments.out.string(), "is no .png",
                     "frames are final codes, written as PNG");
  }
  CheckWritable(arguments.out);
  const Display display = FindDisplay(arguments.display);
  if (arguments.layer >= static_cast<int>(display.layers.size())) {
    throw UsageError(
        "--layer",
        fmt::format("{} of a display of {} layers", arguments.layer, display.layers.size()),
        "0 is the layer at the back");
  }
  const Calibration calibration = LoadCalibration(arguments.calibration);
  const std::array<double, 3> eye =
      arguments.eye_mm.value_or(std::array{0.0, 0.0, display.viewing_distance_mm});
  const EmitterImage shown = WarpToPanel(ReadImage(arguments.picture), display, calibration,
                                         arguments.layer, {eye[0], eye[1], eye[2]});
  double covered = 0;
  for (std::size_t i = 0; i < shown.coverage.size(); ++i) {
    covered += static_cast<double>(shown.coverage.data()[i]);
  }
  const PanelResponse response = PanelResponse::Of(calibration, arguments.layer);
  WriteCodes8(arguments.out, EmitterFrame(shown, display, arguments.layer, response).span());
  fmt::print("{:.1f} % of the panel shows the picture\n{}\n",
             100 * covered / static_cast<double>(shown.coverage.size()), arguments.out.string());
  return ExitCode::kDone;
}

}  // namespace

void AddWarp(CLI::App& calibrate, Invocation& invocation) {
  CLI::App& verb = *calibrate.add_subcommand(
      "warp", "a ready picture for a bare panel, for where the panel really stands");
  auto arguments = std::make_shared<WarpArguments>();
  verb.add_option("PICTURE", arguments->picture,
                  "as the panel as designed should show it, seen from the front: a pixel for every "
                  "emitter")
      ->required();
  verb.add_option("--display", arguments->display, "a preset's name or a file")->required();
  verb.add_option("--calibration", arguments->calibration, "calibration.json of the display")
      ->required();
  verb.add_option("--layer", arguments->layer, "whose panel; 0 is at the back [0]")
      ->check(CLI::Range(0, 1023));
  verb.add_option("--eye-mm", arguments->eye_mm,
                  "X,Y,Z of the eye that sees it in its place [0,0,viewing distance]")
      ->delimiter(',');
  verb.add_option("--out", arguments->out, "frame to write, a PNG for the panel")->required();
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "For pictures that come from elsewhere, and layers without barrier or lenses "
      "([layer.bare]):\n"
      "from a capture `lamella run --calibration` renders what the panels really show, and "
      "nothing\n"
      "is resampled. Turned and shifted in linear light; the panel's response is applied last, "
      "and\n"
      "a mirrored layer's frame is flipped. Emitters that look beside the picture stay black.\n\n"
      "Example\n"
      "  lamella calibrate warp back.png --display depth-fused --calibration calibration.json \\\n"
      "      --layer 0 --out back_panel.png");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress&) { return RunWarp(*arguments); };
  });
}

}  // namespace lamella
