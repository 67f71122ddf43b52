// Which points and photographs agree with a solution. calibration.md section 5.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace lamella {

// The median of |r|^2 of a Gaussian of deviation s in the plane is 2 ln 2 s^2.
inline constexpr double kMedianOfSquares = 1.3862943611198906;

// Robust deviation of whitened residuals (2 x points of each photograph): 1 where the stated
// covariances are right.
double RobustDeviation(const std::vector<Eigen::Matrix2Xd>& residuals);

struct TrimmedPoints {
  std::vector<std::vector<char>> inlier;  // per photograph and point
  std::vector<std::string> rejected;      // "LABEL: why" of whole photographs
};
// A photograph and its kind, whose points may scatter otherwise than those of other kinds, up to 5
// times as much: a plane, which is about as sharp in all photographs.
struct PhotoKind {
  std::string label;
  int kind = 0;
};
// Points within 4 robust deviations of their kind (of all, where it has fewer than 3 photographs),
// of photographs that agree with the rest: half of whose points or more are such, that are shifted
// by no more than six times what others are (slips_px, one of each photograph, or none), and whose
// points scatter no more than twice as much as their kind's.
TrimmedPoints TrimPoints(const std::vector<Eigen::Matrix2Xd>& residuals,
                         const std::vector<Eigen::Vector2d>& slips_px,
                         const std::vector<PhotoKind>& photos);

}  // namespace lamella
