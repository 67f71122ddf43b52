// lamella synth: generated captures with exact truth.
#include "pipeline/program/synth.h"

#include <CLI/CLI.hpp>

namespace lamella {

void AddSynth(CLI::App& program, Invocation& invocation) {
  CLI::App& synth =
      *program.add_subcommand("synth", "generated captures and layers with exact truth");
  synth.require_subcommand(1);
  AddSynthScene(synth, invocation);
  AddSynthLayers(synth, invocation);
  AddSynthMisalignment(synth, invocation);
  AddSynthPhotos(synth, invocation);
}

}  // namespace lamella
