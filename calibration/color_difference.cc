#include "calibration/color_difference.h"

#include <cmath>
#include <numbers>

namespace lamella {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

// Rec. 709 to XYZ (IEC 61966-2-1).
const Eigen::Matrix3d& XyzFromLight() {
  static const Eigen::Matrix3d matrix = [] {
    Eigen::Matrix3d m;
    m << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
    return m;
  }();
  return matrix;
}

double Cubed(double t) {
  constexpr double kEdge = 6.0 / 29;
  return t > kEdge * kEdge * kEdge ? std::cbrt(t) : t / (3 * kEdge * kEdge) + 4.0 / 29;
}

double SeventhPowerShare(double chroma) {
  const double power = std::pow(chroma, 7);
  return std::sqrt(power / (power + std::pow(25.0, 7)));
}

// Degrees, 0 to 360; 0 of grey.
double HueOf(double a, double b) {
  if (a == 0 && b == 0) return 0;
  const double hue = std::atan2(b, a) / kDegree;
  return hue < 0 ? hue + 360 : hue;
}

struct Polar {
  double lightness, chroma, hue;
};

// From the first hue to the second the shorter way round; 0 where either is grey.
double HueStep(const Polar& first, const Polar& second) {
  if (first.chroma * second.chroma == 0) return 0;
  const double step = second.hue - first.hue;
  if (step > 180) return step - 360;
  return step < -180 ? step + 360 : step;
}

double MeanHue(const Polar& first, const Polar& second) {
  const double sum = first.hue + second.hue;
  if (first.chroma * second.chroma == 0) return sum;
  if (std::abs(first.hue - second.hue) <= 180) return sum / 2;
  return sum < 360 ? (sum + 360) / 2 : (sum - 360) / 2;
}

}  // namespace

Lab LabOf(const Eigen::Vector3d& light) {
  const Eigen::Vector3d white = XyzFromLight() * Eigen::Vector3d::Ones();
  const Eigen::Vector3d share = (XyzFromLight() * light).cwiseQuotient(white);
  const double x = Cubed(share.x()), y = Cubed(share.y()), z = Cubed(share.z());
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double ColorDifference(const Lab& first, const Lab& second) {
  const double mean_chroma = (std::hypot(first.a, first.b) + std::hypot(second.a, second.b)) / 2;
  const double stretch = 1 + (1 - SeventhPowerShare(mean_chroma)) / 2;
  const auto polar = [&](const Lab& lab) {
    const double a = stretch * lab.a;
    return Polar{lab.l, std::hypot(a, lab.b), HueOf(a, lab.b)};
  };
  const Polar p = polar(first), q = polar(second);
  const double step = HueStep(p, q), hue = MeanHue(p, q);
  const double lightness = (p.lightness + q.lightness) / 2, chroma = (p.chroma + q.chroma) / 2;
  const auto cosine = [](double degrees) { return std::cos(degrees * kDegree); };
  const double t = 1 - 0.17 * cosine(hue - 30) + 0.24 * cosine(2 * hue) +
                   0.32 * cosine(3 * hue + 6) - 0.20 * cosine(4 * hue - 63);
  const double from_grey = (lightness - 50) * (lightness - 50);
  const double scale_l = 1 + 0.015 * from_grey / std::sqrt(20 + from_grey);
  const double scale_c = 1 + 0.045 * chroma, scale_h = 1 + 0.015 * chroma * t;
  const double blue = (hue - 275) / 25;
  const double turn = 60 * std::exp(-blue * blue);  // degrees
  const double rotation = -2 * SeventhPowerShare(chroma) * std::sin(turn * kDegree);
  const double dl = (q.lightness - p.lightness) / scale_l, dc = (q.chroma - p.chroma) / scale_c;
  const double dh = 2 * std::sqrt(p.chroma * q.chroma) * std::sin(step / 2 * kDegree) / scale_h;
  return std::sqrt(dl * dl + dc * dc + dh * dh + rotation * dc * dh);
}

}  // namespace lamella
