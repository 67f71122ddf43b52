// The halos of a layered display: dark rims around what stands before something that another layer
// shows, and bright ones on it (ranieri2012.md section 8, experiments 8 to 10).
//
// A thing at z before another one leaves a shadow in the layer that shows the farther one, at z_l.
// Its edge is as wide there as that layer's beams are at z: boxes W_a and W_b (displays.md section
// 1.3), applied by the prefilter and again by the display, so that nothing of it is farther than
// W_a + W_b from the edge. The nearer thing's own edge, in its own layer, is less blurred; the two
// do not add up to the scene.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "distribute/assign.h"
#include "distribute/band_limit.h"
#include "distribute/metrics.h"
#include "distribute/simulate_eye.h"
#include "lightfield/beam.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

struct ShadowBlur {
  LayerWeights weights;
  std::vector<double> layers_mm;  // the modulating planes
  std::vector<Beam> beams;        // in the middle of each layer
  // What changes in depth by more than this per length along an axis hides something from some of a
  // layer's directions: 1 / tan of half the widest field of view. Without parallax +inf.
  double steepest_x = 0, steepest_y = 0;

  int LayerOf(float z) const;  // which shows most of it
};
// Nothing of a display with one layer.
std::optional<ShadowBlur> ShadowBlurOf(const Display& display);

enum class Rim : std::uint8_t {
  kNone,
  kBehind,
  kBefore
};  // of the edge: its farther, its nearer side

// The pixels within a shadow's blur of an edge, along the axis across which it lies and on both of
// its sides; where several meet, kBefore. An edge lies between neighbours, both known, that are
// shown by different layers and whose depths change so steeply that the nearer one occludes.
// Empty where nothing is occluded. Does not depend on the number of threads.
Image<Rim> RimsOf(const SeenScene& scene, const ShadowBlur& blur, const Eye& eye);

// Sums over pixels, of luminance in linear light.
struct LuminanceErrors {
  std::int64_t pixels = 0;
  double target = 0, error = 0, squared_error = 0;  // error: seen minus target

  // error / target, the mean error relative to the mean luminance; nothing where that is 0.
  std::optional<double> Relative() const;
  LuminanceErrors& operator+=(const LuminanceErrors& other);
};
struct HaloErrors {
  LuminanceErrors behind, before, elsewhere;
  HaloErrors& operator+=(const HaloErrors& other);
};
// Of what is seen against its target over the region's pixels, sRGB codes decoded. `rims` has the
// pictures' size.
HaloErrors SumHaloErrors(ImageSpan<const Rgb8> seen, ImageSpan<const Rgb8> target,
                         const Image<Rim>& rims, const MetricRegion& region);

// What is said of them.
struct HaloFigures {
  // Mean error relative to the mean luminance: of all rims; beside the edges, where shadows darken;
  // and on what stands before them, where light leaks.
  std::optional<double> relative_error, behind, before;
  double share_of_pixels = 0, share_of_squared_error = 0;
};
// Nothing where no rim's pixel counts.
std::optional<HaloFigures> FiguresOf(const HaloErrors& errors);

}  // namespace lamella
