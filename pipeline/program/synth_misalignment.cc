// lamella synth misalignment: a display as it might have been built.
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "datasets_synthetic/misalign.h"
#include "distribute/displays.h"
#include "pipeline/calibration_record.h"
#include "pipeline/program/synth.h"

namespace lamella {
namespace {

struct MisalignmentArguments {
  std::string display, out;
  Misalignment by;
  std::pair<double, double> gap_mm{0, 0};
  std::uint32_t seed = 1;
};

}  // namespace

void AddSynthMisalignment(CLI::App& synth, Invocation& invocation) {
  CLI::App& verb = *synth.add_subcommand(
      "misalignment", "a display with every panel off its place, for virtual photographs of it");
  auto arguments = std::make_shared<MisalignmentArguments>();
  Misalignment& by = arguments->by;
  verb.add_option("DISPLAY", arguments->display, "preset or file")->required();
  verb.add_option("--out", arguments->out, "calibration.json to write: the truth")->required();
  verb.add_option("--seed", arguments->seed, "of the deviations [1]");
  verb.add_option("--shift-mm", by.shift_mm, "largest, of stacks and of emitters in them [20]");
  verb.add_option("--turn-deg", by.turn_deg, "largest, of stacks and of emitters in them [5]");
  verb.add_option("--scale", by.scale,
                  "largest, of every panel but the reference, of every varifocal plane [0.005]");
  verb.add_option("--gap-mm", arguments->gap_mm, "LOW HIGH: gaps between these [as designed]");
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Example: a prototype, and photographs of what it shows\n"
      "  lamella synth misalignment paper-two-layer --seed 7 --gap-mm 3 10 --out truth.json\n"
      "  lamella synth photos --misalignment truth.json --shots patterns/shots.json --views 12 \\\n"
      "      --out taken\n"
      "Planes of a varifocal display must keep their order: give --shift-mm less than half of "
      "their\n"
      "distance, and --turn-deg so small that their sides do not meet.");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress&) {
      std::tie(arguments->by.least_gap_mm, arguments->by.most_gap_mm) = arguments->gap_mm;
      const Display display = FindDisplay(arguments->display);
      SaveCalibration(arguments->out, Misaligned(DesignCalibration(display), arguments->by,
                                                 arguments->seed, display.varifocal.has_value()));
      fmt::print("{}\n", arguments->out);
      return ExitCode::kDone;
    };
  });
}

}  // namespace lamella
