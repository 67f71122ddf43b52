#include "lightfield/quilt.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace lamella {
namespace {

// Takes digits (and, where `fraction`, a point and more digits) off the front of `text`.
std::optional<double> TakeNumber(std::string_view& text, bool fraction) {
  const auto digits = [&](std::size_t from) {
    return std::min(text.find_first_not_of("0123456789", from), text.size());
  };
  std::size_t end = digits(0);
  if (end == 0) return std::nullopt;
  if (fraction && end + 1 < text.size() && text[end] == '.' && digits(end + 1) > end + 1) {
    end = digits(end + 1);
  }
  double number = 0;
  const auto result = std::from_chars(text.data(), text.data() + end, number);
  if (result.ec != std::errc()) return std::nullopt;
  text.remove_prefix(end);
  return number;
}

bool Take(std::string_view& text, char letter) {
  if (text.empty() || text.front() != letter) return false;
  text.remove_prefix(1);
  return true;
}

bool IsSide(const std::optional<double>& tiles) {
  return tiles && *tiles >= 1 && *tiles <= kMaxQuiltSide;
}

// Of what follows "_qs".
std::optional<QuiltLayout> ParseLayout(std::string_view text) {
  const std::optional<double> columns = TakeNumber(text, false);
  if (!Take(text, 'x')) return std::nullopt;
  const std::optional<double> rows = TakeNumber(text, false);
  if (!IsSide(columns) || !IsSide(rows)) return std::nullopt;
  QuiltLayout layout{static_cast<int>(*columns), static_cast<int>(*rows), std::nullopt};
  if (Take(text, 'a')) layout.aspect = TakeNumber(text, true);
  if (layout.aspect && !(*layout.aspect > 0)) return std::nullopt;
  return layout;
}

// Without an extension; the fraction of an aspect is none.
std::string_view Stem(std::string_view name) {
  const std::size_t point = name.rfind('.');
  if (point == std::string_view::npos) return name;
  const bool is_fraction =
      name.find_first_not_of("0123456789", point + 1) == std::string_view::npos;
  return is_fraction ? name : name.substr(0, point);
}

}  // namespace

Rect QuiltTile(int view, int columns, int rows, int width_px, int height_px) {
  const int width = width_px / columns, height = height_px / rows;
  return {view % columns * width, height_px - (view / columns + 1) * height, width, height};
}

std::optional<QuiltLayout> QuiltLayoutOf(std::string_view file_name) {
  constexpr std::string_view kMark = "_qs";
  std::string_view name = Stem(file_name);
  for (std::size_t at = name.rfind(kMark); at != std::string_view::npos; at = name.rfind(kMark)) {
    if (const auto layout = ParseLayout(name.substr(at + kMark.size()))) return layout;
    name = name.substr(0, at);
  }
  return std::nullopt;
}

std::string QuiltSuffix(const QuiltLayout& layout) {
  const std::string grid = fmt::format("_qs{}x{}", layout.columns, layout.rows);
  return layout.aspect ? grid + fmt::format("a{:.5g}", *layout.aspect) : grid;
}

ImageSpan<const Rgb8> QuiltView(ImageSpan<const Rgb8> quilt, const QuiltLayout& layout, int view) {
  return quilt.Sub(QuiltTile(view, layout.columns, layout.rows, quilt.width, quilt.height));
}

void PutQuiltView(ImageSpan<Rgb8> quilt, const QuiltLayout& layout, int view,
                  ImageSpan<const Rgb8> picture) {
  const ImageSpan<Rgb8> tile =
      quilt.Sub(QuiltTile(view, layout.columns, layout.rows, quilt.width, quilt.height));
  for (int y = 0; y < tile.height; ++y) {
    std::copy(picture.row(y), picture.row(y) + tile.width, tile.row(y));
  }
}

int QuiltViews(ImageSpan<const Rgb8> quilt, const QuiltLayout& layout) {
  const auto is_black = [&](int view) {
    const ImageSpan<const Rgb8> tile = QuiltView(quilt, layout, view);
    double sum = 0;
    for (int y = 0; y < tile.height; ++y) {
      for (int x = 0; x < tile.width; ++x) {
        const Rgb8 p = tile(x, y);
        sum += p.r + p.g + p.b;
      }
    }
    return sum < 3.0 * tile.width * tile.height;
  };
  int views = layout.columns * layout.rows;
  while (views > 0 && is_black(views - 1)) --views;
  return views;
}

QuiltCamera CameraOf(const QuiltCameras& cameras, int view) {
  constexpr double kRadians = std::numbers::pi / 180;
  QuiltCamera camera;
  camera.distance = cameras.half_height / std::tan(cameras.vertical_deg * kRadians / 2);
  const double share = cameras.views > 1 ? static_cast<double>(view) / (cameras.views - 1) : 0.5;
  camera.x = camera.distance * std::tan(cameras.cone_deg * kRadians * (share - 0.5));
  camera.shift = -camera.x / (cameras.half_height * cameras.aspect);
  return camera;
}

double QuiltPosition(const QuiltCameras& cameras, int view, double x, double z) {
  const QuiltCamera camera = CameraOf(cameras, view);
  const double on_screen = camera.x + (x - camera.x) * camera.distance / (camera.distance - z);
  return on_screen / (cameras.half_height * cameras.aspect);
}

RayBundle QuiltRays(const QuiltCameras& cameras, int view, int tile_width_px, int tile_height_px) {
  const QuiltCamera camera = CameraOf(cameras, view);
  const double half_width = cameras.half_height * cameras.aspect;
  RayBundle rays;
  rays.centre = {camera.x, 0, camera.distance, 1};
  rays.origin = {-half_width, cameras.half_height, 0};
  rays.dx = {2 * half_width / tile_width_px, 0, 0};
  rays.dy = {0, -2 * cameras.half_height / tile_height_px, 0};
  rays.width = tile_width_px;
  rays.height = tile_height_px;
  return rays;
}

}  // namespace lamella
