// What an eye sees of a display: the ray map integrated over the eye's pixels and the time slots
// (displays.md section 1.4; Ranieri et al. 2012, section 6 "display simulation").
//
// Included are the encoder's prefilter (it is in the emitter images), the display's response
// (openings and lenses, emitters, slots, superposed layers, light that crosses into a neighbour's
// window; the panels' contrasts and crosstalk of slots, where the display has any) and the eye's
// pixels. Not included: reflections, diffraction.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "distribute/distribute.h"
#include "distribute/emitter_strip.h"
#include "lightfield/display.h"
#include "lightfield/image.h"
#include "lightfield/ray_source.h"

namespace lamella {

// A pinhole eye and the raster of its picture, which lies on the plane z = plane_mm, upright, row 0
// on top. All lengths in mm, in the display's frame.
struct Eye {
  Eigen::Vector3d position{0, 0, 600};  // in front of every layer and of the picture
  double plane_mm = 0;
  double left_mm = 0, top_mm = 0;  // the picture's top left corner
  double pixel_mm = 1;
  int width = 0, height = 0;  // px
};

// The rays through the centres of the picture's pixels, each pixel split into `split` x `split`:
// what a scene is asked for the picture that the display should show.
RayBundle BundleOfEye(const Eye& eye, int split = 1);

struct EyePicture {
  // Linear. Divided by the brightness (a/P)^2 / n of the barrier and the superposition, computed
  // and not fitted, so that a display without error shows the scene's own radiance; what panels of
  // finite contrast leak comes on top, once for every layer. A striped panel's sub-pixel has three
  // times its pixel's light in its channel.
  Image<Rgb> color;
  // Share of the light paths (line of sight, layer, slot, by how far it is open) that end at an
  // emitter whose content is known; a line of sight that misses a barrier's panel counts as
  // unknown, one that meets no whole lens or ends at a guard pixel or beside the lenses' panel not
  // at all. Unknown light is black in `color`.
  Image<float> coverage;
};

// The entrance pupil of an eye or camera, a disc around the eye's position.
struct Pupil {
  double diameter_mm = 4;
  int samples = 48;  // in a sunflower's spiral (Vogel 1979)
};
std::vector<Eye> PupilSamples(const Eye& eye, const Pupil& pupil);

// Every line of sight of every pixel, followed through all layers and slots: integrated exactly
// over the parts of a pixel in which lines meet the same element and emitter. `layers` has the
// display's layers and slots (InputError where it has not, UsageError where the eye is inside the
// display). With a pupil the eye is focused on the picture's plane, eye.plane_mm: the mean of what
// pinholes in the pupil see of it. The result does not depend on the number of threads.
EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye,
                       const std::optional<Pupil>& pupil = std::nullopt);

// The picture's rows `rows` of the same, from the emitters that they show. CheckEye holds.
EyePicture SimulateRows(const EmitterStrip& strip, const Display& display, const Eye& eye,
                        const std::optional<Pupil>& pupil, const RowRange& rows);
// All emitters; InputError where they are not the display's. Refers to them.
EmitterStrip WholeStrip(const LayerImages& layers, const Display& display);
// UsageError where the eye is not in front of all layers.
void CheckEye(const Display& display, const Eye& eye);

// How far the eye may move sideways on either axis before a line of sight meets a neighbour's
// window, of the most restrictive layer (CleanEyeBoxOf of distribute/analyze.h).
double CleanEyeBox(const Display& display);

}  // namespace lamella
