// What a pinhole eye sees of a display: the ray map integrated over the eye's pixels and the time
// slots (displays.md section 1.4; Ranieri et al. 2012, section 6 "display simulation").
//
// Included are the encoder's prefilter (it is in the emitter images), the display's response
// (openings, emitters, slots, superposed layers, light that crosses into a neighbour's window) and
// the eye's pixels. Not included: a pupil's width, reflections, diffraction, a panel's contrast.
#pragma once

#include <Eigen/Core>

#include "distribute/distribute.h"
#include "lightfield/display.h"
#include "lightfield/image.h"
#include "lightfield/ray_source.h"

namespace lamella {

// A pinhole eye and the raster of its picture, which lies on the reference plane z = 0, upright,
// row 0 on top. All lengths in mm, in the display's frame.
struct Eye {
  Eigen::Vector3d position{0, 0, 600};  // in front of every layer
  double left_mm = 0, top_mm = 0;       // the picture's top left corner
  double pixel_mm = 1;
  int width = 0, height = 0;  // px
};

// The rays through the centres of the picture's pixels, each pixel split into `split` x `split`:
// what a scene is asked for the picture that the display should show.
RayBundle BundleOfEye(const Eye& eye, int split = 1);

struct EyePicture {
  // Linear. Divided by the brightness (a/P)^2 / n of the barrier and the superposition, computed
  // and not fitted, so that a display without error shows the scene's own radiance.
  Image<Rgb> color;
  // Share of the light paths (line of sight, layer, open slot) that end at an emitter whose content
  // is known; a line of sight that misses a panel counts as unknown. Unknown light is black in
  // `color`.
  Image<float> coverage;
};

// Every line of sight of every pixel, followed through all layers and slots: integrated exactly
// over the parts of a pixel in which lines meet the same element and emitter. `layers` has the
// display's layers and slots (InputError where it has not, UsageError where the eye is inside the
// display or its optics are not barriers). The result does not depend on the number of threads.
EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye);

// How far the eye may move sideways on one axis before a line of sight meets a neighbour's window
// (simulation.md section 5): ((P - a)/2 - 1/2) * p * D / d0 of the most restrictive layer; with no
// shear the fans are parallel and the box is 0.
double CleanEyeBox(const Display& display);

}  // namespace lamella
