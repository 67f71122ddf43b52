// Chosen cameras rendered from a workspace's views and depth, and compared with photographs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "depth/render.h"
#include "lightfield/progress.h"

namespace lamella {

struct ViewsArguments {
  std::filesystem::path workspace;
  std::filesystem::path cameras;  // whatever ReadKnownCameras reads; in the workspace's world frame
  std::filesystem::path out;      // NAME.png: sRGB, unassociated alpha = coverage
  std::filesystem::path images;   // photographs to compare with; empty: those of `cameras`
  std::string views;              // NAME|GLOB|!NAME,...: which cameras; empty: all
  int size_px = 0;                // longer side of what is rendered and compared; 0: the camera's
  int border_px = 0;              // left out when comparing
  RenderOptions render;
};

// Figures are on 8-bit sRGB codes; a pixel counts as seen from alpha 0.5 on.
struct RenderedView {
  std::string name;
  double seen = 0;                        // share of pixels
  std::optional<double> psnr, psnr_seen;  // dB, over all and over seen pixels; no photograph: none
  // Over seen pixels, after the best gain per channel (in linear light): without the difference of
  // the photograph's exposure.
  std::optional<double> psnr_seen_gain;
};

// Renders and writes every chosen camera. UsageError where a camera is no pinhole or the patterns
// choose none, InputError where a photograph can't be read.
std::vector<RenderedView> RenderViews(const ViewsArguments& arguments, Progress& progress);

}  // namespace lamella
