#include "depth/forward_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "depth/bundle_map.h"

namespace lamella {
namespace {

constexpr int kBlock = DepthLevel::kBlock;
// Cells nearer to the viewer's own plane than this (of the block's distance) are not drawn: they
// have no extent there.
constexpr float kInFront = 1e-6F;
// Triangles overlap by this share of their size, so that rounding leaves no cracks between them.
constexpr float kOverlap = 1e-3F;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Vertex {
  float u, v, n;
};

class Canvas {
 public:
  explicit Canvas(ImageSpan<float> nearness) : nearness_(nearness) {}

  // Cell corners a b / c d with the diagonal b-c.
  void Quad(const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d) const {
    const Rect box = Box(std::min(std::min(a.u, b.u), std::min(c.u, d.u)),
                         std::max(std::max(a.u, b.u), std::max(c.u, d.u)),
                         std::min(std::min(a.v, b.v), std::min(c.v, d.v)),
                         std::max(std::max(a.v, b.v), std::max(c.v, d.v)));
    if (box.width <= 0 || box.height <= 0) return;
    Triangle(a, b, c, box);
    Triangle(d, c, b, box);
  }

 private:
  // The rays whose plane points (i + 0.5, j + 0.5) lie in the box, cut to the bundle.
  Rect Box(float u0, float u1, float v0, float v1) const {
    // Written so that what is not a number becomes the whole side; no triangle comes of it.
    const auto first = [](float low, int size) {
      const float at = low - 0.5F > 0 ? low - 0.5F : 0.0F;
      return static_cast<int>(
          std::ceil(at < static_cast<float>(size) ? at : static_cast<float>(size)));
    };
    const auto last = [](float high, int size) {
      const float at =
          high - 0.5F < static_cast<float>(size - 1) ? high - 0.5F : static_cast<float>(size - 1);
      return static_cast<int>(std::floor(at > -1.0F ? at : -1.0F));
    };
    const int x = first(u0, nearness_.width), y = first(v0, nearness_.height);
    return {x, y, last(u1, nearness_.width) - x + 1, last(v1, nearness_.height) - y + 1};
  }

  void Triangle(const Vertex& a, const Vertex& b, const Vertex& c, const Rect& box) const {
    const float bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v;
    const float area = bu * cv - cu * bv;
    if (!(area > 0)) return;  // from behind, on edge, or not a number
    const float inverse = 1.0F / area;
    // Barycentric weights of b and c: linear in the position.
    const float beta_u = cv * inverse, beta_v = -cu * inverse;
    const float gamma_u = -bv * inverse, gamma_v = bu * inverse;
    const float n_b = b.n - a.n, n_c = c.n - a.n;
    for (int y = box.y; y < box.y + box.height; ++y) {
      const float dv = static_cast<float>(y) + 0.5F - a.v;
      const float beta_0 = beta_v * dv, gamma_0 = gamma_v * dv;
      float* row = nearness_.row(y);
      const auto [first, last] = box.width <= 8
                                     ? std::pair(box.x, box.x + box.width)
                                     : Covered(box, a.u, beta_u, beta_0, gamma_u, gamma_0);
      for (int x = first; x < last; ++x) {
        const float du = static_cast<float>(x) + 0.5F - a.u;
        const float beta = beta_u * du + beta_0, gamma = gamma_u * du + gamma_0;
        if (beta < -kOverlap || gamma < -kOverlap || beta + gamma > 1 + kOverlap) continue;
        const float n = a.n + beta * n_b + gamma * n_c;
        if (n > row[x] && n < kInfinity) row[x] = n;
      }
    }
  }

  // Columns of a row that the triangle can cover, a little generous: long thin triangles would
  // otherwise cost their whole box.
  static std::pair<int, int> Covered(const Rect& box, float at_u, float beta_u, float beta_0,
                                     float gamma_u, float gamma_0) {
    float low = static_cast<float>(box.x), high = static_cast<float>(box.x + box.width);
    const auto cut = [&](float slope, float value) {  // slope * du + value >= -kOverlap
      if (slope == 0) return;
      const float at = at_u + (-2 * kOverlap - value) / slope;
      if (slope > 0) {
        low = std::max(low, at - 1.5F);
      } else {
        high = std::min(high, at + 1.5F);
      }
    };
    cut(beta_u, beta_0);
    cut(gamma_u, gamma_0);
    cut(-(beta_u + gamma_u), 1 - beta_0 - gamma_0);
    if (!(low < high)) return {0, 0};
    return {static_cast<int>(low), static_cast<int>(high)};
  }

  ImageSpan<float> nearness_;
};

// Rows of a block's vertices, mapped.
struct VertexRow {
  std::array<float, kBlock + 1> u, v, n, m;
};

class BlockDrawer {
 public:
  BlockDrawer(const DepthLevel& level, const LocalMap& map, double at_x, double at_y, double at_w,
              const Canvas& canvas)
      : level_(level),
        map_(map),
        at_x_(static_cast<float>(at_x)),
        at_y_(static_cast<float>(at_y)),
        at_w_(static_cast<float>(at_w)),
        canvas_(canvas) {}

  void Draw(const Rect& cells) const {
    std::array<VertexRow, 2> rows;
    MapRow(cells, cells.y, rows[0]);
    for (int y = cells.y; y < cells.y + cells.height; ++y) {
      const VertexRow& upper = rows[static_cast<std::size_t>((y - cells.y) % 2)];
      VertexRow& lower = rows[static_cast<std::size_t>((y - cells.y + 1) % 2)];
      MapRow(cells, y + 1, lower);
      const std::uint8_t* smooth = level_.smooth.row(y);
      for (int x = cells.x; x < cells.x + cells.width; ++x) {
        if (smooth[x] != 0) {
          DrawSmooth(upper, lower, static_cast<std::size_t>(x - cells.x));
        } else {
          DrawBroken(x, y);
        }
      }
    }
  }

 private:
  void MapRow(const Rect& cells, int y, VertexRow& row) const {
    const DepthPixel* pixels = level_.pixels.row(y) + cells.x;
    const float dy = level_.RowAt(y) - at_y_;
    for (int i = 0; i <= cells.width; ++i) {
      const float w = pixels[i].inverse_depth;
      const LocalMap::Out out = map_(level_.ColumnAt(cells.x + i) - at_x_, dy, w - at_w_, w);
      const auto k = static_cast<std::size_t>(i);
      row.u[k] = out.x;
      row.v[k] = out.y;
      row.n[k] = out.q;
      row.m[k] = out.m;
    }
  }

  void DrawSmooth(const VertexRow& upper, const VertexRow& lower, std::size_t i) const {
    const float behind =
        std::min(std::min(upper.m[i], upper.m[i + 1]), std::min(lower.m[i], lower.m[i + 1]));
    if (!(behind > kInFront)) return;
    canvas_.Quad(
        {upper.u[i], upper.v[i], upper.n[i]}, {upper.u[i + 1], upper.v[i + 1], upper.n[i + 1]},
        {lower.u[i], lower.v[i], lower.n[i]}, {lower.u[i + 1], lower.v[i + 1], lower.n[i + 1]});
  }

  // A broken cell: every known corner keeps its quarter.
  void DrawBroken(int x, int y) const {
    const float x0 = level_.ColumnAt(x), x1 = level_.ColumnAt(x + 1), xm = 0.5F * (x0 + x1);
    const float y0 = level_.RowAt(y), y1 = level_.RowAt(y + 1), ym = 0.5F * (y0 + y1);
    Quarter(x0, xm, y0, ym, level_.pixels(x, y).inverse_depth);
    Quarter(xm, x1, y0, ym, level_.pixels(x + 1, y).inverse_depth);
    Quarter(x0, xm, ym, y1, level_.pixels(x, y + 1).inverse_depth);
    Quarter(xm, x1, ym, y1, level_.pixels(x + 1, y + 1).inverse_depth);
  }

  void Quarter(float x0, float x1, float y0, float y1, float w) const {
    if (w < 0) return;
    const auto at = [&](float x, float y) { return map_(x - at_x_, y - at_y_, w - at_w_, w); };
    const LocalMap::Out a = at(x0, y0), b = at(x1, y0), c = at(x0, y1), d = at(x1, y1);
    if (!(std::min(std::min(a.m, b.m), std::min(c.m, d.m)) > kInFront)) return;
    canvas_.Quad({a.x, a.y, a.q}, {b.x, b.y, b.q}, {c.x, c.y, c.q}, {d.x, d.y, d.q});
  }

  const DepthLevel& level_;
  const LocalMap& map_;
  float at_x_, at_y_, at_w_;
  const Canvas& canvas_;
};

// True where the box of pixels and inverse depths can land in a wanted tile.
bool CanBeWanted(const Eigen::Matrix4d& map, const std::array<double, 2>& xs,
                 const std::array<double, 2>& ys, const std::array<double, 2>& ws,
                 const TileMask& tiles, const ImageSpan<float>& nearness) {
  double u0 = 1e300, u1 = -1e300, v0 = 1e300, v1 = -1e300;
  int behind = 0;
  for (const double x : xs) {
    for (const double y : ys) {
      for (const double w : ws) {
        const Eigen::Vector4d out = map * Eigen::Vector4d(x, y, 1, w);
        if (!(out.z() > 0)) {
          ++behind;
          continue;
        }
        u0 = std::min(u0, out.x() / out.z()), u1 = std::max(u1, out.x() / out.z());
        v0 = std::min(v0, out.y() / out.z()), v1 = std::max(v1, out.y() / out.z());
      }
    }
  }
  if (behind == 8) return false;
  if (behind > 0) return true;  // crosses the viewer's plane: its extent is not bounded
  if (u1 < 0 || v1 < 0 || u0 > nearness.width || v0 > nearness.height) return false;
  const auto tile = [&](double at, int count) {
    return static_cast<int>(std::clamp(at / tiles.size, 0.0, count - 1.0));
  };
  for (int y = tile(v0, tiles.wanted.height); y <= tile(v1, tiles.wanted.height); ++y) {
    for (int x = tile(u0, tiles.wanted.width); x <= tile(u1, tiles.wanted.width); ++x) {
      if (tiles.wanted(x, y) != 0) return true;
    }
  }
  return false;
}

}  // namespace

void DrawSurface(const DepthLevel& level, const Eigen::Matrix4d& bundle_from_level,
                 const TileMask& tiles, ImageSpan<float> nearness) {
  const Canvas canvas(nearness);
  for (int by = 0; by < level.blocks.height(); ++by) {
    for (int bx = 0; bx < level.blocks.width(); ++bx) {
      const DepthLevel::Block& block = level.blocks(bx, by);
      if (block.nearest < 0) continue;
      const Rect cells{bx * kBlock, by * kBlock, std::min(kBlock, level.width + 1 - bx * kBlock),
                       std::min(kBlock, level.height + 1 - by * kBlock)};
      const std::array<double, 2> xs{static_cast<double>(level.ColumnAt(cells.x)),
                                     static_cast<double>(level.ColumnAt(cells.x + cells.width))};
      const std::array<double, 2> ys{static_cast<double>(level.RowAt(cells.y)),
                                     static_cast<double>(level.RowAt(cells.y + cells.height))};
      const std::array<double, 2> ws{static_cast<double>(block.farthest),
                                     static_cast<double>(block.nearest)};
      if (!CanBeWanted(bundle_from_level, xs, ys, ws, tiles, nearness)) continue;
      const double at_x = 0.5 * (xs[0] + xs[1]), at_y = 0.5 * (ys[0] + ys[1]);
      const double at_w = 0.5 * (ws[0] + ws[1]);
      const LocalMap map(bundle_from_level, at_x, at_y, at_w);
      BlockDrawer(level, map, at_x, at_y, at_w, canvas).Draw(cells);
    }
  }
}

void FillFromFartherSide(float otherwise, ImageSpan<float> nearness) {
  const int width = nearness.width, height = nearness.height;
  constexpr float kNone = kInfinity;
  // What a hole is filled with; +inf elsewhere and where nothing is found.
  Image<float> fill(width, height, kNone);
  bool any = false;
  std::vector<float> above(static_cast<std::size_t>(width), kNone);
  for (int y = 0; y < height; ++y) {
    const float* row = nearness.row(y);
    float* to = fill.row(y);
    float last = kNone;
    for (int x = 0; x < width; ++x) {
      const auto column = static_cast<std::size_t>(x);
      if (row[x] != kNoSurface) {
        last = above[column] = row[x];
      } else {
        any = true;
        to[x] = std::min(last, above[column]);
      }
    }
  }
  if (!any) return;
  std::vector<float> below(static_cast<std::size_t>(width), kNone);
  for (int y = height - 1; y >= 0; --y) {
    const float* row = nearness.row(y);
    float* to = fill.row(y);
    float last = kNone;
    for (int x = width - 1; x >= 0; --x) {
      const auto column = static_cast<std::size_t>(x);
      if (row[x] != kNoSurface) {
        last = below[column] = row[x];
      } else {
        to[x] = std::min(to[x], std::min(last, below[column]));
      }
    }
  }
  for (int y = 0; y < height; ++y) {
    float* row = nearness.row(y);
    for (int x = 0; x < width; ++x) {
      if (row[x] == kNoSurface) row[x] = fill(x, y) == kNone ? otherwise : fill(x, y);
    }
  }
}

}  // namespace lamella
