// Where the preview's eyes stand and which raster their pictures have.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "distribute/place.h"
#include "distribute/simulate_eye.h"
#include "lightfield/display.h"
#include "lightfield/view.h"
#include "pipeline/stages.h"

namespace lamella {

// The reference view's picture on z = 0, cut to the panel and to whole pixels: left, top, pixel
// size and count; its position is the middle of the eye box. The pixel is options.eye_pixel_mm or,
// where that is not set, the panel's pitch, or what makes options.width_px of them where that is
// larger. InputError where the picture lies beside the panel.
Eye CentralEye(const Display& display, const Placement& placement, const View& reference,
               const PreviewOptions& options);

// positions x positions eyes, row by row, the highest first, each row from the left.
std::vector<Eigen::Vector2d> EyeGrid(const PreviewOptions& options);

// The planes on which the eye in the middle focuses, evenly spaced from the backmost layer to the
// frontmost one (of one layer: over its depth budget), back to front; mm.
std::vector<double> FocusPlanes(const Display& display, int count);
// The same lines of sight with the picture in another plane.
Eye FocusedOn(const Eye& eye, double plane_mm);

// options.eyes, "X,Y;X,Y" in mm; UsageError where it is something else.
std::vector<Eigen::Vector2d> ParseEyes(const std::string& text);

// A captured view as an eye: the raster is its own pixels on z = 0, `shrink` x `shrink` of them a
// pixel, cut to the panel.
struct CapturedEye {
  int view = 0;  // index
  Eye eye;
  int shrink = 1;
  Rect pixels;  // of the view under the raster; multiples of shrink
};

// Those of the views that stand at one of the positions (within 0.05 mm) in the eyes' plane and
// whose pixels are an upright square raster there, so that they can be compared without being
// resampled.
std::vector<CapturedEye> CapturedEyes(const std::vector<View>& views, const Placement& placement,
                                      const Display& display,
                                      const std::vector<Eigen::Vector2d>& positions,
                                      double pixel_mm);

}  // namespace lamella
