#include "distribute/box_blur.h"

#include <cmath>
#include <vector>

namespace lamella {
namespace {

struct RunningSum {
  double r = 0, g = 0, b = 0, coverage = 0;

  void Move(const Light& in, const Light& out) {
    r += static_cast<double>(in.r) - static_cast<double>(out.r);
    g += static_cast<double>(in.g) - static_cast<double>(out.g);
    b += static_cast<double>(in.b) - static_cast<double>(out.b);
    coverage += static_cast<double>(in.coverage) - static_cast<double>(out.coverage);
  }
  // With the pixels beside those of the sum.
  Light Filtered(const BoxFilter& box, const Light& before, const Light& behind) const {
    const auto value = [&](double sum, float one, float other) {
      return static_cast<float>(
          box.scale * (sum + box.edge * (static_cast<double>(one) + static_cast<double>(other))));
    };
    return {value(r, before.r, behind.r), value(g, before.g, behind.g),
            value(b, before.b, behind.b), value(coverage, before.coverage, behind.coverage)};
  }
};

}  // namespace

BoxFilter BoxOfWidth(double width_px) {
  const double variance = width_px * width_px / 12;
  BoxFilter box;
  box.core = static_cast<int>((std::sqrt(width_px * width_px + 1) - 1) / 2);
  const double core = box.core, full = 2 * core + 1;
  // (2 (1 + 4 + ... + core^2) + 2 edge (core + 1)^2) / (full + 2 edge) = variance.
  box.edge = full * (variance - core * (core + 1) / 3) / (2 * ((core + 1) * (core + 1) - variance));
  box.edge = box.edge > 0 ? box.edge : 0;  // rounding
  box.scale = 1 / (full + 2 * box.edge);
  return box;
}

void BlurRow(const BoxFilter& box, const Light* in, int count, Light* out) {
  RunningSum sum;
  for (int i = -box.core; i <= box.core; ++i) sum.Move(in[i], {});
  const Light *before = in - box.core - 1, *behind = in + box.core + 1;
  for (int i = 0; i < count; ++i) {
    out[i] = sum.Filtered(box, before[i], behind[i]);
    sum.Move(behind[i], before[i + 1]);
  }
}

void BlurColumns(const BoxFilter& box, ImageSpan<const Light> in, ImageSpan<Light> out) {
  std::vector<RunningSum> sums(static_cast<std::size_t>(out.width));
  for (int j = 1; j <= 2 * box.core + 1; ++j) {
    for (int x = 0; x < out.width; ++x) sums[static_cast<std::size_t>(x)].Move(in(x, j), {});
  }
  for (int y = 0; y < out.height; ++y) {
    const Light *before = in.row(y), *last = in.row(y + 1), *behind = in.row(y + 2 * box.core + 2);
    Light* row = out.row(y);
    for (int x = 0; x < out.width; ++x) {
      RunningSum& sum = sums[static_cast<std::size_t>(x)];
      row[x] = sum.Filtered(box, before[x], behind[x]);
      sum.Move(behind[x], last[x]);
    }
  }
}

}  // namespace lamella
