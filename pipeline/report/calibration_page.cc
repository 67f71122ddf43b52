#include "pipeline/report/calibration_page.h"

#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pipeline/calibration_report.h"
#include "pipeline/report/calibration_figures.h"
#include "pipeline/report/page_embedded.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

std::string Section(const std::string& title, const std::string& content) {
  return fmt::format("<section class=\"card\">\n<h2>{}</h2>\n{}</section>\n", EscapedHtml(title),
                     content);
}

std::string Note(const std::string& text) {
  return fmt::format("<p class=\"muted\">{}</p>\n", EscapedHtml(text));
}

std::string Figure(const std::string& caption, const std::string& svg) {
  return fmt::format("<figure><figcaption>{}</figcaption>\n{}</figure>\n", EscapedHtml(caption),
                     svg);
}

// A third and last column holds words.
std::string Table(const std::vector<std::string>& columns,
                  const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"scroll\"><table>\n<tr>";
  const auto cell = [](const char* kind, bool words, const std::string& text) {
    return fmt::format("<{0}{1}>{2}</{0}>", kind, words ? " class=\"words\"" : "",
                       EscapedHtml(text));
  };
  const auto words = [](std::size_t i, std::size_t count) { return i > 1 && i + 1 == count; };
  for (std::size_t i = 0; i < columns.size(); ++i) {
    html += cell("th", words(i, columns.size()), columns[i]);
  }
  html += "</tr>\n";
  for (const std::vector<std::string>& row : rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      html += cell("td", words(i, row.size()), row[i]);
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string Verdict(const CalibrationReport& report) {
  std::string words = report.accepted() ? "Certain enough: the calibration was written."
                                        : "Not certain: there is no calibration, only this report.";
  std::string html = fmt::format("<section class=\"card verdict{}\">\n<p><strong>{}</strong></p>\n",
                                 report.accepted() ? "" : " open", words);
  html += "<dl>\n";
  const auto fact = [&](const char* name, const std::string& value) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, EscapedHtml(value));
  };
  if (report.rays.sd_px.empty()) {
    fact("Rays", "no number: some parameters are unknown");
  } else {
    fact("Rays are known to",
         fmt::format("{:.4f} px RMS ({} asked for), {:.4f} px at worst ({} asked for)",
                     report.rays.rms_sd_px, report.limits.largest_ray_rms_px, report.rays.max_sd_px,
                     report.limits.largest_ray_max_px));
  }
  fact("Chi squared per degree of freedom", fmt::format("{:.3f}", report.chi2));
  fact("Photographs of one position shift by", fmt::format("{:.4f} px", report.slip_px));
  fact("The unit of length is the pitch of", NameOf(report.reference));
  return html + "</dl>\n</section>\n";
}

std::string Weaknesses(const std::string& title, const std::vector<Weakness>& weaknesses) {
  if (weaknesses.empty()) return "";
  std::string list = "<ul>\n";
  for (const Weakness& weakness : weaknesses) {
    list += fmt::format("<li>{}. <strong>Cure:</strong> {}.</li>\n", EscapedHtml(weakness.lost),
                        EscapedHtml(weakness.cure));
  }
  return Section(title, list + "</ul>\n");
}

std::string Lines(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string list = "<ul>\n";
  for (const std::string& line : lines) list += "<li>" + EscapedHtml(line) + "</li>\n";
  return Section(title, list + "</ul>\n");
}

std::string RayErrors(const CalibrationReport& report) {
  if (report.rays.sd_px.empty()) return "";
  std::string figures = "<div class=\"figures\">\n";
  for (const ResidualMap& map : report.residuals) {
    if (map.panel == report.reference) continue;
    figures +=
        Figure(NameOf(map.panel), RayFigure(report, map.panel, report.limits.largest_ray_rms_px));
  }
  const EyeBox& box = report.limits.eye_box;
  return Section(
      "How well rays are known",
      Note(fmt::format(
          "Standard deviation, px of each panel, of the pixel that an eye sees behind "
          "or before a place of {} (as seen from the front); RMS over eyes within {:.0f} "
          "x {:.0f} mm, {:.0f} to {:.0f} mm away. Orange: more than is asked for.",
          NameOf(report.reference), 2 * box.half_width_mm, 2 * box.half_height_mm, box.near_mm,
          box.far_mm)) +
          figures + "</div>\n");
}

std::string Residuals(const CalibrationReport& report) {
  std::string figures = "<div class=\"figures\">\n";
  for (const ResidualMap& map : report.residuals) {
    figures += Figure(fmt::format("{}, in {} views", NameOf(map.panel), map.views.size()),
                      ResidualFigure(map));
  }
  return Section(
      "Where points were seen, and where they should have been",
      Note(
          "Each panel as it is given its image. Numbers, and darker cells: points. Lines: the mean "
          "of seen minus predicted, in the panel's pixels; 0.03 px would reach nearly to the "
          "cell's "
          "edge, and more is orange. Means that follow a pattern are a shape that is not "
          "modelled.") +
          figures + "</div>\n");
}

std::string Views(const CalibrationReport& report) {
  std::string note =
      "Left: cameras by their number, in degrees from the normal of the reference panel; dashed: "
      "where eyes are; orange ring: ";
  const std::string next = DescribeNextView(report);
  note += next.empty() ? "none, no place shows all panels at once."
                       : "the photographs that would help most, " + next + ".";
  return Section("Camera positions",
                 Note(note) + "<div class=\"figures\">\n" +
                     Figure("Directions", DirectionFigure(report)) +
                     Figure("Chi squared of views", Chi2Figure(report.views_fit)) +
                     Figure("Chi squared of panels", Chi2Figure(report.panels)) + "</div>\n");
}

std::string Parameters(const CalibrationReport& report) {
  std::vector<std::vector<std::string>> groups, deviations;
  for (const GroupVerdict& verdict : report.groups) {
    groups.push_back({verdict.group, verdict.freed ? "freed" : "as designed", verdict.reason});
  }
  for (const ParameterDeviation& deviation : report.deviations) {
    deviations.push_back({deviation.name, fmt::format("{:.3g} {}", deviation.sd, deviation.unit)});
  }
  std::string html =
      Section("Parameters beyond poses and gaps", Table({"parameters", "", "why"}, groups));
  if (deviations.empty()) return html;
  return html + Section("Standard deviations", Table({"parameter", "deviation"}, deviations));
}

}  // namespace

std::string CalibrationPage(const SolvedPhotos& solved) {
  const CalibrationReport& report = solved.report;
  const std::string body =
      Verdict(report) + Weaknesses("What the photographs leave open", report.failures) +
      Weaknesses("What is weak", report.warnings) + Views(report) + RayErrors(report) +
      Residuals(report) + Lines("Left out", solved.left_out) +
      Lines("Used, though better ones would help", solved.doubtful) + Parameters(report);
  const std::pair<std::string_view, std::string> parts[] = {
      {"@STYLE@", std::string(kPageStyle)},
      {"@TITLE@", EscapedHtml(fmt::format("{} from {} photographs", solved.display.name,
                                          solved.photos.size()))},
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
