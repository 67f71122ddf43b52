// Shadows of occluders and their halos: experiments 8, 9 and 10.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"
#include "tests/reference/analytic_scene.h"

namespace lamella::experiments {
namespace {

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

constexpr double kHalfWidthMm = 15;  // of the occluder
constexpr double kPictureMm = 60;
constexpr int kShadowPixels = 1200;  // 0.05 mm
constexpr double kPixelMm = kPictureMm / kShadowPixels;

// A white plane in the back layer and before it, in the front layer, a bar around middle_mm.
SceneAlongX BarBeforeWhite(double spacing_mm, double bar, double middle_mm) {
  return SceneAlongX([=](double x0, double slope) {
    const double z = spacing_mm / 2;
    const bool hit = std::abs(x0 + slope * z - middle_mm) <= kHalfWidthMm;
    return hit ? Seen{bar, z} : Seen{1, -z};
  });
}

Display TwoLayers(bool lens, double spacing_mm) {
  const std::vector<double> positions = {-spacing_mm / 2, spacing_mm / 2};
  return lens ? Lenses(positions, 121) : Pinholes(positions, 6 * 41);
}

LayersOptions Encoder(bool lens) { return lens ? Sampling(8, 2) : Sampling(6, 3); }

// Seen brightness by distance outwards from the rim, on the occluder's plane; both rims, mean over
// eyes of one emitter step and over lattice phases of the rim.
struct Rim {
  std::vector<double> distance_mm, seen;

  double At(double distance) const {
    const double place = (distance - distance_mm[0]) / kPixelMm;
    const std::size_t i = static_cast<std::size_t>(place);
    return seen[i] + (place - static_cast<double>(i)) * (seen[i + 1] - seen[i]);
  }
  // Where the rising profile crosses a level first.
  double Crossing(double level) const {
    for (std::size_t i = 1; i < seen.size(); ++i) {
      if (seen[i - 1] < level && seen[i] >= level) {
        return distance_mm[i] - kPixelMm * (seen[i] - level) / (seen[i] - seen[i - 1]);
      }
    }
    return distance_mm.back();
  }
  double Width() const { return Crossing(0.9) - Crossing(0.1); }
};

Rim MeanRim(bool lens, double spacing_mm, int phases) {
  const Display display = TwoLayers(lens, spacing_mm);
  const int half = kShadowPixels / 2, reach = static_cast<int>(14 / kPixelMm);
  const int rim = static_cast<int>(kHalfWidthMm / kPixelMm);
  Rim profile;
  for (int i = -reach; i < reach; ++i) profile.distance_mm.push_back((i + 0.5) * kPixelMm);
  profile.seen.assign(profile.distance_mm.size(), 0);
  const std::vector<double> slopes = SlopesOverSteps(display, 1, 8);
  for (int phase = 0; phase < phases; ++phase) {
    const double middle = phase * kLatticeMm / phases;
    const LayerImages images =
        Distribute(BarBeforeWhite(spacing_mm, 0, middle), display, Encoder(lens), SilentProgress());
    for (const double slope : slopes) {
      Eye eye = FarEye(slope, spacing_mm / 2, kPictureMm, kShadowPixels);
      eye.left_mm += middle;
      eye.position.x() += middle;
      const std::vector<double> row = RowOf(SimulateEye(images, display, eye));
      for (int i = -reach; i < reach; ++i) {
        profile.seen[Index(i + reach)] +=
            (row[Index(half + rim + i)] + row[Index(half - rim - 1 - i)]) /
            (2.0 * phases * static_cast<double>(slopes.size()));
      }
    }
  }
  return profile;
}

// 10-90 % width of a step behind two boxes of each width, by their samples.
double TwiceFilteredWidth(double a_mm, double b_mm) {
  constexpr double kStep = 0.002;
  constexpr int kCount = 30000;
  std::vector<double> profile(kCount);
  for (int i = 0; i < kCount; ++i) profile[static_cast<std::size_t>(i)] = i >= kCount / 2 ? 1 : 0;
  for (const double width : {a_mm, b_mm, a_mm, b_mm}) {
    std::vector<double> sums(kCount + 1, 0);
    for (std::size_t i = 0; i < kCount; ++i) sums[i + 1] = sums[i] + profile[i];
    const int half = static_cast<int>(std::lround(width / kStep / 2));
    if (half == 0) continue;
    for (int i = 0; i < kCount; ++i) {
      const int from = std::max(0, i - half), to = std::min(kCount, i + half);
      profile[static_cast<std::size_t>(i)] =
          (sums[static_cast<std::size_t>(to)] - sums[static_cast<std::size_t>(from)]) / (to - from);
    }
  }
  const auto at = [&](double level) {
    return kStep * static_cast<double>(std::lower_bound(profile.begin() + kCount / 4,
                                                        profile.end() - kCount / 4, level) -
                                       profile.begin());
  };
  return at(0.9) - at(0.1);
}

// Of the front content's shadow in the back layer.
double ExpectedWidth(bool lens, double spacing_mm) {
  const double step = kLatticeMm / kLensPitchPx / (kSharpRangeMm / kLensPitchPx);
  return TwiceFilteredWidth(lens ? kLatticeMm : kLatticeMm * (1 + spacing_mm / 5),
                            spacing_mm * step);
}

// The part of a rim that a figure shows.
constexpr double kShownMm = 8;

Curve Within(double most_mm, const Rim& rim, std::string name) {
  Curve curve{std::move(name), {}, {}};
  for (std::size_t i = 0; i < rim.seen.size(); ++i) {
    if (std::abs(rim.distance_mm[i]) > most_mm) continue;
    curve.x.push_back(rim.distance_mm[i]);
    curve.y.push_back(rim.seen[i]);
  }
  return curve;
}

const char* NameOf(bool lens) { return lens ? "lenses" : "pinholes"; }

// A disc instead of a bar, before pinholes: brightness that eyes see in its middle.
double InsideADisc(double radius_mm, double inner_mm) {
  Display display = Pinholes({-5, 5}, 84, 84);
  AnalyticScene scene;
  scene.rectangles = {{-5, -1e9, 1e9, -1e9, 1e9, [](double, double) { return Rgb{1, 1, 1}; }}};
  constexpr int kStrips = 200;  // of which the disc is made, as its rectangles
  for (int i = 0; i < kStrips; ++i) {
    const double bottom = radius_mm * (2.0 * i / kStrips - 1);
    const double top = radius_mm * (2.0 * (i + 1) / kStrips - 1), y = (bottom + top) / 2;
    const double half = std::sqrt(radius_mm * radius_mm - y * y);
    scene.rectangles.push_back({5, -half, half, bottom, top, [](double, double) { return Rgb{}; }});
  }
  const LayerImages images = Distribute(scene, display, Sampling(1, 1), SilentProgress());
  double brightest = 0;
  for (const double slope : SlopesOverSteps(display, 1, 4)) {
    Eye eye = FarEye(slope, 5, 2 * inner_mm, 16);
    eye.height = eye.width;
    eye.top_mm = inner_mm;
    const EyePicture picture = SimulateEye(images, display, eye);
    for (int y = 0; y < eye.height; ++y) {
      for (int x = 0; x < eye.width; ++x) {
        const double px = eye.left_mm + (x + 0.5) * eye.pixel_mm;
        const double py = eye.top_mm - (y + 0.5) * eye.pixel_mm;
        if (std::hypot(px, py) > inner_mm) continue;
        brightest = std::max(brightest, static_cast<double>(picture.color(x, y).g));
      }
    }
  }
  return brightest;
}

}  // namespace

Experiment Shadows(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "8";
  experiment.claim =
      "Shadows imitate occlusion: inside a dark disc before a bright plane, farther than the "
      "halo's width from its rim, at most 2 % of the background is seen (100 % without zero rays).";
  experiment.set_up =
      "White plane in the back layer, a black bar of 30 mm in the front one, z_D apart, mean over "
      "far eyes of a step; and a black disc of 9 mm radius before pinholes, z_D = 10 mm.";
  for (const bool lens : {true, false}) {
    Figure figure{fmt::format("Seen brightness across the rim of a black bar, {}", NameOf(lens)),
                  "distance outwards from the rim, mm",
                  "seen / background",
                  {}};
    for (const double spacing : {5.0, 10.0, 20.0, 40.0}) {
      if (quick && spacing != 10) continue;
      const Rim rim = MeanRim(lens, spacing, 1);
      double brightest = 0;
      for (double inside = rim.Width(); inside < 13.5; inside += kPixelMm) {
        brightest = std::max(brightest, std::abs(rim.At(-inside)));
      }
      const std::string name = fmt::format("{}, z_D = {:g} mm", NameOf(lens), spacing);
      experiment.rows.push_back(AtMost(name + ": brightest inside the bar", brightest, 0.02));
      figure.curves.push_back(Within(kShownMm, quick ? rim : MeanRim(lens, spacing, 4),
                                     fmt::format("z_D = {:g} mm", spacing)));
    }
    experiment.figures.push_back(std::move(figure));
  }
  experiment.rows.push_back(
      AtMost("pinholes, z_D = 10 mm: brightest inside the disc, one halo from its rim",
             InsideADisc(9, 9 - ExpectedWidth(false, 10)), 0.02));
  experiment.rows.push_back(
      Reported("the same without zero rays: the back layer alone shows its whole plane",
               InsideADisc(0, 9 - ExpectedWidth(false, 10))));
  return experiment;
}

Experiment HaloWidth(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "9";
  experiment.claim =
      "The halo of a filtered shadow grows with the distance of the layers: 10-90 % width of the "
      "beam's two boxes at z_D, each applied twice (encoder and display), within 15 %.";
  experiment.set_up =
      "Black bar of 30 mm in the front layer, white plane in the back one; mean over 8 far eyes of "
      "one emitter step and 4 lattice phases of the rim.";
  Figure figure{"10-90 % width of the halo", "z_D, mm", "width, mm", {}};
  for (const bool lens : {true, false}) {
    Curve measured{NameOf(lens), {}, {}}, expected{NameOf(lens), {}, {}, Stroke::kClosedForm};
    for (const double spacing : {5.0, 10.0, 20.0, 40.0}) {
      if (quick && spacing != 10 && spacing != 20) continue;
      measured.x.push_back(spacing);
      measured.y.push_back(MeanRim(lens, spacing, 4).Width());
      experiment.rows.push_back(
          Near(fmt::format("{}, z_D = {:g} mm: width, mm", NameOf(lens), spacing),
               measured.y.back(), ExpectedWidth(lens, spacing), 0.15));
    }
    for (double spacing = 5; spacing <= 40; spacing += 1) {
      expected.x.push_back(spacing);
      expected.y.push_back(ExpectedWidth(lens, spacing));
    }
    double least_growth = 1e9;
    for (std::size_t i = 1; i < measured.y.size(); ++i) {
      least_growth = std::min(least_growth, measured.y[i] - measured.y[i - 1]);
    }
    experiment.rows.push_back(
        AtLeast(fmt::format("{}: least growth from one z_D to the next, mm", NameOf(lens)),
                least_growth, 0));
    figure.curves.push_back(std::move(measured));
    figure.curves.push_back(std::move(expected));
  }
  experiment.figures.push_back(std::move(figure));
  return experiment;
}

namespace {

// Outside the rim of a bar as bright as the plane behind it, from single eyes.
struct Halo {
  double darkest_of_mean = 1, darkest_of_eyes = 1;
  double largest_jump = 0;  // of a pixel from an eye to the next
  std::vector<double> mean;
};

Halo WatchHalo(const Display& display, double spacing_mm, const LayersOptions& options) {
  Halo halo;
  const double step = StepOfView(display) * (600 - spacing_mm / 2);
  constexpr int kEyes = 16, kPhases = 4;  // of the rim in the lattice
  const int half = kShadowPixels / 2, rim = static_cast<int>(kHalfWidthMm / kPixelMm);
  halo.mean.assign(static_cast<std::size_t>(half - rim), 0);
  for (int phase = 0; phase < kPhases; ++phase) {
    const double middle = phase * kLatticeMm / kPhases;
    const LayerImages images =
        Distribute(BarBeforeWhite(spacing_mm, 1, middle), display, options, SilentProgress());
    std::vector<double> before;
    for (int e = 0; e < kEyes; ++e) {
      Eye eye = FarEye(0, spacing_mm / 2, kPictureMm, kShadowPixels);
      eye.position = {middle + ((e + 0.5) / kEyes - 0.5) * step, 0, 600};
      eye.left_mm += middle;
      const std::vector<double> row = RowOf(SimulateEye(images, display, eye));
      const std::vector<double> outside(row.begin() + half + rim, row.end());
      for (std::size_t i = 0; i < outside.size(); ++i) {
        halo.mean[i] += outside[i] / (kEyes * kPhases);
        halo.darkest_of_eyes = std::min(halo.darkest_of_eyes, outside[i]);
        if (!before.empty()) {
          halo.largest_jump = std::max(halo.largest_jump, std::abs(outside[i] - before[i]));
        }
      }
      before = outside;
    }
  }
  halo.darkest_of_mean = *std::min_element(halo.mean.begin(), halo.mean.end());
  return halo;
}

}  // namespace

Experiment HaloStrength(Effort effort) {
  Experiment experiment;
  experiment.id = "10";
  experiment.claim =
      "Filtering makes the halos around occluders barely noticeable (reported, no gate): the mean "
      "over views stays near 1/2 at the rim, single views lose contrast and jump less.";
  experiment.set_up =
      "A bar as bright as the plane behind it, so that only halos are seen; 16 eyes of one emitter "
      "step at 600 mm, no shear; mean, darkest and largest over four lattice phases of the rim.";
  for (const bool lens : {true, false}) {
    Figure figure{fmt::format("Mean over views outside the rim, {}", NameOf(lens)),
                  "distance outwards from the rim, mm",
                  "seen",
                  {}};
    for (const double spacing : {10.0, 20.0, 40.0}) {
      if (effort == Effort::kQuick && spacing != 20) continue;
      const Display display = TwoLayers(lens, spacing);
      for (const bool filter : {true, false}) {
        const LayersOptions options = filter ? Encoder(lens) : Sampling(1, lens ? 2 : 4, "ray");
        const Halo halo = WatchHalo(display, spacing, options);
        const std::string name =
            fmt::format("z_D = {:g} mm, filter {}", spacing, filter ? "on" : "off");
        const std::string at = fmt::format("{}, {}: ", NameOf(lens), name);
        experiment.rows.push_back(Reported(at + "darkest, mean over views", halo.darkest_of_mean));
        experiment.rows.push_back(Reported(at + "darkest, single view", halo.darkest_of_eyes));
        experiment.rows.push_back(
            Reported(at + "largest jump from view to view", halo.largest_jump));
        Curve curve{name,
                    {},
                    {},
                    filter ? Stroke::kMeasured : Stroke::kSecond,
                    fmt::format("z_D = {:g} mm, filter on", spacing)};
        for (std::size_t i = 0; i < halo.mean.size(); ++i) {
          const double distance = (static_cast<double>(i) + 0.5) * kPixelMm;
          if (distance > kShownMm) break;
          curve.x.push_back(distance);
          curve.y.push_back(halo.mean[i]);
        }
        figure.curves.push_back(std::move(curve));
      }
    }
    experiment.figures.push_back(std::move(figure));
  }
  experiment.reason =
      "The halo does not go: the shadow's blur in the back layer, and without a filter its jumps, "
      "leave about the same mean at the rim. What the filter changes are single views: their "
      "darkest pixels are no longer black, and the jumps between views are smaller, by little at "
      "large z_D.";
  return experiment;
}

}  // namespace lamella::experiments
