// What eyes see of a calibrated display: virtual photographs (datasets_synthetic/prototype.h) of
// one that is what the calibration says, with pinhole cameras whose picture lies on the eye's
// plane.
#pragma once

#include <optional>

#include "datasets_synthetic/prototype.h"
#include "distribute/simulate_eye.h"
#include "pipeline/layers_record.h"

namespace lamella {

class CalibratedEyes {
 public:
  // `shown`: of scene's light, white 1, as SimulateEye takes it; `record` has a calibration.
  CalibratedEyes(const LayersRecord& record, const LayerImages& shown);
  // Color and coverage as SimulateEye's, by so many lines of sight a pixel. An eye without a pupil
  // is a pinhole; one with it focuses on its picture's plane.
  EyePicture See(const Eye& eye, const std::optional<Pupil>& pupil, int samples = 32) const;

 private:
  Prototype light_;
  Prototype known_;  // red: coverage, green: 1, of emitters that have a beam
};

}  // namespace lamella
