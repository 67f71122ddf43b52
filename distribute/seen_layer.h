// A display's layer as an eye sees it: the parts of the simulated eye (distribute/simulate_eye.h)
// that know the optics.
#pragma once

#include <memory>
#include <vector>

#include "distribute/emitter_strip.h"
#include "distribute/simulate_eye.h"
#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

// Rows of pictures that are worked on together.
inline constexpr int kPictureBandRows = 16;

struct Seen {
  double r = 0, g = 0, b = 0;
  double known = 0, all = 0;
};

// Some rows of the picture.
struct PictureRows {
  int first_row = 0, end_row = 0;
  Image<Seen> sums;  // first_row is row 0
};

// What it shows of a band can be added by many threads.
class LayerSeen {
 public:
  virtual ~LayerSeen() = default;
  virtual void Add(PictureRows& band) const = 0;
};

// The picture's rows `rows` of a layer, and of the emitters the strip's, which are all that these
// rows show (SeenEmitterRows). Refers to the strip.
std::unique_ptr<LayerSeen> SeeLayer(const EmitterStrip& strip, const Display& display, int layer,
                                    const Eye& eye, const RowRange& rows);

// By band of the picture the rows of a layer's emitters that are seen there; hardly more.
std::vector<RowRange> SeenEmitterRows(const Display& display, int layer, const Eye& eye);

// Of a barrier's layer or a bare panel, and of lenses.
std::unique_ptr<LayerSeen> SeeThroughOpenings(const EmitterStrip& strip, const Display& display,
                                              int layer, const Eye& eye);
std::unique_ptr<LayerSeen> SeeThroughLenses(const EmitterStrip& strip, const Display& display,
                                            int layer, const Eye& eye, const RowRange& rows);
std::vector<RowRange> RowsThroughOpenings(const Display& display, int layer, const Eye& eye);
std::vector<RowRange> RowsThroughLenses(const Display& display, int layer, const Eye& eye);

}  // namespace lamella
