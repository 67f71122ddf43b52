#include "pipeline/report/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "depth/resize_area.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace {

std::string Base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t at) {
      return at < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at]))
                               : 0U;
    };
    const std::uint32_t bits = byte(i) << 16U | byte(i + 1) << 8U | byte(i + 2);
    text += kDigits[bits >> 18U & 63U];
    text += kDigits[bits >> 12U & 63U];
    text += i + 1 < bytes.size() ? kDigits[bits >> 6U & 63U] : '=';
    text += i + 2 < bytes.size() ? kDigits[bits & 63U] : '=';
  }
  return text;
}

int HeightFor(int width, int height, int new_width) {
  return std::max(1,
                  static_cast<int>(std::lround(static_cast<double>(height) * new_width / width)));
}

}  // namespace

Image<Rgb8> PageCodes(ImageSpan<const Rgb> linear, int max_width) {
  if (linear.width <= max_width) return EncodeSrgb8(linear);
  const int height = HeightFor(linear.width, linear.height, max_width);
  return EncodeSrgb8(ResizeArea(linear, max_width, height).span());
}

Image<Rgb8> PageCodes(int width, int height, const RowOf& row_of, int max_width) {
  const int page_width = std::min(width, max_width);
  const int page_height = page_width == width ? height : HeightFor(width, height, max_width);
  return EncodeSrgb8(ResizeAreaDownwards(width, height, row_of, page_width, page_height).span());
}

std::string DataUri(ImageSpan<const Rgb8> codes, const std::string& format, int jpeg_quality) {
  return "data:image/" + format + ";base64," + Base64(EncodeCodes8(codes, format, jpeg_quality));
}

std::string SvgDataUri(const std::string& svg) {
  return "data:image/svg+xml;base64," + Base64(svg);
}

DepthScale ScaleOf(const std::vector<const DepthMap*>& maps) {
  std::vector<float> inverse;
  for (const DepthMap* map : maps) {
    for (std::size_t i = 0; i < map->depth.size(); i += 7) {  // a seventh of them is plenty
      const float depth = map->depth.data()[i];
      if (depth > 0) inverse.push_back(std::isinf(depth) ? 0.0F : 1.0F / depth);
    }
  }
  if (inverse.empty()) return {};
  std::sort(inverse.begin(), inverse.end());
  const auto at = [&](double share) {
    const auto index = std::lround(share * static_cast<double>(inverse.size() - 1));
    return static_cast<double>(inverse[static_cast<std::size_t>(index)]);
  };
  DepthScale scale{at(0.01), at(0.99)};
  // All at one depth: it gets the middle colour.
  if (!(scale.near_inverse > scale.far_inverse)) {
    const double w = scale.far_inverse, half = w > 0 ? 0.05 * w : 0.5;
    scale = {w - half, w + half};
  }
  return scale;
}

Rgb8 DepthColor(double share) {
  const double x = std::clamp(share, 0.0, 1.0);
  const auto code = [x](const std::array<double, 6>& c) {
    const double value = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  };
  return {code({0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943}),
          code({0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604}),
          code({0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973})};
}

Image<Rgb8> ColoredDepth(const DepthMap& map, const DepthScale& scale, int max_width) {
  const int from_width = map.depth.width(), from_height = map.depth.height();
  const int width = std::min(max_width, from_width);
  const int height = HeightFor(from_width, from_height, width);
  Image<Rgb8> picture(width, height);
  const double range = scale.near_inverse - scale.far_inverse;
  for (int y = 0; y < height; ++y) {
    const int from_y =
        std::min(from_height - 1, static_cast<int>((y + 0.5) * from_height / height));
    for (int x = 0; x < width; ++x) {
      const int from_x = std::min(from_width - 1, static_cast<int>((x + 0.5) * from_width / width));
      const double depth = static_cast<double>(map.depth(from_x, from_y));
      if (depth > 0) {
        const double inverse = std::isinf(depth) ? 0 : 1 / depth;
        picture(x, y) = DepthColor((inverse - scale.far_inverse) / range);
      } else {
        const std::uint8_t grey = (x + y) / 4 % 2 == 0 ? 107 : 168;
        picture(x, y) = {grey, grey, grey};
      }
    }
  }
  return picture;
}

double KnownShare(const DepthMap& map) {
  const float* depth = map.depth.data();
  const auto known = std::count_if(depth, depth + map.depth.size(), [](float d) { return d > 0; });
  return map.depth.empty() ? 0 : static_cast<double>(known) / static_cast<double>(map.depth.size());
}

}  // namespace lamella
