// The view of a sub-pixel by geometry alone, in long double: where it lies on the panel in inches
// from the bottom left corner, and how many lenses lie between, measured across them.
#pragma once

#include <cmath>

#include "lightfield/looking_glass.h"

namespace lamella {

// In [0, 1]. `from_bottom` counts rows upwards.
inline long double ReferenceView(const LookingGlass& c, int column, int from_bottom, int channel) {
  using Long = long double;
  const Long mirror = c.flip_x ? -1 : 1;
  Long right = column + Long(0.5), up = from_bottom + Long(0.5);
  if (c.cells.empty()) {
    const int stripe = c.flip_subpixels ? 2 - channel : channel;
    right += mirror * stripe / 3;
  } else {
    const int n = static_cast<int>(c.cells.size());
    const int pattern[] = {0, (column + from_bottom) % 2, column % 2,
                           (from_bottom + 2 * (column % 2)) % 4, from_bottom % 2};
    const auto& cell = c.cells[static_cast<std::size_t>(pattern[c.cell_pattern] % n)];
    right += Long(cell[static_cast<std::size_t>(channel)][0]);
    up += Long(cell[static_cast<std::size_t>(channel)][1]);
  }
  // The lenses run along (-1, slope): their unit normal is (slope, 1) / its length.
  const Long slope = mirror * Long(c.slope);
  const Long length = std::sqrt(slope * slope + 1);
  const Long sign = slope < 0 ? -1 : 1;
  const Long across = sign * (slope * right + up) / length / Long(c.dpi);  // inches
  const Long lenses = across * Long(c.pitch_per_in) - Long(c.center);
  const Long share = lenses - std::floor(lenses);
  return c.invert_views ? 1 - share : share;
}

// Whether a view's number is the reference's: where the direction is within rounding of the border
// of two views (or of the last and the first), either.
inline bool IsViewOfReference(long double view, int index, int views) {
  const long double at = view * views;
  constexpr long double kRounding = 1e-8L;
  const auto low = static_cast<int>(std::floor(at - kRounding));
  const auto high = static_cast<int>(std::floor(at + kRounding));
  const auto wrapped = [views](int i) { return (i + views) % views; };
  return index == wrapped(low) || index == wrapped(high) || (high >= views && index == views - 1);
}

}  // namespace lamella
