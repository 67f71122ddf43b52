#include "depth/resize_area.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

// The old pixels first .. first + weights.size() - 1 that a new one covers, and their shares.
struct Covered {
  int first = 0;
  std::vector<float> weights;  // sum 1
};

std::vector<Covered> Covers(int from, int to) {
  std::vector<Covered> covers(static_cast<std::size_t>(to));
  const double step = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double begin = i * step, end = (i + 1) * step;
    Covered& cover = covers[static_cast<std::size_t>(i)];
    cover.first = std::min(static_cast<int>(begin), from - 1);
    const int last = std::clamp(static_cast<int>(std::ceil(end)) - 1, cover.first, from - 1);
    for (int j = cover.first; j <= last; ++j) {
      const double overlap = std::min<double>(end, j + 1) - std::max<double>(begin, j);
      cover.weights.push_back(static_cast<float>(std::max(overlap, 0.0) / step));
    }
  }
  return covers;
}

class AreaFilter {
 public:
  AreaFilter(int image_width, int image_height, const RowOf& row_of, int width, int height)
      : columns_(Covers(image_width, width)),
        rows_(Covers(image_height, height)),
        row_of_(row_of),
        image_width_(static_cast<std::size_t>(image_width)) {}

  // New rows [first, last).
  void Resize(int first, int last, Image<Rgb>& resized) const {
    std::vector<Rgb> line(image_width_), buffer(image_width_);
    for (int y = first; y < last; ++y) {
      const Covered& row = rows_[static_cast<std::size_t>(y)];
      std::fill(line.begin(), line.end(), Rgb());
      for (std::size_t j = 0; j < row.weights.size(); ++j) {
        const Rgb* from = row_of_(row.first + static_cast<int>(j), buffer.data());
        for (std::size_t x = 0; x < line.size(); ++x) line[x] += row.weights[j] * from[x];
      }
      for (int x = 0; x < resized.width(); ++x) {
        const Covered& column = columns_[static_cast<std::size_t>(x)];
        Rgb sum;
        for (std::size_t j = 0; j < column.weights.size(); ++j) {
          sum += column.weights[j] * line[static_cast<std::size_t>(column.first) + j];
        }
        resized(x, y) = sum;
      }
    }
  }

 private:
  const std::vector<Covered> columns_, rows_;
  const RowOf& row_of_;
  const std::size_t image_width_;
};

}  // namespace

Image<Rgb> ResizeArea(ImageSpan<const Rgb> image, int width, int height) {
  return ResizeArea(
      image.width, image.height, [&](int y, Rgb*) { return image.row(y); }, width, height);
}

Image<Rgb> ResizeArea(int image_width, int image_height, const RowOf& row, int width, int height) {
  const AreaFilter filter(image_width, image_height, row, width, height);
  Image<Rgb> resized(width, height);
  ParallelFor(0, height, 16, [&](std::int64_t first, std::int64_t last) {
    filter.Resize(static_cast<int>(first), static_cast<int>(last), resized);
  });
  return resized;
}

Image<Rgb> ResizeAreaDownwards(int image_width, int image_height, const RowOf& row, int width,
                               int height) {
  Image<Rgb> resized(width, height);
  AreaFilter(image_width, image_height, row, width, height).Resize(0, height, resized);
  return resized;
}

}  // namespace lamella
