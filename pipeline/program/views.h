// Plain functions of the verbs `lamella views` and `lamella compare images`.
#pragma once

#include <filesystem>

#include "lightfield/error.h"
#include "lightfield/progress.h"
#include "pipeline/compare_images.h"
#include "pipeline/render_views.h"

namespace lamella {

// Renders, and prints a line a view and the means.
ExitCode RunViews(const ViewsArguments& arguments, Progress& progress);

ExitCode RunCompareImages(const std::filesystem::path& a, const std::filesystem::path& b,
                          const CompareImagesOptions& options);

}  // namespace lamella
