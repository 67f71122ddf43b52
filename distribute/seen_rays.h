// How many of a display's rays a scene is known for.
#pragma once

#include <cstdint>
#include <vector>

#include "distribute/distribute.h"
#include "distribute/emitter_beams.h"
#include "lightfield/image.h"

namespace lamella {

// Rays and the coverage that they have in all.
struct SeenRays {
  double rays = 0, seen = 0;
  double Share() const { return rays > 0 ? seen / rays : 0; }
  void Add(const SeenRays& more) {
    rays += more.rays;
    seen += more.seen;
  }
};

// Whether a beam of an element at z = element_mm meets z = 0 within a picture of that size.
bool PassesWithin(const AxisBeam& beam, double element_mm, double size_mm);

// Counts the emitters of a slot that have a ray through the picture.
class SeenCounter {
 public:
  SeenCounter(const LayerBeams& beams, double layer_mm, int slot, int slots_per_axis,
              const PictureSize& picture);
  // Rows of the panel from first_row on.
  void Add(int first_row, const Image<float>& coverage, SeenRays& count) const;

 private:
  const LayerBeams& beams_;
  double layer_mm_;
  int slot_y_;
  double height_mm_;
  std::vector<std::vector<int>> columns_;  // by family
};

// Where the beam of an emitter of its own goes; of a strip, ways[row][column].
enum class Way : std::uint8_t { kDark, kBesidePicture, kThroughPicture };
using Ways = std::vector<std::vector<Way>>;
// Counts rows of a strip from first_row on.
void CountOwn(const Ways& ways, int first_row, const Image<float>& coverage, SeenRays& all,
              SeenRays& in_picture);

}  // namespace lamella
