// What a display shows while a camera photographs it for calibration, in order (calibration.md
// section 3).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/charuco_board.h"
#include "calibration/observations.h"
#include "calibration/phase_patterns.h"
#include "lightfield/calibration.h"
#include "lightfield/image.h"

namespace lamella {

// What one panel shows. The image that it is given, also where a mirror shows it reversed.
struct Pattern {
  // kFlat: one colour everywhere. kColumns: one column in `period_px` is white, from `step` on.
  enum class Kind { kBlack, kWhite, kBoard, kPhase, kFlat, kColumns };
  Kind kind = Kind::kBlack;
  PhaseSeries series = {};  // of kPhase
  int step = 0;             // of kPhase and kColumns
  Rgb8 color = {};          // of kFlat: codes
  int period_px = 0;        // of kColumns
  friend bool operator==(const Pattern&, const Pattern&) = default;
};

struct PatternShot {
  // kDark: all black. kWhite: both panels of a layer white. kLeak: emitter white, modulator black.
  // kBoard, kPhase, kFlat: of the panel under test, the layer's other panel white. kMixed: both
  // panels show the pattern. kLines: the emitter shows it, the modulator is open at kOpeningPx.
  // kPrinted: all black, the room lit: the printed board is seen.
  enum class Kind { kDark, kWhite, kLeak, kBoard, kPhase, kFlat, kMixed, kLines, kPrinted };
  std::string name;  // "03_layer0_modulator_board": its number, then what it is of
  Kind kind = Kind::kDark;
  PanelId panel;       // under test; of kWhite and kLeak its layer counts
  Pattern pattern;     // of the panel under test
  bool again = false;  // repeats an earlier one, to tell whether the camera has moved
  int exposure = 1;    // times the others' exposure
  bool first_position_only = false;
};

// Of the photographs of lines: the emitter's columns are lit one in so many, and the modulator has
// openings of 1 px as far apart, the first at kOpeningPx.
inline constexpr int kLinesPeriodPx = 8, kOpeningPx = 4;

struct LayerPatterns {
  Pattern emitter, modulator;
};
// What the layers show in a shot: those not under test are black.
std::vector<LayerPatterns> ShownIn(const PatternShot& shot, int num_layers);

struct CalibratedPanel {
  PanelId id;
  PanelSize size;
  bool mirrored = false;
  std::optional<CharucoBoard> board;  // none under lenses, which do not resolve one
};

enum class CalibrationMode { kQuick, kPrecise, kPhotometry };

struct ShotList {
  std::string display;
  CalibrationMode mode = CalibrationMode::kQuick;
  int num_layers = 0;
  // The layers are planes of a varifocal display: what a shot shows is lit in its plane's time slot
  // alone.
  bool planes_in_turn = false;
  std::vector<CalibratedPanel> panels;  // back to front, a layer's modulator before its emitter
  std::vector<PatternShot> shots;       // of one camera position
  std::optional<PrintedBoard> printed = {};  // fixed to the display, of the shot kPrinted
};

// quick: dark, white and leak of every layer, a board on every panel, the first board again.
// precise: sinusoids on every panel as well, and boards where there is room. UsageError where a
// panel is too small for the board of quick, or there is nothing but lenses, which need sinusoids.
// photometry: photometric_shots.h. Planes in turn are a varifocal display's.
ShotList PlanShots(const Calibration& calibration, CalibrationMode mode,
                   bool planes_in_turn = false);

// The list with a printed board, which is photographed last at every position. UsageError where
// panels show boards of their own, or the list is of photometry: neither needs it.
ShotList WithPrintedBoard(ShotList list);

// The image of a pattern. The board's is drawn by calibration/detect_board.h.
std::string PatternFile(const CalibratedPanel& panel, const Pattern& pattern);

std::string PlaceName(const PanelId& panel);  // "layer1_modulator", of names of files

// A line per shot: its name and what it is.
std::string ListOfShots(const ShotList& list);

// For the person at the camera: how to set it up, and what every shot is.
std::string DescribeShots(const ShotList& list);

}  // namespace lamella
