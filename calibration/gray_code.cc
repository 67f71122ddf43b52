#include "calibration/gray_code.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr double kLeastShare = 0.25;  // of white less black

int NumCells(int size_px, int cell_px) { return (size_px + cell_px - 1) / cell_px; }

int NumBits(int num_cells) {
  return std::max(1, static_cast<int>(std::bit_width(static_cast<unsigned>(num_cells - 1))));
}

unsigned GrayOf(unsigned cell) { return cell ^ (cell >> 1U); }

void CheckPhotos(const GrayCodeCapture& capture) {
  if (capture.width_px < 1 || capture.height_px < 1 || capture.cell_px < 1) {
    throw InputError("Gray code", "has no size", "give the projector's pixels");
  }
  if (capture.photos.size() != capture.NumPhotos()) {
    throw InputError(
        "Gray code",
        fmt::format("has {} photographs; {} x {} px in cells of {} need {}", capture.photos.size(),
                    capture.width_px, capture.height_px, capture.cell_px, capture.NumPhotos()),
        "give every pattern with its inverse, then white and black");
  }
  for (const auto& photo : capture.photos) {
    if (photo.width == capture.photos[0].width && photo.height == capture.photos[0].height)
      continue;
    throw InputError("Gray code", "has photographs of different sizes",
                     "take them with one camera, unturned and uncropped");
  }
}

// The cell that a pixel sees; nothing where a bit is not clear or there is no such cell.
std::optional<unsigned> CellAt(const GrayCodeCapture& capture, std::size_t first, int num_bits,
                               int num_cells, float least, int x, int y) {
  unsigned cell = 0, bit = 0;
  for (int i = 0; i < num_bits; ++i) {
    const std::size_t photo = first + 2 * static_cast<std::size_t>(i);
    const float difference = capture.photos[photo](x, y) - capture.photos[photo + 1](x, y);
    if (std::abs(difference) < least) return std::nullopt;
    bit ^= difference > 0 ? 1U : 0U;  // a bit of the cell is the parity of the code's so far
    cell = cell << 1U | bit;
  }
  return cell < static_cast<unsigned>(num_cells) ? std::optional(cell) : std::nullopt;
}

}  // namespace

int GrayCodeCapture::NumColumnBits() const { return NumBits(NumCells(width_px, cell_px)); }
int GrayCodeCapture::NumRowBits() const { return NumBits(NumCells(height_px, cell_px)); }
std::size_t GrayCodeCapture::NumPhotos() const {
  return 2 * static_cast<std::size_t>(NumColumnBits() + NumRowBits() + 1);
}

ScreenMap DecodeGrayCode(const GrayCodeCapture& capture, double least_contrast) {
  CheckPhotos(capture);
  const int columns = NumCells(capture.width_px, capture.cell_px);
  const int rows = NumCells(capture.height_px, capture.cell_px);
  const auto first_row = 2 * static_cast<std::size_t>(capture.NumColumnBits());
  const ImageSpan<const float> white = capture.photos[capture.photos.size() - 2];
  const ImageSpan<const float> black = capture.photos.back();
  const int width = white.width, height = white.height;
  const auto sigma = static_cast<float>(capture.cell_px / std::sqrt(12.0));
  ScreenMap map{{width, height},
                {width, height},
                {width, height, sigma},
                {width, height, sigma},
                {width, height}};
  const auto middle = [&](unsigned cell, int size_px) {
    const int begin = static_cast<int>(cell) * capture.cell_px;
    return static_cast<float>(begin + std::min(begin + capture.cell_px, size_px)) / 2;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float contrast = white(x, y) - black(x, y);
      if (static_cast<double>(contrast) < least_contrast) continue;
      const float least = static_cast<float>(kLeastShare) * contrast;
      const auto u = CellAt(capture, 0, capture.NumColumnBits(), columns, least, x, y);
      const auto v = CellAt(capture, first_row, capture.NumRowBits(), rows, least, x, y);
      if (!u || !v) continue;
      map.u_px(x, y) = middle(*u, capture.width_px);
      map.v_px(x, y) = middle(*v, capture.height_px);
      map.valid(x, y) = 1;
    }
  }
  return map;
}

Image<Rgb8> DrawGrayCode(const GrayCodeCapture& capture, std::size_t photo) {
  Image<Rgb8> image(capture.width_px, capture.height_px);
  const auto num_columns = 2 * static_cast<std::size_t>(capture.NumColumnBits());
  const auto num_bits = num_columns + 2 * static_cast<std::size_t>(capture.NumRowBits());
  for (int v = 0; v < capture.height_px; ++v) {
    for (int u = 0; u < capture.width_px; ++u) {
      bool white = photo == num_bits;
      if (photo < num_bits) {
        const bool is_column = photo < num_columns;
        const std::size_t index = (is_column ? photo : photo - num_columns) / 2;
        const int bits = is_column ? capture.NumColumnBits() : capture.NumRowBits();
        const auto cell = static_cast<unsigned>((is_column ? u : v) / capture.cell_px);
        const unsigned bit =
            GrayOf(cell) >> static_cast<unsigned>(bits - 1 - static_cast<int>(index)) & 1U;
        white = (bit == 1) != (photo % 2 == 1);
      }
      if (white) image(u, v) = {255, 255, 255};
    }
  }
  return image;
}

}  // namespace lamella
