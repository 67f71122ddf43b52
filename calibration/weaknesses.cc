#include "calibration/weaknesses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "calibration/covariance.h"

namespace lamella {
namespace {

constexpr double kWellKnown = 100;
constexpr double kLeastSeen = 0.6;  // of a panel's cells

// The photograph that would settle a parameter, by what its name speaks of.
std::string CureFor(const std::string& names) {
  const auto speaks_of = [&](const char* word) { return names.find(word) != std::string::npos; };
  if (speaks_of("distortion")) {
    return "photograph the panels so that they fill the picture to its corners";
  }
  if (speaks_of("gap") || speaks_of("offset") || speaks_of("tilt")) {
    return "photograph that layer's emitter and modulator from both sides, 20 degrees and more "
           "apart";
  }
  if (speaks_of("focal") || speaks_of("centre") || speaks_of("distance") || speaks_of("scale")) {
    return "photograph all panels slanted by 20 degrees, from both sides and from above and below";
  }
  if (speaks_of("view")) return "take that view again with more of the panels in it";
  return "photograph that layer together with the reference panel from more and other directions";
}

double Reach(const std::vector<double>& values, double sign) {
  double reach = 0;
  for (const double value : values) reach = std::max(reach, sign * value);
  return reach;
}

// Cameras' directions as slopes x/z, y/z in the world's frame.
void CheckDirections(const Fit& fit, const Structure& structure, const EyeBox& box,
                     std::vector<Weakness>& weaknesses) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < structure.views.size(); ++i) {
    const Eigen::Vector3d centre = Centre(fit.state.camera_from_world[i]);
    x.push_back(centre.x() / centre.z());
    y.push_back(centre.y() / centre.z());
  }
  const double middle = (box.near_mm + box.far_mm) / 2;
  const auto side = [&](const std::vector<double>& slopes, double sign, double half,
                        const char* name) {
    if (Reach(slopes, sign) >= 0.4 * half / middle) return;
    const auto degrees = [](double slope) { return std::atan(slope) * 180 / std::numbers::pi; };
    weaknesses.push_back(
        {fmt::format("rays to the {} are extrapolated: cameras reach {:.0f} degrees there, eyes "
                     "{:.0f}; gaps lean on offsets",
                     name, degrees(Reach(slopes, sign)), degrees(half / middle)),
         fmt::format("photograph all panels from the {}", name)});
  };
  side(x, -1, box.half_width_mm, "left");
  side(x, 1, box.half_width_mm, "right");
  side(y, -1, box.half_height_mm, "lower side");
  side(y, 1, box.half_height_mm, "upper side");
}

}  // namespace

std::vector<Weakness> UnknownDirections(const Fit& fit) {
  Eigen::MatrixXd scaled = WithoutSlips(fit.equations, fit.columns);
  const Eigen::Map<const Eigen::VectorXd> sd(fit.columns.prior_sd.data(), scaled.rows());
  scaled = sd.asDiagonal() * scaled * sd.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  std::vector<Weakness> weaknesses;
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    const double value = eigen.eigenvalues()(i) / std::max(1.0, fit.variance);
    if (value >= kWellKnown) break;
    const std::string names = NameOfDirection({value, eigen.eigenvectors().col(i)}, fit.columns);
    const auto same = [&](const Weakness& other) { return other.lost == names; };
    if (std::any_of(weaknesses.begin(), weaknesses.end(), same)) continue;
    weaknesses.push_back({names, CureFor(names)});
  }
  return weaknesses;
}

std::optional<Weakness> SeenInPart(const std::string& name, const ResidualMap& map,
                                   const std::string& leaning) {
  const double share = static_cast<double>(map.CellsSeen()) / ResidualMap::kCells;
  if (share >= kLeastSeen) return std::nullopt;
  return Weakness{fmt::format("{} was seen in {:.0f} % of its area: {} extrapolated to the rest",
                              name, 100 * share, leaning),
                  "photograph the whole panel"};
}

std::vector<Weakness> ThinCoverage(const Fit& fit, const Structure& structure,
                                   const std::vector<ResidualMap>& maps, const EyeBox& box) {
  std::vector<Weakness> weaknesses;
  CheckDirections(fit, structure, box, weaknesses);
  for (const ResidualMap& map : maps) {
    const std::string name = NameOf(map.panel);
    if (const auto in_part = SeenInPart(name, map)) weaknesses.push_back(*in_part);
    if (map.views.size() < 2 || map.views.size() > 3) continue;
    weaknesses.push_back(
        {fmt::format("{} is in {} views only: its distance or gap is weak", name, map.views.size()),
         "photograph it from 6 positions or more, on opposite sides"});
  }
  return weaknesses;
}

}  // namespace lamella
