// How much of a neighbouring view a view shows, and the emitter's spread that makes it so
// (calibration.md section 9).
//
// One axis. Emitters in a row; above them openings whose distance is a multiple of K emitters. A
// line of sight through an opening meets the row at a place s, in emitters. Photograph k shows the
// emitters lit whose number is k modulo K: K views, one per emitter of a period.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/calibration.h"

namespace lamella {

// How an emitter's light reaches its neighbours' places: as by a diffuser, a Gaussian; or in whole
// pixels (lightfield's GaussianSpread), as where neighbours are lit along.
enum class SpreadKind { kDiffuse, kWholePixels };

struct CrosstalkSetup {
  int num_views = 8;       // K
  double opening_px = 1;   // the opening's width as it is thrown on the row from where one looks
  double pupil_px = 0;     // the camera's pupil as the opening throws it on the row: its diameter
  double drift_px = 0;     // by which places within a series' part of the panel differ, evenly
  double pupil_sd_px = 0;  // how well the pupil is known: a standard deviation
};

// The light of photographs 0 .. K - 1 where lines of sight meet the row `place` emitters from the
// middle of emitter 0: the boxes of emitter and opening, the spread of the emitters' light (its
// sigma) and the pupil's disc, one over another, over a period. They sum to 1.
Eigen::VectorXd ViewsSeen(const CrosstalkSetup& setup, SpreadKind kind, double spread_px,
                          double place);

// Standard deviations are of the lights' noise, by the residuals or by how the series scatter,
// whichever is more, and of the pupil's (a pupil taken too wide makes the spread too narrow). Those
// of light's shares hold, too, what the other kind would say, by how likely the residuals make it.
struct CrosstalkFit {
  SpreadKind kind = SpreadKind::kDiffuse;  // which fits better
  double spread_px = 0, spread_sd_px = 0;  // its sigma
  SpreadKernel kernel;                     // the same in whole pixels, as calibrations have it
  double own_sd = 0;                       // of the kernel's middle weight
  double neighbour_sd = 0;                 // of the next views' shares in `without_pupil`
  // Share of view k in what an eye in the middle of view j sees: K x K, rows sum to 1. Of one with
  // the camera's pupil, which is an extra blur, and of one without any. A series' drift, which is
  // one more, is taken out of both.
  Eigen::MatrixXd with_pupil, without_pupil;
  double rms = 0;  // of the residuals, share of a series' sum
};

// `series` are K lights each, less the dark frame's, of parts of the panel within which lines of
// sight meet the row at one place each; where, is found. A constant that all K share (what closed
// openings let through) is taken off. InputError (naming `panel`) where a series has not K numbers
// or no light.
CrosstalkFit FitCrosstalk(const std::vector<Eigen::VectorXd>& series, const CrosstalkSetup& setup,
                          const std::string& panel);

}  // namespace lamella
