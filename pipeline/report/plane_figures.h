// Figures over the planes of a varifocal display, back to front, as SVG in HTML.
#pragma once

#include <string>
#include <vector>

namespace lamella {

// A number of every plane; deviations may be infinite.
struct PlaneSeries {
  std::string label, unit;
  std::vector<double> values, sds;  // sds: empty where there are none
};

// Points, joined, with a line of one standard deviation to either side, about zero.
std::string PlaneLineFigure(const PlaneSeries& series);

// Columns from zero; those outside `low` to `high` are of another colour.
std::string PlaneColumnFigure(const PlaneSeries& series, double low, double high);

}  // namespace lamella
