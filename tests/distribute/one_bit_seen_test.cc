// The one-bit result as an eye sees it: a scene with edges, a black hole and an occluder, on four
// planes of the varifocal preset, against its closed form under the same blur of one lens pitch.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/one_bit.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

constexpr int kWidth = 416, kHeight = 304, kPlanes = 4;
constexpr double kPitch = 13, kRowPitch = 11.258330249197702;  // 13 sqrt(3)/2

Display FourPlanes() {
  Display display = FindDisplay("paper-varifocal");
  display.width_px = kWidth;
  display.height_px = kHeight;
  display.varifocal->planes = kPlanes;
  display.varifocal->depth_mm = 3 * 188.0 / 23;  // the preset's spacing
  display.layers = PlanesOf(*display.varifocal, display.layers[0]);
  return display;
}

// What a ray meets first: a disc in front, or a ramp in depth with smooth and sharp patterns. mm; x
// and y where the ray passes z = 0, y down; slopes likewise.
struct Seen {
  double light = 0, z = 0;
};
Seen Scene(double x, double y, double slope_x, double slope_y) {
  const double disc_z = 9;
  const double dx = x + disc_z * slope_x + 8, dy = y + disc_z * slope_y - 3;
  if (dx * dx + dy * dy < 49) return {0.35 + 0.3 * dx / 7, disc_z};
  const double c = 0.3, X = x / (1 - c * slope_x), z = c * X, Y = y + z * slope_y;
  if (std::abs(X - 15) < 5 && std::abs(Y + 8) < 6) return {0, z};  // a hole
  double light = 0.45 + 0.25 * std::sin(0.35 * X + 0.2 * Y) + 0.15 * std::cos(0.5 * Y);
  if (std::fmod(X + 100, 11) < 3.5 && Y > 4) light = 0.9;  // bars
  return {std::clamp(light, 0.0, 1.0), z};
}

// Linear blending between the planes on both sides of z.
double Weight(const std::vector<double>& depths, int plane, double z) {
  z = std::clamp(z, depths.front(), depths.back());
  return std::max(0.0, 1 - std::abs(z - depths[plane]) / (depths[1] - depths[0]));
}

// Per emitter the mean over its lens's brick, each part with the plane's weight.
std::vector<Image<float>> Emitters(const Display& display) {
  const std::vector<double> depths = PlaneDepthsMm(*display.varifocal);
  const LensletArray& lenses = std::get<LensletArray>(display.layers[0].optics);
  const double p = display.pitch_mm, d0 = display.layers[0].d0_mm;
  std::vector<Image<float>> grey;
  for (int plane = 0; plane < kPlanes; ++plane) {
    Image<float> image(kWidth, kHeight);
    for (int j = 0; j < kHeight; ++j) {
      for (int i = 0; i < kWidth; ++i) {
        const Lens lens = NearestLens(lenses, i + 0.5, j + 0.5);
        const double slope_x = (lens.x_px - i - 0.5) * p / d0;
        const double slope_y = (lens.y_px - j - 0.5) * p / d0;
        double sum = 0;
        for (int part = 0; part < 25; ++part) {
          const int part_x = part % 5, part_y = part / 5;
          const double x = (lens.x_px + ((part_x + 0.5) / 5 - 0.5) * kPitch - kWidth / 2.0) * p;
          const double y = (lens.y_px + ((part_y + 0.5) / 5 - 0.5) * kRowPitch - kHeight / 2.0) * p;
          const double z = depths[plane];
          const Seen seen = Scene(x - z * slope_x, y - z * slope_y, slope_x, slope_y);
          sum += seen.light * Weight(depths, plane, seen.z);
        }
        image(i, j) = static_cast<float>(sum / 25);
      }
    }
    grey.push_back(std::move(image));
  }
  return grey;
}

// What an eye far away that looks along direction (a, b) sees, a point per emitter on z = 0: in
// every plane, of the lens there, the emitter of that direction. Its index, or -1.
using Sight = std::vector<Image<int>>;
Sight Look(const Display& display, int a, int b) {
  const std::vector<double> depths = PlaneDepthsMm(*display.varifocal);
  const LensletArray& lenses = std::get<LensletArray>(display.layers[0].optics);
  const double d0_px = display.layers[0].d0_mm / display.pitch_mm;
  const double slope_x = -(a - 2.5) / d0_px, slope_y = -(b - 2.5) / d0_px;
  Sight sight;
  for (int plane = 0; plane < kPlanes; ++plane) {
    const double z_px = depths[plane] / display.pitch_mm;
    Image<int> seen(kWidth, kHeight, -1);
    for (int j = 0; j < kHeight; ++j) {
      for (int i = 0; i < kWidth; ++i) {
        const Lens lens = NearestLens(lenses, i + 0.5 + z_px * slope_x, j + 0.5 + z_px * slope_y);
        // The emitter whose centre is in [a - 3, a - 2) right of the lens's centre.
        const int column = static_cast<int>(std::ceil(lens.x_px + a - 3 - 0.5));
        const int row = static_cast<int>(std::ceil(lens.y_px + b - 3 - 0.5));
        if (column < 0 || column >= kWidth || row < 0 || row >= kHeight) continue;
        seen(i, j) = row * kWidth + column;
      }
    }
    sight.push_back(std::move(seen));
  }
  return sight;
}

// All planes added up.
Image<float> View(const Sight& sight, const std::vector<Image<float>>& planes) {
  Image<float> seen(kWidth, kHeight);
  for (int plane = 0; plane < kPlanes; ++plane) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const int emitter = sight[plane].data()[i];
      if (emitter >= 0) seen.data()[i] += planes[plane].data()[emitter];
    }
  }
  return seen;
}

Image<float> Target(const Display& display, int a, int b) {
  const double p = display.pitch_mm, d0 = display.layers[0].d0_mm;
  const double slope_x = -(a - 2.5) * p / d0, slope_y = -(b - 2.5) * p / d0;
  Image<float> seen(kWidth, kHeight);
  for (int j = 0; j < kHeight; ++j) {
    for (int i = 0; i < kWidth; ++i) {
      seen(i, j) = static_cast<float>(
          Scene((i + 0.5 - kWidth / 2.0) * p, (j + 0.5 - kHeight / 2.0) * p, slope_x, slope_y)
              .light);
    }
  }
  return seen;
}

// A separable kernel, weights at -n ... n; pixels beyond the picture are left out of the border.
Image<float> Blurred(const Image<float>& image, const std::vector<double>& kernel) {
  const int n = static_cast<int>(kernel.size() / 2);
  Image<float> rows(kWidth, kHeight), both(kWidth, kHeight);
  const auto pass = [&](const Image<float>& from, Image<float>& to, int dx, int dy) {
    for (int j = 0; j < kHeight; ++j) {
      for (int i = 0; i < kWidth; ++i) {
        double sum = 0;
        for (int k = -n; k <= n; ++k) {
          const int x = std::clamp(i + k * dx, 0, kWidth - 1);
          const int y = std::clamp(j + k * dy, 0, kHeight - 1);
          sum += kernel[k + n] * static_cast<double>(from(x, y));
        }
        to(i, j) = static_cast<float>(sum);
      }
    }
  };
  pass(image, rows, 1, 0);
  pass(rows, both, 0, 1);
  return both;
}

std::vector<double> Box() { return std::vector<double>(13, 1 / 13.0); }
std::vector<double> Gaussian() {  // its full width at half maximum is a lens pitch
  std::vector<double> kernel;
  double sum = 0;
  for (int k = -18; k <= 18; ++k) {
    kernel.push_back(std::exp(-std::log(2.0) * k * k / (6.5 * 6.5)));
    sum += kernel.back();
  }
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

double MeanSquare(const Image<float>& a, const Image<float>& b) {
  constexpr int kBorder = 52;  // four lenses: planes are shifted against each other there
  double sum = 0;
  for (int j = kBorder; j < kHeight - kBorder; ++j) {
    for (int i = kBorder; i < kWidth - kBorder; ++i) {
      const double difference = static_cast<double>(a(i, j)) - static_cast<double>(b(i, j));
      sum += difference * difference;
    }
  }
  return sum / ((kHeight - 2 * kBorder) * (kWidth - 2 * kBorder));
}

constexpr int kViews[][2] = {{0, 0}, {2, 3}, {5, 4}, {1, 5}};

// Views of the display and their targets, once.
struct Eyes {
  std::vector<Sight> sights;
  std::vector<Image<float>> targets;
};
Eyes MakeEyes(const Display& display) {
  Eyes eyes;
  for (const auto& [a, b] : kViews) {
    eyes.sights.push_back(Look(display, a, b));
    eyes.targets.push_back(Target(display, a, b));
  }
  return eyes;
}

// Over all views, linear light, peak 1, dB; `against` are the views' blurred pictures.
double Psnr(const std::vector<Image<float>>& seen, const std::vector<Image<float>>& against) {
  double sum = 0;
  for (std::size_t view = 0; view < seen.size(); ++view)
    sum += MeanSquare(seen[view], against[view]);
  return -10 * std::log10(sum / static_cast<double>(seen.size()));
}

std::vector<Image<float>> BlurredViews(const Eyes& eyes, const std::vector<Image<float>>& planes,
                                       const std::vector<double>& blur) {
  std::vector<Image<float>> views;
  for (const Sight& sight : eyes.sights) views.push_back(Blurred(View(sight, planes), blur));
  return views;
}

std::vector<Image<float>> Means(const std::vector<Image<float>>& grey, const Display& display,
                                const OneBitOptions& options) {
  const BitPlanes bits = OneBitPlanes(grey, display, options);
  std::vector<Image<float>> means;
  for (int plane = 0; plane < kPlanes; ++plane) means.push_back(MeanOfStrokes(bits, plane));
  return means;
}

TEST(OneBitSeen, SixteenStrokesAreWithinOneAndAHalfDecibelOfGrey) {
  const Display display = FourPlanes();
  const Eyes eyes = MakeEyes(display);
  const std::vector<Image<float>> grey = Emitters(display);
  const std::vector<std::vector<double>> blurs{Box(), Gaussian()};
  for (const std::vector<double>& blur : blurs) {
    std::vector<Image<float>> targets;
    for (const Image<float>& target : eyes.targets) targets.push_back(Blurred(target, blur));
    const std::vector<Image<float>> grey_views = BlurredViews(eyes, grey, blur);
    const double grey_db = Psnr(grey_views, targets);
    std::printf("%s: grey %.2f dB\n", blur.size() == 13 ? "box" : "Gaussian", grey_db);
    EXPECT_GT(grey_db, 25);  // the display shows the scene at all
    for (const bool couple : {true, false}) {
      for (const std::string& name : OneBitMethodNames()) {
        const OneBitMethod method = OneBitMethodOf(name);
        if (!couple && method != OneBitMethod::kSigmaDelta) continue;
        const auto views = BlurredViews(eyes, Means(grey, display, {method, 16, couple}), blur);
        const double db = Psnr(views, targets);
        std::printf("  %s%s: %.2f dB, %.2f below grey; %.1f against grey\n", name.c_str(),
                    couple ? "" : " (planes apart)", db, grey_db - db, Psnr(views, grey_views));
        EXPECT_GT(db, grey_db - 1.5) << name;
      }
    }
  }
}

}  // namespace
}  // namespace lamella
