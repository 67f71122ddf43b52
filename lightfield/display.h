// A display: layers that stand at different depths, each an emissive panel behind a modulator
// (Ranieri et al. 2012). All of its geometry that is not a misalignment.
//
// Display frame: x right, y up, z towards the viewer, origin at the centre of the reference plane,
// millimetres. A layer's position is that of its modulating plane; its emitter lies d0 behind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lamella {

// A parallax barrier (paper section 3; displays.md section 2): openings of aperture_px x
// aperture_px emitters every period_px, shown in slots x slots time slots that shift it by
// period_px / slots.
struct Barrier {
  int period_px = 6;    // P, emitters
  int aperture_px = 2;  // a, emitters; same parity as P
  int slots = 3;        // k per axis; divides P

  int stride_px() const { return period_px / slots; }  // q, from slot to slot
  friend bool operator==(const Barrier&, const Barrier&) = default;
};

struct Layer {
  double position_mm = 0;  // z of the modulating plane
  double d0_mm = 5;        // emissive plane to modulating plane, air-equivalent (gap / index)
  Barrier barrier;
  bool mirror_x = false;  // seen by reflection: its finished frames are flipped in x

  friend bool operator==(const Layer&, const Layer&) = default;
};

struct Display {
  std::string name;
  int width_px = 0, height_px = 0;  // of every panel
  double pitch_mm = 0;              // of the panel's pixels
  int binning_px = 1;               // an emitter is binning x binning panel pixels
  double viewing_distance_mm = 0;   // D: the fans of all elements meet at (0, 0, D)
  bool shear = true;                // off: all fans are parallel to the axis
  double border_mm = 0;             // w: width over which neighbouring layers' ranges overlap
  // Borders lie this far in front of the middles between modulating planes; 0 is the paper's rule.
  double border_offset_mm = 0;
  std::vector<Layer> layers;  // by rising position; 0 is at the back

  int emitter_columns() const { return width_px / binning_px; }
  int emitter_rows() const { return height_px / binning_px; }
  double emitter_pitch_mm() const { return pitch_mm * binning_px; }
  double width_mm() const { return width_px * pitch_mm; }
  double height_mm() const { return height_px * pitch_mm; }
  // The distance from the modulating plane of a layer to where its fans meet.
  double distance_mm(const Layer& layer) const { return viewing_distance_mm - layer.position_mm; }

  friend bool operator==(const Display&, const Display&) = default;
};

// UsageError (one line: what, where, what to do) where the display can't work: no layer, layers at
// one place or out of order, period not divided by slots, period and aperture of unequal parity,
// aperture wider than the period, non-positive or non-finite lengths, panel not a multiple of the
// binning or smaller than an opening, more than 2^28 emitters, more than 1024 slots, a fan wider
// than 178 degrees, a border wider than the layers' spacing, a viewing distance that is not in
// front of all layers by more than their gaps.
void Check(const Display& display, const std::string& where);

// Reads the TOML of docs/formats.md; an unknown key is refused with the nearest known one.
Display ReadDisplay(const std::filesystem::path& path);
Display ParseDisplay(const std::string& toml, const std::string& where);
std::string ToToml(const Display& display);  // reads back to the same display

// What follows from the numbers (displays.md sections 1.4 and 2; ranieri2012.md section 5).
double FieldOfViewDeg(const Display& display, const Layer& layer);  // 2 atan(P p / (2 d0))
double LatticePitchMm(const Display& display, const Layer& layer);  // Delta x = q p, of all slots
double SharpRangeMm(const Display& display, const Layer& layer);    // z_max = d0 Delta x / Delta u
// Where a barrier's beam is narrowest, relative to the modulating plane (displays.md section 1.3):
// -d0 w_x^2 / (w_x^2 + w_u^2), between the emitters (wide openings) and the modulator (narrow
// ones).
double SharpestOffsetMm(const Layer& layer);
// Its mean over the layers: with borders moved by it a point goes to the layer that shows it
// sharpest (docs/decisions/0006). What a display's file without border_offset_mm gets.
double MeanSharpestOffsetMm(const std::vector<Layer>& layers);
double CutoffPerMm(const Display& display, const Layer& layer, double offset_mm);  // Eq. 1
// Neighbouring emitters of an opening are seen this far apart at a distance from the modulator.
double ViewSpacingMm(const Display& display, const Layer& layer, double distance_mm);
// Period of the windows on the emissive plane whose fans all meet at the viewing distance.
double WindowPitchMm(const Display& display, const Layer& layer);
// Share of an emitter's light that an eye gets, mean over the slots: (a/P)^2 / layers.
double Brightness(const Display& display, const Layer& layer);
// The depth to either side of z = 0 that the layers show at full resolution by the paper's box:
// the outermost layer's position and its sharp range.
double DepthBudgetMm(const Display& display);

}  // namespace lamella
