#include "depth/shrink.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Sum = std::array<float, 3>;

// What of the input an output pixel covers: pixels [begin, end), the first and the last in part.
struct Cover {
  int begin, end;
  float first, last;
  float Weight(int i) const { return i == begin ? first : i == end - 1 ? last : 1.0F; }
};

Cover CoverOf(int i, int from, int to) {
  const double scale = static_cast<double>(from) / to;
  const double left = i * scale, right = std::min<double>(from, (i + 1) * scale);
  const int begin = std::min(static_cast<int>(left), from - 1);
  const int end = std::clamp(static_cast<int>(std::ceil(right - 1e-9)), begin + 1, from);
  const double first = std::min(right, begin + 1.0) - left;
  const double last = end - 1 == begin ? first : right - (end - 1);
  return {begin, end, static_cast<float>(first), static_cast<float>(last)};
}

void AddRow(const Rgb8* row, float weight, const std::vector<Cover>& columns,
            std::vector<Sum>& sums) {
  for (std::size_t x = 0; x < columns.size(); ++x) {
    const Cover& cover = columns[x];
    for (int u = cover.begin; u < cover.end; ++u) {
      const float w = weight * cover.Weight(u);
      sums[x][0] += w * static_cast<float>(row[u].r);
      sums[x][1] += w * static_cast<float>(row[u].g);
      sums[x][2] += w * static_cast<float>(row[u].b);
    }
  }
}

}  // namespace

Image<Rgb8> ShrinkTo(ImageSpan<const Rgb8> image, int width, int height) {
  Image<Rgb8> small(width, height);
  std::vector<Cover> columns;
  for (int x = 0; x < width; ++x) columns.push_back(CoverOf(x, image.width, width));
  const float area = static_cast<float>(static_cast<double>(image.width) / width *
                                        (static_cast<double>(image.height) / height));
  ParallelFor(0, height, 16, [&](std::int64_t first, std::int64_t last) {
    std::vector<Sum> sums(columns.size());
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      std::fill(sums.begin(), sums.end(), Sum{});
      const Cover rows = CoverOf(y, image.height, height);
      for (int v = rows.begin; v < rows.end; ++v)
        AddRow(image.row(v), rows.Weight(v), columns, sums);
      for (int x = 0; x < width; ++x) {
        const Sum& s = sums[static_cast<std::size_t>(x)];
        const auto code = [&](float sum) {
          return static_cast<std::uint8_t>(std::clamp(sum / area + 0.5F, 0.0F, 255.0F));
        };
        small(x, y) = {code(s[0]), code(s[1]), code(s[2])};
      }
    }
  });
  return small;
}

Image<std::uint8_t> LumaOf(ImageSpan<const Rgb8> image) {
  Image<std::uint8_t> luma(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb8 p = image(x, y);
      luma(x, y) = static_cast<std::uint8_t>((77 * p.r + 150 * p.g + 29 * p.b + 128) >> 8);
    }
  }
  return luma;
}

}  // namespace lamella
