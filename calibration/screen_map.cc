#include "calibration/screen_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kMapColumns = 24, kMapRows = 13;
constexpr int kHalfWindows[] = {10, 15, 20};
constexpr double kLeastValidShare = 0.6;  // of a window that must be valid
constexpr double kMostSigma = 4;

struct Pixel {
  int x = 0, y = 0;
};

// The valid pixel that sees the panel nearest to each node. Nodes are sorted into the cells of a
// grid as wide as their spacing, so that a pixel looks at those around it only.
class NearestPixels {
 public:
  explicit NearestPixels(const std::vector<Vector2d>& nodes) : nodes_(nodes) {
    Vector2d high = Vector2d::Zero();
    for (const Vector2d& node : nodes) high = high.cwiseMax(node);
    cell_ = std::max(1.0, std::sqrt(high.x() * high.y() / static_cast<double>(nodes.size())));
    columns_ = static_cast<int>(high.x() / cell_) + 1;
    rows_ = static_cast<int>(high.y() / cell_) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto [x, y] = CellOf(nodes[i]);
      cells_[Index(x, y)].push_back(i);
    }
    best_.resize(nodes.size());
  }

  void Add(const Vector2d& seen, Pixel pixel) {
    const auto [cx, cy] = CellOf(seen);
    for (int y = std::max(0, cy - 1); y <= std::min(rows_ - 1, cy + 1); ++y) {
      for (int x = std::max(0, cx - 1); x <= std::min(columns_ - 1, cx + 1); ++x) {
        for (const std::size_t i : cells_[Index(x, y)]) {
          const double distance = (nodes_[i] - seen).squaredNorm();
          if (distance < best_[i].distance) best_[i] = {distance, pixel};
        }
      }
    }
  }

  // Nothing where the nearest pixel sees a point a cell or more away.
  std::optional<Pixel> Of(std::size_t node) const {
    if (!(best_[node].distance < cell_ * cell_)) return std::nullopt;
    return best_[node].pixel;
  }

 private:
  struct Best {
    double distance = std::numeric_limits<double>::infinity();
    Pixel pixel;
  };
  Pixel CellOf(const Vector2d& point) const {
    return {static_cast<int>(std::floor(point.x() / cell_)),
            static_cast<int>(std::floor(point.y() / cell_))};
  }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  }

  const std::vector<Vector2d>& nodes_;
  double cell_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<std::size_t>> cells_;
  std::vector<Best> best_;
};

// A photograph's pixel relative to the window's middle, and what it sees relative to the node.
struct Sample {
  Vector2d image, panel;
};

std::vector<Sample> SamplesAround(const ScreenMap& map, Pixel middle, int half_window,
                                  const Vector2d& node) {
  std::vector<Sample> samples;
  for (int y = std::max(0, middle.y - half_window);
       y <= std::min(map.height() - 1, middle.y + half_window); ++y) {
    for (int x = std::max(0, middle.x - half_window);
         x <= std::min(map.width() - 1, middle.x + half_window); ++x) {
      if (map.valid(x, y) == 0) continue;
      samples.push_back(
          {Vector2d(x - middle.x, y - middle.y),
           Vector2d(static_cast<double>(map.u_px(x, y)), static_cast<double>(map.v_px(x, y))) -
               node});
    }
  }
  return samples;
}

// u (1 + h.x) = a0 + a1 x + a2 y, v likewise with b and the same h. Since u and v are small around
// the node, the errors stay those of u and v. Numbers: a0 a1 a2 b0 b1 b2 h1 h2.
using HomographyNumbers = Eigen::Matrix<double, 8, 1>;
using HomographyInformation = Eigen::Matrix<double, 8, 8>;

Eigen::Matrix<double, 2, 8> RowsOf(const Sample& sample) {
  const double x = sample.image.x(), y = sample.image.y();
  const double u = sample.panel.x(), v = sample.panel.y();
  Eigen::Matrix<double, 2, 8> rows;
  rows << 1, x, y, 0, 0, 0, -u * x, -u * y,  //
      0, 0, 0, 1, x, y, -v * x, -v * y;
  return rows;
}

struct WindowFit {
  HomographyNumbers parameters;
  HomographyInformation covariance;
  double variance = 0;  // of a sample's u or v about it
};

std::optional<WindowFit> FitWindow(const std::vector<Sample>& samples) {
  constexpr std::size_t kLeastSamples = 24;
  if (samples.size() < kLeastSamples) return std::nullopt;
  HomographyInformation information = HomographyInformation::Zero();
  HomographyNumbers right = HomographyNumbers::Zero();
  for (const Sample& sample : samples) {
    const auto rows = RowsOf(sample);
    information += rows.transpose() * rows;
    right += rows.transpose() * sample.panel;
  }
  const Eigen::LDLT<HomographyInformation> solver(information);
  if (solver.info() != Eigen::Success || !solver.isPositive() || solver.rcond() < 1e-14) {
    return std::nullopt;
  }
  WindowFit fit{solver.solve(right), {}, 0};
  double sum = 0;
  for (const Sample& sample : samples) {
    sum += (sample.panel - RowsOf(sample) * fit.parameters).squaredNorm();
  }
  fit.variance = sum / (2.0 * static_cast<double>(samples.size()) - 8);
  fit.covariance = fit.variance * solver.solve(HomographyInformation::Identity());
  return fit;
}

// Fitted twice: the second time without what lies too far off the first.
std::optional<WindowFit> FitTrimmed(std::vector<Sample> samples) {
  const auto first = FitWindow(samples);
  if (!first) return std::nullopt;
  const double most = 2 * kMostSigma * kMostSigma * first->variance;
  std::erase_if(samples, [&](const Sample& sample) {
    return (sample.panel - RowsOf(sample) * first->parameters).squaredNorm() > most;
  });
  return FitWindow(samples);
}

std::optional<Observation> ObserveNode(const ScreenMap& map, const Vector2d& node, Pixel start) {
  for (const int half_window : kHalfWindows) {
    const int side = 2 * half_window + 1;
    const std::vector<Sample> samples = SamplesAround(map, start, half_window, node);
    if (static_cast<double>(samples.size()) < kLeastValidShare * side * side) continue;
    const auto fit = FitTrimmed(samples);
    if (!fit) continue;
    const HomographyNumbers& p = fit->parameters;
    Matrix2d panel_from_image;
    panel_from_image << p[1], p[2], p[4], p[5];
    if (!(std::abs(panel_from_image.determinant()) > 1e-12)) continue;
    const Matrix2d image_from_panel = panel_from_image.inverse();
    const Vector2d offset = -image_from_panel * Vector2d(p[0], p[3]);
    if (offset.cwiseAbs().maxCoeff() > half_window / 2.0) continue;  // would extrapolate
    const auto at_node = RowsOf({offset, Vector2d::Zero()});
    const Matrix2d covariance = image_from_panel *
                                (at_node * fit->covariance * at_node.transpose()) *
                                image_from_panel.transpose();
    return Observation{node, Vector2d(start.x + 0.5, start.y + 0.5) + offset,
                       (covariance + covariance.transpose()) / 2};
  }
  return std::nullopt;
}

}  // namespace

std::vector<Vector2d> NodesOf(int width_px, int height_px) {
  const int columns = std::min(kMapColumns, width_px), rows = std::min(kMapRows, height_px);
  std::vector<Vector2d> nodes;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      nodes.emplace_back((i + 0.5) * width_px / columns, (j + 0.5) * height_px / rows);
    }
  }
  return nodes;
}

std::vector<Observation> ObserveNodes(const ScreenMap& map, const std::vector<Vector2d>& nodes_px) {
  if (nodes_px.empty()) return {};
  NearestPixels nearest(nodes_px);
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.valid(x, y) == 0) continue;
      nearest.Add({static_cast<double>(map.u_px(x, y)), static_cast<double>(map.v_px(x, y))},
                  {x, y});
    }
  }
  std::vector<Observation> observations;
  for (std::size_t i = 0; i < nodes_px.size(); ++i) {
    const auto start = nearest.Of(i);
    if (!start) continue;
    if (const auto seen = ObserveNode(map, nodes_px[i], *start)) observations.push_back(*seen);
  }
  return observations;
}

}  // namespace lamella
