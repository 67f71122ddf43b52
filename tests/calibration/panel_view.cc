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

constexpr int kFine = 2;  // fine pixels along a side of a pixel
constexpr unsigned kSamples = 16, kSamplesOfEdges = 256;

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

Image<float> OfPixels(const Image<float>& fine) {
  Image<float> light(fine.width() / kFine, fine.height() / kFine);
  for (int y = 0; y < fine.height(); ++y) {
    for (int x = 0; x < fine.width(); ++x) {
      light(x / kFine, y / kFine) += fine(x, y) / (kFine * kFine);
    }
  }
  return light;
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
  shifts_.resize(static_cast<std::size_t>(kFine * options.width_px) *
                 static_cast<std::size_t>(kFine * options.height_px));
  for (Vector2d& at : shifts_) at = {shift(random), shift(random)};
}

std::int32_t PanelView::Seen(int x, int y, unsigned i, unsigned n) const {
  const Vector2d& shift =
      shifts_[static_cast<std::size_t>(y) * static_cast<std::size_t>(kFine * options_.width_px) +
              static_cast<std::size_t>(x)];
  const Vector2d within(std::fmod(i / static_cast<double>(n) + shift.x(), 1.0),
                        std::fmod(RadicalInverse(i) + shift.y(), 1.0));
  const Vector2d at = PanelFromImage((Vector2d(x, y) + within) / kFine);
  const bool inside = at.x() >= 0 && at.y() >= 0 && at.x() < panel_width_ && at.y() < panel_height_;
  return inside ? static_cast<int>(at.y()) * panel_width_ + static_cast<int>(at.x()) : -1;
}

Vector2d PanelView::ImageFromPanel(const Vector2d& panel_px) const {
  return Mapped(image_from_panel_, panel_px);
}

Vector2d PanelView::PanelFromImage(const Vector2d& image_px) const {
  return Mapped(panel_from_image_, image_px);
}

Image<float> PanelView::Photograph(ImageSpan<const Rgb8> codes) const {
  const auto light_of = [&](std::int32_t pixel) {
    if (pixel < 0) return 0.0;
    return static_cast<double>(Srgb8ToLinear(codes(pixel % panel_width_, pixel / panel_width_).g));
  };
  const auto mean_of = [&](int x, int y, unsigned samples) {
    double sum = 0;
    for (unsigned i = 0; i < samples; ++i) sum += light_of(Seen(x, y, i, samples));
    return sum / samples;
  };
  Image<float> fine(kFine * options_.width_px, kFine * options_.height_px);
  for (int y = 0; y < fine.height(); ++y) {
    for (int x = 0; x < fine.width(); ++x) {
      const double mean = mean_of(x, y, kSamples);
      const bool flat = mean == light_of(Seen(x, y, 0, kSamples));
      fine(x, y) = static_cast<float>(flat ? mean : mean_of(x, y, kSamplesOfEdges));
    }
  }
  if (options_.blur_px > 0) {
    BlurAlong(fine, kFine * options_.blur_px, true);
    BlurAlong(fine, kFine * options_.blur_px, false);
  }
  return OfPixels(fine);
}

Image<float> Exposed(ImageSpan<const float> light, const PhotoNoise& noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Image<float> numbers(light.width, light.height);
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      const auto here = static_cast<double>(light(x, y));
      double number = noise.low + (noise.high - noise.low) * here +
                      std::sqrt(noise.sigma * noise.sigma + noise.shot * here) * normal(random);
      if (noise.rounded) number = std::round(255 * std::clamp(number, 0.0, 1.0)) / 255;
      numbers(x, y) = static_cast<float>(number);
    }
  }
  return numbers;
}

}  // namespace lamella
