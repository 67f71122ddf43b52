// A calibration against another one or against truth, whatever frame each is in.
#pragma once

#include <vector>

#include "calibration/observations.h"
#include "calibration/uncertainty.h"
#include "lightfield/calibration.h"

namespace lamella {

// Differences of a layer's numbers, the reference stack of both in one place. Rotations are those
// that lead from one to the other: about the panel's normal, and the rest.
struct LayerDifference {
  double stack_shift_mm = 0, stack_tilt_deg = 0, stack_rotation_deg = 0;
  double offset_mm = 0, gap_mm = 0, tilt_deg = 0, rotation_deg = 0;  // of the emitter in its stack
};

struct PanelRays {
  PanelId panel;
  RayDifference rays;
};

struct LensRays {
  int layer = 0;
  RayDifference rays;
};

struct CalibrationComparison {
  PanelId reference;  // its pixels and the eyes before it define the rays
  std::vector<LayerDifference> layers;
  std::vector<PanelRays> panels;  // all but the reference
  RayDifference rays;             // of all of them
  // Of layers with lenses: the emitter's pixels that the eyes see through the lens before 7 x 5 of
  // its pixels, by each calibration's nearest lens, across a line's.
  std::vector<LensRays> lenses;
  double gap_mm = 0, rotation_deg = 0, tilt_deg = 0;  // the largest, stacks' and emitters'
};

// Ray error in panel pixels (calibration/uncertainty.h): 7 x 5 pixels of the reference panel seen
// from 27 eyes in `box`, which stands before that panel. It depends on neither's world frame.
// UsageError where the two differ in layers, panels or their sizes.
CalibrationComparison CompareCalibrations(const Calibration& a, const Calibration& b,
                                          const EyeBox& box = {});

}  // namespace lamella
