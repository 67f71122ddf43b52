#include "calibration/residuals.h"

#include "calibration/problem-inl.h"
#include "lightfield/parallel.h"

namespace lamella {

std::vector<Eigen::Matrix2Xd> WhitenedResiduals(const CalibrationState& state,
                                                const Structure& structure,
                                                const Observations& observations) {
  std::vector<Eigen::Matrix2Xd> residuals(observations.photos.size());
  CalibrationState numbers = state;  // blocks of parameters are not const
  ParallelForEach(0, static_cast<std::int64_t>(residuals.size()), [&](std::int64_t number) {
    const auto at = static_cast<std::size_t>(number);
    const PanelPhoto& photo = observations.photos[at];
    residuals[at].resize(2, static_cast<Eigen::Index>(photo.points.size()));
    if (photo.points.empty()) return;
    const auto blocks = BlocksOfPhoto(numbers, structure, photo, at);
    MakePhotoCost(structure, photo.panel, photo.points)
        ->Evaluate(blocks.data(), residuals[at].data(), nullptr);
  });
  return residuals;
}

NormalEquations Linearise(const CalibrationState& state, const Structure& structure,
                          const Columns& columns, const Observations& observations,
                          const Weighting& weighting) {
  Weighting without_loss = weighting;
  without_loss.cauchy = 0;
  return JointProblem(state, structure, columns, observations, without_loss).Equations();
}

}  // namespace lamella
