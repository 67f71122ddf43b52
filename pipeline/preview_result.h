// What the preview measured: every eye's pictures and figures, and the means over its grid.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "distribute/analyze.h"
#include "distribute/halo.h"
#include "distribute/simulate_eye.h"
#include "pipeline/preview_measure.h"

namespace lamella {

struct EyeResult {
  std::string name;  // RR_CC of the grid, "further_NN" of options.eyes, "focus_NN"
  Eye eye;
  std::optional<Pupil> pupil = {};  // none: a pinhole
  PreviewPicture simulated;
  EyeTarget target;  // of which the picture alone is left once it is compared
  PreviewMetrics metrics;
  BandLimitMetrics band_limit = {};
  std::optional<HaloErrors> halo = {};
};

struct CapturedResult {
  std::string view;
  Eye eye;
  PreviewPicture simulated, direct;  // on the raster of the view's own pixels
  PreviewMetrics simulated_to_captured, direct_to_captured, simulated_to_direct;
};

// Between the grid's middle eye and one a step to its right (negative: left), which is not among
// the eyes.
struct AliasingResult {
  double step_mm = 0;
  std::optional<double> db = {};  // AngularAliasing()
};

struct PreviewResult {
  std::vector<EyeResult> grid, further;  // the grid row by row, the highest first
  std::vector<EyeResult> focus;          // in the middle, focused on planes from back to front
  std::vector<CapturedResult> captured;
  AliasingResult aliasing = {};
  DisplayTotals totals = {};
};

// Means over the grid's eyes that have a figure (equal pictures have none of PSNR). PSNR and SSIM
// are those of the pixels that both pictures know: where no camera saw anything the display is
// black and the target a guess.
struct GridMeans {
  std::optional<double> psnr_seen_db, worst_psnr_seen_db, ssim_seen;
  // Against the band-limited target: of what the eyes see, and of the target.
  std::optional<double> to_band_limited_db, to_band_limited_ssim, band_limited_to_target_db;
  std::optional<HaloFigures> halo;  // of the sums over all eyes
  double known = 0, seen = 0;
};
GridMeans MeansOf(const PreviewResult& result);

}  // namespace lamella
