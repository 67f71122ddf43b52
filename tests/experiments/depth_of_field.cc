// Cut-offs over depth: experiments 1, 2, 4 and 5.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "distribute/analyze.h"
#include "distribute/displays.h"
#include "lightfield/bandwidth.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

constexpr double kTolerance = 0.05;
constexpr int kStages = 2;  // boxes in the measurement: prefilter and display
constexpr int kViewsPerStep = 16;
constexpr int kMarginLenses = 12;

// The cut-off of the display over depth, by MTFs relative to that in a layer's own plane; of the
// sharpest depths, the largest frequency that was looked at.
struct CutoffCurve {
  std::vector<double> depths, cutoffs;
};

class CutoffMeter {
 public:
  CutoffMeter(Display display, Window window, double highest)
      : display_(std::move(display)),
        window_(window),
        frequencies_(window.Frequencies(0.1, highest)),
        reference_(MtfAt(display_.layers[0].position_mm)) {}

  double CutoffAt(double z) const { return CutoffOf(frequencies_, MtfAt(z), reference_, kStages); }

  CutoffCurve Over(double most, double step) const {
    CutoffCurve curve;
    const int half = static_cast<int>(std::lround(most / step));
    for (int i = -half; i <= half; ++i) {
      curve.depths.push_back(i * step);
      curve.cutoffs.push_back(CutoffAt(i * step));
    }
    return curve;
  }

 private:
  std::vector<double> MtfAt(double z) const {
    return ChainMtfAt(display_, window_, z, frequencies_, Sampling(6, 1), kViewsPerStep);
  }

  Display display_;
  Window window_;
  std::vector<double> frequencies_;
  std::vector<double> reference_;
};

// Length of the depths whose cut-off is at least `least`, ends interpolated.
double RangeWithCutoff(const CutoffCurve& curve, double least) {
  double range = 0;
  for (std::size_t i = 0; i + 1 < curve.depths.size(); ++i) {
    const double step = curve.depths[i + 1] - curve.depths[i];
    const double a = curve.cutoffs[i] - least, b = curve.cutoffs[i + 1] - least;
    if (a >= 0 && b >= 0) range += step;
    if (a >= 0 && b < 0) range += step * a / (a - b);
    if (a < 0 && b >= 0) range += step * b / (b - a);
  }
  return range;
}

Curve Capped(const std::string& name, const CutoffCurve& curve) {
  Curve capped{name, curve.depths, curve.cutoffs};
  for (double& cutoff : capped.y) cutoff = std::min(cutoff, 1 / (2 * kLatticeMm));
  return capped;
}

// Eq. 1 of the best of the layers.
Curve Expected(const std::string& name, const Display& display, double most) {
  Curve curve{name, {}, {}, Stroke::kClosedForm};
  for (double z = -most; z <= most; z += most / 120) {
    double best = 0;
    for (const Layer& layer : display.layers) {
      best = std::max(best, CutoffPerMm(display, layer, z - layer.position_mm));
    }
    curve.x.push_back(z);
    curve.y.push_back(best);
  }
  return curve;
}

Figure CutoffFigure(const std::string& title) { return {title, "z, mm", "cut-off, cycles/mm", {}}; }

constexpr double kNyquist = 1 / (2 * kLatticeMm);

}  // namespace

Experiment DepthOfField(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "1";
  experiment.claim =
      "More layers of equal angular sampling, 2 z_max apart, make the depth of field wider: n "
      "times with full cut-off 1/(2 Delta x), (n + 1)/2 times with at least half of it.";
  experiment.set_up =
      "Lens beam, z_max = 10 mm, hard borders, planes from -60 to 60 mm; prefilter and display, "
      "mean over 16 far eyes in an emitter step.";
  const Window window{.lattice_periods = 45, .lattice_mm = kLatticeMm};
  Figure figure = CutoffFigure("Depth of field of 1 to 4 layers");
  for (int n = 1; n <= (quick ? 2 : 4); ++n) {
    const Display display =
        Lenses(EqualBandwidthPositionsMm(n), window.lattice_periods + kMarginLenses);
    const double most = quick ? 10.0 * (n + 1) + 5 : 60;
    const CutoffCurve curve =
        CutoffMeter(display, window, 1.3 * kNyquist).Over(most, quick ? 5 : 2.5);
    const std::string name = fmt::format("{} layer{}", n, n > 1 ? "s" : "");
    experiment.rows.push_back(Near(name + ": range with full cut-off, mm",
                                   RangeWithCutoff(curve, kNyquist), 2 * n * kSharpRangeMm,
                                   kTolerance));
    experiment.rows.push_back(Near(name + ": range with at least half of it, mm",
                                   RangeWithCutoff(curve, kNyquist / 2),
                                   (2 * n + 2) * kSharpRangeMm, kTolerance));
    figure.curves.push_back(Capped(name, curve));
    figure.curves.push_back(Expected(name, display, most));
  }
  experiment.figures.push_back(std::move(figure));
  return experiment;
}

Experiment HalfTheRays(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "2";
  experiment.claim =
      "Two layers of half the rays in all show the same diffuse content, without occlusion, within "
      "z_max of one layer: cut-off 1/(2 Delta x) at every z in both, worst and mean MTF over z "
      "equal.";
  experiment.set_up =
      "Rays of paper-one-layer and paper-two-layer-half; MTF of lens beams: one layer at 0, two of "
      "doubled Delta u at +-5 mm, hard border, z = 0 to 10 mm.";
  const auto rays = [](const char* preset) {
    const Display display = FindDisplay(preset);
    double sum = 0;
    for (const Layer& layer : display.layers) sum += RaysOf(display, layer);
    return sum;
  };
  experiment.rows.push_back(Near("rays of paper-two-layer-half over those of paper-one-layer",
                                 rays("paper-two-layer-half") / rays("paper-one-layer"), 0.5,
                                 1e-12));
  const Window window{.lattice_periods = quick ? 45 : 99, .lattice_mm = kLatticeMm};
  const int lenses = window.lattice_periods + kMarginLenses;
  const Display one = Lenses({0}, lenses), half = Lenses({-5, 5}, lenses, 2);
  std::vector<double> frequencies, depths;
  for (const double about : {0.2, 0.4, 0.6}) frequencies.push_back(window.Frequency(about));
  for (double z = 0; z <= 10; z += 1) depths.push_back(z);
  Figure figure{"MTF over depth: one layer, and two with half of its rays", "z, mm", "MTF", {}};
  std::vector<std::vector<double>> mtf_one, mtf_half;  // [frequency][depth]
  mtf_one.resize(frequencies.size());
  mtf_half.resize(frequencies.size());
  for (const double z : depths) {
    const auto add = [&](const Display& display, std::vector<std::vector<double>>& mtf) {
      const std::vector<double> at =
          ChainMtfAt(display, window, z, frequencies, Sampling(8, 2), kViewsPerStep);
      for (std::size_t f = 0; f < at.size(); ++f) mtf[f].push_back(at[f]);
    };
    add(one, mtf_one);
    add(half, mtf_half);
  }
  for (std::size_t f = 0; f < frequencies.size(); ++f) {
    const std::string at = fmt::format("f = {:.2f}: ", frequencies[f]);
    experiment.rows.push_back(Near(at + "worst MTF of two over that of one",
                                   *std::min_element(mtf_half[f].begin(), mtf_half[f].end()) /
                                       *std::min_element(mtf_one[f].begin(), mtf_one[f].end()),
                                   1, kTolerance));
    experiment.rows.push_back(Near(at + "mean MTF of two over that of one",
                                   Mean(mtf_half[f]) / Mean(mtf_one[f]), 1, kTolerance));
    figure.curves.push_back({at + "two layers", depths, mtf_half[f]});
    figure.curves.push_back(
        {at + "one layer", depths, mtf_one[f], Stroke::kSecond, at + "two layers"});
  }
  for (const auto& [name, display] :
       {std::pair("one layer", &one), std::pair("two layers", &half)}) {
    const CutoffMeter meter(*display, window, 1.3 * kNyquist);
    double least = kNyquist;
    for (const double z : depths) {
      if (z < 10) least = std::min(least, meter.CutoffAt(z));
    }
    experiment.rows.push_back(
        Near(fmt::format("{}: smallest cut-off inside z_max, over 1/(2 Delta x)", name),
             least / kNyquist, 1, kTolerance));
  }
  experiment.figures.push_back(std::move(figure));
  return experiment;
}

Experiment OutsideTheRange(Effort effort) {
  Experiment experiment;
  experiment.id = "4";
  experiment.claim =
      "Outside z_max layers lose: at t = |z|/z_max the cut-off of n layers that share the range of "
      "one is t/(nt - n + 1) of that one's.";
  experiment.set_up = "Lens beam, one layer at 0 or n with n Delta u; planes at t = 1.25 to 3.";
  const Window window{.lattice_periods = 99, .lattice_mm = kLatticeMm};
  const int lenses = window.lattice_periods + kMarginLenses;
  const std::vector<double> times =
      effort == Effort::kQuick ? std::vector<double>{2} : std::vector<double>{1.25, 1.5, 2, 2.5, 3};
  Figure figure = CutoffFigure("Cut-off outside the range that the layers share");
  figure.x_label = "t = |z|/z_max";
  std::vector<std::vector<double>> cutoffs;
  for (int n = 1; n <= 3; ++n) {
    const Display display = Lenses(EqualRangePositionsMm(n, kSharpRangeMm), lenses, n);
    const CutoffMeter meter(display, window, 1.3 * kNyquist);
    Curve measured{fmt::format("n = {}", n), times, {}};
    Curve expected{fmt::format("n = {}", n), {}, {}, Stroke::kClosedForm};
    const auto closed = [&](double t) {
      return CombinedCutoffPerMm(t * kSharpRangeMm, n, kSharpRangeMm / kLensPitchPx, kLatticeMm,
                                 kLatticeMm / kLensPitchPx);
    };
    for (const double t : times) measured.y.push_back(meter.CutoffAt(t * kSharpRangeMm));
    for (double t = 1.2; t <= 3; t += 0.05) {
      expected.x.push_back(t);
      expected.y.push_back(closed(t));
    }
    cutoffs.push_back(measured.y);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const std::string at = fmt::format("n = {}, t = {:g}: ", n, times[i]);
      experiment.rows.push_back(
          Near(at + "cut-off, cycles/mm", measured.y[i], closed(times[i]), kTolerance));
      if (n == 1) continue;
      experiment.rows.push_back(Near(at + "relative to one layer", measured.y[i] / cutoffs[0][i],
                                     times[i] / (n * times[i] - n + 1), kTolerance));
    }
    figure.curves.push_back(std::move(measured));
    figure.curves.push_back(std::move(expected));
  }
  experiment.figures.push_back(std::move(figure));
  return experiment;
}

Experiment EqualBandwidth(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "5";
  experiment.claim =
      "Two layers with all the rays of one each double the range: sharp over +-20 mm instead of "
      "+-10 mm, and as good in the gap between them as at its ends.";
  experiment.set_up =
      "One layer at 0, two at +-10 mm, hard border; lens beam, and pinholes of 2 px to show where "
      "it fails.";
  const Window window{.lattice_periods = 45, .lattice_mm = kLatticeMm};
  const int lenses = window.lattice_periods + kMarginLenses;
  Figure figure = CutoffFigure("Sharp range of one and two layers, lenses");
  for (int n = 1; n <= 2; ++n) {
    const Display display = Lenses(EqualBandwidthPositionsMm(n), lenses);
    const double most = 40;
    const CutoffCurve curve =
        CutoffMeter(display, window, 1.3 * kNyquist).Over(most, quick ? 5 : 2.5);
    experiment.rows.push_back(Near(fmt::format("lenses, n = {}: sharp range, mm", n),
                                   RangeWithCutoff(curve, kNyquist), 20.0 * n, kTolerance));
    figure.curves.push_back(Capped(fmt::format("n = {}", n), curve));
    figure.curves.push_back(Expected(fmt::format("n = {}", n), display, most));
  }
  experiment.figures.push_back(std::move(figure));
  const double f = window.Frequency(0.4);
  Figure over_depth{"MTF of two layers over depth at 0.4 cycles/mm", "z, mm", "MTF", {}};
  for (const bool lens : {true, false}) {
    const Display display = lens ? Lenses({-10, 10}, lenses) : Pinholes({-10, 10}, 2 * lenses);
    const AxisBeam beam = MiddleBeam(display, display.layers[0]);
    const std::string name = lens ? "lenses" : "pinholes";
    Curve curve{name, {}, {}}, closed{name, {}, {}, Stroke::kClosedForm};
    for (double z = -20; z <= 20; z += quick ? 10 : 2.5) {
      curve.x.push_back(z);
      curve.y.push_back(ChainMtfAt(display, window, z, {f}, lens ? Sampling(8, 2) : Sampling(6, 3),
                                   kViewsPerStep)[0]);
    }
    for (double z = -20; z <= 20; z += 0.25) {
      closed.x.push_back(z);
      closed.y.push_back(ChainMtf(beam, z - (z < 0 ? -10 : 10), f));
    }
    const double ends = (curve.y.front() + curve.y.back()) / 2;
    const double gap = curve.y[curve.y.size() / 2];
    if (lens) {
      experiment.rows.push_back(
          Near("lenses: MTF in the gap over that at the ends", gap / ends, 1, kTolerance));
    } else {
      experiment.rows.push_back(
          Reported("pinholes: MTF 10 mm behind the back layer", curve.y.front()));
      experiment.rows.push_back(
          Reported("pinholes: MTF in the gap (shown by the front layer)", gap));
      experiment.rows.push_back(
          Reported("pinholes: MTF 10 mm before the front layer", curve.y.back()));
    }
    over_depth.curves.push_back(std::move(curve));
    over_depth.curves.push_back(std::move(closed));
  }
  experiment.figures.push_back(std::move(over_depth));
  experiment.reason =
      "Pinholes of 2 px do not double the range: their beam is three openings wide 10 mm in front "
      "of a layer and one wide 10 mm behind it, so that their blur is symmetric about z_l - 4 mm.";
  return experiment;
}

}  // namespace lamella::experiments
