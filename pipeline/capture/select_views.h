// `--views NAME|GLOB|!NAME,...`: a part of a capture.
#pragma once

#include <string>
#include <vector>

namespace lamella {

// Which of the names the patterns choose, separated by commas: all that one without '!' meets (all
// names where every pattern has a '!'), less those that one with '!' meets. UsageError, with the
// nearest name, where a pattern meets no name, and where nothing is left.
std::vector<bool> SelectViews(const std::vector<std::string>& names, const std::string& patterns);

}  // namespace lamella
