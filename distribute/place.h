// Placement: the scene in the display's volume (DESIGN 5.1), decided once and kept in layers.json.
//
// In the frame of a reference camera (X right, Y down, Z forward, focal length f px, principal
// point removed):
//   Z' = 1/(a/Z + b),  x = k f X/Z Z',  y = -k f Y/Z Z',  z = D - Z'        [mm]
// with k = mm_per_view_px / Z'(z = 0) = mm_per_view_px / D, so that one view pixel is
// mm_per_view_px on z = 0. It is a projective map: straight lines stay straight, planes Z = const
// become planes z = const, a camera shifted sideways becomes an eye shifted sideways in the plane z
// = D.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/display.h"
#include "lightfield/options.h"
#include "lightfield/ray_source.h"
#include "lightfield/view.h"

namespace lamella {

struct PlacementOptions {
  std::string depth_range;                    // "NEAR,FAR" world units; empty: from the capture
  std::string disparity_range;                // "NEAR,FAR" px per grid step; grids only
  std::optional<double> depth_budget_mm;      // near -> +budget, far -> -budget
  std::optional<double> mm_per_view_px;       // default: the view fills the panel's height
  std::optional<double> viewing_distance_mm;  // default: the display's
  std::optional<double> focus;                // world depth shown on z = 0
  std::string reference_view;                 // default: the most central view
};

struct Placement {
  std::string reference_view;
  double viewing_distance_mm = 0;  // D
  double a = 0, b = 0;             // Z' = 1/(a/Z + b), mm
  double mm_per_view_px = 0;
  double focal_px = 0;                                               // f of the reference view
  Eigen::Matrix4d display_from_world = Eigen::Matrix4d::Identity();  // homogeneous, projective
};

// `near` and `far`: depths along the reference view's axis (world units, far may be +inf).
// Were b negative (the content would need to turn inside out), b = 0 and the budget shrinks; the
// reason is put in `note`.
Placement Place(const View& reference, double near, double far, const Display& display,
                const PlacementOptions& options, std::string* note);

// The world seen through the placement: bundles and z in the display's frame. Keeps references.
// Bundles must have their plane parallel to z = 0 (place.cc says why).
std::unique_ptr<RaySource> Placed(const RaySource& world, const Placement& placement);

// Where an eye of the display's frame is for a camera of the world: its centre under the map.
Eigen::Vector3d EyeOfCamera(const Placement& placement, const Rigid& camera_from_world);

}  // namespace lamella
