// The depths for which a blur by beams is made, where content at any depth is to be blurred: what
// lies between two of them is interpolated.
#pragma once

#include <vector>

#include "lightfield/beam.h"
#include "lightfield/display.h"

namespace lamella {

// The widths of a layer's beams along an axis, and where its modulating plane is.
struct BeamOfLayer {
  AxisBeam beam;
  double layer_mm = 0;
};

// Rising depths z, mm. From one to the next no beam's width changes by more than `widening` times
// itself (of a beam that is narrower than a tenth of its element: times that tenth). They end half
// the viewing distance before the display and beyond farthest_mm, which lies behind it. Without
// beams it is the backmost layer's position alone.
std::vector<double> BlurPlanes(const Display& display, const std::vector<BeamOfLayer>& beams,
                               double widening, double farthest_mm);

}  // namespace lamella
