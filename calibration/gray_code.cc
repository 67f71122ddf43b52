#include "calibration/gray_code.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr double kLeastShare = 0.25;  // of white less black

int NumCells(int size_px, int cell_px) { return (size_px + cell_px - 1) / cell_px; }

int NumBits(int num_cells) {
  return std::max(1, static_cast<int>(std::bit_width(static_cast<unsigned>(num_cells - 1))));
}

unsigned GrayOf(unsigned cell) { return cell ^ (cell >> 1U); }

void CheckSameSize(const Image<float>& a, int width, int height) {
  if (a.width() == width && a.height() == height) return;
  throw InputError("Gray code", "has photographs of different sizes",
                   "take them with one camera, unturned and uncropped");
}

// By how much a bit must differ from its inverse; infinite in pixels without contrast.
Image<float> LeastDifference(const Image<float>& white, const Image<float>& black,
                             double least_contrast) {
  CheckSameSize(black, white.width(), white.height());
  Image<float> least(white.width(), white.height());
  for (std::size_t i = 0; i < least.size(); ++i) {
    const double contrast =
        static_cast<double>(white.data()[i]) - static_cast<double>(black.data()[i]);
    least.data()[i] = contrast >= least_contrast ? static_cast<float>(kLeastShare * contrast)
                                                 : std::numeric_limits<float>::infinity();
  }
  return least;
}

// Takes the next bit into the cells; -1 where one was not clear.
void AddBit(const Image<float>& pattern, const Image<float>& inverse, const Image<float>& least,
            Image<std::int32_t>& cells) {
  CheckSameSize(pattern, cells.width(), cells.height());
  CheckSameSize(inverse, cells.width(), cells.height());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const float difference = pattern.data()[i] - inverse.data()[i];
    std::int32_t& cell = cells.data()[i];
    if (!(std::abs(difference) >= least.data()[i])) {
      cell = -1;
    } else if (cell >= 0) {
      // A bit of the cell is the parity of the code's so far.
      cell = 2 * cell + ((cell % 2 == 1) != (difference > 0) ? 1 : 0);
    }
  }
}

// The middles of cells and their standard deviations, px; the last cell may be a narrower one.
void FillAxis(const Image<std::int32_t>& cells, int size_px, int cell_px, Image<float>& middle,
              Image<float>& sigma, Image<std::uint8_t>& valid) {
  const int num_cells = NumCells(size_px, cell_px);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::int32_t cell = cells.data()[i];
    if (cell < 0 || cell >= num_cells) {
      valid.data()[i] = 0;
      continue;
    }
    const int begin = cell * cell_px, end = std::min(begin + cell_px, size_px);
    middle.data()[i] = static_cast<float>(begin + end) / 2;
    sigma.data()[i] = static_cast<float>((end - begin) / std::sqrt(12.0));
  }
}

struct CellSteps {
  std::int64_t all = 0, back = 0;
  double ShareBack() const {
    return all > 0 ? static_cast<double>(back) / static_cast<double>(all) : 0;
  }
};

// From cell to cell of the valid pixels of all rows, or of all columns.
CellSteps StepsAlong(const Image<float>& position, const Image<std::uint8_t>& valid, bool rows) {
  CellSteps steps;
  const int lines = rows ? valid.height() : valid.width();
  const int length = rows ? valid.width() : valid.height();
  for (int line = 0; line < lines; ++line) {
    float last = 0;
    int direction = 0;  // of the last step
    for (int i = 0; i < length; ++i) {
      const int x = rows ? i : line, y = rows ? line : i;
      if (valid(x, y) == 0 || position(x, y) == last) continue;
      if (last > 0) {
        const int step = position(x, y) > last ? 1 : -1;
        if (direction != 0) ++steps.all;
        if (direction == -step) ++steps.back;
        direction = step;
      }
      last = position(x, y);
    }
  }
  return steps;
}

// Along the lines that meet more cells: those nearly along a border of cells go to and fro over it.
double ShareBack(const Image<float>& position, const Image<std::uint8_t>& valid) {
  const CellSteps rows = StepsAlong(position, valid, true);
  const CellSteps columns = StepsAlong(position, valid, false);
  return (rows.all > columns.all ? rows : columns).ShareBack();
}

}  // namespace

int GrayCodePatterns::NumColumnBits() const { return NumBits(NumCells(width_px, cell_px)); }
int GrayCodePatterns::NumRowBits() const { return NumBits(NumCells(height_px, cell_px)); }
std::size_t GrayCodePatterns::Count() const {
  return 2 * static_cast<std::size_t>(NumColumnBits() + NumRowBits() + 1);
}

ScreenMap DecodeGrayCode(const GrayCodePatterns& patterns,
                         const std::function<Image<float>(std::size_t)>& photo,
                         double least_contrast) {
  if (patterns.width_px < 1 || patterns.height_px < 1 || patterns.cell_px < 1) {
    throw InputError("Gray code", "has no size", "give the projector's pixels");
  }
  const std::size_t count = patterns.Count();
  const Image<float> least = [&] {
    const Image<float> white = photo(count - 2);
    return LeastDifference(white, photo(count - 1), least_contrast);
  }();
  const int width = least.width(), height = least.height();
  const auto cells_of = [&](std::size_t first, int num_bits) {
    Image<std::int32_t> cells(width, height);
    for (std::size_t i = first; i < first + 2 * static_cast<std::size_t>(num_bits); i += 2) {
      const Image<float> pattern = photo(i);
      AddBit(pattern, photo(i + 1), least, cells);
    }
    return cells;
  };
  const Image<std::int32_t> columns = cells_of(0, patterns.NumColumnBits());
  const Image<std::int32_t> rows =
      cells_of(2 * static_cast<std::size_t>(patterns.NumColumnBits()), patterns.NumRowBits());
  ScreenMap map{
      {width, height}, {width, height}, {width, height}, {width, height}, {width, height, 1}};
  FillAxis(columns, patterns.width_px, patterns.cell_px, map.u_px, map.sigma_u, map.valid);
  FillAxis(rows, patterns.height_px, patterns.cell_px, map.v_px, map.sigma_v, map.valid);
  return map;
}

double ShareOfStepsBack(const ScreenMap& map) {
  return std::max(ShareBack(map.u_px, map.valid), ShareBack(map.v_px, map.valid));
}

Image<Rgb8> DrawGrayCode(const GrayCodePatterns& patterns, std::size_t i) {
  Image<Rgb8> image(patterns.width_px, patterns.height_px);
  const auto num_columns = 2 * static_cast<std::size_t>(patterns.NumColumnBits());
  const auto num_bits = num_columns + 2 * static_cast<std::size_t>(patterns.NumRowBits());
  for (int v = 0; v < patterns.height_px; ++v) {
    for (int u = 0; u < patterns.width_px; ++u) {
      bool white = i == num_bits;
      if (i < num_bits) {
        const bool is_column = i < num_columns;
        const std::size_t index = (is_column ? i : i - num_columns) / 2;
        const int bits = is_column ? patterns.NumColumnBits() : patterns.NumRowBits();
        const auto cell = static_cast<unsigned>((is_column ? u : v) / patterns.cell_px);
        const unsigned bit =
            GrayOf(cell) >> static_cast<unsigned>(bits - 1 - static_cast<int>(index)) & 1U;
        white = (bit == 1) != (i % 2 == 1);
      }
      if (white) image(u, v) = {255, 255, 255};
    }
  }
  return image;
}

}  // namespace lamella
