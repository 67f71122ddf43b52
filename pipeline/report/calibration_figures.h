// Figures that the pages of all calibrations share, as SVG in HTML; colours follow the page's.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/calibrate.h"
#include "lightfield/rigid.h"

namespace lamella {

// What is known of a place of a panel, px: over the eyes. NaN where no ray passes.
struct PlaceDeviation {
  double rms_px = 0, max_px = 0;
};
// Of 7 x 5 places, row by row from the top left; of the rays that meet `panel`, or all of them.
std::vector<PlaceDeviation> DeviationsOf(const std::vector<ProbedRay>& probed,
                                         const RayUncertainty& rays,
                                         const std::optional<PanelId>& panel = std::nullopt);
// The places' RMS as numbers in `columns` columns. Darkest at `limit_px`, of another colour beyond.
std::string DeviationFigure(const std::string& label, int columns,
                            const std::vector<PlaceDeviation>& places, double limit_px);

// A panel's cells: as dark as they have points, with their number, and the mean residual as an
// arrow, which nearly reaches the cell's edge at `limit_px`; of another colour beyond that and what
// chance does.
std::string ResidualFigure(const std::string& label, const ResidualMap& map, double limit_px);

// Degrees to the right and up from a normal, with the number of the camera position.
struct CameraDirection {
  Eigen::Vector2d degrees{0, 0};
  std::string position;
  bool of_board_alone = false;  // drawn hollow
};
// To a point before a plane that faces z.
Eigen::Vector2d DirectionTo(const Eigen::Vector3d& point_mm);
// Where cameras stood and eyes are, and where the next photographs help most.
std::string DirectionFigure(const std::vector<CameraDirection>& cameras, const EyeBox& eyes,
                            const std::optional<Eigen::Vector2d>& next_degrees);

// With chi^2 in units of the mean of `all`: photographs that are noisier than they look make all of
// it large, and standard deviations with it.
std::vector<FitOf> InTheMean(std::vector<FitOf> fits, const std::vector<FitOf>& all);
// chi^2 of each, in the mean of all.
std::string Chi2Figure(const std::vector<FitOf>& fits);
// The band that is neither too good nor too bad; calibration.md section 7.
inline constexpr double kLeastChi2Drawn = 0.7, kMostChi2Drawn = 1.5;

}  // namespace lamella
