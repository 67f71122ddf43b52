// What keeps a photograph from being perfect. Each effect is off by default; all are the same for a
// seed whatever the number of threads.
//
// Light passes lens and shutter (defocus, motion, distortion: datasets_synthetic/photograph.h),
// then it is vignetted, exposed, counted by the sensor, and its white balance is set.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets_synthetic/photograph.h"
#include "lightfield/image.h"
#include "lightfield/options.h"

namespace lamella {

struct Degradation {
  double full_well_e = 0;     // electrons of a colour that is 1: shot noise; 0: none, no read noise
  double read_noise_e = 0;    // standard deviation, electrons
  double aperture = 0;        // diameter of the lens, world units; 0: a pinhole, all in focus
  double focus_distance = 0;  // world units along the axis; 0: the distance of the layout's target
  double shake = 0;           // way of the camera during the exposure, world units
  double shake_deg = 0;       // its turn during the exposure
  int samples = 64;           // of lens, shutter and pixel together, where one of them is needed
  double vignetting = 0;      // 1: natural (cos^4); light is 1 + vignetting (cos^4 - 1)
  double exposure_ev = 0;     // standard deviation from view to view, stops
  double white_balance_ev = 0;            // of red and of blue, stops
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;  // lens distortion as in lightfield/camera.h (Brown)
  int jpeg_quality = 95;
  int dropped_views = 0;     // photographs that are missing
  int duplicated_views = 0;  // taken twice from one place
};
OptionTable Describe(Degradation& degradation);  // the table [degradation] of a recipe

// A photograph to take: what was drawn at random for it. Truth, to be written beside it.
struct Exposure {
  int view = 0;        // index of the layout's camera
  bool again = false;  // the second photograph from there
  Shutter shutter;     // motion; lens
  float exposure = 1;  // factors on linear light
  float red = 1, blue = 1;
  std::uint32_t seed = 0;  // of the sensor's noise
};

// Those of `num_views` cameras that were not dropped, in order, duplicates after their originals.
// `where` is named by the UsageError where fewer than one view would remain.
std::vector<Exposure> ExposuresOf(const Degradation& degradation, int num_views, std::uint32_t seed,
                                  double focus_distance, const std::string& where = {});

// Camera with the distortion of `degradation`; UsageError naming `where` where the picture folds
// over within it.
Camera Distorted(const Camera& camera, const Degradation& degradation,
                 const std::string& where = {});

// Vignetting, exposure, sensor noise and white balance, in this order, in place. `camera` says at
// which angle a pixel sees.
void Degrade(const Degradation& degradation, const Exposure& exposure, const Camera& camera,
             Image<Rgb>& linear);

}  // namespace lamella
