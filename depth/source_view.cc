#include "depth/source_view.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "depth/resize_area.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr double kStep = 0.5, kStandsOut = 3;  // see SurfaceRule
constexpr float kLeastConfidence = 1e-3F;
constexpr float kLargestInverseDepth = 1e20F;  // far from overflow when it is mapped
constexpr int kHalfExponent = 15;              // 2^16 is beyond the largest half float
constexpr int kReadAhead = 32;                 // kernels read so many pixels too far
constexpr int kSmallestColorLevel = 8;         // px of the longer side
// Levels so much coarser than the finest one are made of it, nearer ones of the picture itself:
// averaging twice would blur them.
constexpr std::size_t kMuchCoarser = 3;

struct DepthPixel {
  float inverse_depth = -1, confidence = 0;
};

DepthPixel FromDepth(float depth, float confidence) {
  if (!(depth > 0)) return {};  // also NaN
  // Merging weighs by confidence, so that none is ever 0.
  const float sure = confidence > kLeastConfidence ? std::min(confidence, 1.0F) : kLeastConfidence;
  return {std::min(1.0F / depth, kLargestInverseDepth), sure};
}

void Allocate(DepthLevel& level) {
  const int stride = level.width + 2;
  level.inverse_depth = Image<float>(stride, level.height + 2 + kReadAhead / stride + 1, -1.0F);
  level.confidence = Image<float>(level.width + 2, level.height + 2);
}

void Set(DepthLevel& level, int x, int y, const DepthPixel& pixel) {
  level.inverse_depth(x + 1, y + 1) = pixel.inverse_depth;
  level.confidence(x + 1, y + 1) = pixel.confidence;
}

void RepeatBorder(int width, int height, Image<float>& pixels) {
  const int right = width + 1, bottom = height + 1;
  for (int y = 1; y < bottom; ++y) {
    pixels(0, y) = pixels(1, y);
    pixels(right, y) = pixels(right - 1, y);
  }
  for (int x = 0; x <= right; ++x) {
    pixels(x, 0) = pixels(x, 1);
    pixels(x, bottom) = pixels(x, bottom - 1);
  }
}

// Which neighbours are joined, for all pixels of a padded map: bit 0 to the right, bit 1 downwards.
Image<std::uint8_t> Joints(const DepthLevel& level, const SurfaceRule& rule) {
  const Image<float>& pixels = level.inverse_depth;
  const int width = level.width + 2, height = level.height + 2;
  Image<std::uint8_t> joints(width, height);
  const auto at = [&](int x, int y) {
    return pixels(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1));
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool right = rule.Joined(at(x - 1, y), at(x, y), at(x + 1, y), at(x + 2, y));
      const bool down = rule.Joined(at(x, y - 1), at(x, y), at(x, y + 1), at(x, y + 2));
      joints(x, y) = static_cast<std::uint8_t>((right ? 1 : 0) | (down ? 2 : 0));
    }
  }
  return joints;
}

DepthLevel::Block RangeOf(const Image<float>& pixels, const Rect& cells) {
  DepthLevel::Block block{-1, std::numeric_limits<float>::max()};
  for (int y = cells.y; y <= cells.y + cells.height; ++y) {
    for (int x = cells.x; x <= cells.x + cells.width; ++x) {
      const float w = pixels(x, y);
      if (w < 0) continue;
      block.nearest = std::max(block.nearest, w);
      block.farthest = std::min(block.farthest, w);
    }
  }
  return block;
}

// Cells and blocks of a level whose pixels are there.
void Finish(DepthLevel& level, const SurfaceRule& rule) {
  RepeatBorder(level.width, level.height, level.inverse_depth);
  RepeatBorder(level.width, level.height, level.confidence);
  const Image<std::uint8_t> joints = Joints(level, rule);
  const int stride = level.width + 2;
  level.smooth = Image<std::uint8_t>(stride, level.height + 2 + kReadAhead / stride);
  for (int y = 0; y <= level.height; ++y) {
    for (int x = 0; x <= level.width; ++x) {
      const int all = joints(x, y) & 3;
      level.smooth(x, y) = all == 3 && (joints(x + 1, y) & 2) != 0 && (joints(x, y + 1) & 1) != 0;
    }
  }
  constexpr int kBlock = DepthLevel::kBlock;
  level.blocks = Image<DepthLevel::Block>(level.width / kBlock + 1, level.height / kBlock + 1);
  for (int y = 0; y < level.blocks.height(); ++y) {
    for (int x = 0; x < level.blocks.width(); ++x) {
      const Rect cells{x * kBlock, y * kBlock, std::min(kBlock, level.width + 1 - x * kBlock),
                       std::min(kBlock, level.height + 1 - y * kBlock)};
      level.blocks(x, y) = RangeOf(level.inverse_depth, cells);
    }
  }
}

// One pixel for up to four: of the surface that has the most confidence among them (the nearer one
// of equals), its mean; pixels that are unknown or of other surfaces lower the confidence.
DepthPixel Merge(const std::array<DepthPixel, 4>& pixels, int count, const SurfaceRule& rule) {
  float best_support = 0, best_nearest = -1;
  DepthPixel merged;
  for (int i = 0; i < count; ++i) {
    const DepthPixel& seed = pixels[static_cast<std::size_t>(i)];
    if (seed.inverse_depth < 0) continue;
    float support = 0, sum = 0;
    for (int j = 0; j < count; ++j) {
      const DepthPixel& other = pixels[static_cast<std::size_t>(j)];
      if (other.inverse_depth < 0 || !rule.Same(seed.inverse_depth, other.inverse_depth)) continue;
      support += other.confidence;
      sum += other.confidence * (other.inverse_depth - seed.inverse_depth);
    }
    if (support < best_support || (support == best_support && seed.inverse_depth <= best_nearest)) {
      continue;
    }
    best_support = support;
    best_nearest = seed.inverse_depth;
    merged = {std::max(seed.inverse_depth + sum / support, 0.0F),
              support / static_cast<float>(count)};
  }
  return merged;
}

DepthLevel Halved(const DepthLevel& fine, const SurfaceRule& rule) {
  DepthLevel level;
  level.width = (fine.width + 1) / 2;
  level.height = (fine.height + 1) / 2;
  level.extent_x = fine.extent_x / 2;
  level.extent_y = fine.extent_y / 2;
  level.per_color_x = fine.per_color_x / 2;
  level.per_color_y = fine.per_color_y / 2;
  Allocate(level);
  for (int y = 0; y < level.height; ++y) {
    for (int x = 0; x < level.width; ++x) {
      std::array<DepthPixel, 4> square;
      int count = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, fine.height); ++v) {
        for (int u = 2 * x; u < std::min(2 * x + 2, fine.width); ++u) {
          square[static_cast<std::size_t>(count++)] = {fine.inverse_depth(u + 1, v + 1),
                                                       fine.confidence(u + 1, v + 1)};
        }
      }
      Set(level, x, y, Merge(square, count, rule));
    }
  }
  Finish(level, rule);
  return level;
}

// IEEE 754 binary16, to nearest even; negative values are 0, larger ones the largest half.
std::uint16_t HalfFromFloat(float value) {
  if (!(value > 0)) return 0;
  if (value >= 65504.0F) return 0x7BFF;
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const int exponent = static_cast<int>(bits >> 23) - 127;
  if (exponent < -14) {  // subnormal: a multiple of 2^-24
    return static_cast<std::uint16_t>(std::nearbyint(std::ldexp(value, 24)));
  }
  const std::uint32_t rounded = bits + 0x0FFF + ((bits >> 13) & 1);  // carries into the exponent
  return static_cast<std::uint16_t>((rounded >> 13) - ((127 - 15) << 10));
}

ColorLevel Padded(const Image<Rgb>& color, Rgb gain, int picture_width, int picture_height) {
  constexpr int kPad = ColorLevel::kPad;
  ColorLevel level;
  level.width = color.width();
  level.height = color.height();
  level.scale_x = static_cast<float>(level.width) / static_cast<float>(picture_width);
  level.scale_y = static_cast<float>(level.height) / static_cast<float>(picture_height);
  level.pixels = Image<ColorLevel::Pixel>(level.width + 2 * kPad, level.height + 2 * kPad);
  ParallelFor(0, level.pixels.height(), 32, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      const Rgb* from = color.row(std::clamp(y - kPad, 0, level.height - 1));
      ColorLevel::Pixel* to = level.pixels.row(y);
      for (int x = 0; x < level.pixels.width(); ++x) {
        const Rgb& p = from[std::clamp(x - kPad, 0, level.width - 1)];
        to[x] = {HalfFromFloat(gain.r * p.r), HalfFromFloat(gain.g * p.g),
                 HalfFromFloat(gain.b * p.b), 0};
      }
    }
  });
  return level;
}

float FloatFromHalf(std::uint16_t half) {
  if (half < 0x0400) return std::ldexp(static_cast<float>(half), -24);
  return std::bit_cast<float>((static_cast<std::uint32_t>(half) << 13) + ((127U - 15U) << 23));
}

// A smaller level of a picture than `whole` is.
ColorLevel Reduced(const ColorLevel& whole, int width, int height, int picture_width,
                   int picture_height) {
  const auto row = [&](int y, Rgb* buffer) -> const Rgb* {
    const ColorLevel::Pixel* from = whole.pixels.row(y + ColorLevel::kPad) + ColorLevel::kPad;
    for (int x = 0; x < whole.width; ++x) {
      buffer[x] = {FloatFromHalf(from[x].r), FloatFromHalf(from[x].g), FloatFromHalf(from[x].b)};
    }
    return buffer;
  };
  return Padded(ResizeArea(whole.width, whole.height, row, width, height), {1, 1, 1}, picture_width,
                picture_height);
}

}  // namespace

bool SurfaceRule::Joined(float a, float b, float c, float d) const {
  if (b < 0 || c < 0) return false;
  const double step = std::abs(static_cast<double>(c) - static_cast<double>(b));
  const double tolerance = Tolerance(b, c);
  if (step > tolerance) return false;
  if (step <= kStep * tolerance) return true;
  const double before = a < 0 ? 0 : std::abs(static_cast<double>(b) - static_cast<double>(a));
  const double after = d < 0 ? 0 : std::abs(static_cast<double>(d) - static_cast<double>(c));
  return step <= kStandsOut * std::max(before, after);
}

std::vector<DepthLevel> DepthPyramid(const DepthMap& depth, int color_width, int color_height,
                                     const SurfaceRule& rule) {
  DepthLevel base;
  base.width = depth.depth.width();
  base.height = depth.depth.height();
  base.extent_x = base.width;
  base.extent_y = base.height;
  base.per_color_x = static_cast<double>(base.width) / color_width;
  base.per_color_y = static_cast<double>(base.height) / color_height;
  Allocate(base);
  for (int y = 0; y < base.height; ++y) {
    for (int x = 0; x < base.width; ++x) {
      Set(base, x, y, FromDepth(depth.depth(x, y), depth.confidence(x, y)));
    }
  }
  Finish(base, rule);
  std::vector<DepthLevel> levels;
  levels.push_back(std::move(base));
  while (levels.back().width > 1 || levels.back().height > 1) {
    levels.push_back(Halved(levels.back(), rule));
  }
  return levels;
}

ColorPyramid::ColorPyramid(const Image<Rgb>& color, Rgb gain, int exponent, std::size_t finest) {
  for (int l = 0;; ++l) {
    const double scale = std::exp2(-0.5 * l);
    const int width = std::max(1, static_cast<int>(std::lround(color.width() * scale)));
    const int height = std::max(1, static_cast<int>(std::lround(color.height() * scale)));
    if (l > 0 && std::max(width, height) < kSmallestColorLevel) break;
    levels_.push_back(std::make_unique<Lazy>());
    levels_.back()->width = width;
    levels_.back()->height = height;
  }
  finest_ = std::min(finest, levels_.size() - 1);
  const Rgb scale = std::ldexp(1.0F, exponent) * gain;
  const std::size_t end = finest_ == 0 ? 1 : std::min(finest_ + kMuchCoarser, levels_.size());
  for (std::size_t l = finest_; l < end; ++l) {
    Lazy& made = *levels_[l];
    std::call_once(made.made, [&] {
      made.level = l == 0 ? Padded(color, scale, color.width(), color.height())
                          : Padded(ResizeArea(color.span(), made.width, made.height), scale,
                                   color.width(), color.height());
    });
  }
}

const ColorLevel& ColorPyramid::operator[](std::size_t level) const {
  Lazy& lazy = *levels_[std::max(level, finest_)];
  // Rays of other threads wait for the level meanwhile.
  std::call_once(lazy.made, [&] {
    Isolated([&] {
      lazy.level = Reduced(levels_[finest_]->level, lazy.width, lazy.height, levels_[0]->width,
                           levels_[0]->height);
    });
  });
  return lazy.level;
}

ColorPyramid::Bytes ColorPyramid::BytesToCome() const {
  if (finest_ + 1 >= levels_.size()) return {};
  const Lazy& next = *levels_[finest_ + 1];
  if (next.level.width > 0) return {};
  const double pixels = static_cast<double>(next.width) * next.height;
  return {sizeof(ColorLevel::Pixel) * pixels, sizeof(Rgb) * pixels};
}

int ColorExponent(float largest) {
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);  // largest < 2^exponent
  return std::clamp(kHalfExponent - exponent, -120, 120);
}

}  // namespace lamella
