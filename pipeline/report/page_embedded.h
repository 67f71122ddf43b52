// The pages' templates, style and script as text; page_embedded.cc is made by CMake.
#pragma once

#include <string_view>

namespace lamella {

extern const std::string_view kPageTemplate, kPageStyle, kPageScript, kCalibrationTemplate;

}  // namespace lamella
