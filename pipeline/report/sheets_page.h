// The page of a calibration of lens sheets: what the lenses are known to, where on their panels,
// and which photographs would tell more.
#pragma once

#include <string>

#include "pipeline/solve_sheets.h"

namespace lamella {

std::string SheetsPage(const SolvedSheets& solved);

}  // namespace lamella
