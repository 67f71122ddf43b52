// metrics.json (docs/formats.md): the preview's figures for programs.
#pragma once

#include <string>

#include "pipeline/preview_result.h"
#include "pipeline/stages.h"

namespace lamella {

// The JSON's text; null where a figure has no number or its pictures are equal.
std::string MetricsJson(const PreviewResult& result, const PreviewOptions& options);

}  // namespace lamella
