#include "lightfield/looking_glass.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// Which cell a pixel has; y counts from the bottom. Ports disagree about 2 and 4: this is the
// shipped shader's (displays.md section 4).
std::size_t CellOf(int pattern, int x, int y) {
  switch (pattern) {
    case 1:
      return static_cast<std::size_t>((x + y) % 2);
    case 2:
      return static_cast<std::size_t>(x % 2);
    case 3:
      return static_cast<std::size_t>((y + 2 * (x % 2)) % 4);
    case 4:
      return static_cast<std::size_t>(y % 2);
    default:
      return 0;
  }
}

}  // namespace

LookingGlassWeave WeaveOf(const LookingGlass& c) {
  const double sign = c.flip_x ? -1 : 1;
  return {c.pitch_per_in * c.width_px / c.dpi * std::cos(std::atan(1 / c.slope)),
          sign * c.height_px / (c.width_px * c.slope), sign / (3.0 * c.width_px)};
}

double LookingGlassView(const LookingGlass& c, int column, int row, int channel) {
  return LookingGlassView(c, WeaveOf(c), column, row, channel);
}

double LookingGlassView(const LookingGlass& c, const LookingGlassWeave& weave, int column, int row,
                        int channel) {
  const int from_bottom = c.height_px - 1 - row;
  double u = (column + 0.5) / c.width_px, v = (from_bottom + 0.5) / c.height_px;
  if (c.cells.empty()) {
    // From the pixel's centre: `center` absorbs the third of a pixel.
    u += (c.flip_subpixels ? 2 - channel : channel) * weave.subpixel;
  } else {
    const std::size_t cell = CellOf(c.cell_pattern, column, from_bottom) % c.cells.size();
    const auto& [right, up] = c.cells[cell][static_cast<std::size_t>(channel)];
    u += right / c.width_px;
    v += up / c.height_px;
  }
  const double phase = (u + v * weave.tilt) * weave.lenses - c.center;
  const double share = phase - std::floor(phase);
  return c.invert_views ? 1 - share : share;
}

int ViewIndex(double view, int views) {
  return std::min(static_cast<int>(view * views), views - 1);
}

}  // namespace lamella
