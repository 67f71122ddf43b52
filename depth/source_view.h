// A view of a capture made ready for being resampled: its inverse depth as a surface, its colours
// as a pyramid. Made once per view when a CaptureSource is built; read by every query.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Core>

#include "lightfield/camera.h"
#include "lightfield/depth_map.h"
#include "lightfield/image.h"
#include "lightfield/rigid.h"

namespace lamella {

// When neighbouring pixels belong to one surface: their inverse depths differ by less than a
// tolerance, and not by a step: a difference of more than half of the tolerance that is
// more than three times what it is on both sides (a slanted surface has one slope, an edge stands
// out).
struct SurfaceRule {
  double absolute = 0;  // 1 / world units
  double relative = 0;  // of the larger inverse depth
  double Tolerance(float a, float b) const {
    return absolute + relative * static_cast<double>(a > b ? a : b);
  }
  bool Same(float a, float b) const {
    return std::abs(static_cast<double>(a) - static_cast<double>(b)) <= Tolerance(a, b);
  }
  // b and c, between a and d in a row or column; unknown ones (< 0) outside count as level.
  bool Joined(float a, float b, float c, float d) const;
};

// One level of a view's depth: pixels 2^level times as large as those of the depth map. A surface:
// smooth cells (four neighbouring pixels of one surface) are interpolated, a broken cell is divided
// among its corners.
struct DepthLevel {
  int width = 0, height = 0;                // pixels
  double extent_x = 0, extent_y = 0;        // the picture spans [0, extent] level pixels
  double per_color_x = 0, per_color_y = 0;  // level pixels per colour pixel
  // (width + 2) x (height + 2): a border of repeated pixels, so that cells cover the whole picture
  // and lookups need no clamping. A few rows more, so that kernels may read a little too far.
  Image<float> inverse_depth;  // 1 / world units along the optical axis; 0 infinity, < 0 unknown
  Image<float> confidence;
  // Of cell (x, y), right below padded pixel (x, y): 1 or 0. As wide as the pixels, so that cell
  // and pixel have one index.
  Image<std::uint8_t> smooth;

  float Known(int x, int y) const { return inverse_depth(x + 1, y + 1); }  // unpadded

  // Squares of kBlock x kBlock cells with the range of what is known in them.
  struct Block {
    float nearest = -1, farthest = 0;  // inverse depth; nearest < 0: nothing is known
  };
  static constexpr int kBlock = 32;
  Image<Block> blocks;

  // Position of padded column or row `index` (0: the picture's side).
  float ColumnAt(int index) const {
    return std::min(std::max(static_cast<float>(index) - 0.5F, 0.0F), static_cast<float>(extent_x));
  }
  float RowAt(int index) const {
    return std::min(std::max(static_cast<float>(index) - 0.5F, 0.0F), static_cast<float>(extent_y));
  }
};

// Level 0 is the depth map itself; each further one halves it (the surface of a 2x2 square with
// most confidence, its mean). Ends at one pixel. `color_width` and `color_height`: the view's size.
std::vector<DepthLevel> DepthPyramid(const DepthMap& depth, int color_width, int color_height,
                                     const SurfaceRule& rule);

// One level of a view's colours, linear, non-negative, as half floats of colour * 2^exponent.
struct ColorLevel {
  struct Pixel {  // 8 bytes: four lanes, and half the memory traffic of floats
    std::uint16_t r = 0, g = 0, b = 0, unused = 0;
  };
  struct alignas(16) Sum {  // of pixels
    float channels[4] = {0, 0, 0, 0};
  };
  static constexpr int kPad = 2;  // repeated pixels on every side, for 4-tap filters
  int width = 0, height = 0;
  float scale_x = 1, scale_y = 1;  // level pixels per picture pixel
  Image<Pixel> pixels;             // (width + 4) x (height + 4)
};

// A view's colours at every scale: level l is about 2^(-l/2) as large as the picture
// (area-filtered), so that the nearest level is at most 2^(1/4) off a wanted scale. Most levels are
// made when they are first asked for: a display needs one or two of a photograph's.
class ColorPyramid {
 public:
  ColorPyramid() = default;
  // Colours are multiplied by `gain` and 2^exponent. Levels finer than `finest` are not kept; it
  // stands for them.
  ColorPyramid(const Image<Rgb>& color, Rgb gain, int exponent, std::size_t finest = 0);

  std::size_t size() const { return levels_.size(); }
  const ColorLevel& operator[](std::size_t level) const;  // from any thread
  // Of the next level where it is not there yet: bytes that it keeps, and those that it takes
  // meanwhile. Not while rays are asked for.
  struct Bytes {
    double kept = 0, meanwhile = 0;
  };
  Bytes BytesToCome() const;

 private:
  struct Lazy {
    int width = 0, height = 0;
    std::once_flag made;
    ColorLevel level;
  };
  std::vector<std::unique_ptr<Lazy>> levels_;
  std::size_t finest_ = 0;
};

// The exponent with which the largest colour is just below the largest half float, so that 40
// binary orders of magnitude fit below it.
int ColorExponent(float largest);

}  // namespace lamella
