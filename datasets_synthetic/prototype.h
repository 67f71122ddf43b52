// The virtual prototype: what a camera photographs of a display that shows given panel images.
//
// Light is traced physically from a calibration's numbers, line of sight by line of sight: through
// the lens, the plate, the posed and bowed modulator's pixel, refracted or bent by a lens of the
// sheet, to the emitter's pixel. It shares no code with the ray map, so that a simulated eye and a
// virtual photograph are two ways to one picture.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "lightfield/calibration.h"
#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/progress.h"
#include "lightfield/rigid.h"

namespace lamella {

// What one layer shows while the shutter is open: its time slots, all equally long; both panels of
// the sizes that the calibration says, images as the panels are addressed (a mirrored layer's
// frames are flipped already). Slots may share images.
struct ShownLayer {
  std::vector<std::shared_ptr<const Image<Rgb>>> emitter;      // linear light, white 1
  std::vector<std::shared_ptr<const Image<float>>> modulator;  // transmittance; as many, or none
};

// With panels that still show the share `crosstalk` of the slot before, the slots being shown in
// that order over and over (all of them, by their numbers).
ShownLayer WithSlotCrosstalk(const ShownLayer& shown, const std::vector<int>& order,
                             double crosstalk);

// A sheet of paper that is fixed to the display, as bright from everywhere.
struct PrintedSheet {
  Rigid display_from_sheet;  // mm; the sheet's origin is its middle, x right, y up, z to the viewer
  double pixel_mm = 0;
  std::shared_ptr<const Image<Rgb>> light;
};

// What is before the camera at one time.
struct Show {
  std::vector<ShownLayer> layers;          // all of them
  std::optional<PrintedSheet> sheet = {};  // its light is added: it stands beside the panels
};

struct Prototype {
  Calibration calibration;
  std::vector<ShownLayer> shown;           // one per layer
  std::optional<PrintedSheet> sheet = {};  // as of a show
};

// Panel images from 8-bit codes through the panel's photometry: curve, black level, primaries,
// evenness and spread (crosstalk) of an emitter; curve and leakage of a modulator (grey: the green
// code).
Image<Rgb> LightOfEmitter(const PanelCalibration& panel, ImageSpan<const Rgb8> codes);
Image<float> TransmittanceOfModulator(const PanelCalibration& panel, ImageSpan<const Rgb8> codes);

struct PrototypeCamera {
  Camera camera;
  Rigid camera_from_display;  // mm
  double aperture_mm = 0;     // diameter of the entrance pupil; 0: everything is sharp
  double focus_mm = 0;        // along the optical axis to the sharp plane; used with an aperture
  double vignetting = 0;  // share of light lost in the corners: 1 - v r^2, r = 1 half a diagonal
                          // from the principal point
  double blur_px = 0;     // sigma of the Gaussian by which the lens spreads light, a quarter px or
                          // more: before there are pixels, so that half pixels are spread
};

// The linear light on the camera's pixels, each the mean over its area, the pupil and the time
// slots. The layers' light is summed. Through a pinhole and panels without lenses a pixel is cut
// along the sides of the panels' pixels that it sees and its pieces' areas are weighed, so that no
// noise of samples is in it; there lines of sight turn smoothly, and of a tile of pixels those of
// the corners follow from nine that are traced, where two more agree to 1e-4 px of the panels.
// Elsewhere, and where a pixel sees more than 64 pieces, it is the mean of `samples` lines of sight
// (powers of two are the most exact; four at least with a blur).
// Does not depend on the number of threads. `progress` advances by one per row.
// UsageError where the camera is not in front of every layer; InputError where what is shown does
// not fit the calibration.
Image<Rgb> PhotographPrototype(const Prototype& prototype, const PrototypeCamera& camera,
                               int samples, Progress& progress);

// Of several shows, a photograph each, the same as one at a time: every line of sight is traced
// once for all of them. `progress` advances by one per row of each. Errors are as above.
std::vector<Image<Rgb>> PhotographShows(const Calibration& calibration, std::span<const Show> shows,
                                        const PrototypeCamera& camera, int samples,
                                        Progress& progress);

// The light that the display shows along one line of sight, in the display's frame.
Rgb LightAlong(const Prototype& prototype, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction);

}  // namespace lamella
