// Photographs of a display's flat levels, colours and lines, read: the light of each panel's pixels
// and where they lie in the picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "calibration/response_fit.h"
#include "calibration/shot_list.h"
#include "calibration/vignetting.h"
#include "lightfield/progress.h"

namespace lamella {

// A layer with a modulator, at the first camera position. Lights are less those of the same
// exposure's dark photograph, in shares of full scale, the sum of the channels where not said.
struct LayerLight {
  int layer = 0;
  // Of each panel; exposures are numbered as in PhotometricLight::exposures.
  std::vector<FlatReading> emitter, modulator;
  double white = 0, mixed = 0;
  // Red, green and blue shown (columns), as the camera's channels (rows), of each cell.
  std::vector<Eigen::Matrix3d> colors;
  std::vector<Eigen::VectorXd> lines;  // series of calibration/crosstalk.h
};

// A layer's white in one photograph.
struct WhiteCell {
  int layer = 0, view = 0, cell = 0;
  double light = 0, variance = 0;
  Eigen::Vector2d image_px{0, 0};  // the cell's middle
  Eigen::Vector2d panel_px{0, 0};  // likewise, on the emitter
};

struct PhotometricLight {
  ShotList list;
  int width = 0, height = 0;  // of the photographs, px
  int num_views = 0;
  std::vector<int> exposures;  // factors, the first 1
  std::vector<LayerLight> layers;
  std::vector<WhiteCell> whites;
  Observations boards;                // all, of one camera
  double curve_rms = 0;               // of kEstimated: how far exposures differ, share of light
  std::vector<std::string> left_out;  // overexposed levels: how many of which panel
};

// How the numbers of integer files follow from light; float files are linear. kEstimated: from the
// exposures, which are then taken at their word (calibration/camera_response.h); of 8 bits, too.
enum class PhotoCurve { kLinear, kSrgb, kEstimated };

// `photos`: a folder whose names sort as the photographs were taken: all shots of the list, then,
// from every further position, those that are not of the first position only. InputError naming the
// file and shot where their number does not fit, sizes differ, a board is not the one that the shot
// shows, a panel has fewer than 2000 px, white or a colour is overexposed, or files have 8 bits
// and their curve is not estimated.
PhotometricLight ReadPhotometricPhotos(const std::filesystem::path& patterns,
                                       const std::filesystem::path& photos, PhotoCurve curve,
                                       Progress& progress);

}  // namespace lamella
