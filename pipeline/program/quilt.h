// What the files of `lamella quilt` share.
#pragma once

#include "pipeline/program/command_line.h"

namespace lamella {

// Adds its verb to `lamella quilt`.
void AddRenderQuilt(CLI::App& quilt, Invocation& invocation);

}  // namespace lamella
