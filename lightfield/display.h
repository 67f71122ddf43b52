// A display: layers that stand at different depths, each an emissive panel behind a modulator
// (Ranieri et al. 2012). All of its geometry that is not a misalignment.
//
// Display frame: x right, y up, z towards the viewer, origin at the centre of the reference plane,
// millimetres. A layer's position is that of its modulating plane; its emitter lies d0 behind.
#pragma once

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
};

struct Layer {
  double position_mm = 0;  // z of the modulating plane
  double d0_mm = 5;        // emissive plane to modulating plane, air-equivalent (gap / index)
  Barrier barrier;
  bool mirror_x = false;  // seen by reflection: its finished frames are flipped in x
};

struct Display {
  std::string name;
  int width_px = 0, height_px = 0;  // of every panel
  double pitch_mm = 0;              // of the panel's pixels
  int binning_px = 1;               // an emitter is binning x binning panel pixels
  double viewing_distance_mm = 0;   // D: the fans of all elements meet at (0, 0, D)
  bool shear = true;                // off: all fans are parallel to the axis
  double border_mm = 0;             // w: width over which neighbouring layers' ranges overlap
  std::vector<Layer> layers;        // by rising position; 0 is at the back

  int emitter_columns() const { return width_px / binning_px; }
  int emitter_rows() const { return height_px / binning_px; }
  double emitter_pitch_mm() const { return pitch_mm * binning_px; }
  double width_mm() const { return width_px * pitch_mm; }
  double height_mm() const { return height_px * pitch_mm; }
};

// InputError/UsageError (one line: what, where, what to do) where the display can't work:
// no layer, layers at one place or out of order, period not divided by slots, period and aperture
// of unequal parity, aperture wider than the period, non-positive or non-finite lengths, panel not
// a multiple of the binning, more than 2^28 emitters, viewing distance not in front of all layers.
void Check(const Display& display, const std::string& where);

// Reads the TOML of docs/formats.md; an unknown key is refused with the nearest known one.
Display ReadDisplay(const std::filesystem::path& path);
Display ParseDisplay(const std::string& toml, const std::string& where);
std::string ToToml(const Display& display);  // reads back to the same display

}  // namespace lamella
