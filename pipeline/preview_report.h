// The preview's page: its pictures, and the words beside them (preview_tables.h).
#pragma once

#include <string>
#include <vector>

#include "distribute/emitter_strip.h"
#include "lightfield/image.h"
#include "lightfield/view.h"
#include "pipeline/layers_record.h"
#include "pipeline/preview_result.h"
#include "pipeline/report/preview_page.h"
#include "pipeline/stages.h"
#include "pipeline/workspace.h"

namespace lamella {

// The views whose photographs and depth are on the page, rising; and such a photograph as it is
// shown there.
std::vector<std::size_t> ViewsOnPage(const ViewSet& set, const std::string& reference);
Image<Rgb8> PhotographOnPage(ImageSpan<const Rgb> photograph, bool is_reference);

// The page but for its stages and warnings. `photographs`: of ViewsOnPage, in their order. Its
// eyes' pictures are made as small as the page's 20 MB ask for.
PreviewPage MakePreviewPage(const Workspace& workspace, const LayersRecord& record,
                            const ViewSet& set, const OpenEmitters& emitters,
                            const std::vector<Image<Rgb8>>& photographs,
                            const PreviewResult& result, const PreviewOptions& options);

}  // namespace lamella
