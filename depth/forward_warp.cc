#include "depth/forward_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "depth/bundle_map.h"
#include "depth/draw_quads.h"

namespace lamella {
namespace {

constexpr int kBlock = DepthLevel::kBlock;
// A row of a block's vertices, mapped.
struct VertexRow {
  static constexpr int kSize = kBlock + 1 + kQuadPadding;
  std::array<float, kSize> u{}, v{}, n{};
};

// Quads that are not cells, gathered to be drawn together.
class QuadBatch {
 public:
  explicit QuadBatch(ImageSpan<float> raster) : raster_(raster) { drawn_.fill(1); }

  // Corners a b / c d of [x0, x1] x [y0, y1] around the map's point, at one inverse depth.
  void Add(const LocalMap& map, const std::array<float, 2>& x, const std::array<float, 2>& y,
           float dw, float w) {
    for (std::size_t k = 0; k < 4; ++k) {
      const LocalMap::Out corner = map(x[k % 2], y[k / 2], dw, w);
      if (!(corner.m > 0)) return;
      u_[k][count_] = corner.x;
      v_[k][count_] = corner.y;
      n_[k][count_] = corner.q;
    }
    if (++count_ == kSize) Flush();
  }

  void Flush() {
    Quads quads{{}, {}, {}, drawn_.data(), static_cast<int>(count_)};
    for (std::size_t k = 0; k < 4; ++k) {
      quads.u[k] = u_[k].data();
      quads.v[k] = v_[k].data();
      quads.n[k] = n_[k].data();
    }
    DrawQuads(quads, raster_);
    count_ = 0;
  }

 private:
  static constexpr std::size_t kSize = 64;
  using Corners = std::array<std::array<float, kSize + kQuadPadding>, 4>;
  ImageSpan<float> raster_;
  std::size_t count_ = 0;
  Corners u_{}, v_{}, n_{};
  std::array<std::uint8_t, kSize + kQuadPadding> drawn_;
};

class BlockDrawer {
 public:
  BlockDrawer(const DepthLevel& level, const LocalMap& map, double at_x, double at_y, double at_w,
              ImageSpan<float> raster)
      : level_(level),
        map_(map),
        at_x_(static_cast<float>(at_x)),
        at_y_(static_cast<float>(at_y)),
        at_w_(static_cast<float>(at_w)),
        raster_(raster),
        quarters_(raster) {}

  void Draw(const Rect& cells) {
    for (int i = 0; i <= cells.width; ++i) {
      da_[static_cast<std::size_t>(i)] = level_.ColumnAt(cells.x + i) - at_x_;
    }
    std::array<VertexRow, 2> rows;
    MapRow(cells, cells.y, rows[0]);
    for (int y = cells.y; y < cells.y + cells.height; ++y) {
      const VertexRow& upper = rows[static_cast<std::size_t>((y - cells.y) % 2)];
      VertexRow& lower = rows[static_cast<std::size_t>((y - cells.y + 1) % 2)];
      MapRow(cells, y + 1, lower);
      DrawCells(cells, y, upper, lower);
    }
    quarters_.Flush();
  }

 private:
  void MapRow(const Rect& cells, int y, VertexRow& row) const {
    MapVertices(map_, at_w_, da_.data(), level_.RowAt(y) - at_y_,
                level_.inverse_depth.row(y) + cells.x, cells.width + 1, row.u.data(), row.v.data(),
                row.n.data());
  }

  void DrawCells(const Rect& cells, int y, const VertexRow& upper, const VertexRow& lower) {
    const std::uint8_t* smooth = level_.smooth.row(y) + cells.x;
    const float *uu = upper.u.data(), *uv = upper.v.data(), *un = upper.n.data();
    const float *lu = lower.u.data(), *lv = lower.v.data(), *ln = lower.n.data();
    DrawQuads({{uu, uu + 1, lu, lu + 1},
               {uv, uv + 1, lv, lv + 1},
               {un, un + 1, ln, ln + 1},
               smooth,
               cells.width},
              raster_);
    const std::uint8_t* end = smooth + cells.width;
    for (const std::uint8_t* cell = std::find(smooth, end, 0); cell != end;
         cell = std::find(cell + 1, end, 0)) {
      DrawBroken(cells.x + static_cast<int>(cell - smooth), y);
    }
  }

  // A broken cell: every known corner keeps its quarter.
  void DrawBroken(int x, int y) {
    const float x0 = level_.ColumnAt(x) - at_x_, x1 = level_.ColumnAt(x + 1) - at_x_;
    const float y0 = level_.RowAt(y) - at_y_, y1 = level_.RowAt(y + 1) - at_y_;
    const float xm = 0.5F * (x0 + x1), ym = 0.5F * (y0 + y1);
    for (int corner = 0; corner < 4; ++corner) {
      const float w = level_.inverse_depth(x + corner % 2, y + corner / 2);
      if (w < 0) continue;
      quarters_.Add(map_, {corner % 2 == 0 ? x0 : xm, corner % 2 == 0 ? xm : x1},
                    {corner / 2 == 0 ? y0 : ym, corner / 2 == 0 ? ym : y1}, w - at_w_, w);
    }
  }

  const DepthLevel& level_;
  const LocalMap& map_;
  float at_x_, at_y_, at_w_;
  std::array<float, VertexRow::kSize> da_{};
  ImageSpan<float> raster_;
  QuadBatch quarters_;
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
      BlockDrawer(level, map, at_x, at_y, at_w, nearness).Draw(cells);
    }
  }
}

void FillFromFartherSide(float otherwise, ImageSpan<float> nearness) {
  const int width = nearness.width, height = nearness.height;
  constexpr float kNone = std::numeric_limits<float>::infinity();
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
