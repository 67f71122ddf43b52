// What the photographs of a display's panels say: points of a panel's pattern and where a camera
// saw them. Detection fills it, calibration reads it.
//
// Pixels of panels and of photographs alike: continuous, the first pixel's centre at (0.5, 0.5),
// v down (docs/conventions.md). Panel pixels are those of the image that the panel was given, also
// where a mirror shows it reversed; photo pixels are those of the photograph as the camera took it,
// never of a flipped copy.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace lamella {

// A panel of a display: its layer, as in Calibration::layers, and which of the layer's two it is.
struct PanelId {
  int layer = 0;
  enum Role { kEmitter, kModulator } role = kEmitter;
  friend auto operator<=>(const PanelId&,
                          const PanelId&) = default;  // NOLINT(modernize-use-nullptr)
};
std::string NameOf(const PanelId& panel);  // "layer 1 modulator"

// One point of a panel's pattern as one photograph shows it.
struct Observation {
  Eigen::Vector2d panel_px{0, 0};
  Eigen::Vector2d image_px{0, 0};
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  // of image_px
};

// A camera body at one zoom and focus (and one colour channel, where channels are told apart): what
// is known of it beforehand.
struct PhotoCamera {
  std::string name;
  int width = 0, height = 0;  // px
  double focal_px = 0;        // a guess, for instance from EXIF; 0: none, one is estimated
};

// InputError naming `where` unless its size and focal length are possible.
void Check(const PhotoCamera& camera, const std::string& where);

// The points of one panel in one photograph.
struct PanelPhoto {
  PanelId panel;
  int view = 0;    // the camera position: photographs with one number were taken without moving it
  int camera = 0;  // in Observations::cameras
  std::string photo;  // its name; panels told apart by colour may share one
  std::vector<Observation> points;
};

struct Observations {
  std::vector<PhotoCamera> cameras;
  std::vector<PanelPhoto> photos;
};

// InputError (one line naming the photograph) where a number is not finite, a covariance is not
// positive definite, a camera is not in the list or has no size, one view has two cameras, or a
// panel appears twice in one photograph.
void Check(const Observations& observations, const std::string& where);

}  // namespace lamella
