// Which views of a capture know most of a ray: their order by direction, resolution and picture
// (Buehler et al., Unstructured Lumigraph Rendering, 2001; depth.md section 4).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "depth/bundle_map.h"
#include "depth/source_view.h"
#include "lightfield/ray_source.h"

namespace lamella {

// A view ready to be resampled.
struct SourceView {
  int width = 0, height = 0;        // colour px
  Eigen::Matrix4d view_from_world;  // homogeneous point to m (x, y, 1, 1/Z), colour px
  Eigen::Vector3d centre;
  std::vector<DepthLevel> depth;
  ColorPyramid color;
  // Softness of the visibility test in inverse depth: absolute + relative * inverse depth.
  double softness_absolute = 0, softness_relative = 0;
  std::vector<Eigen::Vector4d> samples;  // a few of its surface's points, homogeneous
};

// The levels whose pixels suit rays that are `spacing` view pixels apart: the nearest for colours,
// not coarser than the rays for depth.
std::size_t ColorLevelForSpacing(double spacing, std::size_t levels);
const ColorLevel& ColorLevelForSpacing(const SourceView& view, double spacing);
const DepthLevel& DepthLevelForSpacing(const SourceView& view, double spacing);

// The bundle as the views see it, prepared once per query.
class BundleGeometry {
 public:
  // Nearnesses count from `zero`.
  explicit BundleGeometry(const RayBundle& bundle, double zero = 0);
  const RayBundle& bundle() const { return bundle_; }
  const Eigen::Matrix4d& world_from_bundle() const { return world_from_bundle_; }
  const Eigen::Matrix4d& bundle_from_world() const { return bundle_from_world_; }
  double zero() const { return zero_; }
  bool valid() const { return valid_; }  // false: the plane holds the centre, or has no area

  // Of ray (u, v): a point and the unit direction towards the viewer.
  void Line(double u, double v, Eigen::Vector3d* point, Eigen::Vector3d* toward) const;
  // Squared distance of a point from ray (u, v).
  double DistanceSquared(double u, double v, const Eigen::Vector3d& point) const;

 private:
  RayBundle bundle_;
  double zero_;
  Eigen::Matrix4d world_from_bundle_, bundle_from_world_ = Eigen::Matrix4d::Identity();
  bool valid_ = false;
};

// How well a view knows what lies around a ray.
struct Sight {
  int view = -1;
  double penalty = 0;     // offset of the view from the ray in neighbour spacings, and more
  double resolution = 0;  // the part of it for coarse pixels
  double spacing = 0;     // view pixels per ray
};

// All views as a bundle meets them, prepared once per query.
class ViewRanking {
 public:
  // `neighbour`: the usual distance between neighbouring views; > 0.
  ViewRanking(const BundleGeometry& geometry, const std::vector<SourceView>& views,
              double neighbour);

  // The views in front of which the points (u, v, n) for the given n lie, best first, at most
  // `count`. Of views that are farther from the ray than `count` good ones none is looked at, so a
  // finer close-up far aside is not weighed.
  std::vector<Sight> Best(double u, double v, const std::array<double, 3>& nearness,
                          int count) const;

 private:
  struct Candidate {
    Sight sight;
    double distance = 0;  // from the view to the point
  };
  // Direction and picture; false where no point lies in front of the view and before the viewer.
  bool Assess(std::size_t index, double u, double v, const std::array<double, 3>& nearness,
              const Eigen::Vector3d& toward, double offset, Candidate* candidate) const;

  const BundleGeometry& geometry_;
  const std::vector<SourceView>& views_;
  double neighbour_;
  std::vector<Eigen::Matrix4d> view_from_bundle_;
};

}  // namespace lamella
