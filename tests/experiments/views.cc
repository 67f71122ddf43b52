// Experiments 16 and 17: what time slots and a second layer do to a view.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"
#include "tests/reference/analytic_scene.h"

namespace lamella::experiments {
namespace {

// "EIFHTL", 3 x 5 cells a letter, rows from the top, the leftmost cell in bit 2.
constexpr std::array<std::array<std::uint8_t, 5>, 6> kLetters = {{{7, 4, 6, 4, 7},
                                                                  {7, 2, 2, 2, 7},
                                                                  {7, 4, 6, 4, 4},
                                                                  {5, 5, 7, 5, 5},
                                                                  {7, 2, 2, 2, 2},
                                                                  {4, 4, 4, 4, 7}}};
constexpr double kCellMm = 0.77;  // of a letter: off the panel's raster

// White letters on black, row after row of them.
bool Letter(double x, double y) {
  const int column = static_cast<int>(std::floor(x / kCellMm));
  const int row = static_cast<int>(std::floor(-y / kCellMm));
  const auto wrap = [](int a, int n) { return ((a % n) + n) % n; };
  const int in_x = wrap(column, 4), in_y = wrap(row, 6);
  if (in_x == 3 || in_y == 5) return false;
  const int letter = wrap((column - in_x) / 4 + 2 * (row - in_y) / 6, 6);
  return (kLetters[static_cast<std::size_t>(letter)][static_cast<std::size_t>(in_y)] >> (2 - in_x) &
          1) != 0;
}

AnalyticScene Text() {
  AnalyticScene scene;
  scene.rectangles = {{0, -1e9, 1e9, -1e9, 1e9, [](double x, double y) {
                         const float value = Letter(x, y) ? 1 : 0;
                         return Rgb{value, value, value};
                       }}};
  return scene;
}

// What the eye's pixels see of the text itself, 64 x 64 lines a pixel.
std::vector<double> TextSeen(const Eye& eye) {
  constexpr int kSplit = 64;
  std::vector<double> values;
  for (int j = 0; j < eye.height; ++j) {
    for (int i = 0; i < eye.width; ++i) {
      int lit = 0;
      for (int t = 0; t < kSplit; ++t) {
        for (int s = 0; s < kSplit; ++s) {
          const double x = eye.left_mm + (i + (s + 0.5) / kSplit) * eye.pixel_mm;
          const double y = eye.top_mm - (j + (t + 0.5) / kSplit) * eye.pixel_mm;
          if (Letter(x, y)) ++lit;
        }
      }
      values.push_back(static_cast<double>(lit) / (kSplit * kSplit));
    }
  }
  return values;
}

// By eye pixels of these numbers of panel pixels.
constexpr std::array<int, 3> kEyePixels = {1, 2, 6};

std::vector<double> TextPsnr(const Barrier& barrier, Effort effort) {
  const bool quick = effort == Effort::kQuick;
  const int width = quick ? 36 : 60, height = quick ? 12 : 24, margin = 12;
  Display display = Pinholes({0}, width + margin, height + margin);
  display.layers[0].optics = barrier;
  const LayerImages images = Distribute(Text(), display, Sampling(1, 16), SilentProgress());
  std::vector<double> psnr;
  for (const int pixels : kEyePixels) {
    Eye eye = FarEye(0, 0, width * kPitchMm, width / pixels);
    eye.height = height / pixels;
    eye.top_mm = height * kPitchMm / 2;
    const EyePicture picture = SimulateEye(images, display, eye);
    std::vector<double> seen;
    for (std::size_t i = 0; i < picture.color.size(); ++i) {
      seen.push_back(static_cast<double>(picture.color.data()[i].g));
    }
    psnr.push_back(PsnrOf(seen, TextSeen(eye)));
  }
  return psnr;
}

// Largest correlation of a picture with shifted parts of another, wider one.
double Correlation(const std::vector<double>& picture, const std::vector<double>& wider) {
  const std::size_t n = picture.size();
  double best = -1;
  for (std::size_t shift = 0; shift + n <= wider.size(); ++shift) {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double x = picture[i], y = wider[shift + i];
      a += x;
      b += y;
      aa += x * x;
      bb += y * y;
      ab += x * y;
    }
    const double count = static_cast<double>(n);
    const double cov = ab - a * b / count;
    best = std::max(best, cov / std::sqrt((aa - a * a / count) * (bb - b * b / count)));
  }
  return best;
}

}  // namespace

Experiment SlotsAndDetail(Effort effort) {
  Experiment experiment;
  experiment.id = "16";
  experiment.claim =
      "Time slots restore resolution: text in the layer's plane gets better with 1, 9 and 36 slots "
      "of P = 6; openings of one pixel in every position show the panel's own pixels (38 dB and "
      "more).";
  experiment.set_up =
      "White text of cells of 0.77 mm on z = z_l, pinholes; far eye on the axis, pixels of 1, 2 "
      "and 6 panel pixels; PSNR in linear light against the text seen by the same pixels.";
  struct Case {
    std::string name;
    Barrier barrier;
  };
  const std::vector<Case> cases = {{"1 slot, a = 2", {6, 2, 1}},
                                   {"9 slots, a = 2", {6, 2, 3}},
                                   {"36 slots, a = 2", {6, 2, 6}},
                                   {"49 slots of P = 7, a = 1", {7, 1, 7}},
                                   {"25 slots of P = 5, a = 1", {5, 1, 5}}};
  Figure figure{"Text in the layer's plane", "eye pixel, panel pixels", "PSNR, dB", {}, true};
  std::vector<Curve> curves;
  for (const Case& c : cases) {
    Curve curve{c.name, {kEyePixels.begin(), kEyePixels.end()}, TextPsnr(c.barrier, effort)};
    for (std::size_t i = 0; i < kEyePixels.size(); ++i) {
      experiment.rows.push_back(Reported(
          fmt::format("{}, eye pixels of {} p: PSNR, dB", c.name, kEyePixels[i]), curve.y[i]));
    }
    curves.push_back(curve);
  }
  experiment.rows.push_back(
      AtLeast("gain of 9 slots over 1, eye pixels of 6 p, dB", curves[1].y[2] - curves[0].y[2], 0));
  experiment.rows.push_back(AtLeast("gain of 36 slots over 9 (a = 2), eye pixels of p, dB",
                                    curves[2].y[0] - curves[1].y[0], 0));
  experiment.rows.push_back(Reported("gain of 36 slots over 9 (a = 2), eye pixels of 6 p, dB",
                                     curves[2].y[2] - curves[1].y[2]));
  experiment.rows.push_back(
      AtLeast("49 slots of P = 7, a = 1, eye pixels of p: PSNR, dB", curves[3].y[0], 38));
  figure.curves = std::move(curves);
  experiment.figures.push_back(std::move(figure));
  experiment.reason =
      "36 slots with openings of one pixel cannot be had with P = 6: an opening and its period of "
      "unequal parity have a fan that is off by half a pixel, and such displays are refused. The "
      "nearest ones, P = 5 and P = 7, stand for it. 36 slots of 2-px openings overlap by half: to "
      "eyes that resolve a pixel they are a little better than 9, to coarser eyes worse, since the "
      "9 tile the panel and show exact means of 2 x 2 px (what is missing to more than 41 dB is "
      "the 16 x 16 rays a pixel of the encoder).";
  return experiment;
}

Experiment ViewRepeats(Effort effort) {
  Experiment experiment;
  experiment.id = "17";
  experiment.claim =
      "Two layers have no zones of repeated views: beyond the field of view, at the angle where "
      "one layer repeats its centre view, the picture of two does not.";
  experiment.set_up =
      "Textured plane at -10 mm, bars of another texture before it at 10 mm; pinholes, one layer "
      "at 0 or two at +-10 mm; far camera to 1.25 of the repeat's slope P p/d0; largest "
      "correlation with the centre view over shifts.";
  const std::function<double(double)> back = TextureAlongX(1), front = TextureAlongX(2);
  const SceneAlongX scene([&](double x0, double slope) {
    const double x = x0 + 10 * slope;
    if (std::fmod(std::abs(x + 200), 12) < 5) return Seen{front(x), 10};
    return Seen{back(x0 - 10 * slope), -10};
  });
  Figure figure{"Likeness to the centre view", "slope / repeat", "largest correlation", {}};
  std::vector<double> at_repeat;
  for (const bool two : {false, true}) {
    const Display display = two ? Pinholes({-10, 10}, 6 * 45) : Pinholes({0}, 6 * 45);
    const LayerImages images = Distribute(scene, display, Sampling(4, 2), SilentProgress());
    const double repeat = 6 * kPitchMm / 5;
    const auto row = [&](double slope, double width) {
      return RowOf(
          SimulateEye(images, display, FarEye(slope, 0, width, static_cast<int>(8 * width))));
    };
    const std::vector<double> centre = row(0, 64);
    Curve curve{two ? "two layers" : "one layer", {}, {}};
    const int steps = effort == Effort::kQuick ? 4 : 40;
    for (int i = 0; i <= steps * 5 / 4; ++i) {
      curve.x.push_back(static_cast<double>(i) / steps);
      curve.y.push_back(Correlation(row(repeat * i / steps, 48), centre));
    }
    at_repeat.push_back(curve.y[static_cast<std::size_t>(steps)]);
    experiment.rows.push_back(
        Reported(fmt::format("{}: correlation at half of the repeat's slope", curve.name),
                 curve.y[static_cast<std::size_t>(steps / 2)]));
    figure.curves.push_back(std::move(curve));
  }
  experiment.rows.push_back(AtLeast("one layer: correlation at the repeat", at_repeat[0], 0.99));
  experiment.rows.push_back(Reported("two layers: correlation at the repeat", at_repeat[1]));
  experiment.rows.push_back(
      AtLeast("fall from one layer to two", at_repeat[0] - at_repeat[1], 0.1));
  experiment.figures.push_back(std::move(figure));
  return experiment;
}

}  // namespace lamella::experiments
