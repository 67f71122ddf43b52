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

std::optional<Eigen::Matrix3d> HomographyOf(const std::vector<Observation>& points) {
  const auto num = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix2Xd panel(2, num), image(2, num);
  for (Eigen::Index k = 0; k < num; ++k) {
    panel.col(k) = points[static_cast<std::size_t>(k)].panel_px;
    image.col(k) = points[static_cast<std::size_t>(k)].image_px;
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
void AddPhoto(const PanelResiduals& photo, const PanelCalibration& panel, ResidualMap& map) {
  const auto homography = HomographyOf(*photo.points);
  if (!homography) return;
  for (std::size_t k = 0; k < photo.points->size(); ++k) {
    const Observation& point = (*photo.points)[k];
    ResidualCell& cell = map.cells[CellOf(point.panel_px, panel)];
    if (!(*photo.inlier)[k]) {
      ++cell.num_left_out;
      continue;
    }
    const Vector2d predicted_minus_seen =
        InPixels(photo.whitened->col(static_cast<Eigen::Index>(k)), point.covariance_px2);
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

double ResidualCell::ChancePx() const {
  return num_points > 0 ? 4 * rms_px / std::sqrt(num_points) : 0;
}

std::size_t ResidualMap::CellsSeen() const {
  return static_cast<std::size_t>(std::count_if(
      cells.begin(), cells.end(), [](const ResidualCell& cell) { return cell.num_points > 0; }));
}

ResidualMap MapOf(const PanelId& id, const PanelCalibration& panel,
                  const std::vector<PanelResiduals>& photos) {
  ResidualMap map;
  map.panel = id;
  map.cells.resize(ResidualMap::kCells);
  std::set<int> views;
  for (const PanelResiduals& photo : photos) {
    if (std::find(photo.inlier->begin(), photo.inlier->end(), 1) == photo.inlier->end()) continue;
    views.insert(photo.view);
    AddPhoto(photo, panel, map);
  }
  map.views.assign(views.begin(), views.end());
  Finish(map);
  return map;
}

ResidualMap Pooled(const std::vector<ResidualMap>& maps) {
  ResidualMap pooled;
  pooled.cells.resize(ResidualMap::kCells);
  std::set<int> views;
  for (const ResidualMap& map : maps) {
    views.insert(map.views.begin(), map.views.end());
    for (std::size_t i = 0; i < map.cells.size(); ++i) {
      const ResidualCell& of = map.cells[i];
      ResidualCell& cell = pooled.cells[i];
      cell.num_points += of.num_points;
      cell.num_left_out += of.num_left_out;
      cell.mean_px += of.num_points * of.mean_px;
      cell.rms_px += of.num_points * of.rms_px * of.rms_px;
    }
  }
  pooled.views.assign(views.begin(), views.end());
  Finish(pooled);
  return pooled;
}

std::vector<ResidualMap> MapResiduals(const Fit& fit, const Structure& structure,
                                      const Observations& observations) {
  const auto residuals = WhitenedResiduals(fit.state, structure, observations);
  std::vector<ResidualMap> maps;
  for (const PanelId& panel : structure.panels) {
    std::vector<PanelResiduals> photos;
    for (std::size_t i = 0; i < observations.photos.size(); ++i) {
      const PanelPhoto& photo = observations.photos[i];
      if (photo.panel != panel) continue;
      photos.push_back({photo.view, &photo.points, &residuals[i], &fit.weighting.inlier[i]});
    }
    maps.push_back(MapOf(panel, structure.Panel(panel), photos));
  }
  return maps;
}

}  // namespace lamella
