// Structural similarity of two pictures' rows (Wang et al. 2004), one channel at a time.
#pragma once

#include <array>
#include <vector>

namespace lamella {

// The window's weights beside its centre: a Gaussian of sigma 1.5 px, cut at 3.3 sigma. What lies
// beyond the picture has no weight; the rest is renormalised.
struct SimilarityWindow {
  static constexpr int kRadius = 5;
  SimilarityWindow();
  // Sum of the weights of a window at `at` of `size` pixels.
  double SumAt(int at, int size) const;
  std::array<double, kRadius + 1> weights;  // by distance
};

// Means of a, b, a^2, b^2, ab over the row's windows, unnormalised; each of the width.
struct RowMoments {
  static constexpr int kNumMeans = 5;
  std::array<std::vector<double>, kNumMeans> means;
};

// `a` and `b`: a row of one channel, values in [0, 1], `width` of them from kRadius on; before and
// behind are kRadius zeros.
void HorizontalMoments(const SimilarityWindow& window, const double* a, const double* b, int width,
                       RowMoments& moments);

// The similarity of the pixels of a row, from the moments of the rows around it: rows[kRadius] is
// its own, those beyond the picture are null. scale[x] is 1 over the sum of a window's weights.
void SimilarityOfRow(const SimilarityWindow& window,
                     const std::array<const RowMoments*, 2 * SimilarityWindow::kRadius + 1>& rows,
                     const double* scale, int width, double* similarity);

}  // namespace lamella
