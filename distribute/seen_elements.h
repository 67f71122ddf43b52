// What an eye sees through the elements of one layer, exactly: each element is a convex polygon of
// the modulating plane through which emitters are seen along an affine map (the `See` of
// lightfield/lenslet_map.h and lenticular_map.h). For optics that are no product of two axes.
#pragma once

#include <array>
#include <vector>

#include "lightfield/display.h"

namespace lamella {

struct PlanePoint {
  double x = 0, y = 0;
};

// A convex polygon. Cuts add a corner each; hexagons that are cut to a pixel and to an emitter have
// at most 14.
struct ConvexPolygon {
  std::array<PlanePoint, 16> corners;
  int size = 0;
  void Add(const PlanePoint& point) { corners[static_cast<std::size_t>(size++)] = point; }
  const PlanePoint& operator[](int i) const { return corners[static_cast<std::size_t>(i % size)]; }
  double Area() const;
};

// c + x p.x + y p.y
struct AffineForm {
  double c = 0, x = 0, y = 0;
  double At(const PlanePoint& p) const { return c + x * p.x + y * p.y; }
};
// The part of a polygon where low <= form <= high.
ConvexPolygon CutBetween(const ConvexPolygon& polygon, const AffineForm& form, double low,
                         double high);

// Where a polygon begins and ends in y.
std::array<double, 2> RowsOfCell(const ConvexPolygon& polygon);

// An element in coordinates of the eye's picture, px right and down.
struct SeenElement {
  ConvexPolygon cell;
  AffineForm column, row;  // of the emitter seen there; of a striped panel, columns are sub-pixels
  int window_column = 0, window_row = 0;  // first emitter of the element's own window
};

// How a layer lies before an eye: picture px = scale * emitters of the modulating plane + offset;
// the slope of the line of sight is affine in the picture, too.
struct LayerView {
  double scale = 1;
  double offset_x = 0, offset_y = 0;
  AffineForm slope_x, slope_y;  // dx/dz of picture x, dy/dz (y up) of picture y
};

// The elements that lie on the panel whole and reach into the picture's rows [first_row, end_row);
// a lenticular sheet's are cut to the panel, and all of them.
std::vector<SeenElement> SeenElements(const Display& display, int layer, const LayerView& view,
                                      int first_row, int end_row);
// One element of every row of lenses, of the panel or just beside it: which rows of emitters are
// seen does not depend on its column. All of a lenticular sheet's.
std::vector<SeenElement> ElementOfEveryRow(const Display& display, int layer,
                                           const LayerView& view);

}  // namespace lamella
