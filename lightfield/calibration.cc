#include "lightfield/calibration.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "lightfield/color.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr double kFarthestMm = 1e7;
constexpr double kLargestShape = 0.2;

// Refuses with the name of what was being looked at: "layer 1, emitter".
struct CalibrationChecker {
  const std::string& where;
  std::string part;

  void Require(bool holds, const std::string& what, const std::string& fix) const {
    if (!holds) throw UsageError(where, fmt::format("{}: {}", part, what), fix);
  }
  void Between(double value, double low, double high, const char* name) const {
    Require(value >= low && value <= high, fmt::format("{} = {}", name, value),
            fmt::format("give a number from {:g} to {:g}", low, high));
  }
  void Finite(double value, const char* name) const {
    Between(value, -kFarthestMm, kFarthestMm, name);
  }
};

void CheckCurve(const ToneCurve& curve, const CalibrationChecker& check) {
  if (curve.kind == ToneCurve::Kind::kGamma) check.Between(curve.gamma, 0.05, 20, "gamma");
  if (curve.kind != ToneCurve::Kind::kTable) return;
  const std::vector<double>& table = curve.table;
  check.Require(table.size() >= 2 && std::is_sorted(table.begin(), table.end()) &&
                    table.front() == 0 && table.back() == 1,
                "the response table does not rise from 0 to 1", "mend its knots");
}

void CheckEvenness(const GainMap& map, const CalibrationChecker& check) {
  check.Require(map.columns >= 1 && map.columns <= 1000 && map.rows >= 1 && map.rows <= 1000 &&
                    map.gains.size() ==
                        static_cast<std::size_t>(map.columns) * static_cast<std::size_t>(map.rows),
                "evenness is not of columns x rows gains", "mend it");
  for (const double gain : map.gains) check.Between(gain, 1e-3, 1e3, "a gain of evenness");
}

void CheckPhotometry(const Photometry& photometry, const CalibrationChecker& check) {
  CheckCurve(photometry.curve, check);
  check.Between(photometry.black, 0, 1 - 1e-9, "black (of a modulator its leakage)");
  check.Between(photometry.falloff, 0, 100, "falloff");
  check.Require(photometry.primaries.allFinite(), "primaries are not finite", "give 9 numbers");
  CheckEvenness(photometry.evenness, check);
  const SpreadKernel& kernel = photometry.crosstalk;
  const bool square = kernel.size >= 1 && kernel.size <= 99 && kernel.size % 2 == 1 &&
                      static_cast<int>(kernel.weights.size()) == kernel.size * kernel.size;
  check.Require(square, "crosstalk is not of size x size weights, size odd and at most 99",
                "mend it");
  const double sum = std::accumulate(kernel.weights.begin(), kernel.weights.end(), 0.0);
  check.Require(std::abs(sum - 1) < 1e-6, fmt::format("crosstalk weights sum to {:g}", sum),
                "make it 1");
}

void CheckPanel(const PanelCalibration& panel, const CalibrationChecker& check) {
  check.Between(panel.width_px, 1, 1 << 20, "width_px");
  check.Between(panel.height_px, 1, 1 << 20, "height_px");
  check.Between(panel.pitch_mm, 1e-9, kFarthestMm, "pitch_mm");
  check.Between(panel.scale, 1e-3 - 1, 1e3 - 1, "scale");  // a relay's magnification is in it
  check.Between(panel.aspect, -kLargestShape, kLargestShape, "aspect");
  check.Between(panel.skew, -kLargestShape, kLargestShape, "skew");
  check.Between(panel.pincushion, -kLargestShape, kLargestShape, "pincushion");
  check.Between(panel.bow_mm, -panel.HalfDiagonalMm(), panel.HalfDiagonalMm(), "bow_mm");
  CheckPhotometry(panel.photometry, check);
}

void CheckPose(const LayerCalibration& layer, const CalibrationChecker& check) {
  const Rigid& pose = layer.display_from_stack;
  check.Require(std::abs(pose.rotation.norm() - 1) < 1e-6, "the rotation is no unit quaternion",
                "normalise it");
  for (int i = 0; i < 3; ++i) {
    check.Finite(pose.translation(i), "translation_mm");
    check.Between(layer.rotation_rad(i), -1.5, 1.5, "rotation_rad");
  }
  check.Finite(layer.offset_mm.x(), "offset_mm");
  check.Finite(layer.offset_mm.y(), "offset_mm");
  check.Between(layer.gap_mm, 0, kFarthestMm, "gap_mm");
  check.Between(layer.index, 1, 4, "index");
  check.Between(layer.gain, 0, 1e6, "gain");
}

void CheckLattice(const LayerCalibration& layer, const CalibrationChecker& check) {
  const LensLattice& lattice = *layer.lattice;
  check.Require(!layer.modulator, "has both lenses and a modulator", "leave one out");
  check.Require(layer.gap_mm > 0, "has lenses but no gap_mm behind them", "give a gap above 0");
  check.Between(lattice.pitch_mm, 1e-9, kFarthestMm, "lattice pitch_mm");
  check.Finite(lattice.rotation_rad, "lattice rotation_rad");
  check.Between(lattice.phase.x(), 0, 1, "lattice phase");
  check.Between(lattice.phase.y(), 0, 1, "lattice phase");
  check.Between(lattice.focal_mm, 0, kFarthestMm, "lattice focal_mm");
}

void CheckLayer(const LayerCalibration& layer, std::size_t index, const std::string& where) {
  const std::string name = fmt::format("layer {}", index);
  CheckPanel(layer.emitter, {where, name + ", emitter"});
  if (layer.modulator) CheckPanel(*layer.modulator, {where, name + ", modulator"});
  const CalibrationChecker check{where, name};
  CheckPose(layer, check);
  if (layer.lattice) CheckLattice(layer, check);
  if (layer.plate) {
    check.Between(layer.plate->thickness_mm, 0, kFarthestMm, "plate thickness_mm");
    check.Between(layer.plate->index, 1, 4, "plate index");
    check.Require(std::abs(layer.plate->normal.norm() - 1) < 1e-6,
                  "the plate's normal is no unit vector", "normalise it");
  }
}

}  // namespace

double PanelCalibration::HalfDiagonalMm() const {
  return pitch_mm / 2 * std::hypot(width_px, height_px);
}

double LightOfCode(const ToneCurve& curve, double code) {
  const double c = std::clamp(code, 0.0, 1.0);
  switch (curve.kind) {
    case ToneCurve::Kind::kSrgb:
      return static_cast<double>(SrgbToLinear(static_cast<float>(c)));
    case ToneCurve::Kind::kGamma:
      return std::pow(c, curve.gamma);
    case ToneCurve::Kind::kTable:
      break;
  }
  const double at = c * static_cast<double>(curve.table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), curve.table.size() - 2);
  const double t = at - static_cast<double>(i);
  return (1 - t) * curve.table[i] + t * curve.table[i + 1];
}

double GainAt(const GainMap& map, double x, double y) {
  const double u = std::clamp(x * map.columns - 0.5, 0.0, map.columns - 1.0);
  const double v = std::clamp(y * map.rows - 0.5, 0.0, map.rows - 1.0);
  const int left = static_cast<int>(u), top = static_cast<int>(v);
  const int right = std::min(left + 1, map.columns - 1), below = std::min(top + 1, map.rows - 1);
  const auto at = [&](int column, int row) {
    const int index = row * map.columns + column;
    return map.gains[static_cast<std::size_t>(index)];
  };
  const double s = u - left, t = v - top;
  return (1 - t) * ((1 - s) * at(left, top) + s * at(right, top)) +
         t * ((1 - s) * at(left, below) + s * at(right, below));
}

SpreadKernel GaussianSpread(double sigma_px) {
  if (!(sigma_px > 0)) return {};
  const int half = std::min(49, static_cast<int>(std::ceil(3 * sigma_px)));
  std::vector<double> line;
  for (int i = -half; i <= half; ++i) {
    const double scale = 1 / (sigma_px * std::sqrt(2.0));
    line.push_back(std::erf((i + 0.5) * scale) - std::erf((i - 0.5) * scale));
  }
  const double sum = std::accumulate(line.begin(), line.end(), 0.0);
  SpreadKernel kernel{2 * half + 1, {}};
  for (const double a : line) {
    for (const double b : line) kernel.weights.push_back(a * b / (sum * sum));
  }
  return kernel;
}

void Check(const Calibration& calibration, const std::string& where) {
  if (calibration.layers.empty()) throw UsageError(where, "has no layer", "give one or more");
  for (std::size_t i = 0; i < calibration.layers.size(); ++i) {
    CheckLayer(calibration.layers[i], i, where);
  }
}

}  // namespace lamella
