// Photographs' pixels that see a panel through its lens sheet, and what they say of the lattice
// once the cameras are known.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/board_cameras.h"
#include "calibration/lattice.h"
#include "calibration/phase.h"
#include "lightfield/rigid.h"
#include "lightfield/view.h"

namespace lamella {

struct SightedPixel {
  int view = 0;  // in a list of cameras
  Eigen::Vector2d image_px{0, 0};
  Eigen::Vector2d panel_px{0, 0}, sigma_px{1, 1};  // as LatticeSample has them
};
struct SightedPixels {
  std::vector<SightedPixel> pixels;
  double period_px = 0;  // as LatticeObservations has it
};

// What all positions show of one sheet: pixel by pixel, and by single periods.
struct SheetSights {
  SightedPixels whole, fine, middle, coarse;
  int num_views = 0;

  void Add(const PhaseCapture& capture, int view);
  bool IsFaint() const;  // few of the pixels that see the finest sinusoid can be unwrapped
};

// The samples of a stack; what does not look at its sheet is taken off the pixels, too.
LatticeObservations Through(SightedPixels& pixels, const std::vector<View>& cameras,
                            const Rigid& stack_from_world);

// How the samples of `observations`, which the pixels gave, change with what is not known of
// cameras that a board tells; `positions` are the cameras' of the pixels. The board, pixels and
// observations must outlive it.
CameraErrors ErrorsOf(const BoardCameras& board, const SightedPixels& pixels,
                      const std::vector<int>& positions, const LatticeObservations& observations,
                      const Rigid& stack_from_board);

}  // namespace lamella
