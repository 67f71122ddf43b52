// Virtual photographs of a display: the prototype of datasets_synthetic with files around it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lightfield/options.h"
#include "lightfield/progress.h"

namespace lamella {

struct SynthPhotosOptions {
  // What is photographed: a display as designed (a name or a file; where frames are shown, that of
  // their workspace), or with the numbers of a calibration.json.
  std::string display, misalignment;
  // What it shows: a workspace's frames/, or a file of shots. One of the two.
  std::string frames, shots;
  // Where from: a transforms.json in the display's frame (mm), eyes "X,Y,Z;..." whose pictures lie
  // on z = 0, or so many views on two rings (calibration.md section 3). One of the three.
  std::string cameras, eyes;
  int views = 0;
  // Where a shot's printed board is fixed: "X,Y,Z" of its middle in mm, or "X,Y,Z,RX,RY,RZ" with
  // its turns in degrees; "": nowhere, and its shots are left out.
  std::string printed_board;
  std::string raster;  // of the eyes: LEFT,TOP,PIXEL in mm and WIDTH,HEIGHT in px; "": the panel's
  double distance_mm = 1050, tilt_deg = 20;  // of the rings
  int width_px = 2736;                       // of the rings' pictures, 3:2
  double k1 = 0;                             // of the rings' lens, Brown's first radial term

  int samples = 64;  // lines of sight per pixel, where areas can't be summed (prototype.h)
  double aperture_mm = 0, focus_mm = 0, vignetting = 0;
  double blur_px = 0;              // sigma of the lens's spread, beside the pupil's
  std::optional<double> exposure;  // not set: a layer with all emitters white is white
  double full_well_e = 0, read_noise_e = 0, pedestal = 0;
  std::string curve = "srgb";  // of the photographs: linear, srgb, gamma
  double gamma = 2.2;
  int bits = 8;
  std::string format = "png";  // or exr: linear, not rounded
  int seed = 1;                // of the noise
};
OptionTable Describe(SynthPhotosOptions& options);

// Writes into `out`, and returns the number of photographs:
//   images/NAME.png or .exr   the photographs
//   calibration.json          what the display is: the truth
//   transforms.json           a frame per photograph: its camera, in the display's frame
//   photos.json               which camera and shot each is of, exposure and sensor
// A file's bytes depend on the options and their files alone. A run that was stopped goes on where
// it was when the same is asked for again (unfinished.json is there until then). UsageError or
// InputError with a line that says what is missing or does not fit.
int SynthPhotos(const SynthPhotosOptions& options, const std::filesystem::path& out,
                Progress& progress);

}  // namespace lamella
