#include "pipeline/report/page_parts.h"

#include <string_view>

#include <fmt/format.h>

#include "pipeline/report/page_embedded.h"
#include "pipeline/report/svg_drawing.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

std::string TableCell(const char* kind, bool words, const std::string& text) {
  return fmt::format("<{0}{1}>{2}</{0}>", kind, words ? " class=\"words\"" : "", EscapedHtml(text));
}

std::string TableRow(const char* kind, const std::vector<std::string>& cells, LastColumn last) {
  std::string row = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    row += TableCell(kind, last == LastColumn::kWords && i + 1 == cells.size(), cells[i]);
  }
  return row + "</tr>\n";
}

}  // namespace

std::string PageSection(const std::string& title, const std::string& content) {
  return fmt::format("<section class=\"card\">\n<h2>{}</h2>\n{}</section>\n", EscapedHtml(title),
                     content);
}

std::string PageNote(const std::string& text) {
  return fmt::format("<p class=\"muted\">{}</p>\n", EscapedHtml(text));
}

std::string PageDrawings(const std::vector<CaptionedDrawing>& drawings) {
  std::string html = "<div class=\"figures\">\n";
  for (const CaptionedDrawing& drawing : drawings) {
    html += fmt::format("<figure><figcaption>{}</figcaption>\n{}</figure>\n",
                        EscapedHtml(drawing.caption), drawing.svg);
  }
  return html + "</div>\n";
}

std::string HtmlTable(const std::vector<std::string>& columns,
                      const std::vector<std::vector<std::string>>& rows, LastColumn last) {
  std::string html = "<div class=\"scroll\"><table>\n" + TableRow("th", columns, last);
  for (const std::vector<std::string>& row : rows) html += TableRow("td", row, last);
  return html + "</table></div>\n";
}

std::string PageVerdict(bool accepted,
                        const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html = fmt::format(
      "<section class=\"card verdict{}\">\n<p><strong>{}</strong></p>\n<dl>\n",
      accepted ? "" : " open",
      accepted ? "Certain enough for a calibration." : "Not certain enough for a calibration.");
  for (const auto& [name, value] : facts) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", EscapedHtml(name), EscapedHtml(value));
  }
  return html + "</dl>\n</section>\n";
}

std::string PageWeaknesses(const std::string& title, const std::vector<Weakness>& weaknesses) {
  if (weaknesses.empty()) return "";
  std::string list = "<ul>\n";
  for (const Weakness& weakness : weaknesses) {
    list += fmt::format("<li>{}. <strong>Cure:</strong> {}.</li>\n", EscapedHtml(weakness.lost),
                        EscapedHtml(weakness.cure));
  }
  return PageSection(title, list + "</ul>\n");
}

std::string PageLines(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string list = "<ul>\n";
  for (const std::string& line : lines) list += "<li>" + EscapedHtml(line) + "</li>\n";
  return PageSection(title, list + "</ul>\n");
}

std::string PageGroups(const std::string& title, const std::vector<GroupVerdict>& groups) {
  if (groups.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const GroupVerdict& verdict : groups) {
    rows.push_back({verdict.group, verdict.freed ? "freed" : "as designed", verdict.reason});
  }
  return PageSection(title, HtmlTable({"parameters", "", "why"}, rows, LastColumn::kWords));
}

std::string CalibrationHtml(const std::string& display, std::size_t num_photos,
                            const std::string& body) {
  const std::pair<std::string_view, std::string> parts[] = {
      {"@STYLE@", std::string(kPageStyle)},
      {"@TITLE@", EscapedHtml(fmt::format("{} from {} photographs", display, num_photos))},
      {"@BODY@", body},
      {"@FOOT@", fmt::format("Made by lamella {}. This file needs no network.", ProgramVersion())}};
  std::string html;
  std::string_view rest = kCalibrationTemplate;
  for (const auto& [mark, text] : parts) {  // in the template's order
    const std::size_t at = rest.find(mark);
    html.append(rest.substr(0, at)).append(text);
    rest.remove_prefix(at + mark.size());
  }
  return html.append(rest);
}

}  // namespace lamella
