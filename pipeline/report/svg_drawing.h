// A drawing as SVG inside a page; its colours may be the page's (var(--ink)).
#pragma once

#include <string>

namespace lamella {

std::string EscapedHtml(const std::string& text);

// Lengths are the drawing's own units, x right, y down. A style is attributes as they stand in the
// file, a title what a mouse that rests there is told.
class SvgDrawing {
 public:
  SvgDrawing(double width, double height, const std::string& label);

  void Rectangle(double x, double y, double width, double height, const std::string& style,
                 const std::string& title = "");
  void Line(double from_x, double from_y, double to_x, double to_y, const std::string& style);
  void Circle(double x, double y, double radius, const std::string& style,
              const std::string& title = "");
  // Anchored at its "start", "middle" or "end".
  void Text(double x, double y, const char* anchor, const std::string& text);
  // A cell as dark as its share of what is allowed, in kSvgBeyond where that is above 1.
  void Cell(double x, double y, double width, double height, double share,
            const std::string& title);

  std::string Done() const;  // the whole element

 private:
  std::string svg_;
};

inline constexpr const char* kSvgBeyond = "#e08a1e";  // of what is more than allowed

}  // namespace lamella
