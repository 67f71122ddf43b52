// lamella synth photos: virtual photographs of a display.
#include "pipeline/synth_photos.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "pipeline/program/command_line.h"
#include "pipeline/program/synth.h"

namespace lamella {
namespace {

struct PhotosArguments {
  SynthPhotosOptions options;
  std::string out;
  OptionFlags flags;
};

}  // namespace

void AddSynthPhotos(CLI::App& synth, Invocation& invocation) {
  CLI::App& verb = *synth.add_subcommand(
      "photos", "what a camera photographs of a display, with the display's truth beside it");
  auto arguments = std::make_shared<PhotosArguments>();
  verb.add_option("--out", arguments->out,
                  "folder to write images/, calibration.json, transforms.json, photos.json to")
      ->required();
  arguments->flags.Add(verb, {Describe(arguments->options)});
  AddGlobalOptions(verb, invocation);
  verb.footer(
      "Examples: what the display of a workspace shows to two eyes (= before a minus sign)\n"
      "  lamella synth photos --frames W/frames --eyes='-32,0,600;32,0,600' --out photos\n"
      "a misaligned display shows patterns (docs/formats.md, shots) to 12 noisy cameras\n"
      "  lamella synth photos --misalignment true.json --shots shots.json --views 12 \\\n"
      "      --full-well-e 20000 --read-noise-e 4 --bits 12 --curve linear --out photos");
  verb.callback([arguments, &invocation] {
    invocation.action = [arguments](Progress& progress) {
      arguments->flags.Apply({Describe(arguments->options)});
      const int photos = SynthPhotos(arguments->options, arguments->out, progress);
      fmt::print("{} photographs in {}/images, truth beside them\n", photos, arguments->out);
      return ExitCode::kDone;
    };
  });
}

}  // namespace lamella
