// What `lamella analyze` prints.
#pragma once

#include <optional>
#include <string>

#include "pipeline/analysis_record.h"

namespace lamella {

std::string AnalysisTable(const Display& display, const Analysis& analysis,
                          const std::optional<SceneAnalysis>& scene);

}  // namespace lamella
