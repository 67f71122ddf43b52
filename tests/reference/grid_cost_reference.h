// The cost of depth/grid_cost.h in double precision, pixel by pixel, as its formula says it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "lightfield/image.h"

namespace lamella::reference {

struct GridView {
  const Image<Rgb8>* image = nullptr;
  int columns = 0, rows = 0;
};

// Catmull-Rom (bicubic, a = -0.5) at continuous index coordinates; edges repeat.
inline double Cubic(const Image<double>& plane, double x, double y) {
  const auto weight = [](double t) {
    t = std::abs(t);
    if (t < 1) return 1.5 * t * t * t - 2.5 * t * t + 1;
    if (t < 2) return -0.5 * t * t * t + 2.5 * t * t - 4 * t + 2;
    return 0.0;
  };
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  double sum = 0;
  for (int v = y0 - 1; v <= y0 + 2; ++v) {
    for (int u = x0 - 1; u <= x0 + 2; ++u) {
      sum += weight(x - u) * weight(y - v) *
             plane(std::clamp(u, 0, plane.width() - 1), std::clamp(v, 0, plane.height() - 1));
    }
  }
  return sum;
}

class GridCostReference {
 public:
  GridCostReference(const Image<Rgb8>& reference, bool color)
      : color_(color), planes_(Planes(reference)) {}

  // One source's sample; the box and the mean are MeanOverArms' business.
  double Sample(const GridView& source, double disparity, int x, int y) const {
    const double sx = x - disparity * source.columns, sy = y - disparity * source.rows;
    const int width = source.image->width(), height = source.image->height();
    const double most = (color_ ? 6 : 0) + 40;
    if (sx < -0.5 || sy < -0.5 || sx > width - 0.5 || sy > height - 0.5) return most / 2;
    const std::vector<Image<double>> planes = Planes(*source.image);
    const auto luma = [&](int dx, int dy) {
      const Image<double>& mine = planes_[3];
      const int u = std::clamp(x + dx, 0, width - 1), v = std::clamp(y + dy, 0, height - 1);
      return Cubic(planes[3], sx + dx, sy + dy) - mine(u, v);
    };
    double cost = 4 * std::min(std::abs(luma(1, 0) - luma(-1, 0)) / 2 +
                                   std::abs(luma(0, 1) - luma(0, -1)) / 2,
                               10.0);
    if (color_) {
      double difference = 0;
      for (std::size_t c = 0; c < 3; ++c)
        difference += std::abs(Cubic(planes[c], sx, sy) - planes_[c](x, y)) / 3;
      cost += 0.3 * std::min(difference, 20.0);
    }
    return cost;
  }

 private:
  // R, G, B, luma.
  static std::vector<Image<double>> Planes(const Image<Rgb8>& image) {
    std::vector<Image<double>> planes;
    for (int c = 0; c < 4; ++c) {
      Image<double> plane(image.width(), image.height());
      for (std::size_t i = 0; i < plane.size(); ++i) {
        const Rgb8 p = image.data()[i];
        plane.data()[i] = c == 0   ? p.r
                          : c == 1 ? p.g
                          : c == 2 ? p.b
                                   : (38 * p.r + 75 * p.g + 15 * p.b) / 128.0;
      }
      planes.push_back(std::move(plane));
    }
    return planes;
  }
  bool color_;
  std::vector<Image<double>> planes_;
};

// The whole cost of a pixel and disparity, as a code before rounding: 6 x the best half's mean.
inline double GridCost(const Image<Rgb8>& reference, const std::vector<std::vector<GridView>>& arms,
                       double disparity, bool color, int x, int y) {
  const GridCostReference cost(reference, color);
  std::vector<double> boxes(arms.size(), 0.0);
  for (std::size_t a = 0; a < arms.size(); ++a) {
    for (const GridView& source : arms[a]) {
      for (int i = 0; i < 9; ++i) {
        const int u = std::clamp(x + i % 3 - 1, 0, reference.width() - 1);
        const int v = std::clamp(y + i / 3 - 1, 0, reference.height() - 1);
        boxes[a] += cost.Sample(source, disparity, u, v) / 9;
      }
    }
  }
  double best = 191;
  for (std::size_t first = 0; first < arms.size(); ++first) {
    double sum = 0, sources = 0;
    for (std::size_t i = 0; i < arms.size() / 2; ++i) {
      sum += boxes[(first + i) % arms.size()];
      sources += static_cast<double>(arms[(first + i) % arms.size()].size());
    }
    if (sources > 0) best = std::min(best, 6 * sum / sources);
  }
  return best;
}

}  // namespace lamella::reference
