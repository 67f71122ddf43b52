#include "datasets_synthetic/image_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "lightfield/image_io.h"

namespace lamella {
namespace {

// What texel `i` of n averages of `from` texels: the interval [i, i + 1) from / n, whose ends may
// cut texels. At most 3 texels where n = ceil(from / 2).
struct Cut {
  int first = 0, count = 0;
  float weight[3] = {};
};

Cut CutOf(int i, int n, int from) {
  const double low = static_cast<double>(i) * from / n,
               high = static_cast<double>(i + 1) * from / n;
  Cut cut;
  cut.first = static_cast<int>(std::floor(low));
  for (int k = 0; k < 3 && cut.first + k < from; ++k) {
    const double left = std::max(low, static_cast<double>(cut.first + k));
    const double right = std::min(high, static_cast<double>(cut.first + k + 1));
    if (!(right - left > 1e-9)) break;
    cut.weight[k] = static_cast<float>((right - left) / (high - low));
    cut.count = k + 1;
  }
  return cut;
}

Image<Rgb> Halved(const Image<Rgb>& image) {
  Image<Rgb> half((image.width() + 1) / 2, (image.height() + 1) / 2);
  for (int y = 0; y < half.height(); ++y) {
    const Cut rows = CutOf(y, half.height(), image.height());
    for (int x = 0; x < half.width(); ++x) {
      const Cut columns = CutOf(x, half.width(), image.width());
      Rgb sum;
      for (int j = 0; j < rows.count; ++j) {
        for (int i = 0; i < columns.count; ++i) {
          sum += (rows.weight[j] * columns.weight[i]) * image(columns.first + i, rows.first + j);
        }
      }
      half(x, y) = sum;
    }
  }
  return half;
}

int Inside(std::int64_t i, int n, bool repeat) {
  if (!repeat) return static_cast<int>(std::clamp<std::int64_t>(i, 0, n - 1));
  const std::int64_t r = i % n;
  return static_cast<int>(r < 0 ? r + n : r);
}

// `uv` within a few units of [0, 1].
Rgb Bilinear(const Image<Rgb>& level, const Eigen::Vector2d& uv, bool repeat) {
  const double x = uv.x() * level.width() - 0.5, y = (1 - uv.y()) * level.height() - 0.5;
  const double x_floor = std::floor(x), y_floor = std::floor(y);
  const auto a = static_cast<float>(x - x_floor), b = static_cast<float>(y - y_floor);
  const auto i = static_cast<std::int64_t>(x_floor), j = static_cast<std::int64_t>(y_floor);
  const int x0 = Inside(i, level.width(), repeat), x1 = Inside(i + 1, level.width(), repeat);
  const int y0 = Inside(j, level.height(), repeat), y1 = Inside(j + 1, level.height(), repeat);
  return (1 - b) * ((1 - a) * level(x0, y0) + a * level(x1, y0)) +
         b * ((1 - a) * level(x0, y1) + a * level(x1, y1));
}

}  // namespace

ImageTexture MakeImageTexture(Image<Rgb> picture, bool repeat) {
  auto pyramid = std::make_shared<ImagePyramid>();
  pyramid->levels.push_back(std::move(picture));
  while (pyramid->levels.back().size() > 1) {
    Image<Rgb> next = Halved(pyramid->levels.back());
    pyramid->levels.push_back(std::move(next));
  }
  return {std::move(pyramid), repeat};
}

ImageTexture ReadImageTexture(const std::filesystem::path& path) {
  return MakeImageTexture(ReadImage(path));
}

Rgb ColorAt(const ImageTexture& texture, const Eigen::Vector2d& uv,
            const Eigen::Vector2d& footprint) {
  const std::vector<Image<Rgb>>& levels = texture.pyramid->levels;
  // Whole turns taken off where the picture repeats: texels are then counted in small numbers.
  Eigen::Vector2d at = uv;
  if (texture.repeat) at -= Eigen::Vector2d(std::floor(uv.x()), std::floor(uv.y()));
  at = at.cwiseMax(-2).cwiseMin(3);
  // One level up from texels of the patch's size: between two levels the finer one's texels then
  // still are no smaller than the patch.
  const double texels =
      std::max(footprint.x() * levels[0].width(), footprint.y() * levels[0].height());
  const double last = static_cast<double>(levels.size() - 1);
  const double level = texels > 0 ? std::clamp(std::log2(texels) + 1, 0.0, last) : 0.0;
  const auto fine = static_cast<std::size_t>(level);
  const auto share = static_cast<float>(level - std::floor(level));
  const Rgb color = Bilinear(levels[fine], at, texture.repeat);
  if (share == 0) return color;
  return (1 - share) * color + share * Bilinear(levels[fine + 1], at, texture.repeat);
}

}  // namespace lamella
