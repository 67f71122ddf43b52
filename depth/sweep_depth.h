// Depth of a photograph from its neighbours: plane sweep, semi-global matching, median.
#pragma once

#include <optional>
#include <vector>

#include "depth/plane_sweep.h"
#include "lightfield/depth_map.h"
#include "lightfield/image.h"
#include "lightfield/view.h"

namespace lamella {

// 1/Z with its own validity: infinity is 0 and valid.
struct InverseDepthMap {
  static constexpr float kUnknown = -1;
  Image<float> w;           // 1 / world unit, >= 0, or kUnknown
  Image<float> confidence;  // [0, 1]
};
DepthMap ToDepth(const InverseDepthMap& map);
InverseDepthMap ToInverseDepth(const DepthMap& map);

// The camera of a photograph at the size at which it is swept: Resized, longer side at most
// size_px.
Camera SweepCamera(const Camera& full, int size_px);

// A photograph at that size.
struct SweepView {
  SweepView(const Image<Rgb8>& photograph, const Camera& full, int size_px);
  Camera camera;  // Resized
  Image<Rgb8> pixels;
  SweepImage image;
};

// How a point of `from`'s picture at inverse depth w appears in `to`'s (plane_sweep.h):
//   homogeneous pixel = m (x, y, 1) + w b;  inverse depth there = w / (its third coordinate)
struct PictureMap {
  Eigen::Matrix3d m;
  Eigen::Vector3d b;
};
PictureMap MapPictures(const Camera& from, const Rigid& from_from_world, const Camera& to,
                       const Rigid& to_from_world);

struct SweepOptions {
  int labels = 256;      // at most
  double step_px = 2.4;  // between labels in the widest source, where the labels suffice
  int median_radius = 3;
};

// Inverse depths between which a view's scene lies, 1 / world unit; near >= far.
struct InverseDepthRange {
  double far = 0, near = 0;
};

// Labels at the options' spacing (or as near to that as their number allows) over the range, then
// ever wider apart, up to 2.5 times that, out to infinity and one label beyond: points seldom lie
// on the sky and on the far background, yet these must not be mistaken for something near.
InverseDepthLabels ChooseSweepLabels(const Camera& reference,
                                     const std::vector<PictureMap>& sources,
                                     const InverseDepthRange& range, const SweepOptions& options);

// The range where no points have told: between the 0.5 % and 99.5 % quantiles of what a sweep at
// `reference`'s (small) size is sure of. The sweep goes from infinity up to where some source has
// moved by half of the picture. Nothing where nothing is sure.
std::optional<InverseDepthRange> MeasureRange(const SweepView& reference,
                                              const std::vector<const SweepView*>& sources,
                                              const std::vector<PictureMap>& maps,
                                              MatchMemory& memory);

InverseDepthMap EstimateSweepView(const SweepView& reference,
                                  const std::vector<const SweepView*>& sources,
                                  const std::vector<PictureMap>& maps,
                                  const InverseDepthLabels& labels, const SweepOptions& options,
                                  MatchMemory& memory);

}  // namespace lamella
