// Light blurred by boxes, in a time that does not depend on their widths: by running sums, which
// are kept in double precision, so that bright light leaves nothing behind.
#pragma once

#include "distribute/accumulate.h"
#include "lightfield/image.h"

namespace lamella {

// A box as a filter of pixels: equal weights and less at its ends, so that its variance is w^2/12
// as the box's (Gwosdek et al., Theoretical foundations of Gaussian convolution by extended box
// filtering, SSVM 2011, with that variance instead of a Gaussian's). Of a frequency f it leaves
// sinc(f w) but for terms of (f px)^2 (f w)^2.
struct BoxFilter {
  int core = 0;      // pixels of full weight to both sides of the middle one
  double edge = 0;   // the weight of the next ones relative to theirs, [0, 1)
  double scale = 1;  // 1 / the sum of weights

  int reach() const { return edge > 0 ? core + 1 : core; }
};
BoxFilter BoxOfWidth(double width_px);  // >= 0; a width of 0 changes nothing

// One row: out[i], 0 <= i < count, of in[i - core - 1] to in[i + core + 1].
void BlurRow(const BoxFilter& box, const Light* in, int count, Light* out);
// Columns: row j of `out` of rows j to j + 2 core + 2 of `in`, which has so many more rows. As
// wide.
void BlurColumns(const BoxFilter& box, ImageSpan<const Light> in, ImageSpan<Light> out);

}  // namespace lamella
