// A display: layers that stand at different depths, each an emissive panel behind a modulator
// (Ranieri et al. 2012), or a bare one. All of its geometry that is not a misalignment.
//
// Display frame: x right, y up, z towards the viewer, origin at the centre of the reference plane,
// millimetres. A layer's position is that of its modulating plane; its emitter lies d0 behind.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lamella {

// A parallax barrier (paper section 3; displays.md section 2): openings of aperture_px x
// aperture_px emitters every period_px, shown in slots x slots time slots that shift it by
// period_px / slots.
struct Barrier {
  int period_px = 6;    // P, emitters
  int aperture_px = 2;  // a, emitters; same parity as P
  int slots = 3;        // k per axis; divides P
  // Of the modulator: where it is closed it lets 1/contrast of the light through that it lets
  // through where it is open, in every slot (displays.md section 2, "leaks").
  double contrast = std::numeric_limits<double>::infinity();

  int stride_px() const { return period_px / slots; }  // q, from slot to slot
  friend bool operator==(const Barrier&, const Barrier&) = default;
};

// A fly's-eye sheet (displays.md section 3): a lens over every cell of the lattice. A pixel belongs
// to the lens with the nearest centre; rays x rays of them around that centre are lit, and the rest
// are guard pixels, black. Lenses that the panel's edge cuts are left out, as cut openings are.
struct LensletArray {
  enum class Lattice { kSquare, kHexagonal };

  Lattice lattice = Lattice::kHexagonal;
  double pitch_px = 13;  // emitters from lens to lens of a row; hexagonal rows are sqrt(3)/2 apart
  int rays = 6;          // N, lit emitters per lens and axis
  double offset_x_px = 0, offset_y_px = 0;  // of the lattice, right and down
  bool shift_odd_rows = true;  // hexagonal: odd rows are half a pitch further right; else even ones
  double focal_mm = 0;         // 0: d0, so that a lens sends an emitter's light out parallel

  double row_pitch_px() const;
  friend bool operator==(const LensletArray&, const LensletArray&) = default;
};

// A sheet of slanted cylinder lenses over a panel with three sub-pixels R, G, B side by side
// (displays.md section 3; van Berkel 1999). Parallax along x only.
struct Lenticular {
  double subpixels_per_lens = 4.5;  // X, along a row; may be fractional
  double slant = 1.0 / 6;   // tan alpha: to the right per length down; negative: to the left
  int views = 9;            // N, into which a lens's width is divided
  double offset_subpx = 0;  // k_off, moves the lenses left
  double focal_mm = 0;      // as a lenslet's

  friend bool operator==(const Lenticular&, const Lenticular&) = default;
};

// A panel with nothing before it, as in depth-fused displays (Suyama et al. 2004): every emitter
// sends one light to all eyes. It shows the mean of what eyes in a box around (0, 0, D), eye_box_mm
// wide and high, look at through the emitter: of all it could show that is nearest to what they
// should see.
struct BarePanel {
  double eye_box_mm = 100;
  int views = 8;  // eyes per axis of which the mean is taken
  friend bool operator==(const BarePanel&, const BarePanel&) = default;
};

using Optics = std::variant<Barrier, LensletArray, Lenticular, BarePanel>;

// A flat glass between a layer and the viewer, as a splitter is for the layer seen through it. It
// displaces rays; a calibration takes it into account, layers made without one do not.
struct GlassPlate {
  double thickness_mm = 0;
  double index = 1.5;                     // refractive
  std::array<double, 3> normal{0, 0, 1};  // in the display's frame, of any length

  friend bool operator==(const GlassPlate&, const GlassPlate&) = default;
};

struct Layer {
  double position_mm = 0;  // z of the modulating plane, or of a bare panel
  // Emissive plane to modulating plane, air-equivalent (gap / index); 0 of a bare panel.
  double d0_mm = 5;
  Optics optics;
  bool mirror_x = false;  // seen by reflection: its finished frames are flipped in x
  // M of a relay through which the layer is seen: positions on the plane are M times as far from
  // the axis, slopes 1/M as steep. So its pixels appear to have the pitch M p, and its gap M^2 d0.
  double magnification = 1;
  double index = 1;  // refractive, of what fills the gap, where it is known
  std::optional<GlassPlate> plate = std::nullopt;

  double seen_d0_mm() const { return magnification * magnification * d0_mm; }
  friend bool operator==(const Layer&, const Layer&) = default;
};

// One layer that a moving mirror images to many depths in turn (Ranieri et al. 2012, section 7;
// displays.md section 5).
struct Varifocal {
  enum class Spacing { kUniform, kSinusoidal };  // sinusoidal: a swinging mirror, equal times

  int planes = 24;
  double depth_mm = 188;  // from the first to the last plane; their middle is z = 0
  Spacing spacing = Spacing::kUniform;
  double relay_focal_mm = std::numeric_limits<double>::infinity();  // f: M = M0 + z/f
  double magnification0 = 1;                                        // M0, at z = 0

  friend bool operator==(const Varifocal&, const Varifocal&) = default;
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
  // Where set, `layers` are its planes (PlanesOf).
  std::optional<Varifocal> varifocal = {};
  // Of the emissive panels: black is 1/contrast of white.
  double contrast = std::numeric_limits<double>::infinity();
  // With barriers: the share of what emissive panels and modulators show in a time slot that is
  // still the slot before's (SlotOrder of distribute/encode_barrier.h), as liquid crystals take
  // time to turn.
  double slot_crosstalk = 0;

  int emitter_columns() const { return width_px / binning_px; }
  int emitter_rows() const { return height_px / binning_px; }
  double emitter_pitch_mm() const { return pitch_mm * binning_px; }
  // As seen through the layer's relay.
  double emitter_pitch_mm(const Layer& layer) const {
    return emitter_pitch_mm() * layer.magnification;
  }
  double width_mm() const { return width_px * pitch_mm; }
  double height_mm() const { return height_px * pitch_mm; }
  // The distance from the modulating plane of a layer to where its fans meet.
  double distance_mm(const Layer& layer) const { return viewing_distance_mm - layer.position_mm; }

  friend bool operator==(const Display&, const Display&) = default;
};

// UsageError (one line: what, where, what to do) where the display can't work: no layer, layers at
// one place or out of order, period not divided by slots, period and aperture of unequal parity,
// aperture wider than the period, more rays than pixels under a lens, lenses wider than the panel,
// sub-pixels of binned emitters, non-positive or non-finite lengths and magnifications, panel not a
// multiple of the binning or smaller than an opening, more than 2^28 pixels, more than 1024
// slots, a fan wider than 178 degrees, a border wider than the layers' spacing, a viewing distance
// that is not in front of all layers by more than their gaps, layers that are not the planes of
// the display's varifocal, contrasts below 1.01, a slot_crosstalk outside [0, 1].
void Check(const Display& display, const std::string& where);

void CheckVarifocal(const Varifocal& varifocal, const std::string& where);  // likewise

// Reads the TOML of docs/formats.md; an unknown key is refused with the nearest known one.
Display ReadDisplay(const std::filesystem::path& path);
Display ParseDisplay(const std::string& toml, const std::string& where);
std::string ToToml(const Display& display);  // reads back to the same display

// The optics in words: "a barrier", "lenslets", "lenticular lenses", "a bare panel".
std::string NameOf(const Optics& optics);
// UsageError where the layer has other optics.
const Barrier& BarrierOf(const Display& display, std::size_t index);
// The openings of a layer's barrier; of a bare panel one before every emitter, always open.
Barrier OpeningsOf(const Layer& layer);
// 1/f of a layer's lenses as seen by the viewer; a focal length of 0 is d0.
double LensPowerPerMm(const Layer& layer, double focal_mm);
int SlotsPerAxis(const Layer& layer);  // 1 where it has no barrier

// The layers of such a display: `layer` at every plane (lightfield/varifocal.h), back to front.
std::vector<Layer> PlanesOf(const Varifocal& varifocal, const Layer& layer);

// What follows from the numbers (displays.md sections 1.4, 2 and 3; ranieri2012.md section 5), as
// seen by the viewer.
// How far from the modulating plane an element's directions are told apart: at the emissive plane
// behind it, seen_d0_mm(), or in the eye box before a bare panel.
double ReachMm(const Display& display, const Layer& layer);
// 2 atan(w / (2 d0)) of the lit emitters of an element: a barrier's period, a lens's rays; of
// lenticular lenses their width. Of a bare panel: of its eye box.
double FieldOfViewDeg(const Display& display, const Layer& layer);
int DirectionsPerAxis(const Layer& layer);  // P, N, the lenticular's views; 1 of a bare panel
// Delta x: the stride q p of all slots, or the pitch of the lenses along a row, or the emitters'.
double LatticePitchMm(const Display& display, const Layer& layer);
// Delta u: the emitter pitch; of lenticular lenses their width over their views; the eye box.
double DirectionStepMm(const Display& display, const Layer& layer);
double SharpRangeMm(const Display& display, const Layer& layer);  // z_max = d0 Delta x / Delta u
// Where a layer's beam is narrowest, relative to the modulating plane (displays.md section 1.3):
// -d0 k w_x^2 / (k^2 w_x^2 + w_u^2), k = 1 - d0/f. For a barrier (f infinite) that is between the
// emitters (wide openings) and the modulator (narrow ones), for lenses with f = d0 and (but for a
// few micrometres) for bare panels it is 0.
double SharpestOffsetMm(const Layer& layer);
// Its mean over the layers: with borders moved by it a point goes to the layer that shows it
// sharpest (docs/decisions/0006). What a display's file without border_offset_mm gets.
double MeanSharpestOffsetMm(const std::vector<Layer>& layers);
double CutoffPerMm(const Display& display, const Layer& layer, double offset_mm);  // Eq. 1
// Steps between the eyes for which a layer is made, as aims: mm on the eye plane z = D, or slopes
// where the field of view is not sheared. Of optics: between neighbouring directions.
double AimStep(const Display& display, const Layer& layer);
// Neighbouring directions of an element are seen this far apart at a distance from the modulator.
double ViewSpacingMm(const Display& display, const Layer& layer, double distance_mm);
// Period of the windows on the emissive plane whose fans all meet at the viewing distance.
double WindowPitchMm(const Display& display, const Layer& layer);
// Share of an emitter's light that an eye gets, mean over the slots: (a/P)^2 / layers of a barrier,
// 1 / layers of lenses and bare panels.
double Brightness(const Display& display, const Layer& layer);
// Share of the emitters that are never lit; 0 without lenslets (1 - hex_fill).
double GuardShare(const Layer& layer);
// The depth to either side of z = 0 that the layers show at full resolution by the paper's box:
// the outermost layer's position and its sharp range.
double DepthBudgetMm(const Display& display);

}  // namespace lamella
