#include "calibration/board_cameras.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "calibration/covariance.h"
#include "calibration/initialise.h"
#include "calibration/solve.h"
#include "calibration/uncertainty.h"

namespace lamella {
namespace {

constexpr double kCameraKnown = 100;  // Degeneracy: ten times better than assumed

// The board as the one panel of a display.
Calibration DesignOf(const PrintedBoard& printed) {
  LayerCalibration layer;
  layer.emitter = PanelOf(printed);
  return {"printed board", {layer}};
}

Fit FitOfBoard(const Structure& structure, const Observations& observations) {
  FreeGroups free;
  free.slip = false;  // a view is one photograph: its shift is its pose
  const Fit without = Solve(Initialise(observations, structure), structure, observations, free);
  free.k3 = true;
  Fit with = Refit(without, structure, observations, free);
  const double gain = (without.equations.cost - with.equations.cost) / with.variance;
  const bool asked_for = gain > std::log(with.num_residuals);
  return asked_for && DegeneracyOf(with).smallest >= kCameraKnown ? with : without;
}

// The places of the views whose photograph was not rejected.
std::vector<std::size_t> UsedViews(const Fit& fit, const Structure& structure) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < fit.weighting.inlier.size(); ++i) {
    const std::vector<char>& inlier = fit.weighting.inlier[i];
    if (std::find(inlier.begin(), inlier.end(), 1) == inlier.end()) continue;
    used.push_back(static_cast<std::size_t>(structure.view_of_photo[i]));
  }
  return used;
}

CameraPoses PosesOf(const CalibrationState& state, const PhotoCamera& body,
                    const std::vector<std::size_t>& views) {
  CameraPoses poses{CameraOf(state.cameras.front(), body.width, body.height), {}};
  for (const std::size_t view : views) {
    poses.camera_from_board.push_back(state.camera_from_world[view]);
  }
  return poses;
}

void AddDeviations(const Fit& fit, const PhotoCamera& body, const std::vector<std::size_t>& views,
                   BoardCameras& cameras) {
  const Eigen::MatrixXd covariance = CovarianceOf(fit);
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  if (covariance.size() == 0 || root.info() != Eigen::Success) return;
  const Eigen::MatrixXd directions = root.matrixL();
  for (Eigen::Index i = 0; i < directions.cols(); ++i) {
    cameras.off.push_back(PosesOf(Plus(fit.state, fit.columns, directions.col(i)), body, views));
  }
  const int focal = fit.columns.camera.front();
  cameras.focal_sd_px =
      std::sqrt(std::max(covariance(focal, focal), covariance(focal + 1, focal + 1)));
}

void Summarise(const Fit& fit, const Structure& structure, const Observations& observations,
               BoardCameras& cameras) {
  const auto residuals = WhitenedResiduals(fit.state, structure, observations);
  double squares = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const std::vector<Observation>& points = observations.photos[i].points;
    cameras.num_corners += static_cast<int>(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (!fit.weighting.inlier[i][k]) continue;
      ++cameras.num_used;
      squares += residuals[i].col(static_cast<Eigen::Index>(k)).squaredNorm() *
                 points[k].covariance_px2.trace() / 2;
    }
  }
  cameras.rms_px = std::sqrt(squares / std::max(1, cameras.num_used));
}

}  // namespace

BoardCameras CamerasOfBoard(const std::vector<BoardPhoto>& photos, const PhotoCamera& body,
                            const PrintedBoard& printed) {
  Observations observations;
  observations.cameras.push_back(body);
  for (const BoardPhoto& photo : photos) {
    observations.photos.push_back(
        {{0, PanelId::kEmitter}, photo.view, 0, photo.photo, photo.points});
  }
  std::sort(observations.photos.begin(), observations.photos.end(),
            [](const PanelPhoto& a, const PanelPhoto& b) { return a.view < b.view; });
  const Calibration design = DesignOf(printed);
  Check(observations, "printed board");
  Check(design, "printed board");
  const Structure structure = StructureOf(observations, design);
  const Fit fit = FitOfBoard(structure, observations);
  BoardCameras cameras;
  const std::vector<std::size_t> views = UsedViews(fit, structure);
  cameras.found = PosesOf(fit.state, body, views);
  for (const std::size_t view : views) cameras.views.push_back(structure.views[view]);
  cameras.chi2 = fit.variance;
  cameras.has_k3 = fit.free.k3;
  cameras.rejected = fit.rejected;
  Summarise(fit, structure, observations, cameras);
  AddDeviations(fit, body, views, cameras);
  if (cameras.off.empty()) {
    cameras.failures.push_back(
        {fmt::format("the camera ({}): the photographs of the printed board do not settle it",
                     NameOfDirection(DegeneracyOf(fit), fit.columns)),
         "add photographs of the board alone, slanted by 20 to 40 degrees to all sides"});
  }
  return cameras;
}

}  // namespace lamella
