// How much of a placed scene a display can show: its depths, and the detail of its reference
// picture that lies below the display's cut-off.
#pragma once

#include <optional>
#include <vector>

#include "distribute/analyze.h"
#include "distribute/place.h"
#include "lightfield/image.h"

namespace lamella {

struct SceneFigures {
  double known_share = 0;  // of the pixels of the depth map
  // Of the known pixels, by their z in the display; bins of equal width from edges_mm.front() to
  // .back(), and what lies beyond them.
  std::vector<double> edges_mm;
  std::vector<double> share;
  double share_behind = 0, share_before = 0;
  double far_mm = 0, near_mm = 0;  // 1 % and 99 % quantiles of z; -inf is possible
  // Share of the known pixels at depths that a layer shows at the full resolution of its lattice.
  double sharp_share = 0;
  // Share of the picture's detail that the display keeps, below; nothing where there is no detail.
  std::optional<double> detail_kept;
  std::optional<double> detail_kept_beam;  // by the real widths of its beams instead of Eq. 1
};

// `picture` is the reference view in linear light; `depth` its depth map (world units, 0 unknown),
// of any size. Detail is the energy of the picture's luminance with periods of 2 to 16 px: of each
// block of 32 x 32 px (less its mean, under a Hann window) the power spectrum at bins (kx, ky) with
// max(|kx|, |ky|) >= 2. A pixel at z keeps the bins up to fc(z) s(z), where fc is the display's
// combined cut-off and s = mm_per_view_px (D - z)/D the size of a pixel there; of the bin
// in which the limit falls, the part below it. The limit is of max(|kx|, |ky|), with one axis of
// parallax of |kx|. A block keeps the mean over its known pixels; blocks without any don't count.
SceneFigures AnalyzeScene(const Display& display, const Analysis& analysis,
                          const Placement& placement, ImageSpan<const Rgb> picture,
                          ImageSpan<const float> depth);

}  // namespace lamella
