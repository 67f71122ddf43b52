// The page of a varifocal display's calibration: what its planes are known to and where they stand,
// and what photographs would tell more.
#pragma once

#include <string>

#include "pipeline/solve_varifocal.h"

namespace lamella {

std::string VarifocalPage(const SolvedVarifocal& solved);

}  // namespace lamella
