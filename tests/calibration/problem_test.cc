// Every residual's derivatives against Ceres' own differences, for every kind of photograph.
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <ceres/gradient_checker.h>
#include <ceres/manifold.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calibration/problem-inl.h"
#include "tests/calibration/standard_scene.h"

// A checker's results are allocated in Ceres' library and freed here: Eigen has other ways of both
// where it is compiled for AddressSanitizer.
#ifdef __SANITIZE_ADDRESS__
#define SKIP_WITH_SANITIZERS() GTEST_SKIP() << "Ceres' library allocates without the sanitizer"
#else
#define SKIP_WITH_SANITIZERS() static_cast<void>(0)
#endif

namespace lamella {
namespace {

// What one photograph may have: emitter, mirror, plate, bow.
using Kind = std::tuple<bool, bool, bool, bool>;

std::string NameOf(const Kind& kind) {
  const auto [emitter, mirror, plate, bow] = kind;
  return fmt::format("{}{}{}{}", emitter ? "Emitter" : "Modulator", mirror ? "Mirrored" : "",
                     plate ? "Plate" : "", bow ? "Bow" : "");
}

class PhotoCost : public testing::TestWithParam<Kind> {};

Calibration DesignOf(const Kind& kind) {
  const auto [emitter, mirror, plate, bow] = kind;
  SceneOptions options;
  options.num_views = 1;
  Calibration design = MakeStandardScene(options).design;
  LayerCalibration& layer = design.layers[0];
  layer.index = emitter ? 1.49 : 1;
  layer.modulator->mirror_x = layer.emitter.mirror_x = mirror;
  if (bow) layer.emitter.pincushion = layer.modulator->pincushion = 0.01;
  layer.plate.reset();
  if (plate) layer.plate = Plate{2, 1.5, Eigen::Vector3d(1, 0.2, 1).normalized()};
  return design;
}

// A state away from every special place: nothing is zero.
CalibrationState SomeState(const Structure& structure, const Observations& observations, bool bow) {
  CalibrationState state = StateOfDesign(structure, observations);
  const auto turned = [](double angle, double x, double y, double z) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d(x, y, z).normalized()));
  };
  state.cameras[0] << 7000, 7010, 2700, 1800, -0.05, 0.02, 3e-4, -2e-4, 0.03;
  // Turned by pi about x: the camera looks along -z of the display.
  state.camera_from_world[0] = {turned(3.0, 1, 0.1, 0.05), {12, -7, 1000}};
  LayerState& layer = state.layers[0];
  layer.world_from_stack = {turned(0.04, 0.3, 1, 0.2), {3, -2, -4}};
  layer.relation << 0.5, -0.3, 5, 0.01, -0.02, 0.03;
  layer.emitter_shape << 1e-3, -2e-3, 3e-3, bow ? 0.3 : 0;
  layer.modulator_shape << -1e-3, 1e-3, 2e-3, bow ? -0.2 : 0;
  state.slips_px[0] << 0.1, -0.2;
  return state;
}

TEST_P(PhotoCost, HasTheDerivativesOfItsDifferences) {
  SKIP_WITH_SANITIZERS();
  const auto [emitter, mirror, plate, bow] = GetParam();
  Observations observations;
  observations.cameras = {{"camera", 5472, 3648, 7000}};
  PanelPhoto photo;
  photo.panel = {0, emitter ? PanelId::kEmitter : PanelId::kModulator};
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(100, 80), {1700, 900}, {500, 700}}) {
    Observation point{at, {2700 + at.x(), 1800 - at.y()}, {}};
    point.covariance_px2 << 0.04, 0.01, 0.01, 0.02;
    photo.points.push_back(point);
  }
  observations.photos = {photo};
  const Structure structure = StructureOf(observations, DesignOf(GetParam()));
  CalibrationState state = SomeState(structure, observations, bow);

  const auto cost = MakePhotoCost(structure, photo.panel, photo.points);
  const std::vector<double*> blocks = BlocksOfPhoto(state, structure, photo, 0);
  ASSERT_EQ(blocks.size(), cost->parameter_block_sizes().size());
  EXPECT_EQ(blocks.size(), 7U + (emitter ? 2 : 0) + (plate ? 1 : 0));

  const ceres::EigenQuaternionManifold rotation;
  std::vector<const ceres::Manifold*> manifolds(blocks.size(), nullptr);
  manifolds[1] = manifolds[3] = &rotation;
  ceres::NumericDiffOptions differences;
  differences.ridders_relative_initial_step_size = 1e-4;
  const ceres::GradientChecker checker(cost.get(), &manifolds, differences);
  ceres::GradientChecker::ProbeResults results;
  EXPECT_TRUE(checker.Probe(blocks.data(), 1e-5, &results)) << results.error_log;
  EXPECT_GT(results.residuals.norm(), 1);
  EXPECT_LT(results.residuals.norm(), 1e6) << "the points are seen";
}

INSTANTIATE_TEST_SUITE_P(EveryKind, PhotoCost,
                         testing::Combine(testing::Bool(), testing::Bool(), testing::Bool(),
                                          testing::Bool()),
                         [](const auto& test) { return NameOf(test.param); });

TEST(SlipPrior, HasTheDerivativesOfItsDifferences) {
  SKIP_WITH_SANITIZERS();
  const auto cost = MakeSlipPrior(0.03);
  const ceres::GradientChecker checker(
      cost.get(), static_cast<const std::vector<const ceres::Manifold*>*>(nullptr),
      ceres::NumericDiffOptions());
  const Eigen::Vector2d slip(0.06, -0.015);
  const double* blocks[] = {slip.data()};
  ceres::GradientChecker::ProbeResults results;
  EXPECT_TRUE(checker.Probe(blocks, 1e-9, &results)) << results.error_log;
  EXPECT_NEAR(results.residuals(0), 2, 1e-12);
  EXPECT_NEAR(results.residuals(1), -0.5, 1e-12);
}

// With a loss the squares of a photograph's residuals sum to the loss of each of its points, and
// their gradient is that of the sum.
TEST(PhotoCostWithLoss, IsTheLossOfEachPoint) {
  SceneOptions options;
  options.num_views = 2;
  options.columns = 5;
  options.rows = 4;
  const StandardScene scene = MakeStandardScene(options);
  const Observations observations = Noisy(scene.exact, 3, 1);
  const Structure structure = StructureOf(observations, scene.design);
  CalibrationState state = SomeState(structure, observations, false);
  const PanelPhoto& photo = observations.photos[0];
  constexpr double kWidth = 20000;  // as large as the residuals, so that both its ends count
  const ceres::CauchyLoss cauchy(kWidth);
  const std::vector<double*> blocks = BlocksOfPhoto(state, structure, photo, 0);
  const auto num = static_cast<Eigen::Index>(photo.points.size());
  const auto plain_cost = MakePhotoCost(structure, photo.panel, photo.points);
  const auto loss_cost = MakePhotoCost(structure, photo.panel, photo.points, &cauchy);
  const auto sum_of_losses = [&] {
    Eigen::Matrix2Xd plain(2, num);
    plain_cost->Evaluate(blocks.data(), plain.data(), nullptr);
    return (kWidth * kWidth * (plain.colwise().squaredNorm().array() / (kWidth * kWidth)).log1p())
        .sum();
  };
  Eigen::VectorXd residuals(2 * num + 1);
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> slopes(2 * num + 1, 3);
  std::vector<double*> jacobians(blocks.size(), nullptr);
  jacobians[2] = slopes.data();
  loss_cost->Evaluate(blocks.data(), residuals.data(), jacobians.data());
  EXPECT_NEAR(residuals.squaredNorm() / sum_of_losses(), 1, 1e-12);
  const Eigen::Vector3d gradient = 2 * slopes.transpose() * residuals;
  for (int i = 0; i < 3; ++i) {  // of the view's translation, by differences
    double& at = state.camera_from_world[0].translation(i);
    const double before = at, step = 1e-3;
    at = before + step;
    const double up = sum_of_losses();
    at = before - step;
    const double down = sum_of_losses();
    at = before;
    EXPECT_NEAR(gradient(i) / ((up - down) / (2 * step)), 1, 1e-5) << i;
  }
}

}  // namespace
}  // namespace lamella
