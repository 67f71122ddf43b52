// Quads are as small as the raster's cells: most cover one point, few more than 2 x 2. So lanes are
// quads; what is larger is drawn one by one. No fused multiply-add: every target gives the same
// bytes.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/draw_quads.cc"
#include "depth/draw_quads.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef LAMELLA_DEPTH_DRAW_QUADS_SHARED
#define LAMELLA_DEPTH_DRAW_QUADS_SHARED
namespace lamella {
namespace draw_quads {

constexpr float kOverlap = 1e-3F;
// Vertices nearer to the viewer's own plane than this (of the block's distance) are not drawn: what
// they belong to has no extent there.
constexpr float kInFront = 1e-6F;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Vertex {
  float u, v, n;
};

// Large quads, one at a time.
class Canvas {
 public:
  explicit Canvas(ImageSpan<float> raster) : raster_(raster) {}

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
  // The raster points that lie in the box, cut to the raster.
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
    const int x = first(u0, raster_.width), y = first(v0, raster_.height);
    return {x, y, last(u1, raster_.width) - x + 1, last(v1, raster_.height) - y + 1};
  }

  void Triangle(const Vertex& a, const Vertex& b, const Vertex& c, const Rect& box) const {
    const float bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v;
    const float area = bu * cv - cu * bv;
    if (!(area > 0) || !(area < kInfinity)) return;
    const float inverse = 1.0F / area;
    // Barycentric weights of b and c: linear in the position.
    const float beta_u = cv * inverse, beta_v = -cu * inverse;
    const float gamma_u = -bv * inverse, gamma_v = bu * inverse;
    const float n_b = b.n - a.n, n_c = c.n - a.n;
    for (int y = box.y; y < box.y + box.height; ++y) {
      const float dv = static_cast<float>(y) + 0.5F - a.v;
      const float beta_0 = beta_v * dv, gamma_0 = gamma_v * dv;
      float* row = raster_.row(y);
      const auto [first, last] = box.width <= 8
                                     ? std::pair(box.x, box.x + box.width)
                                     : Covered(box, a.u, beta_u, beta_0, gamma_u, gamma_0);
      for (int x = first; x < last; ++x) {
        const float du = static_cast<float>(x) + 0.5F - a.u;
        const float beta = beta_u * du + beta_0, gamma = gamma_u * du + gamma_0;
        if (beta < -kOverlap || gamma < -kOverlap || beta + gamma > 1 + kOverlap) continue;
        const float n = a.n + (beta * n_b + gamma * n_c);
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

  ImageSpan<float> raster_;
};

inline Vertex Corner(const Quads& quads, std::size_t k, int i) {
  return {quads.u[k][i], quads.v[k][i], quads.n[k][i]};
}

}  // namespace draw_quads
}  // namespace lamella
#endif  // LAMELLA_DEPTH_DRAW_QUADS_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace draw_quads {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kQuadPadding>;
using Ints = hn::RebindToSigned<Floats>;
using F = hn::Vec<Floats>;
using M = hn::Mask<Floats>;

inline std::uint64_t Bits(M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Floats(), mask, bytes);
  std::uint64_t bits = 0;
  for (int i = 0; i < 8; ++i) bits |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  return bits;
}

// The corners of as many quads as there are lanes.
struct Lanes {
  F u[4], v[4], n[4];
};

// Draws raster point (column, row) of each lane in `candidates` where its quad covers it.
inline void DrawPoint(const Lanes& q, F column, F row, M candidates, ImageSpan<float> raster) {
  const Floats d;
  const Ints di;
  const F half = hn::Set(d, 0.5F);
  const F pu = column + half, pv = row + half;
  // On a's side of the diagonal b-c it can only be a b c, else d c b.
  const F side = (q.u[2] - q.u[1]) * (pv - q.v[1]) - (q.v[2] - q.v[1]) * (pu - q.u[1]);
  const M first = side >= hn::Zero(d);
  const F ou = hn::IfThenElse(first, q.u[0], q.u[3]), ov = hn::IfThenElse(first, q.v[0], q.v[3]);
  const F on = hn::IfThenElse(first, q.n[0], q.n[3]);
  const F bu = hn::IfThenElse(first, q.u[1], q.u[2]) - ou;
  const F bv = hn::IfThenElse(first, q.v[1], q.v[2]) - ov;
  const F bn = hn::IfThenElse(first, q.n[1], q.n[2]) - on;
  const F cu = hn::IfThenElse(first, q.u[2], q.u[1]) - ou;
  const F cv = hn::IfThenElse(first, q.v[2], q.v[1]) - ov;
  const F cn = hn::IfThenElse(first, q.n[2], q.n[1]) - on;
  const F du = pu - ou, dv = pv - ov;
  const F area = bu * cv - cu * bv;
  const F beta = cv * du - cu * dv, gamma = bu * dv - bv * du;  // times area
  const F slack = area * hn::Set(d, kOverlap);
  const F least = hn::Neg(slack);
  const F n = on + (beta * bn + gamma * cn) / area;
  M covered = hn::And(candidates, area > hn::Zero(d));
  covered = hn::And(covered, hn::And(beta >= least, gamma >= least));
  covered = hn::And(covered, hn::And(beta + gamma <= area + slack, n < hn::Set(d, kInfinity)));
  // Neighbouring quads mostly cover neighbouring points of one row.
  const F first_column = hn::Set(d, hn::GetLane(column)), first_row = hn::Set(d, hn::GetLane(row));
  const M side_by_side =
      hn::And(column == first_column + hn::Iota(d, 0.0F), hn::And(row == first_row, covered));
  if (hn::AllTrue(d, side_by_side)) {
    float* at = &raster(static_cast<int>(hn::GetLane(column)), static_cast<int>(hn::GetLane(row)));
    hn::StoreU(hn::Max(hn::LoadU(d, at), n), d, at);
    return;
  }
  std::uint64_t bits = Bits(covered);
  if (bits == 0) return;
  float values[hn::MaxLanes(d)];
  std::int32_t columns[hn::MaxLanes(d)], rows[hn::MaxLanes(d)];
  hn::StoreU(n, d, values);
  hn::StoreU(hn::ConvertTo(di, column), di, columns);
  hn::StoreU(hn::ConvertTo(di, row), di, rows);
  for (; bits != 0; bits &= bits - 1) {
    const int lane = std::countr_zero(bits);
    float& at = raster(columns[lane], rows[lane]);
    if (values[lane] > at) at = values[lane];
  }
}

void Map(const LocalMap& map, float at_w, const float* da, float db, const float* w, int count,
         float* u, float* v, float* n) {
  const Floats d;
  const auto c = [&](float value) { return hn::Set(d, value); };
  const F m_row = c(map.m0 + map.mb * db), x_row = c(map.x_0 + map.xb * db);
  const F y_row = c(map.y_0 + map.yb * db), q_row = c(map.q_0 + map.qb * db);
  const F nothing = c(std::numeric_limits<float>::quiet_NaN());
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const F a = hn::LoadU(d, da + i), whole = hn::LoadU(d, w + i), dw = whole - c(at_w);
    const F m = m_row + (c(map.ma) * a + c(map.mc) * dw);
    const F inverse = c(1.0F) / m;
    const F x = c(map.x0) + (x_row + (c(map.xa) * a + c(map.xc) * dw)) * inverse;
    hn::StoreU(hn::IfThenElse(m > c(kInFront), x, nothing), d, u + i);
    hn::StoreU(c(map.y0) + (y_row + (c(map.ya) * a + c(map.yc) * dw)) * inverse, d, v + i);
    hn::StoreU((q_row + (c(map.qa) * a + c(map.qc) * whole)) * inverse, d, n + i);
  }
}

void Draw(const Quads& quads, ImageSpan<float> raster) {
  const Floats d;
  const hn::Rebind<std::uint8_t, Floats> d8;
  const Ints di;
  const Canvas canvas(raster);
  const F half = hn::Set(d, 0.5F), one = hn::Set(d, 1.0F);
  const F right = hn::Set(d, static_cast<float>(raster.width - 1));
  const F bottom = hn::Set(d, static_cast<float>(raster.height - 1));
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < quads.count; i += lanes) {
    Lanes q;
    for (int k = 0; k < 4; ++k) {
      const auto corner = static_cast<std::size_t>(k);
      q.u[k] = hn::LoadU(d, quads.u[corner] + i);
      q.v[k] = hn::LoadU(d, quads.v[corner] + i);
      q.n[k] = hn::LoadU(d, quads.n[corner] + i);
    }
    const auto low = [](const F* x) { return hn::Min(hn::Min(x[0], x[1]), hn::Min(x[2], x[3])); };
    const auto high = [](const F* x) { return hn::Max(hn::Max(x[0], x[1]), hn::Max(x[2], x[3])); };
    const F x0 = hn::Max(hn::Ceil(low(q.u) - half), hn::Zero(d));
    const F x1 = hn::Min(hn::Floor(high(q.u) - half), right);
    const F y0 = hn::Max(hn::Ceil(low(q.v) - half), hn::Zero(d));
    const F y1 = hn::Min(hn::Floor(high(q.v) - half), bottom);
    M drawn = hn::RebindMask(d, hn::PromoteTo(di, hn::LoadU(d8, quads.drawn + i)) != hn::Zero(di));
    drawn = hn::And(drawn, hn::And(x0 <= x1, y0 <= y1));
    if (i + lanes > quads.count) {
      drawn = hn::And(drawn, hn::FirstN(d, static_cast<std::size_t>(quads.count - i)));
    }
    if (hn::AllFalse(d, drawn)) continue;
    const M large = hn::And(drawn, hn::Or(x1 - x0 > one, y1 - y0 > one));
    const M small = hn::AndNot(large, drawn);
    const M two_columns = hn::And(small, x1 > x0), two_rows = hn::And(small, y1 > y0);
    DrawPoint(q, x0, y0, small, raster);
    if (!hn::AllFalse(d, two_columns)) DrawPoint(q, x0 + one, y0, two_columns, raster);
    if (!hn::AllFalse(d, two_rows)) {
      DrawPoint(q, x0, y0 + one, two_rows, raster);
      const M both = hn::And(two_columns, two_rows);
      if (!hn::AllFalse(d, both)) DrawPoint(q, x0 + one, y0 + one, both, raster);
    }
    for (std::uint64_t bits = Bits(large); bits != 0; bits &= bits - 1) {
      const int at = i + std::countr_zero(bits);
      canvas.Quad(Corner(quads, 0, at), Corner(quads, 1, at), Corner(quads, 2, at),
                  Corner(quads, 3, at));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace draw_quads
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace draw_quads {
HWY_EXPORT(Draw);
HWY_EXPORT(Map);
}  // namespace draw_quads

void DrawQuads(const Quads& quads, ImageSpan<float> raster) {
  if (raster.width < 1 || raster.height < 1) return;
  using namespace draw_quads;  // NOLINT
  HWY_DYNAMIC_DISPATCH(Draw)(quads, raster);
}

void MapVertices(const LocalMap& map, float at_w, const float* da, float db, const float* w,
                 int count, float* u, float* v, float* n) {
  using namespace draw_quads;  // NOLINT
  HWY_DYNAMIC_DISPATCH(Map)(map, at_w, da, db, w, count, u, v, n);
}

}  // namespace lamella
#endif  // HWY_ONCE
