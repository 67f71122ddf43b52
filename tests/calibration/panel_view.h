// Photographs of a panel by a slow, obvious camera: the light of pixels of a quarter of the size,
// the mean of 16 lines of sight (of 256 where they do not all see one colour) through a homography
// to the panel's staircase of pixels; spread by a Gaussian, as a lens does before there are pixels;
// the mean over every pixel; white noise.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lightfield/image.h"

namespace lamella {

struct PanelViewOptions {
  int width_px = 640, height_px = 480;  // of the photograph
  double scale = 1;                     // photograph's px per panel px in the middle
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
  double focal_px = 2000;
  double blur_px = 1;  // sigma of the Gaussian, in the photograph's pixels
  // Where the photograph's middle looks at: shares of the panel.
  double middle_u = 0.5, middle_v = 0.5;
  bool mirrored = false;  // the panel is seen by reflection
};

class PanelView {
 public:
  PanelView(int panel_width_px, int panel_height_px, const PanelViewOptions& options);

  // Both with the first pixel's centre at (0.5, 0.5).
  Eigen::Vector2d ImageFromPanel(const Eigen::Vector2d& panel_px) const;
  Eigen::Vector2d PanelFromImage(const Eigen::Vector2d& image_px) const;

  // Linear light of sRGB codes; black around the panel.
  Image<float> Photograph(ImageSpan<const Rgb8> codes) const;
  const PanelViewOptions& options() const { return options_; }

 private:
  // The panel pixel that the i-th of n lines of sight of a fine pixel sees, or -1.
  std::int32_t Seen(int x, int y, unsigned i, unsigned n) const;

  PanelViewOptions options_;
  int panel_width_, panel_height_;
  Eigen::Matrix3d image_from_panel_, panel_from_image_;
  std::vector<Eigen::Vector2d> shifts_;  // of every fine pixel's lines of sight
};

// numbers = low + (high - low) light, plus white noise, rounded to codes of 8 bits where asked.
struct PhotoNoise {
  double low = 0.1, high = 0.9;
  double sigma = 2.0 / 255;
  bool rounded = true;
  double shot = 0;  // variance that a unit of light adds
};
Image<float> Exposed(ImageSpan<const float> light, const PhotoNoise& noise, std::uint32_t seed);

}  // namespace lamella
