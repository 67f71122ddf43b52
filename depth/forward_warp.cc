#include "depth/forward_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
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

// Pixels of a level and inverse depths.
struct BlockBox {
  std::array<double, 2> xs, ys, ws;
};

Rect CellsOf(const DepthLevel& level, int x, int y) {
  return {x * kBlock, y * kBlock, std::min(kBlock, level.width + 1 - x * kBlock),
          std::min(kBlock, level.height + 1 - y * kBlock)};
}

BlockBox BoxOf(const DepthLevel& level, int x, int y) {
  const Rect cells = CellsOf(level, x, y);
  const DepthLevel::Block& block = level.blocks(x, y);
  return {{static_cast<double>(level.ColumnAt(cells.x)),
           static_cast<double>(level.ColumnAt(cells.x + cells.width))},
          {static_cast<double>(level.RowAt(cells.y)),
           static_cast<double>(level.RowAt(cells.y + cells.height))},
          {static_cast<double>(block.farthest), static_cast<double>(block.nearest)}};
}

// False where the box can hit no ray of a bundle of this size, else the box of rays.
bool Lands(const Eigen::Matrix4d& map, const BlockBox& box, int width, int height,
           LandingBlock* block) {
  constexpr double kSlack = 0.01;  // rounding, and what quads reach beyond their edges
  double u0 = 1e300, u1 = -1e300, v0 = 1e300, v1 = -1e300;
  int behind = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const Eigen::Vector4d out =
        map * Eigen::Vector4d(box.xs[corner % 2], box.ys[corner / 2 % 2], 1, box.ws[corner / 4]);
    if (!(out.z() > 0)) {
      ++behind;
      continue;
    }
    u0 = std::min(u0, out.x() / out.z()), u1 = std::max(u1, out.x() / out.z());
    v0 = std::min(v0, out.y() / out.z()), v1 = std::max(v1, out.y() / out.z());
  }
  if (behind == 8) return false;
  // Crosses the viewer's plane: its extent is not bounded.
  if (behind > 0) u0 = v0 = 0, u1 = width, v1 = height;
  if (u1 < 0 || v1 < 0 || u0 > width || v0 > height) return false;
  const auto cut = [](double at, int size) {
    return static_cast<float>(std::clamp(at, 0.0, static_cast<double>(size)));
  };
  block->u0 = cut(u0 - kSlack, width), block->u1 = cut(u1 + kSlack, width);
  block->v0 = cut(v0 - kSlack, height), block->v1 = cut(v1 + kSlack, height);
  return true;
}

}  // namespace

std::vector<LandingBlock> LandingBlocks(const DepthLevel& level,
                                        const Eigen::Matrix4d& bundle_from_level, int width,
                                        int height) {
  std::vector<LandingBlock> blocks;
  for (int y = 0; y < level.blocks.height(); ++y) {
    for (int x = 0; x < level.blocks.width(); ++x) {
      if (level.blocks(x, y).nearest < 0) continue;
      LandingBlock block{x, y};
      if (Lands(bundle_from_level, BoxOf(level, x, y), width, height, &block)) {
        blocks.push_back(block);
      }
    }
  }
  return blocks;
}

void DrawBlocks(const DepthLevel& level, const Eigen::Matrix4d& bundle_from_level,
                std::span<const LandingBlock> blocks, ImageSpan<float> nearness) {
  for (const LandingBlock& block : blocks) {
    const BlockBox box = BoxOf(level, block.x, block.y);
    const double at_x = 0.5 * (box.xs[0] + box.xs[1]), at_y = 0.5 * (box.ys[0] + box.ys[1]);
    const double at_w = 0.5 * (box.ws[0] + box.ws[1]);
    const LocalMap map(bundle_from_level, at_x, at_y, at_w);
    BlockDrawer(level, map, at_x, at_y, at_w, nearness).Draw(CellsOf(level, block.x, block.y));
  }
}

namespace {

// The nearest surface above or below, by column, as rows are gone through one way.
class ColumnMemory {
 public:
  ColumnMemory(int width, int reach)
      : reach_(reach),
        value_(static_cast<std::size_t>(width)),
        row_(static_cast<std::size_t>(width), kNever) {}
  void Keep(int column, int row, float value) {
    value_[static_cast<std::size_t>(column)] = value;
    row_[static_cast<std::size_t>(column)] = row;
  }
  float Recall(int column, int row, float otherwise) const {
    const int at = row_[static_cast<std::size_t>(column)];
    const bool within = at != kNever && std::abs(row - at) <= reach_;
    return within ? value_[static_cast<std::size_t>(column)] : otherwise;
  }

 private:
  static constexpr int kNever = -1;
  int reach_;
  std::vector<float> value_;
  std::vector<int> row_;
};

}  // namespace

void FillFromFartherSide(float otherwise, int reach, ImageSpan<float> nearness) {
  const int width = nearness.width, height = nearness.height;
  constexpr float kNone = std::numeric_limits<float>::infinity();
  // What a hole is filled with; +inf elsewhere and where nothing is found.
  Image<float> fill(width, height, kNone);
  bool any = false;
  ColumnMemory above(width, reach), below(width, reach);
  for (int y = 0; y < height; ++y) {
    const float* row = nearness.row(y);
    float* to = fill.row(y);
    float last = kNone;
    for (int x = 0; x < width; ++x) {
      if (row[x] != kNoSurface) {
        last = row[x];
        above.Keep(x, y, last);
      } else {
        any = true;
        to[x] = std::min(last, above.Recall(x, y, kNone));
      }
    }
  }
  if (!any) return;
  for (int y = height - 1; y >= 0; --y) {
    const float* row = nearness.row(y);
    float* to = fill.row(y);
    float last = kNone;
    for (int x = width - 1; x >= 0; --x) {
      if (row[x] != kNoSurface) {
        last = row[x];
        below.Keep(x, y, last);
      } else {
        to[x] = std::min(to[x], std::min(last, below.Recall(x, y, kNone)));
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
