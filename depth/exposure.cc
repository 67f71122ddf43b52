#include "depth/exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "lightfield/median.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr int kNeighbours = 6;       // nearest views that a view is compared with
constexpr int kSamplesPerSide = 96;  // of a view
constexpr std::size_t kFewest = 50;  // common samples that a pair needs
// Codes near black are noise, near white are cut.
constexpr float kDarkest = 0.01F, kBrightest = 0.8F;

struct PairRatio {
  std::size_t a = 0, b = 0;
  double count = 0;
  std::array<double, 3> log_ratio{};  // of colours, a over b
};

bool Usable(const Rgb& c) {
  return std::min({c.r, c.g, c.b}) > kDarkest && std::max({c.r, c.g, c.b}) < kBrightest;
}

// The colour of b where it shows the surface point that a shows at its depth pixel (x, y); nothing
// where it shows another one.
std::optional<Rgb> SameSurface(const SourceView& b, const Eigen::Matrix4d& b_from_a,
                               const DepthLevel& level, int x, int y, const Image<Rgb>& color_b) {
  const double w = static_cast<double>(level.Known(x, y));
  const Eigen::Vector4d p = b_from_a * Eigen::Vector4d((x + 0.5) / level.per_color_x,
                                                       (y + 0.5) / level.per_color_y, 1, w);
  if (!(p.z() > 0)) return std::nullopt;
  const double u = p.x() / p.z(), v = p.y() / p.z(), q = p.w() / p.z();
  if (!(u >= 0 && v >= 0 && u < b.width && v < b.height)) return std::nullopt;
  const DepthLevel& there = b.depth[0];
  const double found = static_cast<double>(there.Known(static_cast<int>(u * there.per_color_x),
                                                       static_cast<int>(v * there.per_color_y)));
  if (found < 0 || std::abs(found - q) > b.softness_absolute + b.softness_relative * q) {
    return std::nullopt;
  }
  return color_b(static_cast<int>(u), static_cast<int>(v));
}

PairRatio Compare(const std::vector<SourceView>& views,
                  const std::vector<const Image<Rgb>*>& colors, std::size_t a, std::size_t b) {
  const DepthLevel& level = views[a].depth[0];
  const Eigen::Matrix4d b_from_a = views[b].view_from_world * views[a].view_from_world.inverse();
  const int step_x = std::max(1, level.width / kSamplesPerSide);
  const int step_y = std::max(1, level.height / kSamplesPerSide);
  std::array<std::vector<double>, 3> ratios;
  for (int y = step_y / 2; y < level.height; y += step_y) {
    for (int x = step_x / 2; x < level.width; x += step_x) {
      if (level.Known(x, y) < 0) continue;
      const Rgb here = (*colors[a])(static_cast<int>((x + 0.5) / level.per_color_x),
                                    static_cast<int>((y + 0.5) / level.per_color_y));
      if (!Usable(here)) continue;
      const auto there = SameSurface(views[b], b_from_a, level, x, y, *colors[b]);
      if (!there || !Usable(*there)) continue;
      ratios[0].push_back(std::log(static_cast<double>(here.r / there->r)));
      ratios[1].push_back(std::log(static_cast<double>(here.g / there->g)));
      ratios[2].push_back(std::log(static_cast<double>(here.b / there->b)));
    }
  }
  PairRatio pair{a, b, 0, {}};
  if (ratios[0].size() < kFewest) return pair;
  pair.count = static_cast<double>(ratios[0].size());
  for (std::size_t c = 0; c < 3; ++c) pair.log_ratio[c] = Median(ratios[c]);
  return pair;
}

std::vector<PairRatio> NeighbourPairs(const std::vector<SourceView>& views) {
  std::vector<PairRatio> pairs;
  for (std::size_t a = 0; a < views.size(); ++a) {
    std::vector<std::pair<double, std::size_t>> others;
    for (std::size_t b = 0; b < views.size(); ++b) {
      if (b != a) others.emplace_back((views[b].centre - views[a].centre).norm(), b);
    }
    std::sort(others.begin(), others.end());
    for (std::size_t i = 0; i < std::min<std::size_t>(kNeighbours, others.size()); ++i) {
      pairs.push_back({a, others[i].second, 0, {}});
    }
  }
  return pairs;
}

}  // namespace

std::vector<Rgb> ExposureGains(const std::vector<SourceView>& views,
                               const std::vector<const Image<Rgb>*>& colors) {
  std::vector<PairRatio> pairs = NeighbourPairs(views);
  ParallelForEach(0, static_cast<std::int64_t>(pairs.size()), [&](std::int64_t i) {
    PairRatio& pair = pairs[static_cast<std::size_t>(i)];
    pair = Compare(views, colors, pair.a, pair.b);
  });
  // log exposures e: minimise sum count (e_a - e_b - ratio)^2, with a whisper of sum e^2 that fixes
  // the mean of each connected group at 0.
  const auto n = static_cast<Eigen::Index>(views.size());
  Eigen::MatrixXd normal = 1e-6 * Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 3);
  for (const PairRatio& pair : pairs) {
    const auto a = static_cast<Eigen::Index>(pair.a), b = static_cast<Eigen::Index>(pair.b);
    normal(a, a) += pair.count;
    normal(b, b) += pair.count;
    normal(a, b) -= pair.count;
    normal(b, a) -= pair.count;
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double weighted = pair.count * pair.log_ratio[static_cast<std::size_t>(c)];
      right(a, c) += weighted;
      right(b, c) -= weighted;
    }
  }
  const Eigen::MatrixXd exposure = normal.ldlt().solve(right);
  std::vector<Rgb> gains;
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto gain = [&](Eigen::Index c) { return static_cast<float>(std::exp(-exposure(k, c))); };
    gains.push_back({gain(0), gain(1), gain(2)});
  }
  return gains;
}

}  // namespace lamella
