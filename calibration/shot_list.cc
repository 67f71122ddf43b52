#include "calibration/shot_list.h"

#include <algorithm>

#include <fmt/format.h>

#include "calibration/photometric_shots.h"
#include "lightfield/error.h"

namespace lamella {

std::string PlaceName(const PanelId& panel) {
  return fmt::format("layer{}_{}", panel.layer,
                     panel.role == PanelId::kEmitter ? "emitter" : "modulator");
}

namespace {

std::vector<CalibratedPanel> PanelsOf(const Calibration& calibration, CalibrationMode mode) {
  std::vector<CalibratedPanel> panels;
  std::vector<PanelSize> sizes;
  std::vector<std::size_t> with_board;
  for (std::size_t l = 0; l < calibration.layers.size(); ++l) {
    const LayerCalibration& layer = calibration.layers[l];
    const int index = static_cast<int>(l);
    const auto add = [&](PanelId::Role role, const PanelCalibration& panel) {
      panels.push_back(
          {{index, role}, {panel.width_px, panel.height_px}, panel.mirror_x, std::nullopt});
      if (layer.lattice) return;
      if (mode == CalibrationMode::kPrecise && !HasRoomForBoard(panels.back().size)) return;
      with_board.push_back(panels.size() - 1);
      sizes.push_back(panels.back().size);
    };
    if (layer.modulator) add(PanelId::kModulator, *layer.modulator);
    add(PanelId::kEmitter, layer.emitter);
  }
  const std::vector<CharucoBoard> boards = LayOutBoards(sizes);
  for (std::size_t b = 0; b < boards.size(); ++b) panels[with_board[b]].board = boards[b];
  return panels;
}

std::string NameOfShot(const PatternShot& shot) {
  switch (shot.kind) {
    case PatternShot::Kind::kDark:
      return shot.exposure == 1 ? "dark" : fmt::format("dark_x{}", shot.exposure);
    case PatternShot::Kind::kWhite:
      return fmt::format("layer{}_white", shot.panel.layer);
    case PatternShot::Kind::kLeak:
      return fmt::format("layer{}_leak", shot.panel.layer);
    case PatternShot::Kind::kPrinted:
      return "printed_board";
    case PatternShot::Kind::kBoard:
      return PlaceName(shot.panel) + (shot.again ? "_board_again" : "_board");
    case PatternShot::Kind::kFlat:
    case PatternShot::Kind::kMixed:
    case PatternShot::Kind::kLines:
      return NameOfPhotometricShot(shot);
    case PatternShot::Kind::kPhase:
      break;
  }
  return fmt::format("{}_{}_{}{}", PlaceName(shot.panel), NameOf(shot.pattern.series),
                     shot.pattern.step, shot.again ? "_again" : "");
}

void AddPhases(const CalibratedPanel& panel, std::vector<PatternShot>& shots) {
  for (const PhaseSeries& series : PhaseSeriesOf(panel.size.width_px, panel.size.height_px)) {
    for (int step = 0; step < series.steps; ++step) {
      shots.push_back(
          {"", PatternShot::Kind::kPhase, panel.id, {Pattern::Kind::kPhase, series, step}, false});
    }
  }
}

// The first shot with a pattern, at the end once more.
void RepeatFirst(std::vector<PatternShot>& shots) {
  const auto first = std::find_if(shots.begin(), shots.end(), [](const PatternShot& shot) {
    return shot.kind == PatternShot::Kind::kBoard || shot.kind == PatternShot::Kind::kPhase;
  });
  PatternShot again = *first;
  again.again = true;
  shots.push_back(again);
}

void NameShots(ShotList& list) {
  const auto digits = std::max<std::size_t>(2, std::to_string(list.shots.size()).size());
  for (std::size_t i = 0; i < list.shots.size(); ++i) {
    list.shots[i].name = fmt::format("{:0{}}_{}", i + 1, digits, NameOfShot(list.shots[i]));
  }
}

std::string SinusoidOf(const Pattern& pattern) {
  return fmt::format("sinusoid along {} of {} px, step {} of {}",
                     pattern.series.axis == PanelAxis::kU ? "u" : "v", pattern.series.period_px,
                     pattern.step + 1, pattern.series.steps);
}

constexpr const char* kAgain = "; the same as before, it tells whether the camera moved";

constexpr const char* kPrintedShot =
    "every panel black, the room lit: the printed board, evenly, white at about 80 %";

// Of a plane, which has an emitter alone.
std::string WhatOfPlane(const PatternShot& shot) {
  if (shot.kind == PatternShot::Kind::kPrinted) return kPrintedShot;
  if (shot.kind == PatternShot::Kind::kDark) return "every plane black";
  const bool white = shot.kind == PatternShot::Kind::kWhite;
  return fmt::format("plane {} lit alone: {}{}", shot.panel.layer,
                     white ? "white" : SinusoidOf(shot.pattern), shot.again ? kAgain : "");
}

// `stacked`: the layer has another panel.
std::string What(const PatternShot& shot, bool stacked) {
  const std::string layer = fmt::format("layer {}", shot.panel.layer);
  const char* other = !stacked                               ? ""
                      : shot.panel.role == PanelId::kEmitter ? "; its modulator white"
                                                             : "; its emitter white";
  switch (shot.kind) {
    case PatternShot::Kind::kDark:
      return "every panel black" + ExposureText(shot);
    case PatternShot::Kind::kWhite:
      return layer + (stacked ? ": both panels white" : ": white");
    case PatternShot::Kind::kLeak:
      return layer + ": emitter white, modulator black";
    case PatternShot::Kind::kPrinted:
      return kPrintedShot;
    case PatternShot::Kind::kBoard:
      return fmt::format("{}: board{}{}", NameOf(shot.panel), other, shot.again ? kAgain : "");
    case PatternShot::Kind::kFlat:
    case PatternShot::Kind::kMixed:
    case PatternShot::Kind::kLines:
      return DescribePhotometricShot(shot);
    case PatternShot::Kind::kPhase:
      break;
  }
  return fmt::format("{}: {}{}{}", NameOf(shot.panel), SinusoidOf(shot.pattern), other,
                     shot.again ? kAgain : "");
}

// How it comes to be known where the camera stood, of displays with lenses.
std::string PlaceOfCamera(const ShotList& list) {
  if (!list.printed) {
    return "Where the camera stood has to be known to half a mm: `calibrate solve --cameras` takes "
           "it.\n";
  }
  const PrintedBoard& printed = *list.printed;
  return fmt::format(
      "Printed board: it tells where the camera stood. Print printed_board.pdf at 100 %, on matt "
      "paper,\n"
      "glue it flat onto glass or metal, and fix that to the display's frame beside the panel, "
      "facing the\n"
      "same way, so that nothing moves against the panel while you photograph. Measure its width "
      "over the\n"
      "{} squares ({:g} mm as drawn) and give a {}th of it: `calibrate solve --board-square-mm`. "
      "The whole\n"
      "board is in every picture beside the panel, its squares {} camera px wide and more. "
      "Photographs of\n"
      "the board alone, slanted by 20 to 40 degrees to all sides, each from a place of its own, "
      "calibrate\n"
      "the camera better.\n",
      printed.board.columns, printed.board.columns * printed.square_mm, printed.board.columns, 48);
}

std::string DescribePlaneShots(const ShotList& list) {
  std::string text = fmt::format(
      "Calibration of {}: {} photographs from every camera position\n\n"
      "Camera: on a tripod, released from afar, in a dark room; focus, zoom and exposure locked "
      "for\n"
      "all photographs, no automatic corrections; exposed over many periods of the mirror, a "
      "white\n"
      "plane at about 80 % of full scale; every plane in focus, 5 of its pixels or more on a "
      "lens.\n"
      "Projector: the mirror swings; a shot's image is shown in the time slot of its plane alone,\n"
      "all other slots are black.\n"
      "Positions: 12 (never fewer than 6), on two rings about the axis, the outer one as far off "
      "it\n"
      "as the planes are seen from (9 degrees), the inner one a third of that; distances varied "
      "by\n"
      "12 %, the camera rolled by 90 and 180 degrees in some.\n"
      "{}"
      "At every position take all of these without touching the camera:\n\n",
      list.display, list.shots.size(), PlaceOfCamera(list));
  for (const PatternShot& shot : list.shots) {
    text += fmt::format("{:<36} {}\n", shot.name, WhatOfPlane(shot));
  }
  return text;
}

bool IsStacked(const ShotList& list, int layer) {
  return std::any_of(list.panels.begin(), list.panels.end(), [&](const CalibratedPanel& panel) {
    return panel.id == PanelId{layer, PanelId::kModulator};
  });
}

std::string PositionsForPanels(CalibrationMode mode) {
  return fmt::format(
      "Positions: 12 (never fewer than 6), on two rings about the axis, the outer one 20 degrees "
      "or\n"
      "more off it and beyond all eyes, the inner one a third of that; distances varied by 12 %, "
      "the\n"
      "camera rolled by 90 and 180 degrees in some.{}\n",
      mode == CalibrationMode::kPrecise
          ? "\nThe sinusoids are needed from 3 or 4 of the positions only."
          : "");
}

std::string PositionsForLenses(const ShotList& list) {
  return "Positions: 2 and more, as far apart across the lenses as eyes are from side to side (100 "
         "mm at\n"
         "least), the whole panel in the picture, its width 6 and more camera px per lens.\n" +
         PlaceOfCamera(list);
}

}  // namespace

std::vector<LayerPatterns> ShownIn(const PatternShot& shot, int num_layers) {
  const Pattern white{Pattern::Kind::kWhite}, black{Pattern::Kind::kBlack};
  std::vector<LayerPatterns> layers(static_cast<std::size_t>(num_layers), {black, black});
  if (shot.kind == PatternShot::Kind::kDark || shot.kind == PatternShot::Kind::kPrinted) {
    return layers;
  }
  LayerPatterns& layer = layers[static_cast<std::size_t>(shot.panel.layer)];
  layer.emitter = white;
  if (shot.kind == PatternShot::Kind::kLeak) return layers;
  layer.modulator = white;
  if (shot.kind == PatternShot::Kind::kWhite) return layers;
  if (shot.kind == PatternShot::Kind::kMixed) layer = {shot.pattern, shot.pattern};
  if (shot.kind == PatternShot::Kind::kLines) {
    Pattern openings = shot.pattern;
    openings.step = kOpeningPx;
    layer = {shot.pattern, openings};
  }
  if (shot.kind == PatternShot::Kind::kMixed || shot.kind == PatternShot::Kind::kLines) {
    return layers;
  }
  (shot.panel.role == PanelId::kEmitter ? layer.emitter : layer.modulator) = shot.pattern;
  return layers;
}

ShotList PlanShots(const Calibration& calibration, CalibrationMode mode, bool planes_in_turn) {
  ShotList list{calibration.display,
                mode,
                static_cast<int>(calibration.layers.size()),
                planes_in_turn,
                PanelsOf(calibration, mode),
                {}};
  using Kind = PatternShot::Kind;
  if (mode == CalibrationMode::kPhotometry) {
    list.shots = PhotometricShots(calibration);
    NameShots(list);
    return list;
  }
  list.shots.push_back({"", Kind::kDark, {}, {}, false});
  for (int l = 0; l < list.num_layers; ++l) {
    list.shots.push_back({"", Kind::kWhite, {l, PanelId::kEmitter}, {}, false});
    if (calibration.layers[static_cast<std::size_t>(l)].modulator) {
      list.shots.push_back({"", Kind::kLeak, {l, PanelId::kEmitter}, {}, false});
    }
  }
  bool has_pattern = false;
  for (const CalibratedPanel& panel : list.panels) {
    if (!panel.board) continue;
    list.shots.push_back({"", Kind::kBoard, panel.id, {Pattern::Kind::kBoard}, false});
    has_pattern = true;
  }
  if (mode == CalibrationMode::kPrecise) {
    for (const CalibratedPanel& panel : list.panels) AddPhases(panel, list.shots);
  } else if (!has_pattern) {
    throw UsageError(calibration.display, "has nothing but lenses, under which no board is seen",
                     "use --mode precise");
  }
  RepeatFirst(list.shots);
  NameShots(list);
  return list;
}

ShotList WithPrintedBoard(ShotList list) {
  const bool has_boards = std::any_of(list.panels.begin(), list.panels.end(),
                                      [](const auto& panel) { return panel.board.has_value(); });
  if (has_boards || list.mode != CalibrationMode::kPrecise) {
    throw UsageError(list.display, "needs no printed board: its panels tell the camera's place",
                     "leave it out");
  }
  list.printed = BoardToPrint();
  list.shots.push_back({"", PatternShot::Kind::kPrinted, {}, {}, false});
  NameShots(list);
  return list;
}

std::string PatternFile(const CalibratedPanel& panel, const Pattern& pattern) {
  switch (pattern.kind) {
    case Pattern::Kind::kBlack:
      return "black";
    case Pattern::Kind::kWhite:
      return "white";
    case Pattern::Kind::kBoard:
      return PlaceName(panel.id) + "_board.png";
    case Pattern::Kind::kFlat:
      return fmt::format("flat_{}x{}_{:02x}{:02x}{:02x}.png", panel.size.width_px,
                         panel.size.height_px, pattern.color.r, pattern.color.g, pattern.color.b);
    case Pattern::Kind::kColumns:
      return fmt::format("columns_{}x{}_{}_{}.png", panel.size.width_px, panel.size.height_px,
                         pattern.period_px, pattern.step);
    case Pattern::Kind::kPhase:
      break;
  }
  return fmt::format("phase_{}x{}_{}_{}.png", panel.size.width_px, panel.size.height_px,
                     NameOf(pattern.series), pattern.step);
}

std::string ListOfShots(const ShotList& list) {
  std::string text;
  for (const PatternShot& shot : list.shots)
    text += fmt::format("{:<36} {}\n", shot.name, What(shot, IsStacked(list, shot.panel.layer)));
  return text + "\nPanels that a shot does not name are black.\n";
}

std::string DescribeShots(const ShotList& list) {
  if (list.mode == CalibrationMode::kPhotometry) return DescribePhotometry(list);
  if (list.planes_in_turn) return DescribePlaneShots(list);
  // Modulators are told from emitters by boards; lenses show neither.
  const bool lenses = std::all_of(list.panels.begin(), list.panels.end(), [](const auto& panel) {
    return panel.id.role == PanelId::kEmitter && !panel.board;
  });
  std::string text = fmt::format(
      "Calibration of {}: {} photographs from every camera position\n\n"
      "Camera: on a tripod, released from afar, in a dark room; focus, zoom and exposure locked "
      "for\n"
      "all photographs, f/8 to f/11, no automatic corrections; exposed over many refreshes, the\n"
      "white panel at about 80 % of full scale; slightly out of focus (an edge 2 to 3 px wide), "
      "and\n"
      "1.1 to 3 of its pixels on a panel's pixel.\n"
      "Panels: brightness at its final setting, no scaling, no time slots: one image stands "
      "still.\n"
      "{}"
      "At every position take all of these without touching the camera:\n\n",
      list.display, list.shots.size(),
      lenses ? PositionsForLenses(list) : PositionsForPanels(list.mode));
  return text + ListOfShots(list);
}

}  // namespace lamella
