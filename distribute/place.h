// Placement: the scene in the display's volume (DESIGN 5.1), decided once and kept in layers.json.
//
// In the frame of a reference camera (X right, Y down, Z forward, focal length f px; the picture's
// middle lies in direction (t_x, t_y, 1), where t is 0 for a camera whose principal point is
// there):
//   Z' = 1/(a/Z + b),  x = k f (X/Z - t_x) Z',  y = -k f (Y/Z - t_y) Z',  z = D - Z'      [mm]
// with k = mm_per_view_px / Z'(z = 0) = mm_per_view_px / D, so that the reference picture lies in
// the middle of z = 0 and one of its pixels is mm_per_view_px there. It is a projective map:
// straight lines stay straight, planes Z = const become planes z = const, a camera shifted sideways
// becomes an eye shifted sideways in the plane z = D. b = 0 is a similarity (a shear where t is not
// 0).
#pragma once

#include <functional>
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
  std::optional<double> mm_per_view_px;       // default: the whole picture fits the panel
  std::optional<double> viewing_distance_mm;  // default: the display's
  std::optional<double> focus;                // world depth shown on z = 0
  std::string reference_view;                 // default: the most central view
};
// Their fields of [layers]; the flags are --depth-range, --focus, ...
std::vector<OptionField> Describe(PlacementOptions& options);

struct Placement {
  std::string reference_view;
  Rigid camera_from_world;         // of the reference view
  double viewing_distance_mm = 0;  // D
  double a = 0, b = 0;             // Z' = 1/(a/Z + b), mm
  double mm_per_view_px = 0;
  double focal_px = 0;                                 // f of the reference view
  Eigen::Vector2d middle{0, 0};                        // t
  double picture_width_mm = 0, picture_height_mm = 0;  // of the reference view on z = 0
  double near = 0, far = 0;                            // world depths that were placed
  double near_mm = 0, far_mm = 0;                      // z where they are
  Eigen::Matrix4d display_from_world = Eigen::Matrix4d::Identity();  // homogeneous, projective

  // z of a depth along the reference view's axis (+inf allowed), and back.
  double ZFromDepth(double depth) const;
};

// Depths along the reference view's axis, world units; 0 < near <= far <= +inf.
struct DepthRange {
  double near = 0, far = 0;
};

// The named view, or the one nearest to the mean of all centres (the first of equally near ones).
// UsageError with the nearest name where there is no such view.
const View& ReferenceView(const std::vector<View>& views, const std::string& name);

// Between the 1 % and 99 % quantiles of inverse depths (0: infinitely far). InputError where none
// is positive.
DepthRange DepthRangeOf(std::vector<double> inverse_depths);

// What the options ask for, or else `of_capture()`. UsageError where a range is malformed or a
// disparity range meets a capture that is no grid.
DepthRange ChooseDepthRange(const PlacementOptions& options, const std::optional<RegularGrid>& grid,
                            const std::function<DepthRange()>& of_capture);

// `near` and `far`: depths along the reference view's axis (world units, far may be +inf). Near
// goes to +budget, far to -budget, or with --focus the focus to 0 and the others as far as the
// budget allows. Were b negative (the display would stretch depth beyond a similarity, turning far
// content inside out), b = 0 and the budget shrinks; the reason is put in `note`.
Placement Place(const View& reference, double near, double far, const Display& display,
                const PlacementOptions& options, std::string* note);

// The world seen through the placement: bundles and z in the display's frame. Keeps a reference to
// `world`. A bundle's plane must be parallel to z = 0: only then its grid is a grid of the world.
std::unique_ptr<RaySource> Placed(const RaySource& world, const Placement& placement);

// A bundle of the display's frame as Placed asks the world for it.
RayBundle InWorld(const RayBundle& bundle, const Placement& placement);

// Where an eye of the display's frame is for a camera of the world: its centre under the map.
Eigen::Vector3d EyeOfCamera(const Placement& placement, const Rigid& camera_from_world);

}  // namespace lamella
