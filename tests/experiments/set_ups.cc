#include "tests/experiments/set_ups.h"

#include "distribute/displays.h"

namespace lamella::experiments {
namespace {

// 100 mm of it are seen under parallel lines to 1e-4 of an emitter step.
constexpr double kFarMm = 1e6;

Display Bare(const char* name, int columns, int rows) {
  Display display;
  display.name = name;
  display.width_px = columns;
  display.height_px = rows;
  display.viewing_distance_mm = 600;
  display.shear = false;
  return display;
}

}  // namespace

Display Pinholes(const std::vector<double>& positions_mm, int columns, int rows) {
  Display display = Bare("pinholes", columns, rows);
  display.pitch_mm = kPitchMm;
  for (const double z : positions_mm) display.layers.push_back({z, 5, Barrier{6, 2, 3}});
  return display;
}

Display Lenses(const std::vector<double>& positions_mm, int lenses, int binning, int rows) {
  const int per_lens = static_cast<int>(kLensPitchPx);
  Display display = Bare("lenses", lenses * per_lens, rows * per_lens);
  display.pitch_mm = kLatticeMm / kLensPitchPx;
  display.binning_px = binning;
  LensletArray array;
  array.lattice = LensletArray::Lattice::kSquare;
  array.rays = per_lens / binning;
  array.pitch_px = array.rays;
  for (const double z : positions_mm) {
    display.layers.push_back({z, kSharpRangeMm / kLensPitchPx, array});
  }
  return display;
}

std::vector<double> EqualBandwidthPositionsMm(int layers) {
  std::vector<double> positions;
  for (int l = 0; l < layers; ++l) positions.push_back((2 * l + 1 - layers) * kSharpRangeMm);
  return positions;
}

double StepOfView(const Display& display) {
  return display.emitter_pitch_mm() / display.layers[0].d0_mm;
}

std::vector<double> SlopesOverSteps(const Display& display, int steps, int per_step) {
  std::vector<double> slopes;
  const int count = steps * per_step;
  for (int i = 0; i < count; ++i) {
    slopes.push_back(((i + 0.5) / per_step - steps / 2.0) * StepOfView(display));
  }
  return slopes;
}

Eye FarEye(double slope, double plane_mm, double width_mm, int pixels) {
  Eye eye;
  eye.position = {slope * (kFarMm - plane_mm), 0, kFarMm};
  eye.plane_mm = plane_mm;
  eye.pixel_mm = width_mm / pixels;
  eye.left_mm = -width_mm / 2;
  eye.top_mm = eye.pixel_mm / 2;
  eye.width = pixels;
  eye.height = 1;
  return eye;
}

LayersOptions Sampling(int nodes_per_step, int samples_per_pixel, const char* kernel) {
  LayersOptions options;
  options.nodes_per_step = nodes_per_step;
  options.samples_per_pixel = samples_per_pixel;
  options.kernel = kernel;
  return options;
}

}  // namespace lamella::experiments
