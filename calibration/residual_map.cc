#include "calibration/residual_map.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "calibration/homography.h"

namespace lamella {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// How a photograph's pixels move with the panel's at a point, by the homography between them.
Matrix2d JacobianAt(const Eigen::Matrix3d& image_from_panel, const Vector2d& panel_px) {
  const Eigen::Vector3d at = image_from_panel * panel_px.homogeneous();
  return (image_from_panel.topLeftCorner<2, 2>() -
          at.hnormalized() * image_from_panel.row(2).head<2>()) /
         at.z();
}

std::optional<Eigen::Matrix3d> HomographyOf(const PanelPhoto& photo) {
  const auto num = static_cast<Eigen::Index>(photo.points.size());
  Eigen::Matrix2Xd panel(2, num), image(2, num);
  for (Eigen::Index k = 0; k < num; ++k) {
    panel.col(k) = photo.points[static_cast<std::size_t>(k)].panel_px;
    image.col(k) = photo.points[static_cast<std::size_t>(k)].image_px;
  }
  return FitHomography(panel, image);
}

// A whitened residual L^T (predicted - measured), L L^T the inverse covariance, in pixels.
Vector2d InPixels(const Vector2d& whitened, const Matrix2d& covariance_px2) {
  const Matrix2d information = covariance_px2.inverse();
  return information.llt().matrixU().solve(whitened);
}

std::size_t CellOf(const Vector2d& at, const PanelCalibration& panel) {
  const auto place = [](double share, int count) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(share * count), 0, count - 1));
  };
  const std::size_t row = place(at.y() / panel.height_px, ResidualMap::kRows);
  return row * ResidualMap::kColumns + place(at.x() / panel.width_px, ResidualMap::kColumns);
}

// Sums, of which Finish makes means.
void AddPhoto(const PanelPhoto& photo, const Eigen::Matrix2Xd& residuals,
              const std::vector<char>& inlier, const PanelCalibration& panel, ResidualMap& map) {
  const auto homography = HomographyOf(photo);
  if (!homography) return;
  for (std::size_t k = 0; k < photo.points.size(); ++k) {
    const Observation& point = photo.points[k];
    ResidualCell& cell = map.cells[CellOf(point.panel_px, panel)];
    if (!inlier[k]) {
      ++cell.num_left_out;
      continue;
    }
    const Vector2d predicted_minus_seen =
        InPixels(residuals.col(static_cast<Eigen::Index>(k)), point.covariance_px2);
    const Vector2d error =
        -(JacobianAt(*homography, point.panel_px).inverse() * predicted_minus_seen);
    ++cell.num_points;
    cell.mean_px += error;
    cell.rms_px += error.squaredNorm();
  }
}

void Finish(ResidualMap& map) {
  for (ResidualCell& cell : map.cells) {
    if (cell.num_points == 0) continue;
    cell.mean_px /= cell.num_points;
    cell.rms_px = std::sqrt(cell.rms_px / cell.num_points);
  }
}

}  // namespace

std::vector<ResidualMap> MapResiduals(const Fit& fit, const Structure& structure,
                                      const Observations& observations) {
  const auto residuals = WhitenedResiduals(fit.state, structure, observations);
  std::vector<ResidualMap> maps;
  for (const PanelId& panel : structure.panels) {
    ResidualMap map;
    map.panel = panel;
    map.cells.resize(ResidualMap::kCells);
    std::set<int> views;
    for (std::size_t i = 0; i < observations.photos.size(); ++i) {
      const PanelPhoto& photo = observations.photos[i];
      const std::vector<char>& inlier = fit.weighting.inlier[i];
      if (photo.panel != panel || std::find(inlier.begin(), inlier.end(), 1) == inlier.end()) {
        continue;
      }
      views.insert(photo.view);
      AddPhoto(photo, residuals[i], inlier, structure.Panel(panel), map);
    }
    map.views.assign(views.begin(), views.end());
    Finish(map);
    maps.push_back(std::move(map));
  }
  return maps;
}

}  // namespace lamella
