// Layers whose colours differ, made to show one white and one scene (calibration.md section 9).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/calibration.h"

namespace lamella {

// The brightest light that every layer can show alone: the corner of the intersection of their
// gamuts with the largest sum of the camera's channels. Columns of a matrix are the camera's linear
// light of a layer's full red, green and blue. InputError (naming the layer) where a matrix has no
// inverse; UsageError where the gamuts share nothing but black.
Eigen::Vector3d BrightestCommonWhite(const std::vector<Eigen::Matrix3d>& camera_from_panel,
                                     const std::string& display);

struct LayerColors {
  double gain = 1;  // share of the light of all layers' whites that is this one's
  Eigen::Matrix3d primaries = Eigen::Matrix3d::Identity();  // as of Photometry; white's luminance 1
};

// The layers' colours for a viewer to whom the brightest common white is white: the camera's
// channels are scaled so that it is grey (von Kries), since neither the camera's nor the panels'
// balance is known better.
std::vector<LayerColors> MatchColors(const std::vector<Eigen::Matrix3d>& camera_from_panel,
                                     const std::string& display);

}  // namespace lamella
