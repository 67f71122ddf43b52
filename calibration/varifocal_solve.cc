#include "calibration/varifocal_solve.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "calibration/covariance.h"
#include "calibration/inliers.h"
#include "calibration/slip.h"
#include "calibration/varifocal_start.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

constexpr double kLoosePlaneSlipPx = 0.3;
constexpr std::size_t kEnoughOfAPlane = 24;  // points of a photograph to find the way

// At most about kEnoughOfAPlane points of each photograph, evenly chosen.
VarifocalTask Thinned(const VarifocalTask& task) {
  const auto thin = [](auto& points) {
    const std::size_t step =
        std::max<std::size_t>(1, (points.size() + kEnoughOfAPlane - 1) / kEnoughOfAPlane);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); i += step) points[kept++] = points[i];
    points.resize(kept);
  };
  VarifocalTask thinned = task;
  for (PlanePhoto& photo : thinned.observations.photos) thin(photo.points);
  for (VarifocalView& view : thinned.observations.views) thin(view.marks);
  return thinned;
}

std::vector<Eigen::Matrix2Xd> ResidualsOf(const VarifocalState& state, const VarifocalTask& task) {
  return WhitenedResiduals(state, task.planes, task.observations);
}

// Cauchy's loss from far away: its width follows the residuals down.
void Approach(const VarifocalTask& task, const VarifocalColumns& columns, VarifocalState& state) {
  double last = 0;
  for (int round = 0; round < 20; ++round) {
    const double deviation = RobustDeviation(ResidualsOf(state, task));
    Weighting weighting;
    weighting.cauchy = 2 * deviation;
    const bool settled = round > 0 && deviation > 0.9 * last;
    Minimise(task.planes, columns, task.observations, weighting,
             {settled ? 12 : 2, round == 0 ? 1e-4 : 1e-8, 1e-2}, state);
    if (settled) break;
    last = deviation;
  }
}

void Trim(const VarifocalTask& task, VarifocalFit& fit) {
  std::vector<PhotoKind> photos;
  for (const VarifocalPhoto& photo : PhotosOf(task.observations)) {
    photos.push_back({photo.label, photo.plane});
  }
  TrimmedPoints trimmed = TrimPoints(ResidualsOf(fit.state, task), fit.state.slips_px, photos);
  fit.weighting.inlier = std::move(trimmed.inlier);
  fit.rejected = std::move(trimmed.rejected);
}

// chi^2 per degree of freedom, of points that count.
void Judge(const VarifocalTask& task, VarifocalFit& fit) {
  const auto residuals = ResidualsOf(fit.state, task);
  double chi2 = 0;
  fit.num_residuals = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
      if (!fit.weighting.inlier[i][static_cast<std::size_t>(k)]) continue;
      chi2 += residuals[i].col(k).squaredNorm();
      fit.num_residuals += 2;
    }
    chi2 += (fit.state.slips_px[i] / fit.weighting.slip_sd_px).squaredNorm();
  }
  // A slip brings as many residuals (its prior) as columns.
  const int freedom = fit.num_residuals - fit.columns.common.first_slip;
  fit.variance = freedom > 0 ? chi2 / freedom : 1;
}

// From near the solution; to `smallest_gain` of chi^2.
void LeastSquares(const VarifocalTask& task, double smallest_gain, VarifocalFit& fit) {
  fit.weighting.cauchy = 0;
  fit.converged = Minimise(task.planes, fit.columns, task.observations, fit.weighting,
                           {40, 1e-8, smallest_gain}, fit.state)
                      .converged;
  fit.equations = Linearise(fit.state, task.planes, fit.columns, task.observations, fit.weighting);
  Judge(task, fit);
}

// From near the solution, with all points: drops what disagrees, until the points stay the same.
void Settle(const VarifocalTask& task, VarifocalFit& fit) {
  fit.weighting.inlier.clear();
  fit.weighting.cauchy = 2 * RobustDeviation(ResidualsOf(fit.state, task));
  // Loosely held, so that a photograph that was shifted is not taken for one that disagrees.
  fit.weighting.slip_sd_px = kLoosePlaneSlipPx;
  const VarifocalTask thinned = Thinned(task);
  Minimise(task.planes, fit.columns, thinned.observations, fit.weighting, {6, 1e-8, 1e-2},
           fit.state);
  for (int round = 0; round < 4; ++round) {
    const auto before = fit.weighting.inlier;
    Trim(task, fit);
    if (round > 0 && fit.weighting.inlier == before) break;
    LeastSquares(task, 1e-2, fit);
    fit.weighting.slip_sd_px =
        EstimateSlip({fit.equations, fit.columns.common.slip, fit.columns.common.first_slip,
                      fit.state.slips_px, fit.weighting.slip_sd_px, fit.variance});
  }
  LeastSquares(task, 1e-14, fit);
}

constexpr int kPlaneFolds = 4;

// Whitened squares of every fourth view's points, predicted from the others.
void AddFold(const VarifocalFit& fit, const VarifocalTask& task, int fold,
             std::vector<double>& squares) {
  const std::vector<VarifocalPhoto> photos = PhotosOf(task.observations);
  Weighting others = fit.weighting, left_out = fit.weighting;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    auto& unused = photos[i].view % kPlaneFolds == fold ? others.inlier[i] : left_out.inlier[i];
    unused.assign(unused.size(), 0);
  }
  VarifocalState state = fit.state;
  MinimiseOptions nearby{20, 1e-8, 1e-2};
  Minimise(task.planes, fit.columns, task.observations, others, nearby, state);
  nearby.hold_display = true;
  Minimise(task.planes, fit.columns, task.observations, left_out, nearby, state);
  const auto residuals = ResidualsOf(state, task);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    for (Eigen::Index k = 0; k < residuals[i].cols(); ++k) {
      if (left_out.inlier[i][static_cast<std::size_t>(k)]) {
        squares.push_back(residuals[i].col(k).squaredNorm());
      }
    }
  }
}

}  // namespace

VarifocalFit Solve(const VarifocalState& start, const VarifocalTask& task,
                   const VarifocalGroups& free) {
  VarifocalFit fit;
  fit.free = free;
  fit.state = start;
  VarifocalGroups without_slip = free;
  without_slip.slip = false;
  const VarifocalTask thinned = Thinned(task);
  const VarifocalColumns columns = ColumnsOf(task.observations, task.planes.size(), without_slip);
  Approach(thinned, columns, fit.state);
  PoseAnew(task.observations, fit.state);
  Approach(thinned, columns, fit.state);
  fit.columns = ColumnsOf(task.observations, task.planes.size(), free);
  Settle(task, fit);
  return fit;
}

VarifocalFit Refit(const VarifocalFit& fit, const VarifocalTask& task,
                   const VarifocalGroups& free) {
  VarifocalFit next = fit;
  next.free = free;
  next.columns = ColumnsOf(task.observations, task.planes.size(), free);
  for (std::size_t i = 0; i < task.planes.size(); ++i) {
    PlaneShape& shape = next.state.planes[i].shape;
    if (!free.bow) shape(3) = task.planes[i].bow_mm;
    if (!free.pincushion) shape(4) = task.planes[i].pincushion;
  }
  LeastSquares(task, 1e-14, next);
  return next;
}

Eigen::MatrixXd CovarianceOf(const VarifocalFit& fit) {
  return std::max(1.0, fit.variance) * InverseOf(WithoutSlips(fit.equations, fit.columns.common));
}

Degeneracy DegeneracyOf(const VarifocalFit& fit) {
  return DegeneracyOf(fit.equations, fit.columns.common, fit.variance);
}

Rigid DisplayFromFrame(const VarifocalState& state, const VarifocalTask& task) {
  const auto num = static_cast<Eigen::Index>(4 * state.planes.size());
  Eigen::Matrix3Xd from(3, num), to(3, num);
  for (Eigen::Index i = 0; i < num; ++i) {
    const auto plane = static_cast<std::size_t>(i / 4);
    const PanelCalibration& panel = task.planes[plane];
    const Eigen::Vector2d corner((i % 2) * panel.width_px, (i % 4 / 2) * panel.height_px);
    const PlaneState& is = state.planes[plane];
    from.col(i) = is.frame_from_plane * PanelPoint(WithShape(panel, is.shape), corner);
    to.col(i) = task.design.layers[plane].display_from_stack * PanelPoint(panel, corner);
  }
  const Eigen::Matrix3d rotation = AlignSimilarity(from, to).rotation;
  const Eigen::Vector3d shift = to.rowwise().mean() - rotation * from.rowwise().mean();
  return {Eigen::Quaterniond(rotation), shift};
}

std::vector<double> HeldOutSquares(const VarifocalFit& fit, const VarifocalTask& task) {
  std::vector<double> squares;
  for (int fold = 0; fold < kPlaneFolds; ++fold) AddFold(fit, task, fold, squares);
  return squares;
}

}  // namespace lamella
