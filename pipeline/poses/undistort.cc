#include "pipeline/poses/undistort.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/LU>

#include "pipeline/poses/undistort_kernels.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d DirectionOf(const Camera& pinhole, const Vector2d& pixel) {
  return {(pixel.x() - pinhole.cx) / pinhole.fx, (pixel.y() - pinhole.cy) / pinhole.fy, 1};
}

// Where the original shows a pixel of the pinhole; nothing beyond the radius at which the
// distortion folds over.
std::optional<Vector2d> Source(const Camera& camera, const Camera& pinhole, const Vector2d& pixel) {
  PixelJacobian jacobian;
  auto source = Project(camera, DirectionOf(pinhole, pixel), &jacobian);
  if (!source || jacobian.point.leftCols<2>().determinant() <= 0) return std::nullopt;
  return source;
}

bool SeesInsideOnly(const Camera& camera, const Camera& pinhole) {
  constexpr int kSteps = 100;  // along each side
  const auto inside = [&](double x, double y) {
    const auto source = Source(camera, pinhole, {x * pinhole.width, y * pinhole.height});
    constexpr double kRounding = 1e-6;
    return source && source->x() >= -kRounding && source->x() <= camera.width + kRounding &&
           source->y() >= -kRounding && source->y() <= camera.height + kRounding;
  };
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    if (!inside(t, 0) || !inside(t, 1) || !inside(0, t) || !inside(1, t)) return false;
  }
  return true;
}

// About the image's centre, so that any zoom that is large enough sees inside only.
Camera Zoomed(const Camera& camera, double zoom) {
  Camera zoomed = camera;
  zoomed.fx *= zoom;
  zoomed.fy *= zoom;
  zoomed.cx = camera.width / 2.0 + zoom * (camera.cx - camera.width / 2.0);
  zoomed.cy = camera.height / 2.0 + zoom * (camera.cy - camera.height / 2.0);
  return zoomed;
}

// Catmull-Rom (Keys 1981, a = -1/2).
double Cubic(double x) {
  x = std::abs(x);
  if (x < 1) return (1.5 * x - 2.5) * x * x + 1;
  if (x < 2) return ((-0.5 * x + 2.5) * x - 4) * x + 2;
  return 0;
}

// The samples of one axis that make up a value, and their weights, which sum to 1.
struct Taps {
  static constexpr int kMost = 64;
  int first = 0, count = 0;
  std::array<float, kMost> weights;

  // `position` in continuous coordinates; `scale` >= 1 widens the kernel.
  Taps(double position, double scale) {
    const double radius = std::min(2 * scale, kMost / 2.0 - 1);
    first = static_cast<int>(std::ceil(position - 0.5 - radius));
    const int last = static_cast<int>(std::floor(position - 0.5 + radius));
    count = last - first + 1;
    double sum = 0;
    std::array<double, kMost> raw;
    for (int i = 0; i < count; ++i) {
      raw[static_cast<std::size_t>(i)] = Cubic((first + i + 0.5 - position) * 2 / radius);
      sum += raw[static_cast<std::size_t>(i)];
    }
    for (int i = 0; i < count; ++i) {
      weights[static_cast<std::size_t>(i)] =
          static_cast<float>(raw[static_cast<std::size_t>(i)] / sum);
    }
  }
};

Rgb SampleWide(const Image<Rgb>& image, const Vector2d& position, double scale) {
  const Taps across(std::clamp(position.x(), 0.0, 1.0 * image.width()), scale);
  const Taps down(std::clamp(position.y(), 0.0, 1.0 * image.height()), scale);
  Rgb sum;
  for (int j = 0; j < down.count; ++j) {
    const Rgb* row = image.row(std::clamp(down.first + j, 0, image.height() - 1));
    Rgb line;
    for (int i = 0; i < across.count; ++i) {
      const int x = std::clamp(across.first + i, 0, image.width() - 1);
      line += across.weights[static_cast<std::size_t>(i)] * row[x];
    }
    sum += down.weights[static_cast<std::size_t>(j)] * line;
  }
  return sum;
}

// Where the original shows the pixels of a row, into `row.x` and `row.y`; not a number where it
// does not: every `step`-th exactly, those between by the cubic through four of them. A step is at
// most 1/256 of the focal length, so that lenses stray from it by less than 1e-5 px.
void FindSources(const Camera& camera, const Camera& pinhole, int y, SourceRow& row) {
  const auto exact = [&](int x) {
    return Project(camera, DirectionOf(pinhole, {x + 0.5, y + 0.5}));
  };
  const int step = std::clamp(static_cast<int>(pinhole.fx / 256), 1, SourceRow::kMostStep);
  std::vector<std::optional<Vector2d>> knots;  // of the pixels -step, 0, step, ...
  for (int i = 0; i < (pinhole.width - 1) / step + 4; ++i) knots.push_back(exact((i - 1) * step));
  for (int x = 0; x < pinhole.width; x += step) {
    const auto* k = &knots[static_cast<std::size_t>(x / step)];
    if (k[0] && k[1] && k[2] && k[3]) {
      InterpolateSources({*k[0], *k[1], *k[2], *k[3]}, step, x, row);
      continue;
    }
    for (int i = x; i < std::min(x + step, pinhole.width); ++i) {
      const auto source = exact(i);
      constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
      row.x[static_cast<std::size_t>(i)] = source ? source->x() : kNone;
      row.y[static_cast<std::size_t>(i)] = source ? source->y() : kNone;
    }
  }
}

}  // namespace

Camera UndistortedCamera(const Camera& camera, int longer_side_px) {
  Camera pinhole = camera;
  pinhole.model = CameraModel::kPinhole;
  pinhole.distortion = {};
  const int longer = std::max(camera.width, camera.height);
  if (longer_side_px > 0 && longer_side_px < longer) {
    pinhole = Resized(pinhole, static_cast<double>(longer_side_px) / longer);
  }
  if (camera.model == CameraModel::kPinhole || SeesInsideOnly(camera, pinhole)) return pinhole;
  double outside = 1, inside = 2;
  constexpr double kMostZoom = 1024;
  while (!SeesInsideOnly(camera, Zoomed(pinhole, inside)) && inside < kMostZoom) {
    outside = inside;
    inside *= 2;
  }
  for (int i = 0; i < 30; ++i) {
    const double middle = (outside + inside) / 2;
    (SeesInsideOnly(camera, Zoomed(pinhole, middle)) ? inside : outside) = middle;
  }
  return Zoomed(pinhole, inside);
}

void UndistortRows(const Image<Rgb>& image, const Camera& camera, const Camera& pinhole,
                   int first_row, ImageSpan<Rgb> rows) {
  const double scale = std::max(1.0, camera.fx / pinhole.fx);
  SourceRow row(pinhole.width);
  for (int y = 0; y < rows.height; ++y) {
    FindSources(camera, pinhole, first_row + y, row);
    if (scale <= 1) SampleSharpRow(image, row, rows.row(y));
    for (int x = 0; x < rows.width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      if (scale <= 1 && row.first[i] >= 0) continue;
      rows(x, y) = std::isnan(row.x[i]) ? Rgb{} : SampleWide(image, {row.x[i], row.y[i]}, scale);
    }
  }
}

std::optional<Vector2d> UndistortPixel(const Camera& camera, const Camera& pinhole,
                                       const Vector2d& pixel) {
  const auto direction = Unproject(camera, pixel);
  if (!direction) return std::nullopt;
  return Project(pinhole, *direction);
}

}  // namespace lamella
