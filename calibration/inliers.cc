#include "calibration/inliers.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

namespace lamella {
namespace {

constexpr double kTrim = 4;  // deviations; of Gaussian points 3e-4 lie beyond

double MedianSquare(std::vector<double> squares) {
  if (squares.empty()) return 0;
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return *middle;
}

std::vector<double> Squares(const Eigen::Matrix2Xd& residuals) {
  const Eigen::RowVectorXd squares = residuals.colwise().squaredNorm();
  return {squares.begin(), squares.end()};
}

// Why a photograph does not agree with the rest; empty where it does.
std::string Doubt(double share_inside, double slip_px, double usual_slip_px, double scatter) {
  if (share_inside < 0.5) {
    return fmt::format(
        "{:.0f} % of its points disagree with the other photographs: another "
        "panel's or view's file, or the camera had moved",
        100 * (1 - share_inside));
  }
  if (slip_px > 6 * std::max(usual_slip_px, 0.02)) {
    return fmt::format("shifted by {:.2f} px against its view: the camera had moved", slip_px);
  }
  if (scatter > 2) {
    return fmt::format("its points scatter {:.1f} times as much as the others': out of focus?",
                       scatter);
  }
  return "";
}

// Of each kind; no more than a few times that of all, which wrong photographs of a whole kind
// exceed.
std::map<int, double> DeviationsOf(const std::vector<Eigen::Matrix2Xd>& residuals,
                                   const std::vector<PhotoKind>& photos) {
  constexpr std::size_t kFewest = 3;
  constexpr double kMost = 5;
  const double of_all = RobustDeviation(residuals);
  std::map<int, std::vector<Eigen::Matrix2Xd>> of_kind;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    std::vector<Eigen::Matrix2Xd>& same = of_kind[photos[i].kind];
    if (residuals[i].cols() > 0) same.push_back(residuals[i]);
  }
  std::map<int, double> deviations;
  for (const auto& [kind, some] : of_kind) {
    deviations[kind] =
        some.size() < kFewest ? of_all : std::min(RobustDeviation(some), kMost * of_all);
  }
  return deviations;
}

}  // namespace

double RobustDeviation(const std::vector<Eigen::Matrix2Xd>& residuals) {
  std::vector<double> all;
  for (const Eigen::Matrix2Xd& photo : residuals) {
    const std::vector<double> squares = Squares(photo);
    all.insert(all.end(), squares.begin(), squares.end());
  }
  return std::max(std::sqrt(MedianSquare(all) / kMedianOfSquares), 1e-6);
}

TrimmedPoints TrimPoints(const std::vector<Eigen::Matrix2Xd>& residuals,
                         const std::vector<Eigen::Vector2d>& slips_px,
                         const std::vector<PhotoKind>& photos) {
  const std::map<int, double> deviations = DeviationsOf(residuals, photos);
  std::vector<double> slips;
  for (const Eigen::Vector2d& slip : slips_px) slips.push_back(slip.squaredNorm());
  const double usual_slip = std::sqrt(MedianSquare(slips) / kMedianOfSquares);
  TrimmedPoints trimmed;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const std::vector<double> squares = Squares(residuals[i]);
    const double deviation = deviations.at(photos[i].kind);
    std::vector<char>& inlier = trimmed.inlier.emplace_back();
    double inside = 0;
    for (const double square : squares) {
      inlier.push_back(square < kTrim * kTrim * deviation * deviation);
      inside += inlier.back();
    }
    if (squares.empty()) continue;
    const std::string why = Doubt(inside / static_cast<double>(squares.size()),
                                  slips_px.empty() ? 0 : slips_px[i].norm(), usual_slip,
                                  std::sqrt(MedianSquare(squares) / kMedianOfSquares) / deviation);
    if (why.empty()) continue;
    inlier.assign(squares.size(), 0);
    trimmed.rejected.push_back(photos[i].label + ": " + why);
  }
  return trimmed;
}

}  // namespace lamella
