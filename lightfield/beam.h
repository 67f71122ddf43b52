// The beam of one emitter through one element of a layer, and what a line of sight meets there,
// whatever the optics (displays.md sections 1.2 and 1.3). All lengths are as the viewer sees them,
// through the layer's relay if it has one.
#pragma once

#include <cstdint>

namespace lamella {

// One axis of it: all rays from a point of the emitter, emitter_mm +- emitter_width/2 on the
// emissive plane, through a point of the element, element_mm +- aperture/2 on the modulating plane.
// Right emitters send their light to the left.
//
// Of a bare panel these are all rays from a pixel to its eye box: the pixel is the element, and the
// box the "emitter", in front of it: d0_mm is negative.
struct AxisBeam {
  int opening = 0;
  double element_mm = 0;        // centre of the opening, vertex of the lens
  double aperture_mm = 0;       // w_x, full width
  double emitter_mm = 0;        // centre of the emitter
  double emitter_width_mm = 0;  // w_u, full width
  double d0_mm = 0;             // from the emissive to the modulating plane, along z
  // 1/f of the element: 0 for a hole, 1/d0 for a lens that sends the light of a point out parallel.
  double power_per_mm = 0;

  double slope() const { return (element_mm - emitter_mm) / d0_mm; }  // dx/dz of its centre
  // Where its centre is, offset_mm in front of the modulating plane.
  double At(double offset_mm) const { return element_mm + offset_mm * slope(); }
  // kappa = 1/d0 - 1/f: the slope gained per length across the element.
  double kappa_per_mm() const { return 1 / d0_mm - power_per_mm; }
  // Widths of the two boxes whose convolution is the beam's section there: that of the element,
  // w_x |1 + kappa offset|, and that of the emitter, w_u |offset/d0|.
  double OpeningBlurMm(double offset_mm) const;
  double EmitterBlurMm(double offset_mm) const;
};

struct Beam {
  AxisBeam x, y;
};

// What a line of sight meets on a layer: an element, and behind it a place of the emissive plane.
// Through a lens that is where all the light of its slope comes from, if the lens has f = d0.
struct LayerHit {
  int element_column = 0, element_row = 0;  // of the modulator, or of the lens
  double column = 0, row = 0;  // in emitters; their edges are whole numbers, row 0 is on top
  std::uint32_t slots_x = 1, slots_y = 1;  // bit s is set where the element is open in slot s
  int channel = -1;                        // the sub-pixel met; -1: emitters have all colours
  bool guard = false;                      // the emitter there is never lit
};

}  // namespace lamella
