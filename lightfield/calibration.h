// A calibration: what a display's panels really are and where they really stand. A misalignment
// and a calibration are the same numbers: the virtual prototype is built from them, and
// calibrating a display finds them. calibration.md section 1.
//
// Frames, all in mm, x right, y up, z to the viewer:
//   display   of lightfield/display.h
//   stack     of a layer, origin in the middle of its modulator (or lens sheet), which lies in z =
//   0 panel     of one panel, origin in its middle; a modulator's is its layer's stack
// A panel that is seen by reflection is a virtual panel of reversed handedness: mirror_x.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/display.h"
#include "lightfield/rigid.h"

namespace lamella {

// From a panel's code, 0 to 1, to its light, 0 to 1.
struct ToneCurve {
  enum class Kind { kSrgb, kGamma, kTable };
  Kind kind = Kind::kSrgb;
  double gamma = 2.2;         // kGamma: light = code^gamma
  std::vector<double> table;  // kTable: light of the codes i/(n - 1), from 0 to 1, never falling
  friend bool operator==(const ToneCurve&, const ToneCurve&) = default;
};
double LightOfCode(const ToneCurve& curve, double code);

// How an emitter's light spreads over neighbouring pixels (a diffuser): size x size weights, row by
// row, the middle one the pixel's own; size is odd, the sum 1.
struct SpreadKernel {
  int size = 1;
  std::vector<double> weights{1};
  friend bool operator==(const SpreadKernel&, const SpreadKernel&) = default;
};
// A Gaussian integrated over the pixels, cut at 3 sigma and normalised.
SpreadKernel GaussianSpread(double sigma_px);

// How bright a panel is from place to place, against its mean: in the middles of columns x rows
// equal cells, row by row from the top left as the panel is addressed.
struct GainMap {
  int columns = 1, rows = 1;
  std::vector<double> gains{1};
  friend bool operator==(const GainMap&, const GainMap&) = default;
};
// At shares of the panel's width and height, from its left and top: bilinear between the middles,
// level beyond the outermost.
double GainAt(const GainMap& map, double x, double y);

// Codes to light before an emitter's evenness (of a modulator: to transmittance):
//   light = primaries * (black + (1 - black) curve(code)), times cos(angle to the normal)^falloff
struct Photometry {
  ToneCurve curve;
  double black = 0;  // of code 0; of a modulator the leakage where it is closed, 1/contrast
  // Linear Rec. 709 light of the panel's full red, green and blue (columns). Emitters only.
  Eigen::Matrix3d primaries = Eigen::Matrix3d::Identity();
  double falloff = 0;      // exponent; 0: as bright from everywhere
  SpreadKernel crosstalk;  // emitters only
  GainMap evenness;        // emitters only
};

// Pixel (u, v), edges at whole numbers, v down, to mm, with R half the panel's diagonal:
//   x = p (u - W/2)(1 + s)(1 + a) + k y    y = p (H/2 - v)(1 + s)(1 - a)
//   X = x (1 + q r^2/R^2)    Y = y (1 + q r^2/R^2)    r^2 = x^2 + y^2    Z = b (X^2 + Y^2)/R^2
// and -X where it is mirrored.
struct PanelCalibration {
  int width_px = 0, height_px = 0;         // W, H
  double pitch_mm = 0;                     // p
  double scale = 0, aspect = 0, skew = 0;  // s, a, k
  double bow_mm = 0;                       // b: sag of the corners, to the viewer where positive
  double pincushion = 0;                   // q: of relayed images
  bool mirror_x = false;
  bool rgb_stripes = false;  // red, green and blue light fill the thirds of a pixel, from its left
  Photometry photometry;

  double HalfDiagonalMm() const;  // R
};

// A sheet of lenses in the stack's plane z = 0. Lens centres have normal coordinates
// x cos(th) + y sin(th) = (i + phase[0]) p (a line's whole description); square adds the family at
// th + 90 degrees with phase[1]; hexagonal has two families 60 degrees apart, spaced p sqrt(3)/2.
// Its reduced gap f is the layer's gap_mm / index.
struct LensLattice {
  enum class Type { kLine, kSquare, kHexagonal };
  Type type = Type::kSquare;
  double pitch_mm = 0;          // p, between neighbouring lenses
  double rotation_rad = 0;      // th
  Eigen::Vector2d phase{0, 0};  // in lenses, [0, 1)
  double focal_mm = 0;  // of the lenses; 0: the reduced gap, so that light leaves collimated
};

// A flat glass between the layer and the viewer (the splitter seen in transmission).
struct Plate {
  double thickness_mm = 0;
  double index = 1.5;
  Eigen::Vector3d normal{0, 0, 1};  // unit, in the display's frame
};

struct LayerCalibration {
  Rigid display_from_stack;
  PanelCalibration emitter;
  std::optional<PanelCalibration> modulator;  // none before a bare panel or where lenses are
  std::optional<LensLattice> lattice;
  // The emitter in its stack: stack = Rotation(rotation_rad) * panel + (offset_mm, -gap_mm).
  Eigen::Vector2d offset_mm{0, 0};
  double gap_mm = 0;                      // g, of matter, not its air equivalent
  Eigen::Vector3d rotation_rad{0, 0, 0};  // rotation vector: tilt x, tilt y, rotation z
  double index = 1;                       // n of what fills the gap behind the plane z = 0
  std::optional<Plate> plate;
  double gain = 1;  // share of the layer's light that reaches the viewer
};

struct Calibration {
  std::string display;                   // the name of the display that it is of
  std::vector<LayerCalibration> layers;  // as in the display: 0 is at the back
};

// As designed: panels in place, gaps of d0 times their index, an sRGB response with the black of
// the panels' contrasts (1/contrast), n layers of gain 1/n, reflected layers mirrored, lens sheets
// on their lattice, and what a relay magnifies as it is seen: scale M - 1, gap M^2 d0, lens pitch M
// p.
Calibration DesignCalibration(const Display& display);

// A relay that shows a layer's panels larger by a factor: the gap behind its lenses and their focal
// length become so by its square, their pitch with the panel. The panels' scale and offset
// are left to set. `larger` is above 0.
void MagnifyOptics(LayerCalibration& layer, double larger);

// UsageError (one line naming layer, panel and field) where a number is not finite or not possible:
// sizes below 1 px, pitch or index out of range, 1 + s outside [1e-3, 1e3], |a|, |k|, |q| above
// 0.2, a bow beyond the half diagonal, a negative gap, lenses without a gap, black outside [0, 1),
// a falling tone curve, spread weights that do not sum to 1, gains outside [1e-3, 1e3], no layer, a
// layer with both modulator and lenses.
void Check(const Calibration& calibration, const std::string& where);

}  // namespace lamella
