#include "pipeline/report/svg_drawing.h"

#include <fmt/format.h>

namespace lamella {
namespace {

std::string TitleElement(const std::string& title) {
  return title.empty() ? "" : "<title>" + EscapedHtml(title) + "</title>";
}

}  // namespace

std::string EscapedHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

SvgDrawing::SvgDrawing(double width, double height, const std::string& label)
    : svg_(fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n", width,
                       height, EscapedHtml(label))) {}

void SvgDrawing::Rectangle(double x, double y, double width, double height,
                           const std::string& style, const std::string& title) {
  svg_ += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}>{}</rect>\n", x, y,
      width, height, style, TitleElement(title));
}

void SvgDrawing::Line(double from_x, double from_y, double to_x, double to_y,
                      const std::string& style) {
  svg_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n",
                      from_x, from_y, to_x, to_y, style);
}

void SvgDrawing::Circle(double x, double y, double radius, const std::string& style,
                        const std::string& title) {
  svg_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" {}>{}</circle>\n", x, y,
                      radius, style, TitleElement(title));
}

void SvgDrawing::Text(double x, double y, const char* anchor, const std::string& text) {
  svg_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y,
                      anchor, EscapedHtml(text));
}

void SvgDrawing::Cell(double x, double y, double width, double height, double share,
                      const std::string& title) {
  const bool beyond = share > 1;
  Rectangle(x, y, width, height,
            fmt::format("fill=\"{}\" fill-opacity=\"{:.2f}\" stroke=\"var(--line)\"",
                        beyond ? kSvgBeyond : "var(--accent)", beyond ? 0.5 : 0.05 + 0.55 * share),
            title);
}

std::string SvgDrawing::Done() const { return svg_ + "</svg>\n"; }

}  // namespace lamella
