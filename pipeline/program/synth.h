// The verbs of `lamella synth`, one file each.
#pragma once

#include "pipeline/program/command_line.h"

namespace lamella {

void AddSynthScene(CLI::App& synth, Invocation& invocation);
void AddSynthLayers(CLI::App& synth, Invocation& invocation);
void AddSynthMisalignment(CLI::App& synth, Invocation& invocation);
void AddSynthPhotos(CLI::App& synth, Invocation& invocation);

}  // namespace lamella
