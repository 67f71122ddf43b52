// Pixels are judged by row and candidate: those that a candidate is new to are gathered in a list,
// so that lanes have work.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/consistency_kernels.cc"
#include "depth/consistency_kernels.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef LAMELLA_DEPTH_CONSISTENCY_KERNELS_SHARED
#define LAMELLA_DEPTH_CONSISTENCY_KERNELS_SHARED
namespace lamella {
namespace consistency_kernels {

constexpr float kUnknown = InverseDepthMap::kUnknown;
constexpr double kOwnBonus = 0.5;
constexpr float kSureConfirmations = 3;
constexpr float kSurfaceJump = 0.03F;  // between pixels of one surface, relative
constexpr double kNearestDepth = 1e-6;
constexpr std::size_t kPadding = 8;  // whole vectors run so far beyond the end of a row or list

// A map's row, unknown beyond its end.
struct PaddedRow {
  explicit PaddedRow(int width) : w(static_cast<std::size_t>(width) + kPadding, kUnknown) {}
  const float* Copy(const Image<float>& map, int y) {
    std::copy(map.row(y), map.row(y) + map.width(), w.begin());
    return w.data();
  }
  std::vector<float> w;
};

// The best candidates of a row's pixels so far, by column.
struct Winners {
  explicit Winners(std::size_t size)
      : w(size), mean(size), confirmed(size), score(size), confidence(size) {}
  void Clear() {
    std::fill(w.begin(), w.end(), -1);
    std::fill(confirmed.begin(), confirmed.end(), 0);
    std::fill(score.begin(), score.end(), -std::numeric_limits<double>::infinity());
  }
  std::vector<double> w, mean;  // the candidate, and its mean with what confirms it
  std::vector<double> confirmed, score;
  std::vector<float> confidence;
};

// Columns with a candidate w to be judged, and how: `score` is the confirmations less the
// contradictions, of maps other than the one that the candidate is from.
struct Candidates {
  explicit Candidates(std::size_t size)
      : x(size), w(size), own(size), to_beat(size), mean(size), confirmed(size), score(size) {}
  std::size_t count = 0;
  std::vector<float> x, w, own, to_beat;  // all of them exact
  std::vector<double> mean, confirmed, score;
};

struct Scratch {
  explicit Scratch(int width)
      : own(width),
        other(width),
        winners(static_cast<std::size_t>(width) + kPadding),
        candidates(static_cast<std::size_t>(width) + kPadding) {}
  PaddedRow own, other;
  Winners winners;
  Candidates candidates;
};

}  // namespace consistency_kernels
}  // namespace lamella
#endif  // LAMELLA_DEPTH_CONSISTENCY_KERNELS_SHARED

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace consistency_kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kPadding>;
using Floats = hn::Rebind<float, Doubles>;
using Ints = hn::Rebind<std::int32_t, Doubles>;
using D = hn::Vec<Doubles>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Ints>;
using M = hn::Mask<Doubles>;

inline D Constant(double value) { return hn::Set(Doubles(), value); }
inline D Load(const std::vector<double>& from, std::size_t at) {
  return hn::LoadU(Doubles(), from.data() + at);
}
inline void Store(D value, std::size_t at, std::vector<double>& to) {
  hn::StoreU(value, Doubles(), to.data() + at);
}
inline D LoadFloats(const float* from) {
  return hn::PromoteTo(Doubles(), hn::LoadU(Floats(), from));
}

// Points of one picture in another.
struct Seen {
  D x, y, w;
  M in_front;
};

inline Seen Transfer(const PictureMap& map, D x, D y, D w) {
  const auto row = [&](int k) {
    return Constant(map.m(k, 0)) * x + Constant(map.m(k, 1)) * y + Constant(map.m(k, 2)) +
           w * Constant(map.b(k));
  };
  const D z = row(2), reciprocal = Constant(1) / z;
  return {row(0) * reciprocal, row(1) * reciprocal, w * reciprocal, z > Constant(kNearestDepth)};
}

inline M Inside(const Image<float>& image, const Seen& p) {
  const D zero = Constant(0);
  const M from = hn::And(p.x >= zero, p.y >= zero),
          to = hn::And(p.x < Constant(image.width()), p.y < Constant(image.height()));
  return hn::And(p.in_front, hn::And(from, to));
}

// Whether inverse depths agree with b >= 0.
inline M Same(const ConsistencyOptions& options, D a, D b) {
  const D limit = hn::Max(Constant(options.tolerance) * b, Constant(0.5 * options.step));
  return hn::Abs(a - b) <= limit;
}

void Warp(const NeighbourMap& from, InverseDepthMap& warped) {
  const Ints di;
  const Image<float>& w = from.map->w;
  PaddedRow row(w.width());
  const D half = Constant(0.5);
  HWY_ALIGN std::int32_t index[kPadding];
  HWY_ALIGN float value[kPadding];
  const int lanes = static_cast<int>(hn::Lanes(Doubles()));
  for (int y = 0; y < w.height(); ++y) {
    const float* values = row.Copy(w, y);
    for (int x = 0; x < w.width(); x += lanes) {
      const D here = LoadFloats(values + x);
      const D column = hn::Iota(Doubles(), static_cast<double>(x)) + half;
      const Seen p = Transfer(from.back, column, Constant(y + 0.5), here);
      const M seen = hn::And(here >= Constant(0), Inside(warped.w, p));
      if (hn::AllFalse(Doubles(), seen)) continue;
      const I u = hn::DemoteTo(di, hn::IfThenElseZero(seen, p.x)),
              v = hn::DemoteTo(di, hn::IfThenElseZero(seen, p.y));
      hn::Store(v * hn::Set(di, warped.w.width()) + u, di, index);
      // A value below all others never replaces one.
      hn::Store(hn::DemoteTo(Floats(), hn::IfThenElse(seen, p.w, Constant(-2))), Floats(), value);
      for (int i = 0; i < lanes; ++i) {
        if (value[i] <= warped.w.data()[index[i]]) continue;
        warped.w.data()[index[i]] = value[i];
        warped.confidence.data()[index[i]] = from.map->confidence(x + i, y);
      }
    }
  }
}

// Values of neighbouring columns, at `at` and right of it.
struct Pair {
  F left, right;
};

#if HWY_MAX_BYTES >= 32
// Two neighbours are one number of twice the size: half of the lookups.
inline Pair GatherPair(const float* values, I at) {
  const Floats df;
  const hn::Repartition<float, Doubles> twice;
  const hn::RebindToSigned<Doubles> offsets;
  const hn::RebindToUnsigned<Doubles> pairs;
  const auto bytes = hn::ShiftLeft<2>(hn::PromoteTo(offsets, at));
  const auto found = hn::BitCast(
      twice, hn::GatherOffset(pairs, reinterpret_cast<const std::uint64_t*>(values), bytes));
  return {hn::LowerHalf(df, hn::ConcatEven(twice, found, found)),
          hn::LowerHalf(df, hn::ConcatOdd(twice, found, found))};
}
#else
inline Pair GatherPair(const float* values, I at) {
  const Floats df;
  return {hn::GatherIndex(df, values, at), hn::GatherIndex(df, values + 1, at)};
}
#endif

// The map between pixel centres, at places inside of it: bilinear where its four values lie on one
// surface (within kSurfaceJump, relative), else the nearest one. A slanted surface would otherwise
// seem to disagree with itself.
inline D Sample(const Image<float>& w, D x, D y) {
  const Floats df;
  const Ints di;
  const int width = w.width(), height = w.height();
  const D half = Constant(0.5), zero = Constant(0);
  const D gx = hn::Min(hn::Max(x - half, zero), Constant(width - 1)),
          gy = hn::Min(hn::Max(y - half, zero), Constant(height - 1));
  const I x0 = hn::Min(hn::DemoteTo(di, gx), hn::Set(di, std::max(0, width - 2))),
          y0 = hn::Min(hn::DemoteTo(di, gy), hn::Set(di, std::max(0, height - 2)));
  const I at = y0 * hn::Set(di, width) + x0;
  const float *row = w.data(), *below = row + (height > 1 ? width : 0);
  Pair upper, lower;
  if (width > 1) {
    upper = GatherPair(row, at);
    lower = GatherPair(below, at);
  } else {
    upper.left = upper.right = hn::GatherIndex(df, row, at);
    lower.left = lower.right = hn::GatherIndex(df, below, at);
  }
  const auto is_right = hn::RebindMask(df, hn::DemoteTo(di, x) > x0),
             is_lower = hn::RebindMask(df, hn::DemoteTo(di, y) > y0);
  const F nearest = hn::IfThenElse(is_lower, hn::IfThenElse(is_right, lower.right, lower.left),
                                   hn::IfThenElse(is_right, upper.right, upper.left));
  const F jump = hn::Set(df, kSurfaceJump) * nearest;
  const auto near = [&](F corner) { return hn::Abs(corner - nearest) <= jump; };
  const auto smooth = hn::And(hn::And(near(upper.left), near(upper.right)),
                              hn::And(near(lower.left), near(lower.right)));
  const F fx = hn::DemoteTo(df, gx - hn::PromoteTo(Doubles(), x0)),
          fy = hn::DemoteTo(df, gy - hn::PromoteTo(Doubles(), y0));
  const F one = hn::Set(df, 1.0F);
  const F between = (one - fy) * ((one - fx) * upper.left + fx * upper.right) +
                    fy * ((one - fx) * lower.left + fx * lower.right);
  return hn::PromoteTo(Doubles(), hn::IfThenElse(smooth, between, nearest));
}

struct Verdict {
  D sum, confirmed, score;
  void Confirm(M confirms, D w) {
    const D one = hn::IfThenElseZero(confirms, Constant(1));
    sum = hn::IfThenElse(confirms, sum + w, sum);
    confirmed = confirmed + one;
    score = score + one;
  }
};

// What a neighbour says of candidates w at pixels (x, y).
inline void Hear(const NeighbourMap& neighbour, const ConsistencyOptions& options, D x, D y, D w,
                 Verdict& verdict) {
  const Doubles d;
  const D half = Constant(0.5);
  const Image<float>& map = neighbour.map->w;
  const Seen p = Transfer(neighbour.there, x + half, y + half, w);
  const M inside = Inside(map, p);
  if (hn::AllFalse(d, inside)) return;
  // What is outside may not be a number: it is replaced before it becomes an address.
  const D there = Sample(map, hn::IfThenElseZero(inside, p.x), hn::IfThenElseZero(inside, p.y));
  const M known = hn::And(inside, there >= Constant(0));
  const D scale = hn::IfThenElse(w > Constant(0), p.w / w, Constant(1));
  const D limit = hn::Max(Constant(options.tolerance) * p.w, Constant(0.5 * options.step) * scale);
  const M behind = hn::And(known, there < p.w - limit);
  verdict.score = verdict.score - hn::IfThenElseZero(behind, Constant(1));
  const M agrees = hn::And(known, hn::Abs(there - p.w) <= limit);
  if (hn::AllFalse(d, agrees)) return;
  const Seen back = Transfer(neighbour.back, p.x, p.y, there);
  const D dx = back.x - x - half, dy = back.y - y - half;
  const M returns = dx * dx + dy * dy <= Constant(options.return_px * options.return_px);
  verdict.Confirm(hn::And(agrees, hn::And(back.in_front, returns)), back.w);
}

// `from`: 0 the own map's candidates, else those of neighbour from - 1. A map does not confirm
// itself. Ends early where no score can exceed `to_beat` any more.
void Judge(const ConsistencyVote& vote, std::size_t from, int y, Candidates& list) {
  const Doubles d;
  const D row = Constant(y);
  const std::size_t num_neighbours = vote.neighbours.size();
  for (std::size_t k = 0; k < list.count; k += hn::Lanes(d)) {
    const D x = LoadFloats(&list.x[k]), w = LoadFloats(&list.w[k]),
            to_beat = LoadFloats(&list.to_beat[k]);
    Verdict verdict{w, Constant(0), Constant(0)};
    if (from > 0) {
      const D own = LoadFloats(&list.own[k]);
      verdict.Confirm(hn::And(own >= Constant(0), Same(vote.options, own, w)), own);
    }
    for (std::size_t i = 0; i < num_neighbours; ++i) {
      const auto undecided = static_cast<double>(num_neighbours - i);
      if (hn::AllTrue(d, verdict.score + Constant(undecided) <= to_beat)) break;
      if (i + 1 != from) Hear(vote.neighbours[i], vote.options, x, row, w, verdict);
    }
    Store(verdict.sum / (verdict.confirmed + Constant(1)), k, list.mean);
    Store(verdict.confirmed, k, list.confirmed);
    Store(verdict.score, k, list.score);
  }
}

// Lists the columns whose `values` are known and, since most candidates repeat the winner, are not
// the same as that.
void List(const ConsistencyVote& vote, const float* values, const float* own, int width,
          double bonus, const Winners& winners, Candidates& list) {
  const Doubles d;
  const Floats df;
  list.count = 0;
  for (std::size_t x = 0; x < static_cast<std::size_t>(width); x += hn::Lanes(d)) {
    const D value = LoadFloats(values + x), winner = Load(winners.w, x);
    const M same = hn::And(winner >= Constant(0), Same(vote.options, value, winner));
    const M wanted = hn::AndNot(same, value >= Constant(0));
    if (hn::AllFalse(d, wanted)) continue;
    const F ones = hn::DemoteTo(df, hn::IfThenElseZero(wanted, Constant(1)));
    const auto append = [&](F from, std::vector<float>& to) {
      hn::StoreU(hn::Compress(from, ones > hn::Zero(df)), df, to.data() + list.count);
    };
    append(hn::Iota(df, static_cast<float>(x)), list.x);
    append(hn::LoadU(df, values + x), list.w);
    append(hn::LoadU(df, own + x), list.own);
    append(hn::DemoteTo(df, Load(winners.score, x) - Constant(bonus)), list.to_beat);
    list.count += hn::CountTrue(d, wanted);
  }
}

void Update(const Candidates& list, double bonus, const float* confidence, Winners& winners) {
  for (std::size_t k = 0; k < list.count; ++k) {
    const auto x = static_cast<std::size_t>(list.x[k]);
    const double score = list.score[k] + bonus;
    if (score <= winners.score[x]) continue;
    winners.w[x] = static_cast<double>(list.w[k]);
    winners.mean[x] = list.mean[k];
    winners.confirmed[x] = list.confirmed[k];
    winners.score[x] = score;
    winners.confidence[x] = confidence[x];
  }
}

void DecideRow(const ConsistencyVote& vote, int y, Scratch& scratch, InverseDepthMap& result) {
  const int width = result.w.width();
  Winners& winners = scratch.winners;
  winners.Clear();
  const float* own = scratch.own.Copy(vote.own.w, y);
  for (std::size_t i = 0; i <= vote.warped.size(); ++i) {
    const InverseDepthMap& map = i == 0 ? vote.own : vote.warped[i - 1];
    const float* values = i == 0 ? own : scratch.other.Copy(map.w, y);
    const double bonus = i == 0 ? kOwnBonus : 0;
    List(vote, values, own, width, bonus, winners, scratch.candidates);
    Judge(vote, i, y, scratch.candidates);
    Update(scratch.candidates, bonus, map.confidence.row(y), winners);
  }
  const int half = std::max(1, static_cast<int>(vote.neighbours.size()) / 2);
  const double needed = std::min(vote.options.agreeing, half);
  for (int x = 0; x < width; ++x) {
    const auto i = static_cast<std::size_t>(x);
    const bool known = winners.confirmed[i] >= needed && winners.score[i] > 0;
    const float share =
        std::min(1.0F, static_cast<float>(winners.confirmed[i]) / kSureConfirmations);
    result.w(x, y) = known ? static_cast<float>(winners.mean[i]) : kUnknown;
    result.confidence(x, y) = known ? winners.confidence[i] * share : 0;
  }
}

void Decide(const ConsistencyVote& vote, int first_row, int last_row, InverseDepthMap& result) {
  Scratch scratch(result.w.width());
  for (int y = first_row; y < last_row; ++y) DecideRow(vote, y, scratch, result);
}

}  // namespace HWY_NAMESPACE
}  // namespace consistency_kernels
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace consistency_kernels {
HWY_EXPORT(Warp);
HWY_EXPORT(Decide);
}  // namespace consistency_kernels

void WarpMap(const NeighbourMap& from, InverseDepthMap& warped) {
  using namespace consistency_kernels;  // NOLINT
  HWY_DYNAMIC_DISPATCH(Warp)(from, warped);
}

void DecideRows(const ConsistencyVote& vote, int first_row, int last_row, InverseDepthMap& result) {
  using namespace consistency_kernels;  // NOLINT
  HWY_DYNAMIC_DISPATCH(Decide)(vote, first_row, last_row, result);
}

}  // namespace lamella
#endif  // HWY_ONCE
