#include "tests/calibration/panel_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "lightfield/color.h"
#include "tests/calibration/degree.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d Mapped(const Matrix3d& h, const Vector2d& point) {
  return (h * point.homogeneous()).hnormalized();
}

Matrix3d Homography(int panel_width, int panel_height, const PanelViewOptions& o) {
  const Matrix3d turn = (Eigen::AngleAxisd(o.roll_deg * kDegree, Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(o.pitch_deg * kDegree, Vector3d::UnitX()) *
                         Eigen::AngleAxisd(o.yaw_deg * kDegree, Vector3d::UnitY()))
                            .toRotationMatrix();
  const double distance = o.focal_px / o.scale;  // in panel px
  Matrix3d camera_from_panel;                    // of (u, v, 1)
  const double flip = o.mirrored ? -1 : 1;
  camera_from_panel.col(0) = flip * turn.col(0);
  camera_from_panel.col(1) = turn.col(1);
  camera_from_panel.col(2) = Vector3d(0, 0, distance) -
                             flip * o.middle_u * panel_width * turn.col(0) -
                             o.middle_v * panel_height * turn.col(1);
  Matrix3d k;
  k << o.focal_px, 0, o.width_px / 2.0, 0, o.focal_px, o.height_px / 2.0, 0, 0, 1;
  return k * camera_from_panel;
}

double RadicalInverse(unsigned i) {
  double value = 0, digit = 0.5;
  for (; i > 0; i >>= 1U, digit /= 2) value += digit * (i & 1U);
  return value;
}

void BlurAlong(Image<float>& image, double sigma, bool along_x) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    sum += weights.back();
  }
  const Image<float> source = image.Clone();
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      double value = 0;
      auto weight = weights.begin();
      for (int k = -reach; k <= reach; ++k) {
        const int sx = std::clamp(along_x ? x + k : x, 0, image.width() - 1);
        const int sy = std::clamp(along_x ? y : y + k, 0, image.height() - 1);
        value += *weight++ * static_cast<double>(source(sx, sy));
      }
      image(x, y) = static_cast<float>(value / sum);
    }
  }
}

}  // namespace

PanelView::PanelView(int panel_width_px, int panel_height_px, const PanelViewOptions& options)
    : options_(options),
      panel_width_(panel_width_px),
      panel_height_(panel_height_px),
      image_from_panel_(Homography(panel_width_px, panel_height_px, options)),
      panel_from_image_(image_from_panel_.inverse()) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(0, 1);
  seen_.reserve(static_cast<std::size_t>(options.width_px) *
                static_cast<std::size_t>(options.height_px) * kSamples);
  for (int y = 0; y < options.height_px; ++y) {
    for (int x = 0; x < options.width_px; ++x) {
      const double dx = shift(random), dy = shift(random);
      for (unsigned i = 0; i < kSamples; ++i) {
        const double sx = std::fmod(i / double{kSamples} + dx, 1.0);
        const double sy = std::fmod(RadicalInverse(i) + dy, 1.0);
        const Vector2d at = PanelFromImage({x + sx, y + sy});
        const bool inside =
            at.x() >= 0 && at.y() >= 0 && at.x() < panel_width_ && at.y() < panel_height_;
        seen_.push_back(inside ? static_cast<int>(at.y()) * panel_width_ + static_cast<int>(at.x())
                               : -1);
      }
    }
  }
}

Vector2d PanelView::ImageFromPanel(const Vector2d& panel_px) const {
  return Mapped(image_from_panel_, panel_px);
}

Vector2d PanelView::PanelFromImage(const Vector2d& image_px) const {
  return Mapped(panel_from_image_, image_px);
}

Image<float> PanelView::Photograph(ImageSpan<const Rgb8> codes) const {
  Image<float> light(options_.width_px, options_.height_px);
  std::size_t sample = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    double sum = 0;
    for (int k = 0; k < kSamples; ++k, ++sample) {
      const std::int32_t pixel = seen_[sample];
      if (pixel < 0) continue;
      sum +=
          static_cast<double>(Srgb8ToLinear(codes(pixel % panel_width_, pixel / panel_width_).g));
    }
    light.data()[i] = static_cast<float>(sum / kSamples);
  }
  if (options_.blur_px > 0) {
    BlurAlong(light, options_.blur_px, true);
    BlurAlong(light, options_.blur_px, false);
  }
  return light;
}

Image<float> Exposed(ImageSpan<const float> light, const PhotoNoise& noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Image<float> numbers(light.width, light.height);
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      double number = noise.low + (noise.high - noise.low) * static_cast<double>(light(x, y)) +
                      noise.sigma * normal(random);
      if (noise.rounded) number = std::round(255 * std::clamp(number, 0.0, 1.0)) / 255;
      numbers(x, y) = static_cast<float>(number);
    }
  }
  return numbers;
}

}  // namespace lamella
