// What the lines of sight through the corners of a photograph's pixels meet of a layer.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "lightfield/image.h"
#include "lightfield/panel_rays.h"

namespace lamella {

// Traces the line of sight through a point of the photograph, px.
using TraceSight = std::function<std::optional<SightHit>(double x, double y)>;

// Lines of sight through panels without lenses turn smoothly over a photograph: those of a
// rectangle follow from nine that are traced, by a polynomial of second degree in x and y.
class CornerHits {
 public:
  // Nothing where a line that is traced meets nothing, or two others, where the polynomial is
  // worst, are further than 1e-4 px of a panel from what it says of them.
  static std::optional<CornerHits> Between(const Rect& rectangle, const TraceSight& trace);

  // Of the corner of pixel (x, y) of the photograph that is its upper left one, both up to the
  // rectangle's end.
  const SightHit& At(int x, int y) const {
    return hits_[static_cast<std::size_t>(y - rectangle_.y) *
                     (static_cast<std::size_t>(rectangle_.width) + 1) +
                 static_cast<std::size_t>(x - rectangle_.x)];
  }
  // Within a pixel lines turn evenly: places run from 0 to 1 over it.
  SightHit Within(int x, int y, double place_x, double place_y) const;
  // The corners of a pixel, in turn about it.
  std::array<const SightHit*, 4> About(int x, int y) const {
    return {&At(x, y), &At(x + 1, y), &At(x + 1, y + 1), &At(x, y + 1)};
  }

 private:
  explicit CornerHits(const Rect& rectangle) : rectangle_(rectangle) {}
  Rect rectangle_;
  std::vector<SightHit> hits_;
};

}  // namespace lamella
