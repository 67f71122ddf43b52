// How noisy a photograph is, dark and bright.
#pragma once

#include <vector>

#include "lightfield/image.h"

namespace lamella {

// The variance of a photograph's noise over its grey numbers: light arrives in quanta, so that the
// white of a panel is many times as noisy as the dark room around it. Measured on the photograph
// itself, white noise assumed, in numbers of any response; at least that of 8-bit codes.
class NoiseCurve {
 public:
  explicit NoiseCurve(ImageSpan<const float> image);

  double VarianceAt(double grey) const;
  // Of all of the photograph, which may be dark for the most part.
  double MedianDeviation() const { return median_deviation_; }

 private:
  struct Level {
    double grey, variance;
  };
  std::vector<Level> levels_;  // by grey, rising; linear between, constant beyond
  double median_deviation_;
};

}  // namespace lamella
