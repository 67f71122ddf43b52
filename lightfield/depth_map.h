// Depth of a view along its optical axis, and how sure it is.
#pragma once

#include "lightfield/image.h"

namespace lamella {

struct DepthMap {
  Image<float> depth;       // world units along the optical axis; 0 unknown, +inf at infinity
  Image<float> confidence;  // [0, 1]; 0 where depth is unknown
};

}  // namespace lamella
