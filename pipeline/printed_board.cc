#include "pipeline/printed_board.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "lightfield/image.h"

namespace lamella {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;

// Rows that are alike as one rectangle for each run of black.
std::string Rectangles(const Image<Rgb8>& drawn, double points_per_px) {
  std::string text;
  for (int top = 0, bottom = 0; top < drawn.height(); top = bottom) {
    const Rgb8* row = drawn.row(top);
    for (bottom = top + 1; bottom < drawn.height(); ++bottom) {
      if (!std::equal(row, row + drawn.width(), drawn.row(bottom))) break;
    }
    for (int left = 0, right = 0; left < drawn.width(); left = right) {
      for (right = left + 1; right < drawn.width() && row[right] == row[left];) ++right;
      if (row[left].g != 0) continue;
      // Lengths count from the page's lower left corner.
      text += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", left * points_per_px,
                          (drawn.height() - bottom) * points_per_px, (right - left) * points_per_px,
                          (bottom - top) * points_per_px);
    }
  }
  return text + "f\n";
}

}  // namespace

std::string PdfOf(const PrintedBoard& printed) {
  const double points = printed.pitch_mm() * kPointsPerMm;  // per px of the drawing
  const Image<Rgb8> drawn = DrawBoard(printed.board);
  const std::string content = fmt::format(
      "{}BT /F1 8 Tf {:.2f} {:.2f} Td (Print at 100 %, do not fit to the page. The {} squares are "
      "{:g} mm wide together: measure them.) Tj ET\n",
      Rectangles(drawn, points), printed.board.left_px * points,
      0.4 * printed.board.top_px * points, printed.board.columns,
      printed.board.columns * printed.square_mm);
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R "
                  "/Resources << /Font << /F1 5 0 R >> >> >>",
                  drawn.width() * points, drawn.height() * points),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.4\n", places;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    places += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const std::size_t start = pdf.size();
  return pdf + fmt::format(
                   "xref\n0 {0}\n0000000000 65535 f \n{1}trailer\n<< /Size {0} /Root 1 0 R "
                   ">>\nstartxref\n{2}\n%%EOF\n",
                   objects.size() + 1, places, start);
}

}  // namespace lamella
