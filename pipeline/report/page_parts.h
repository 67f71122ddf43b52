// What the pages of calibrations are made of: HTML of their verdict, sections, tables and lists.
// Text is escaped here, so that names of files are only text.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "calibration/calibrate.h"

namespace lamella {

std::string PageSection(const std::string& title, const std::string& content);
std::string PageNote(const std::string& text);
// Drawings with their captions, side by side where there is room.
struct CaptionedDrawing {
  std::string caption, svg;
};
std::string PageDrawings(const std::vector<CaptionedDrawing>& drawings);

enum class LastColumn { kNumbers, kWords };
std::string HtmlTable(const std::vector<std::string>& columns,
                      const std::vector<std::vector<std::string>>& rows,
                      LastColumn last = LastColumn::kNumbers);

// Facts are names and values.
std::string PageVerdict(bool accepted,
                        const std::vector<std::pair<std::string, std::string>>& facts);
// "" where there are none.
std::string PageWeaknesses(const std::string& title, const std::vector<Weakness>& weaknesses);
std::string PageLines(const std::string& title, const std::vector<std::string>& lines);
std::string PageGroups(const std::string& title, const std::vector<GroupVerdict>& groups);

// The whole file, of sections.
std::string CalibrationHtml(const std::string& display, std::size_t num_photos,
                            const std::string& body);

}  // namespace lamella
