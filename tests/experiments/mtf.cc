// The measured MTF against the rows of displays.md section 1.3.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "distribute/analyze.h"
#include "lightfield/bandwidth.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/measure.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

constexpr double kMtfTolerance = 0.02;
constexpr double kLeastFactor = 0.07;  // of the row; below it a measurement is mostly noise

// One kind of measurement, at [depth][frequency].
struct Kind {
  std::string name;
  std::vector<std::vector<double>> measured, expected;
};

struct FrequencySweep {
  Display display;
  LayersOptions encoder, point_samples;
  Window window;
  std::vector<double> depths, frequencies;
};

std::vector<double> MeanModuli(const std::vector<std::vector<Complex>>& amplitudes) {
  std::vector<double> means(amplitudes.at(0).size(), 0);
  for (const auto& view : amplitudes) {
    for (std::size_t f = 0; f < means.size(); ++f) {
      means[f] += std::abs(view[f]) / static_cast<double>(amplitudes.size());
    }
  }
  return means;
}

// Of all views, the modulus that is farthest from the expected one.
std::vector<double> FarthestModuli(const std::vector<std::vector<Complex>>& amplitudes,
                                   const std::vector<double>& expected) {
  std::vector<double> farthest = expected;
  for (const auto& view : amplitudes) {
    for (std::size_t f = 0; f < farthest.size(); ++f) {
      const double modulus = std::abs(view[f]);
      if (std::abs(modulus - expected[f]) > std::abs(farthest[f] - expected[f])) {
        farthest[f] = modulus;
      }
    }
  }
  return farthest;
}

// Single views of pinholes have no closed form; the mean of their moduli is S^2.
void MeasureOneEye(const FrequencySweep& sweep, const std::vector<std::vector<Complex>>& seen,
                   const AxisBeam& beam, double z, Kind& kind) {
  std::vector<double> expected;
  const bool lens = beam.power_per_mm > 0;
  for (const double f : sweep.frequencies) {
    expected.push_back(lens ? FixedEyeChainMtf(beam, z, f) : ChainMtf(beam, z, f));
  }
  kind.measured.push_back(lens ? FarthestModuli(seen, expected) : MeanModuli(seen));
  kind.expected.push_back(expected);
}

std::vector<Kind> Measure(const FrequencySweep& sweep) {
  const AxisBeam beam = MiddleBeam(sweep.display, sweep.display.layers[0]);
  const bool lens = beam.power_per_mm > 0;
  std::vector<Kind> kinds = {
      {"prefilter alone", {}, {}},
      {"display alone, mean over views", {}, {}},
      {"both, mean over views", {}, {}},
      {lens ? "both, one far eye (the worst of them)" : "both, one far eye (mean of the moduli)",
       {},
       {}}};
  const std::vector<double> slopes = SlopesOverSteps(sweep.display, 2, 16);
  for (const double z : sweep.depths) {
    const SceneAlongX scene = PlaneOfWaves(z, sweep.frequencies);
    const auto seen = [&](const LayerImages& images) {
      return SeenAmplitudes(images, sweep.display, sweep.window, z, slopes, sweep.frequencies);
    };
    const LayerImages filtered = Distribute(scene, sweep.display, sweep.encoder, SilentProgress());
    const auto amplitudes = seen(filtered);
    kinds[0].measured.push_back(
        StoredAmplitudes(filtered, sweep.display, sweep.window, z, sweep.frequencies));
    kinds[1].measured.push_back(MeanOverViews(
        seen(Distribute(scene, sweep.display, sweep.point_samples, SilentProgress()))));
    kinds[2].measured.push_back(MeanOverViews(amplitudes));
    std::vector<double> single, both;
    for (const double f : sweep.frequencies) {
      single.push_back(Mtf(beam, z, f));
      both.push_back(ChainMtf(beam, z, f));
    }
    kinds[0].expected.push_back(single);
    kinds[1].expected.push_back(single);
    kinds[2].expected.push_back(both);
    MeasureOneEye(sweep, amplitudes, beam, z, kinds[3]);
  }
  return kinds;
}

void Report(const std::string& beam, const FrequencySweep& sweep, const std::vector<Kind>& kinds,
            Experiment& experiment) {
  Table table{fmt::format("MTF of {} at depth z, frequency f", beam), {"z, mm", "f, c/mm"}, {}};
  for (const Kind& kind : kinds) {
    table.columns.push_back(kind.name);
    table.columns.emplace_back("expected");
    table.columns.emplace_back("deviation, %");
  }
  std::vector<double> worst(kinds.size(), 0);
  for (std::size_t z = 0; z < sweep.depths.size(); ++z) {
    for (std::size_t f = 0; f < sweep.frequencies.size(); ++f) {
      table.rows.push_back({sweep.depths[z], sweep.frequencies[f]});
      for (std::size_t k = 0; k < kinds.size(); ++k) {
        const double measured = kinds[k].measured[z][f], expected = kinds[k].expected[z][f];
        const double deviation = measured / expected - 1;
        if (expected >= kLeastFactor) worst[k] = std::max(worst[k], std::abs(deviation));
        table.rows.back().insert(table.rows.back().end(), {measured, expected, 100 * deviation});
      }
    }
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    experiment.rows.push_back(
        AtMost(fmt::format("{}: {}, worst relative deviation", beam, kinds[k].name), worst[k],
               kMtfTolerance));
  }
  experiment.tables.push_back(std::move(table));
  Figure figure{fmt::format("MTF of {}, prefilter and display, mean over views", beam),
                "f, cycles/mm",
                "MTF",
                {}};
  const AxisBeam middle = MiddleBeam(sweep.display, sweep.display.layers[0]);
  for (std::size_t z = 0; z < sweep.depths.size(); ++z) {
    const std::string name = fmt::format("z = {:g} mm", sweep.depths[z]);
    figure.curves.push_back({name, sweep.frequencies, kinds[2].measured[z]});
    Curve closed{name, {}, {}, Stroke::kClosedForm};
    for (double f = 0; f <= sweep.frequencies.back() * 1.05; f += 0.01) {
      closed.x.push_back(f);
      closed.y.push_back(ChainMtf(middle, sweep.depths[z], f));
    }
    figure.curves.push_back(std::move(closed));
  }
  experiment.figures.push_back(std::move(figure));
}

}  // namespace

Experiment MtfRows(Effort effort) {
  const bool quick = effort == Effort::kQuick;
  Experiment experiment;
  experiment.id = "mtf";
  experiment.claim =
      "The measured MTF of the simulated display is within 2 % of the beam's where that is at "
      "least 0.07: S = sinc(f W_a) sinc(f W_b) of the prefilter alone and of the display alone, "
      "S^2 of both in the mean over views, sinc(f W_a)^2 sinc(f W_b) of both for one far eye "
      "before lenses (W_a, W_b: widths of the beam's boxes at that depth).";
  const Window window{.lattice_periods = quick ? 33 : 99, .lattice_mm = kLatticeMm};
  std::vector<double> frequencies;
  for (const double about : {0.1, 0.2, 0.3, 0.4, 0.6}) {
    if (!quick || about == 0.2 || about == 0.4) frequencies.push_back(window.Frequency(about));
  }
  const std::vector<double> depths =
      quick ? std::vector<double>{-10, 5} : std::vector<double>{-20, -10, -5, 5, 10};
  experiment.set_up = fmt::format(
      "One layer, one element high, before waves on a plane at z; encoder 12 nodes a step and 4 "
      "(pinholes) or 2 (lenses) samples a pixel, point samples by kernel `ray`; far eyes, 16 a "
      "step over two steps; complex amplitudes over {:g} mm, {} lattice periods.",
      window.width_mm(), window.lattice_periods);
  const int margin = 18;  // lattice periods, of which the slopes need a few
  const FrequencySweep pinholes{Pinholes({0}, 2 * (window.lattice_periods + margin)),
                                Sampling(12, 4),
                                Sampling(1, 8, "ray"),
                                window,
                                depths,
                                frequencies};
  const FrequencySweep lenses{Lenses({0}, window.lattice_periods + margin),
                              Sampling(12, 2),
                              Sampling(1, 4, "ray"),
                              window,
                              depths,
                              frequencies};
  Report("pinholes", pinholes, Measure(pinholes), experiment);
  Report("lenses", lenses, Measure(lenses), experiment);
  experiment.reason =
      "Single far views of pinholes have no closed form (opening and emitter are coupled): their "
      "moduli's mean is compared with S^2.";
  return experiment;
}

}  // namespace lamella::experiments
