#include "calibration/column_maker.h"

#include <fmt/format.h>

namespace lamella {

int ColumnMaker::Next(const std::string& name, double prior_sd, const std::string& unit) {
  columns.names.push_back(name);
  columns.units.push_back(unit);
  columns.prior_sd.push_back(prior_sd);
  return columns.size++;
}

int ColumnMaker::Pose(const std::string& of, double angle_sd, double shift_sd) {
  const int first = columns.size;
  for (const char* part : {"rotation x", "rotation y", "rotation z"}) {
    Next(fmt::format("{} {}", of, part), angle_sd, "rad");
  }
  for (const char* part : {"position x", "position y", "distance"}) {
    Next(fmt::format("{} {}", of, part), shift_sd, "mm");
  }
  return first;
}

int ColumnMaker::Camera(const std::string& name, bool k3) {
  const int first = columns.size;
  for (const char* part : {"focal x", "focal y"}) Next(name + " " + part, 200, "px");
  for (const char* part : {"centre x", "centre y"}) Next(name + " " + part, 100, "px");
  Next(name + " distortion k1", 0.3, "");
  Next(name + " distortion k2", 1, "");
  for (const char* part : {"p1", "p2"}) Next(name + " distortion " + part, 0.02, "");
  if (k3) Next(name + " distortion k3", 3, "");
  return first;
}

}  // namespace lamella
