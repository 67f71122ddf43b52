#include "calibration/next_view.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calibration/imagined_view.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr int kPanelColumns = 9, kPanelRows = 6;  // points of a panel

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double MedianDistance(const Fit& fit) {
  std::vector<double> distances;
  for (const Rigid& camera_from_world : fit.state.camera_from_world) {
    distances.push_back(Centre(camera_from_world).norm());
  }
  return MedianOf(std::move(distances));
}

// The variance of a point's coordinate, and the points' number on a panel, of a photograph so far.
struct Typical {
  double variance_px2 = 1, points = 1;
};
Typical TypicalPhoto(const Fit& fit, const Observations& observations) {
  std::vector<double> variances, counts;
  for (const PanelPhoto& photo : observations.photos) {
    if (photo.points.empty()) continue;
    counts.push_back(static_cast<double>(photo.points.size()));
    variances.push_back(photo.points.front().covariance_px2.trace() / 2);
  }
  return {std::max(1.0, fit.variance) * MedianOf(std::move(variances)),
          MedianOf(std::move(counts))};
}

// A view of all panels that was not taken: its photographs, and the numbers around them.
struct ImaginedView {
  Structure structure;
  CalibrationState state;
  Observations observations;
};

// Nothing where a point would lie outside of the picture.
std::optional<ImaginedView> Imagine(const Fit& fit, const Structure& structure,
                                    const Observations& observations, const Rigid& pose,
                                    double variance_px2) {
  ImaginedView view{structure, fit.state, {observations.cameras, {}}};
  view.structure.views = {0};
  view.structure.camera_of_view = {0};
  view.structure.view_of_photo.assign(structure.panels.size(), 0);
  view.state.camera_from_world = {pose};
  view.state.slips_px.assign(structure.panels.size(), Vector2d::Zero());
  for (const PanelId& id : structure.panels) {
    const PanelCalibration& panel = structure.Panel(id);
    PanelPhoto photo{id, 0, 0, NameOf(id), {}};
    for (int i = 0; i < kPanelColumns * kPanelRows; ++i) {
      const int column = i % kPanelColumns, row = i / kPanelColumns;
      const Vector2d share((column + 0.5) / kPanelColumns, (row + 0.5) / kPanelRows);
      photo.points.push_back({share.cwiseProduct(Vector2d(panel.width_px, panel.height_px)),
                              Vector2d::Zero(), Eigen::Matrix2d::Identity()});
    }
    view.observations.photos.push_back(std::move(photo));
  }
  // Against a point at (0, 0) of unit covariance a residual is what is predicted.
  const auto predicted = WhitenedResiduals(view.state, view.structure, view.observations);
  const PhotoCamera& camera = observations.cameras.front();
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const Eigen::Array2d low = predicted[i].rowwise().minCoeff();
    const Eigen::Array2d high = predicted[i].rowwise().maxCoeff();
    if (!(low >= 0).all() || !(high.x() <= camera.width) || !(high.y() <= camera.height)) return {};
    for (std::size_t k = 0; k < view.observations.photos[i].points.size(); ++k) {
      Observation& point = view.observations.photos[i].points[k];
      point.image_px = predicted[i].col(static_cast<Eigen::Index>(k));
      point.covariance_px2 = variance_px2 * Eigen::Matrix2d::Identity();
    }
  }
  return view;
}

MatrixXd InformationOf(const ImaginedView& view, const Fit& fit) {
  const Columns columns = ColumnsOf(view.structure, fit.free, view.observations);
  Weighting weighting;
  weighting.slip_sd_px = fit.weighting.slip_sd_px;
  return InformationOfView(
      Linearise(view.state, view.structure, columns, view.observations, weighting), columns);
}

}  // namespace

std::optional<NextView> BestNextView(const Fit& fit, const Structure& structure,
                                     const Observations& observations, const EyeBox& box) {
  const std::vector<ProbedRay> rays = RaysToProbe(structure, box);
  if (rays.empty()) return {};
  const MatrixXd so_far = InformationSoFar(fit.equations, fit.columns, fit.variance);
  const MatrixXd covariance = CovarianceOfInformation(so_far);
  // Small against what is assumed where nothing is known.
  const Eigen::VectorXd steps = 0.01 * covariance.diagonal().cwiseSqrt();
  const MatrixXd slopes = SlopesOfRays(fit, structure, rays, steps);
  const double now = UncertaintyOfRays(rays, slopes, covariance).rms_sd_px;
  const Typical typical = TypicalPhoto(fit, observations);
  const double variance = typical.variance_px2 * kPanelColumns * kPanelRows / typical.points;
  const double distance = MedianDistance(fit);
  std::optional<NextView> best;
  for (const double up_deg : {0, 10, -10, 20, -20}) {
    for (const double right_deg : {0, 10, -10, 20, -20, 30, -30}) {
      const auto view = Imagine(fit, structure, observations,
                                LookingFrom(PlaceAt(right_deg, up_deg, distance)), variance);
      if (!view) continue;
      const MatrixXd then = CovarianceOfInformation(so_far + InformationOf(*view, fit));
      const double next = UncertaintyOfRays(rays, slopes, then).rms_sd_px;
      if (best && !(next < best->next_rms_sd_px)) continue;
      best = NextView{right_deg, up_deg, distance, now, next};
    }
  }
  return best;
}

}  // namespace lamella
