// Which pixels of a photograph show which part of a panel, and the light on them.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "calibration/shot_list.h"
#include "calibration/vignetting.h"
#include "lightfield/image.h"

namespace lamella {

// The panel without the outer twentieth, where a parallax may show its border.
struct PanelRegion {
  Image<std::int16_t> cell;   // of each pixel: kGainColumns x kGainRows cells, -1 beside the panel
  Image<std::int16_t> patch;  // in the middle of each cell, around one opening; -1 elsewhere
  int num_px = 0;
  std::vector<int> cell_px, patch_px;                   // pixels of each
  std::vector<Eigen::Vector2d> cell_image, cell_panel;  // their middles, px
};

double PatchHeightPx(const PanelSize& panel);  // panel px

// `image_from_panel` is a homography; width and height are the photograph's.
PanelRegion RegionOf(const Eigen::Matrix3d& image_from_panel, const PanelSize& panel, int width,
                     int height);

// Light less the dark photograph's.
struct RegionLight {
  Eigen::Vector3d mean{0, 0, 0};  // of the camera's channels
  double sum = 0;                 // of their means
  double variance = 0;            // of `sum`: from differences of neighbours, over the pixels
  double saturated = 0;           // share of the pixels with a channel at full scale
  std::vector<Eigen::Vector3d> cells;
};
RegionLight LightOf(ImageSpan<const Rgb> photo, ImageSpan<const Rgb> dark,
                    const PanelRegion& region);

// The sum of the channels' means of each patch; 0 of those without pixels.
std::vector<double> PatchLightOf(ImageSpan<const Rgb> photo, ImageSpan<const Rgb> dark,
                                 const PanelRegion& region);

}  // namespace lamella
