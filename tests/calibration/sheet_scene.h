// Lens sheets photographed by pinhole cameras: every pixel's line of sight goes to a lens's vertex
// and on to the panel, by geometry of this file's own.
#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include "calibration/lattice.h"
#include "lightfield/calibration.h"
#include "tests/calibration/degree.h"

namespace lamella {

constexpr double kSheetPixel = 0.0784;  // mm; 324 per inch
constexpr int kSheetWidth = 1536, kSheetHeight = 2048;

// Lens centres (i + phase 0) b1 + (j + phase 1) b2; a line's lenses run along b2 everywhere.
struct Sheet {
  LensLattice::Type type = LensLattice::Type::kLine;
  double pitch = 5.7 * kSheetPixel, rotation = 0.14, gap = 0.9;
  Eigen::Vector2d phase{0.31, 0.77};

  Eigen::Vector2d NearestCentre(const Eigen::Vector2d& q) const;
  // What an eye sees through the lens at q, mm: s_k (1 + f/D) - e_s f/D in every direction that the
  // lens bends, the pixel's own line of sight giving the slope.
  Eigen::Vector2d Seen(const Eigen::Vector2d& q, const Eigen::Vector3d& eye) const;
};

LayerCalibration DesignOf(const Sheet& sheet);
// Wrong by 1 %, a degree and a tenth of the gap.
LayerCalibration WrongDesign(const Sheet& sheet, int sign);

struct SheetNoise {
  double decode_px = 0;  // of a decoded pixel
  // Of photographs of the sinusoid of 16 px in eight steps, in its amplitudes: decoded here, the
  // period unknown.
  double intensity = 0;
  double borders = 0;  // share of a lens at its rim where two lenses' light mixes
  double stray = 0;    // share of samples that are anything
  double eye_mm = 0;   // of the cameras' positions, as they are said to be
};
// So many samples from every eye, places at random.
LatticeObservations PhotographSheet(const Sheet& sheet, const std::vector<Eigen::Vector3d>& eyes,
                                    int samples, const SheetNoise& noise, std::uint32_t seed);
std::vector<Eigen::Vector3d> TwoEyes();  // 240 mm apart, half a metre away

// What lenses at the panel's edges and middle show to eyes within 120 mm of the axis, by the
// estimate and in truth, px: the largest difference, of a line's across its lenses.
double DriftOf(const LayerCalibration& layer, const Sheet& truth);
double PhaseErrorPx(const LayerCalibration& layer, const Sheet& truth);
LatticeOptions SheetViewers();  // who are as far from the axis

}  // namespace lamella
