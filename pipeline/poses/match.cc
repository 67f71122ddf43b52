#include "pipeline/poses/match.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pipeline/poses/match.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef LAMELLA_POSES_MATCH_ONCE
#define LAMELLA_POSES_MATCH_ONCE
namespace lamella {

// The two largest dot products of every feature of one image with those of the other, and which
// feature has the largest; -1 where all are 0.
struct BestTwo {
  explicit BestTwo(int features)
      : best(static_cast<std::size_t>(features), 0),
        second(static_cast<std::size_t>(features), 0),
        index(static_cast<std::size_t>(features), -1) {}
  std::vector<std::int32_t> best, second, index;
};

}  // namespace lamella
#endif  // LAMELLA_POSES_MATCH_ONCE

HWY_BEFORE_NAMESPACE();
namespace lamella {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kBlock = PackedDescriptors::kBlock;
constexpr int kPairs = PackedDescriptors::kPairs;
constexpr int kQueries = 4;  // at a time: their sums stay in registers

using Tag = hn::CappedTag<std::int32_t, kBlock>;
using Vector = hn::Vec<Tag>;

// sum + a.low * b.low + a.high * b.high of the 16-bit halves of every word.
HWY_INLINE Vector AddPairProducts([[maybe_unused]] Tag d, Vector sum, Vector a, Vector b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR  // pmaddwd: neighbours are added
  const hn::Repartition<std::int16_t, Tag> d16;
  Vector unused = hn::Zero(d);
  return hn::ReorderWidenMulAccumulate(d, hn::BitCast(d16, a), hn::BitCast(d16, b), sum, unused);
#else
  const Vector low =
      hn::Mul(hn::ShiftRight<16>(hn::ShiftLeft<16>(a)), hn::ShiftRight<16>(hn::ShiftLeft<16>(b)));
  return hn::Add(sum, hn::Add(low, hn::Mul(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b))));
#endif
}

struct Lanes {
  Vector best, second, index;
  HWY_INLINE void Take(Vector value, Vector at) {
    second = hn::Max(second, hn::Min(value, best));
    index = hn::IfThenElse(hn::Gt(value, best), at, index);
    best = hn::Max(best, value);
  }
};

// The dot products of kQueries features (lanes `lane` and on of a block) with a vector of features.
HWY_INLINE void DotProducts(Tag d, const std::int32_t* HWY_RESTRICT queries,
                            const std::int32_t* HWY_RESTRICT features, Vector (&sums)[kQueries]) {
  for (Vector& sum : sums) sum = hn::Zero(d);
  for (int pair = 0; pair < kPairs; ++pair) {
    const Vector feature = hn::LoadU(d, features + pair * kBlock);
    for (int q = 0; q < kQueries; ++q) {
      sums[q] = AddPairProducts(d, sums[q], hn::Set(d, queries[pair * kBlock + q]), feature);
    }
  }
}

void Reduce(Tag d, const Lanes& lanes, std::size_t query, BestTwo& of_a) {
  std::int32_t best[kBlock], second[kBlock], index[kBlock];
  hn::StoreU(lanes.best, d, best);
  hn::StoreU(lanes.second, d, second);
  hn::StoreU(lanes.index, d, index);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    of_a.second[query] =
        std::max({of_a.second[query], second[lane], std::min(of_a.best[query], best[lane])});
    if (best[lane] > of_a.best[query]) {
      of_a.best[query] = best[lane];
      of_a.index[query] = index[lane];
    }
  }
}

// Every product is computed once and used for both images. `of_a` and `of_b` have room for whole
// blocks: what is beyond the last feature is 0 and never larger than anything.
void FindBestTwo(const PackedDescriptors& a, const PackedDescriptors& b, BestTwo& of_a,
                 BestTwo& of_b) {
  const Tag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int first = 0; first < a.blocks() * kBlock; first += kQueries) {
    const std::int32_t* queries = a.Block(first / kBlock) + first % kBlock;
    Lanes of_query[kQueries];
    for (Lanes& l : of_query) l = {hn::Zero(d), hn::Zero(d), hn::Set(d, -1)};
    for (int start = 0; start < b.blocks() * kBlock; start += lanes) {
      Vector sums[kQueries];
      DotProducts(d, queries, b.Block(start / kBlock) + start % kBlock, sums);
      const Vector features = hn::Iota(d, start);
      Lanes of_features = {hn::LoadU(d, &of_b.best[static_cast<std::size_t>(start)]),
                           hn::LoadU(d, &of_b.second[static_cast<std::size_t>(start)]),
                           hn::LoadU(d, &of_b.index[static_cast<std::size_t>(start)])};
      for (int q = 0; q < kQueries; ++q) {
        of_query[q].Take(sums[q], features);
        of_features.Take(sums[q], hn::Set(d, first + q));
      }
      hn::StoreU(of_features.best, d, &of_b.best[static_cast<std::size_t>(start)]);
      hn::StoreU(of_features.second, d, &of_b.second[static_cast<std::size_t>(start)]);
      hn::StoreU(of_features.index, d, &of_b.index[static_cast<std::size_t>(start)]);
    }
    for (int q = 0; q < kQueries; ++q) {
      const int query = first + q;
      Reduce(d, of_query[q], static_cast<std::size_t>(query), of_a);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace lamella
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lamella {
namespace {

HWY_EXPORT(FindBestTwo);

double Angle(std::int32_t dot_product) {
  constexpr double kSquaredLength = 512.0 * 512.0;  // of COLMAP's descriptors
  return std::acos(std::min(dot_product / kSquaredLength, 1.0));
}

// The matching feature, or -1.
std::int32_t Chosen(const BestTwo& of, std::size_t feature, const MatchCriteria& criteria) {
  const double best = Angle(of.best[feature]);
  const bool good =
      best <= criteria.max_angle_rad && best < criteria.max_ratio * Angle(of.second[feature]);
  return good ? of.index[feature] : -1;
}

}  // namespace

PackedDescriptors::PackedDescriptors(const Descriptors& descriptors) : count_(descriptors.count) {
  words_.assign(static_cast<std::size_t>(blocks()) * kPairs * kBlock, 0);
  for (int feature = 0; feature < count_; ++feature) {
    const std::uint8_t* row =
        descriptors.rows.data() + static_cast<std::ptrdiff_t>(feature) * Descriptors::kLength;
    const std::size_t start = static_cast<std::size_t>(feature / kBlock) * kPairs * kBlock +
                              static_cast<std::size_t>(feature % kBlock);
    for (int pair = 0; pair < kPairs; ++pair) {
      words_[start + static_cast<std::size_t>(pair * kBlock)] =
          row[2 * pair] | (row[2 * pair + 1] << 16);
    }
  }
}

std::vector<FeatureMatch> MatchFeatures(const PackedDescriptors& a, const PackedDescriptors& b,
                                        const MatchCriteria& criteria) {
  BestTwo of_a(a.blocks() * PackedDescriptors::kBlock),
      of_b(b.blocks() * PackedDescriptors::kBlock);
  HWY_DYNAMIC_DISPATCH(FindBestTwo)(a, b, of_a, of_b);
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < a.count(); ++i) {
    const std::int32_t j = Chosen(of_a, static_cast<std::size_t>(i), criteria);
    if (j >= 0 && Chosen(of_b, static_cast<std::size_t>(j), criteria) == i) {
      matches.push_back({i, j});
    }
  }
  return matches;
}

}  // namespace lamella
#endif  // HWY_ONCE
