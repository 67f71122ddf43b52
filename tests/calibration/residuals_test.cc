// The forward model against lines of sight traced the other way, and its derivatives against
// differences.
#include "calibration/residuals.h"

#include <cmath>
#include <string>
#include <tuple>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "calibration/model.h"
#include "tests/calibration/standard_scene.h"

namespace lamella {
namespace {

// The state that is the scene's truth.
CalibrationState TrueState(const StandardScene& scene, const Structure& structure) {
  Structure true_structure = structure;
  true_structure.design = scene.truth;
  CalibrationState state = StateOfDesign(true_structure, scene.exact);
  const Camera& c = scene.camera;
  state.cameras[0] << c.fx, c.fy, c.cx, c.cy, c.distortion[0], c.distortion[1], c.distortion[2],
      c.distortion[3], c.distortion[4];
  const auto reference = static_cast<std::size_t>(structure.reference.layer);
  for (std::size_t i = 0; i < structure.views.size(); ++i) {
    state.camera_from_world[i] =
        scene.camera_from_display[i] * scene.truth.layers[reference].display_from_stack;
  }
  return state;
}

// Half the sum of squares of points and slips.
double HalfCost(const CalibrationState& state, const Structure& structure,
                const Observations& observations, const Weighting& weighting) {
  double cost = 0;
  for (const Eigen::Matrix2Xd& photo : WhitenedResiduals(state, structure, observations)) {
    cost += photo.squaredNorm() / 2;
  }
  for (const Eigen::Vector2d& slip : state.slips_px) {
    cost += (slip / weighting.slip_sd_px).squaredNorm() / 2;
  }
  return cost;
}

SceneOptions TwoViews() {
  SceneOptions options;
  options.num_views = 3;
  options.columns = 7;
  options.rows = 5;
  options.misalign_mm = 20;
  options.misalign_deg = 5;
  options.scale = 0.005;
  options.k3 = 0.03;
  return options;
}

class ForwardModel : public testing::TestWithParam<std::tuple<double, double, double>> {
 protected:
  static SceneOptions Options() {
    SceneOptions options = TwoViews();
    std::tie(options.bow_mm, options.plate_mm, options.index) = GetParam();
    options.design_plate_mm = options.plate_mm;
    return options;
  }
};

TEST_P(ForwardModel, PutsPointsWhereLinesOfSightMeetThem) {
  const StandardScene scene = MakeStandardScene(Options());
  const Structure structure = StructureOf(scene.exact, scene.design);
  ASSERT_EQ(structure.reference, (PanelId{1, PanelId::kModulator}));
  const CalibrationState state = TrueState(scene, structure);
  double worst = 0;
  std::size_t num = 0;
  for (const Eigen::Matrix2Xd& residuals : WhitenedResiduals(state, structure, scene.exact)) {
    if (residuals.cols() > 0) worst = std::max(worst, 0.1 * residuals.cwiseAbs().maxCoeff());
    num += static_cast<std::size_t>(residuals.cols());
  }
  EXPECT_GT(num, 300U);
  EXPECT_LT(worst, 1e-7) << "px";
}

TEST_P(ForwardModel, HasTheDerivativesOfItsDifferences) {
  const StandardScene scene = MakeStandardScene(Options());
  const Structure structure = StructureOf(scene.exact, scene.design);
  CalibrationState state = TrueState(scene, structure);
  for (std::size_t i = 0; i < state.slips_px.size(); ++i) state.slips_px[i] << 0.1, -0.2;
  const FreeGroups all{true, true, true, true, true, true, true, {}};
  const Columns columns = ColumnsOf(structure, all, scene.exact);
  // The gradient of the cost of a data set with residuals of 1 px at every point.
  Observations moved = scene.exact;
  for (PanelPhoto& photo : moved.photos) {
    for (std::size_t i = 0; i < photo.points.size(); ++i) {
      const double angle = 2.4 * static_cast<double>(i);
      photo.points[i].image_px += Eigen::Vector2d(std::cos(angle), std::sin(angle));
      photo.points[i].covariance_px2 << 0.04, 0.01, 0.01, 0.02;
    }
  }
  const Weighting weighting;
  const NormalEquations equations = Linearise(state, structure, columns, moved, weighting);
  for (int column = 0; column < columns.size; ++column) {
    // Sized so that the image moves by about 1e-3 px.
    const double step = 1e-2 / std::sqrt(equations.hessian(column, column));
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(columns.size);
    delta(column) = step;
    const double up = HalfCost(Plus(state, columns, delta), structure, moved, weighting);
    const double down = HalfCost(Plus(state, columns, -delta), structure, moved, weighting);
    const double slope = (up - down) / (2 * step);
    const double scale = std::sqrt(equations.hessian(column, column));
    EXPECT_NEAR(equations.gradient(column) / scale, slope / scale, 2e-4)
        << columns.names[static_cast<std::size_t>(column)];
  }
}

INSTANTIATE_TEST_SUITE_P(EveryFlag, ForwardModel,
                         testing::Values(std::tuple(0.0, 0.0, 1.49), std::tuple(0.3, 0.0, 1.49),
                                         std::tuple(0.0, 3.0, 1.49), std::tuple(-0.4, 2.0, 1.6),
                                         std::tuple(0.2, 0.0, 1.0)));

// Each column of each point's Jacobian, without sums that could hide one another.
TEST(ForwardModelJacobian, IsThatOfDifferencesAtEveryPoint) {
  SceneOptions options = TwoViews();
  options.num_views = 1;
  options.bow_mm = 0.3;
  options.plate_mm = options.design_plate_mm = 2;
  const StandardScene scene = MakeStandardScene(options);
  const Structure structure = StructureOf(scene.exact, scene.design);
  const CalibrationState state = TrueState(scene, structure);
  const FreeGroups all{true, true, true, true, true, true, true, {}};
  const Columns columns = ColumnsOf(structure, all, scene.exact);
  const Weighting weighting;
  const NormalEquations equations = Linearise(state, structure, columns, scene.exact, weighting);
  std::vector<Eigen::VectorXd> rows;
  for (int column = 0; column < columns.size; ++column) {
    const double step = 1e-2 / std::sqrt(equations.hessian(column, column));
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(columns.size);
    delta(column) = step;
    const auto up = WhitenedResiduals(Plus(state, columns, delta), structure, scene.exact);
    const auto down = WhitenedResiduals(Plus(state, columns, -delta), structure, scene.exact);
    Eigen::VectorXd row(0);
    for (std::size_t i = 0; i < up.size(); ++i) {
      const Eigen::Matrix2Xd slope = (up[i] - down[i]) / (2 * step);
      row.conservativeResize(row.size() + slope.size());
      row.tail(slope.size()) = slope.reshaped();
    }
    rows.push_back(row);
  }
  for (int i = 0; i < columns.first_slip; ++i) {
    for (int j = 0; j < columns.first_slip; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double scale = std::sqrt(equations.hessian(i, i) * equations.hessian(j, j));
      EXPECT_NEAR(rows[a].dot(rows[b]) / scale, equations.hessian(i, j) / scale, 1e-6)
          << columns.names[a] << ", " << columns.names[b];
    }
  }
}

TEST(Refraction, HasADerivativeStraightAhead) {
  using D = ceres::Jet<double, 3>;
  const model::Vec3<D> eye(D(0), D(0), D(900));
  const model::Vec3<D> point(D(0, 0), D(0, 1), D(-5, 2));
  const model::Vec3<D> towards = model::Towards<D>(eye, point, D(1.5));
  EXPECT_EQ(towards.x().a, 0);
  // An apparent depth of 5/1.5 where it crosses: dx of the crossing is d/(d + z/n).
  EXPECT_NEAR(towards.x().v(0), 900 / (900 + 5 / 1.5), 1e-9);
  EXPECT_TRUE(std::isfinite(towards.y().v(2)));
}

}  // namespace
}  // namespace lamella
