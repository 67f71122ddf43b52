// What the preview's page says in words and numbers: facts of the display and the scene, tables of
// the eyes.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lightfield/display.h"
#include "pipeline/layers_record.h"
#include "pipeline/preview_result.h"
#include "pipeline/report/preview_page.h"
#include "pipeline/stages.h"

namespace lamella {

// "+35.2": with its sign and to a tenth.
std::string Millimetres(double value);

// "35.2", "equal" or "no pixels".
std::string Decibels(const std::optional<double>& value);

// What eyes beyond the display's clean eye box see: "light of neighbouring windows".
std::string BeyondEyeBox(const Display& display);

// "-10.0, +10.0 mm"; of many layers the first and the last: "-10.0 to +10.0 mm".
std::string ListOfLayers(const Display& display);

// Names and values.
std::vector<std::pair<std::string, std::string>> PreviewFacts(const LayersRecord& record,
                                                              const PreviewResult& result,
                                                              const PreviewOptions& options);

// Of the means, the artefacts and all eyes but the grid's, whose figures stand beside their
// pictures.
std::vector<PageTable> PreviewTables(const PreviewResult& result);

}  // namespace lamella
