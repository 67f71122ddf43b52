// The cut-off over depth as a picture (SVG), with a scene's depth histogram under it.
#pragma once

#include <optional>
#include <string>

#include "pipeline/analysis_record.h"

namespace lamella {

// A standalone SVG of 640 units' width; it scales, and its text is readable from 360 px on.
std::string AnalysisFigure(const Display& display, const Analysis& analysis,
                           const std::optional<SceneAnalysis>& scene);

}  // namespace lamella
