// What eyes see of a display whose emitters are larger than memory: strip by strip of the emitters'
// rows, each shown to all eyes, since every row is decoded once and a strip is of use to all.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "distribute/emitter_strip.h"
#include "distribute/simulate_eye.h"
#include "lightfield/display.h"

namespace lamella {

// A pinhole, or an eye that focuses on its picture's plane.
struct Viewer {
  Eye eye;
  std::optional<Pupil> pupil;
};

// Some rows of a viewer's picture, of which every one has been given when the work is done.
using TakePictureRows =
    std::function<void(std::size_t viewer, int first_row, const EyePicture& rows)>;

// Rows of emitters that are held together, by layer, and whose they are.
struct EmitterStripPlan {
  struct Part {
    std::size_t viewer = 0;
    RowRange picture;
  };
  std::vector<RowRange> emitters;
  std::vector<Part> parts;
};

// As few strips as hold at most `bytes` of emitters; where none does, strips as low as one band of
// a picture needs. Their rows rise. UsageError where an eye is not in front of all layers.
std::vector<EmitterStripPlan> PlanStrips(const Display& display, const std::vector<Viewer>& viewers,
                                         double bytes);
// What a plan's largest strip takes while it is loaded and seen.
double BytesOf(const std::vector<EmitterStripPlan>& plan, const Display& display);

// The same pictures as SimulateEye's. `take` is called by one thread, for every part of the plan.
void SimulateStrips(const std::vector<EmitterStripPlan>& plan, const OpenEmitters& open,
                    const Display& display, const std::vector<Viewer>& viewers,
                    const TakePictureRows& take);

}  // namespace lamella
