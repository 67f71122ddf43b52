#include "tests/experiments/measure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "lightfield/error.h"
#include "lightfield/layer_map.h"
#include "tests/experiments/scenes.h"
#include "tests/experiments/set_ups.h"

namespace lamella::experiments {
namespace {

constexpr double kPi = std::numbers::pi;

double Sinc(double t) { return t == 0 ? 1 : std::sin(kPi * t) / (kPi * t); }

Complex Turn(double f, double x) { return std::polar(1.0, -2 * kPi * f * x); }

// Pixels a lattice period: at least 4 a panel pixel of the pinholes, and one of the lenses' own.
constexpr int kPixelsPerPeriod = 12;

}  // namespace

double Window::Frequency(double about) const {
  return 2 * std::round(about * width_mm() / 2) / width_mm();
}

std::vector<double> Window::Frequencies(double least, double most) const {
  std::vector<double> frequencies;
  for (int k = 2; k / width_mm() <= most; k += 2) {
    if (k / width_mm() >= least) frequencies.push_back(k / width_mm());
  }
  return frequencies;
}

std::vector<double> RowOf(const EyePicture& picture) {
  std::vector<double> row;
  for (int x = 0; x < picture.color.width(); ++x) {
    row.push_back(static_cast<double>(picture.color(x, 0).g));
  }
  return row;
}

Complex AmplitudeOf(const std::vector<double>& row, double pixel_mm, double middle_mm, double f) {
  Complex sum = 0;
  const double half = static_cast<double>(row.size()) / 2;
  for (std::size_t i = 0; i < row.size(); ++i) {
    sum += row[i] * Turn(f, middle_mm + (static_cast<double>(i) + 0.5 - half) * pixel_mm);
  }
  return 2.0 * sum / static_cast<double>(row.size()) / Sinc(f * pixel_mm);
}

std::vector<std::vector<Complex>> SeenAmplitudes(const LayerImages& images, const Display& display,
                                                 const Window& window, double z,
                                                 const std::vector<double>& slopes,
                                                 const std::vector<double>& frequencies) {
  std::vector<std::vector<Complex>> amplitudes;
  for (const double slope : slopes) {
    // Of lines that pass the middle of z = 0, whatever their slope; they meet z beside its middle.
    Eye eye = FarEye(slope, 0, window.width_mm(), kPixelsPerPeriod * window.lattice_periods);
    const std::vector<double> row = RowOf(SimulateEye(images, display, eye));
    amplitudes.emplace_back();
    for (const double f : frequencies) {
      amplitudes.back().push_back(AmplitudeOf(row, eye.pixel_mm, slope * z, f));
    }
  }
  return amplitudes;
}

std::vector<double> MeanOverViews(const std::vector<std::vector<Complex>>& amplitudes) {
  std::vector<double> means;
  for (std::size_t f = 0; f < amplitudes.at(0).size(); ++f) {
    Complex sum = 0;
    for (const std::vector<Complex>& view : amplitudes) sum += view[f];
    means.push_back(std::abs(sum) / static_cast<double>(amplitudes.size()));
  }
  return means;
}

std::vector<double> StoredAmplitudes(const LayerImages& images, const Display& display,
                                     const Window& window, double z,
                                     const std::vector<double>& frequencies) {
  const LayerMap map(display, 0);
  const int k = SlotsPerAxis(display.layers[0]), row = display.emitter_rows() / 2;
  struct Direction {
    std::vector<Complex> sums;
    int count = 0;
  };
  std::map<long, Direction> directions;  // by slope, in thousandths of a step
  for (int slot = 0; slot < k * k; ++slot) {
    for (int column = 0; column < display.emitter_columns(); ++column) {
      const std::optional<Beam> beam = map.BeamOf(slot, 0, column, row);
      if (!beam || std::abs(beam->x.element_mm) > window.width_mm() / 2 - 1e-6) continue;
      Direction& d = directions[std::lround(1000 * beam->x.slope() / StepOfView(display))];
      d.sums.resize(frequencies.size());
      ++d.count;
      const double value =
          static_cast<double>(images.slots[0][static_cast<std::size_t>(slot)].color(column, row).g);
      for (std::size_t f = 0; f < frequencies.size(); ++f) {
        d.sums[f] += 2 * value * Turn(frequencies[f], beam->x.At(z - map.position_mm()));
      }
    }
  }
  std::vector<Complex> means(frequencies.size());
  for (const auto& [slope, d] : directions) {
    if (d.count % window.lattice_periods != 0) {
      throw UsageError("window", "does not hold every element of each direction",
                       "take a larger panel");
    }
    for (std::size_t f = 0; f < means.size(); ++f) {
      means[f] += d.sums[f] / static_cast<double>(d.count) / static_cast<double>(directions.size());
    }
  }
  std::vector<double> moduli;
  for (const Complex& mean : means) moduli.push_back(std::abs(mean));
  return moduli;
}

std::vector<double> ChainMtfAt(const Display& display, const Window& window, double z,
                               const std::vector<double>& frequencies, const LayersOptions& options,
                               int views_per_step) {
  const LayerImages images =
      Distribute(PlaneOfWaves(z, frequencies), display, options, SilentProgress());
  return MeanOverViews(SeenAmplitudes(images, display, window, z,
                                      SlopesOverSteps(display, 1, views_per_step), frequencies));
}

double CutoffOf(const std::vector<double>& frequencies, const std::vector<double>& mtf,
                const std::vector<double>& reference, int stages) {
  const double threshold = std::pow(2 / kPi, stages);
  double last_f = 0, last = 1;
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    const double ratio = mtf[i] / reference[i];
    if (ratio < threshold) {
      return last_f + (frequencies[i] - last_f) * (last - threshold) / (last - ratio);
    }
    last_f = frequencies[i];
    last = ratio;
  }
  return last_f;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double PsnrOf(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return 10 * std::log10(static_cast<double>(a.size()) / sum);
}

}  // namespace lamella::experiments
