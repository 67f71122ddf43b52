// A varifocal display's planes from exact points with noise. The long form of the statistics:
//   LAMELLA_TRIALS=100 build/release/tests/calibration_varifocal_test
#include "calibration/varifocal.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/imagined_view.h"
#include "calibration/inliers.h"
#include "calibration/varifocal_start.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "tests/calibration/varifocal_scene.h"

namespace lamella {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

int Trials(int short_form) {
  const char* text = std::getenv("LAMELLA_TRIALS");
  return text == nullptr ? short_form : std::atoi(text);
}

VarifocalSceneOptions Few() {
  VarifocalSceneOptions options;
  options.num_planes = 3;
  return options;
}

VarifocalReport Solved(const VarifocalScene& scene) {
  CalibrateVarifocalOptions options;
  options.display_from_frame = scene.display_from_frame;
  return CalibrateVarifocal(scene.observations, scene.display, options);
}

std::string Failures(const VarifocalReport& report) {
  std::string text;
  for (const Weakness& weakness : report.failures) {
    text += weakness.lost + "; " + weakness.cure + "\n";
  }
  return text;
}

// The worst errors and the RMS deviations stated, over the planes.
struct Accuracy {
  double depth_mm = 0, magnification = 0;
  double depth_sd_mm = 0, magnification_sd = 0, tilt_sd_rad = 0;
};

Accuracy AccuracyOf(const VarifocalReport& report, const VarifocalScene& scene) {
  Accuracy accuracy;
  const auto num = static_cast<double>(report.planes.size());
  for (std::size_t k = 0; k < report.planes.size(); ++k) {
    const PlaneNumbers errors = ErrorsOf(report.planes[k], scene.planes[k]);
    accuracy.depth_mm = std::max(accuracy.depth_mm, std::abs(errors(5)));
    accuracy.magnification = std::max(accuracy.magnification, std::abs(errors(6)));
    accuracy.depth_sd_mm += report.planes[k].depth_sd_mm / num;
    accuracy.magnification_sd += report.planes[k].magnification_sd / num;
    accuracy.tilt_sd_rad += report.planes[k].tilt_sd_rad / num;
  }
  return accuracy;
}

Accuracy Measured(const char* name, const VarifocalSceneOptions& options) {
  const VarifocalScene scene = MakeVarifocalScene(options);
  const VarifocalReport report = Solved(scene);
  const Accuracy accuracy = AccuracyOf(report, scene);
  fmt::print(
      "{}, {} planes, {} views within {} degrees: depth {:.4f} mm, magnification {:.1e} at worst; "
      "stated: {:.4f} mm, {:.2e}, tilt {:.4f} degrees, correlation {:.2f}; tau {:.4f} px, chi^2 "
      "{:.3f}\n",
      name, options.num_planes, options.num_views, options.angle_deg, accuracy.depth_mm,
      accuracy.magnification, accuracy.depth_sd_mm, accuracy.magnification_sd,
      accuracy.tilt_sd_rad * 180 / std::numbers::pi, report.planes[0].depth_with_magnification,
      report.slip_px, report.chi2);
  EXPECT_TRUE(report.accepted()) << name << ": " << Failures(report);
  EXPECT_THAT(report.rejected, IsEmpty());
  EXPECT_LT(accuracy.depth_mm, 0.03) << name;
  EXPECT_LT(accuracy.magnification, 1e-4) << name;
  for (const GroupVerdict& verdict : report.groups) EXPECT_FALSE(verdict.freed) << verdict.group;
  return accuracy;
}

TEST(Varifocal, KnowsEveryPlaneWherePosesAreKnown) {
  VarifocalSceneOptions options;
  options.known_poses = true;
  options.sheet = false;
  const Accuracy accuracy = Measured("poses known", options);
  // calibration.md section 3, of a scene of which it does not say all: 0.0054 mm, 1.1e-5, 0.007
  // degrees.
  EXPECT_NEAR(accuracy.depth_sd_mm, 0.0054, 0.25 * 0.0054);
  EXPECT_NEAR(accuracy.magnification_sd, 1.1e-5, 0.25 * 1.1e-5);
}

TEST(Varifocal, TellsDepthFromMagnificationByTheViewsAnglesOnly) {
  VarifocalSceneOptions options = Few();
  options.known_poses = true;
  options.sheet = false;
  options.angle_deg = 4;
  const VarifocalReport report = Solved(MakeVarifocalScene(options));
  const CalibratedPlane& plane = report.planes[1];
  fmt::print("within 4 degrees: depth sd {:.4f} mm, magnification {:.1e}, correlation {:.2f}\n",
             plane.depth_sd_mm, plane.magnification_sd, plane.depth_with_magnification);
  // calibration.md: 0.012 mm, correlation 0.84 in size.
  EXPECT_NEAR(plane.depth_sd_mm, 0.012, 0.25 * 0.012);
  EXPECT_LT(plane.depth_with_magnification, -0.6);
}

TEST(Varifocal, KnowsEveryPlaneFromTheSheetOfItsFrame) { Measured("poses from the sheet", {}); }

TEST(Varifocal, KnowsEveryPlaneWithACameraThatIsSolvedAsWell) {
  VarifocalSceneOptions options;
  options.num_planes = 5;
  options.known_camera = false;
  options.num_sheet_views = 8;
  Measured("camera and poses from the sheet", options);
}

// Errors over what is stated of them, pooled over planes and trials.
double NormalisedError(VarifocalSceneOptions options, int trials) {
  double sum = 0, num = 0;
  for (int i = 0; i < trials; ++i) {
    options.seed = 100 + static_cast<std::uint32_t>(i);
    const VarifocalScene scene = MakeVarifocalScene(options);
    const VarifocalReport report = Solved(scene);
    for (std::size_t k = 0; k < report.planes.size(); ++k) {
      const PlaneNumbers errors = ErrorsOf(report.planes[k], scene.planes[k]);
      sum += errors.dot(report.planes[k].covariance.ldlt().solve(errors)) / 7;
      num += 1;
    }
  }
  return sum / num;
}

TEST(Varifocal, SaysHowUncertainItIs) {
  VarifocalSceneOptions options;
  options.num_planes = 4;
  options.columns = 6;
  options.rows = 5;
  for (const double slip : {0.0, 0.05}) {
    options.slip_px = slip;
    const double normalised = NormalisedError(options, Trials(3));
    fmt::print("slips of {} px, {} trials: normalised error {:.3f}\n", slip, Trials(3), normalised);
    EXPECT_GT(normalised, Trials(3) >= 50 ? 0.8 : 0.5);
    EXPECT_LT(normalised, Trials(3) >= 50 ? 1.25 : 1.6);
  }
}

std::string Refusal(const VarifocalScene& scene) {
  try {
    return Failures(Solved(scene));
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(Varifocal, RefusesByNameWhatPhotographsDoNotSettle) {
  VarifocalSceneOptions options = Few();
  options.num_views = 1;
  EXPECT_THAT(Refusal(MakeVarifocalScene(options)),
              HasSubstr("plane 0 is seen from 1 camera position with enough points: its depth "
                        "can't be told from its magnification"));
  options = Few();
  options.angle_deg = 1;
  EXPECT_THAT(Refusal(MakeVarifocalScene(options)),
              AllOf(HasSubstr("depth and magnification of 3 planes"),
                    HasSubstr("the views span 2.0 degrees; photograph every plane from 12")));
  options = Few();
  options.sheet = false;
  EXPECT_THAT(Refusal(MakeVarifocalScene(options)), HasSubstr("nothing gives lengths"));
  options = Few();
  options.num_views = 2;
  options.angle_deg = 1;
  options.known_camera = false;
  EXPECT_THAT(Refusal(MakeVarifocalScene(options)),
              AllOf(HasSubstr("camera body focal"), HasSubstr("calibrate the camera beforehand")));
}

TEST(Varifocal, RefusesByNameWhatIsNotThere) {
  VarifocalScene scene = MakeVarifocalScene(Few());
  VarifocalScene other = scene;
  std::erase_if(other.observations.photos,
                [](const PlanePhoto& photo) { return photo.plane == 1; });
  EXPECT_THAT(Refusal(other), HasSubstr("plane 1 is in no photograph"));
  other = scene;
  other.observations.photos[0].plane = 7;
  EXPECT_THAT(Refusal(other), HasSubstr("shows plane 7, display varifocal has 3"));
  other = scene;
  other.display.varifocal.reset();
  EXPECT_THAT(Refusal(other), HasSubstr("has no [varifocal] planes"));
  other = scene;
  for (Layer& layer : other.display.layers) layer.mirror_x = true;
  EXPECT_THAT(Refusal(other), HasSubstr("plane 0 is mirrored"));
  other = scene;
  other.observations.photos[1].points[2].image_px.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Refusal(other), HasSubstr("has a point that is not finite"));
  other = scene;
  other.observations.views[2].marks.resize(3);
  EXPECT_THAT(Solved(other).rejected,
              testing::Contains(HasSubstr("view 2: 3 marks of the frame's sheet do not say")));
}

// Points in the left third of plane 1 alone, and three views: which is enough, but said.
TEST(Varifocal, SaysWhereItsPlanesWereSeen) {
  VarifocalScene scene = MakeVarifocalScene(Few());
  const VarifocalReport all = Solved(scene);
  EXPECT_TRUE(all.warnings.empty());
  ASSERT_EQ(all.residuals.size(), 3U);
  const ResidualMap pooled = Pooled(all.residuals);
  int points = 0, used = 0;
  double squares = 0;
  for (const ResidualCell& cell : pooled.cells) {
    points += cell.num_points;
    squares += cell.num_points * cell.rms_px * cell.rms_px;
    EXPECT_LT(cell.mean_px.norm(), std::hypot(kLargestMeanPx, cell.ChancePx()));
  }
  for (const FitOf& plane : all.planes_fit) used += plane.num_used;
  EXPECT_EQ(points, used);
  // 0.1 px in the photograph in two directions, where a panel's pixel is 1.1 of its.
  EXPECT_NEAR(std::sqrt(squares / points), 0.1 * std::sqrt(2.0) / 1.09, 0.02);
  EXPECT_EQ(all.probed.size(), all.rays.sd_px.size());
  for (PlanePhoto& photo : scene.observations.photos) {
    if (photo.plane != 1) continue;
    std::erase_if(photo.points, [](const Observation& point) { return point.panel_px.x() > 340; });
  }
  std::erase_if(scene.observations.photos, [](const PlanePhoto& photo) { return photo.view > 2; });
  const VarifocalReport few = Solved(scene);
  EXPECT_EQ(few.residuals[1].CellsSeen(), 15U);
  ASSERT_EQ(few.warnings.size(), 2U);
  EXPECT_THAT(few.warnings[0].lost, HasSubstr("plane 1 was seen in 38 % of its area"));
  EXPECT_THAT(few.warnings[1].lost, HasSubstr("3 planes are in 2 or 3 views only"));
}

TEST(Varifocal, ToleratesWrongPointsAndPhotographs) {
  VarifocalScene scene = MakeVarifocalScene(Few());
  std::mt19937 random(5);
  for (PlanePhoto& photo : scene.observations.photos) {
    for (Observation& point : photo.points) {
      if (random() % 10 < 2) point.image_px.x() += static_cast<double>(random() % 30);
    }
  }
  // Two planes of one view are mixed up.
  std::swap(scene.observations.photos[0].points, scene.observations.photos[1].points);
  const VarifocalReport report = Solved(scene);
  EXPECT_TRUE(report.accepted()) << Failures(report);
  EXPECT_EQ(report.rejected.size(), 2U);
  const Accuracy accuracy = AccuracyOf(report, scene);
  EXPECT_LT(accuracy.depth_mm, 0.03);
  EXPECT_LT(accuracy.magnification, 1e-4);
}

// As one that is out of focus from everywhere is, at the end of a display that is deeper than the
// camera's depth of field; one photograph of another plane is less sharp than the others of it.
TEST(Varifocal, HoldsAPlanesPhotographsAgainstItsOwn) {
  VarifocalScene scene = MakeVarifocalScene(Few());
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.28);  // px; 0.1 px is stated
  std::string unsharp;
  for (PlanePhoto& photo : scene.observations.photos) {
    const bool is_unsharp = photo.plane == 0 && photo.view == 4;
    if (is_unsharp) unsharp = photo.photo;
    if (photo.plane != 1 && !is_unsharp) continue;
    for (Observation& point : photo.points) {
      point.image_px += Eigen::Vector2d(noise(random), noise(random));
    }
  }
  const VarifocalReport report = Solved(scene);
  EXPECT_THAT(report.rejected, ElementsAre(AllOf(HasSubstr(unsharp), HasSubstr("out of focus"))));
  EXPECT_LT(AccuracyOf(report, scene).depth_mm, 0.1);
}

TEST(TrimPoints, HoldsPhotographsAgainstTheirKindWithinReason) {
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0, 1);
  std::vector<Eigen::Matrix2Xd> residuals;
  std::vector<PhotoKind> photos;
  // Sharp, unsharp, and photographs of something else; the last kind's are too few to say.
  for (const auto& [kind, deviation, num] :
       {std::tuple{0, 1.0, 4}, {0, 1.0, 4}, {1, 3.0, 4}, {2, 60.0, 3}, {3, 8.0, 1}}) {
    for (int i = 0; i < num; ++i) {
      Eigen::Matrix2Xd& points = residuals.emplace_back(2, 200);
      for (double& off : points.reshaped()) off = deviation * noise(random);
      photos.push_back({fmt::format("kind {}", kind), kind});
    }
  }
  residuals.emplace_back(2, 0);
  photos.push_back({"nothing seen", 3});
  const TrimmedPoints trimmed = TrimPoints(residuals, {}, photos);
  EXPECT_THAT(trimmed.rejected, ElementsAre(HasSubstr("kind 2: "), HasSubstr("kind 2: "),
                                            HasSubstr("kind 2: "), HasSubstr("kind 3: ")));
}

TEST(Varifocal, FreesBowAndPincushionOnlyWherePlanesHaveThem) {
  const auto freed = [](double bow_mm, double pincushion) {
    VarifocalSceneOptions options = Few();
    options.columns = 7;
    options.rows = 6;
    options.known_poses = true;
    options.sheet = false;
    options.bow_mm = bow_mm;
    options.pincushion = pincushion;
    const VarifocalScene scene = MakeVarifocalScene(options);
    const VarifocalReport report = Solved(scene);
    EXPECT_TRUE(report.accepted()) << Failures(report);
    std::string names;
    for (const GroupVerdict& verdict : report.groups) {
      EXPECT_FALSE(verdict.reason.empty());
      if (verdict.freed) names += verdict.group + " ";
    }
    EXPECT_NEAR(report.planes[1].bow_mm, bow_mm, 0.1);
    EXPECT_NEAR(report.planes[1].pincushion, pincushion, 3e-4);
    const Accuracy accuracy = AccuracyOf(report, scene);
    EXPECT_LT(accuracy.depth_mm, 0.05);
    EXPECT_LT(accuracy.magnification, 2e-4);
    return names;
  };
  EXPECT_EQ(freed(0, 0), "");
  EXPECT_EQ(freed(1, 0), "bow ");
  EXPECT_EQ(freed(0, 0.005), "pincushion ");
  EXPECT_THAT(freed(1, 0.005), AllOf(HasSubstr("bow"), HasSubstr("pincushion")));
}

TEST(Varifocal, DoesNotDependOnTheOrderOfPhotographs) {
  const VarifocalScene scene = MakeVarifocalScene(Few());
  VarifocalScene other = scene;
  std::reverse(other.observations.photos.begin(), other.observations.photos.end());
  const VarifocalReport a = Solved(scene), b = Solved(other);
  for (std::size_t k = 0; k < a.planes.size(); ++k) {
    EXPECT_EQ(a.planes[k].display_from_plane.translation,
              b.planes[k].display_from_plane.translation);
    EXPECT_EQ(a.planes[k].magnification, b.planes[k].magnification);
  }
}

TEST(Varifocal, IsALayerForEveryPlane) {
  VarifocalSceneOptions options = Few();
  const VarifocalScene scene = MakeVarifocalScene(options);
  const VarifocalReport report = Solved(scene);
  ASSERT_EQ(report.calibration.layers.size(), 3U);
  Check(report.calibration, "calibration");
  for (std::size_t k = 0; k < 3; ++k) {
    const LayerCalibration& layer = report.calibration.layers[k];
    const VarifocalScene::Plane& truth = scene.planes[k];
    const double m = truth.magnification;
    // A corner of the panel, by hand.
    const Eigen::Vector3d corner(-512 * 0.1631 * m, 384 * 0.1631 * m, 0);
    const Eigen::Vector3d is = layer.display_from_stack * PanelPoint(layer.emitter, {0, 0});
    EXPECT_LT((is - truth.display_from_plane * corner).norm(), 0.04);
    EXPECT_NEAR(layer.gap_mm, 2.92 * m * m, 2.92 * 2.5e-4);
    EXPECT_NEAR(layer.lattice->pitch_mm, 13 * 0.1631 * m, 3e-4);
  }
  // Without the sheet's place the planes are laid over the design: their middle is its middle.
  const VarifocalReport laid = CalibrateVarifocal(scene.observations, scene.display);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const CalibratedPlane& plane : laid.planes) middle += plane.display_from_plane.translation;
  EXPECT_LT(middle.norm() / 3, 1e-9);
}

TEST(Varifocal, SaysWhetherThePlanesFollowTheMirror) {
  VarifocalSceneOptions options;
  options.num_planes = 8;
  options.known_poses = true;
  options.sheet = false;
  VarifocalReport report = Solved(MakeVarifocalScene(options));
  EXPECT_TRUE(report.mirror.tested);
  EXPECT_TRUE(report.mirror.holds) << Describe(report.mirror);
  EXPECT_EQ(report.mirror.harmonics, 1);
  EXPECT_TRUE(report.mirror.relay_holds);
  EXPECT_NEAR(1 / report.mirror.relay_power_per_mm, 400, 5);
  EXPECT_THAT(Describe(report.mirror), HasSubstr("the planes follow the mirror with 1 harmonic"));
  options.wobble_mm = 0.2;
  report = Solved(MakeVarifocalScene(options));
  EXPECT_TRUE(report.accepted()) << Failures(report);
  EXPECT_FALSE(report.mirror.holds) << Describe(report.mirror);
  EXPECT_GT(report.mirror.depth_rms_mm, 0.03);
  EXPECT_THAT(Describe(report.mirror), HasSubstr("the planes do not follow the mirror"));
}

// Half the sum of squares, with the slips' prior.
double HalfCost(const VarifocalState& state, const std::vector<PanelCalibration>& planes,
                const VarifocalObservations& observations, double slip_sd_px) {
  double sum = 0;
  for (const auto& photo : WhitenedResiduals(state, planes, observations)) {
    sum += photo.squaredNorm();
  }
  for (const Eigen::Vector2d& slip : state.slips_px) {
    sum += slip.squaredNorm() / (slip_sd_px * slip_sd_px);
  }
  return sum / 2;
}

void MovePose(Rigid& pose, int number, double step) {
  if (number >= 3) {
    pose.translation(number - 3) += step;
  } else {
    pose.rotation = Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(number)) * pose.rotation;
  }
}

// One step along a column, written down anew.
VarifocalState Stepped(VarifocalState state, const VarifocalColumns& columns, int column,
                       double step) {
  const Columns& common = columns.common;
  const auto within = [&](int first, int num) { return column >= first && column < first + num; };
  if (within(common.camera[0], 8)) state.cameras[0](column - common.camera[0]) += step;
  for (std::size_t k = 0; k < state.planes.size(); ++k) {
    const int first = columns.plane[k];
    if (within(first, 6)) MovePose(state.planes[k].frame_from_plane, column - first, step);
    if (column == first + 6) state.planes[k].shape(0) += step;
    if (column == columns.bent[k][0]) state.planes[k].shape(3) += step;
    if (column == columns.bent[k][1]) state.planes[k].shape(4) += step;
  }
  for (std::size_t v = 0; v < state.camera_from_frame.size(); ++v) {
    const int first = common.view[v];
    if (within(first, 6)) MovePose(state.camera_from_frame[v], column - first, step);
  }
  for (std::size_t i = 0; i < state.slips_px.size(); ++i) {
    if (within(common.slip[i], 2)) state.slips_px[i](column - common.slip[i]) += step;
  }
  return state;
}

// Three views close to the axis and a further one: what the worst known plane is known to, in what
// is asked for.
double TimesLimitWith(const std::optional<Eigen::Vector3d>& further_mm, bool known_poses,
                      std::optional<NextPlaneView>* next = nullptr) {
  VarifocalSceneOptions options = Few();
  options.num_views = 3;
  options.angle_deg = 4;
  options.known_poses = known_poses;
  options.further_mm = further_mm;
  const VarifocalReport report = Solved(MakeVarifocalScene(options));
  double worst = 0;
  for (const CalibratedPlane& plane : report.planes) {
    worst = std::max({worst, plane.depth_sd_mm / report.limits.largest_depth_sd_mm,
                      plane.magnification_sd / report.limits.largest_magnification_sd});
  }
  if (next != nullptr) *next = report.next_view;
  return worst;
}

TEST(Varifocal, KnowsItsPlanesBestByTheViewThatItAskedFor) {
  for (const bool known_poses : {true, false}) {
    std::optional<NextPlaneView> next;
    const double before = TimesLimitWith(std::nullopt, known_poses, &next);
    ASSERT_TRUE(next);
    EXPECT_NEAR(next->times_limit, before, 0.05 * before);
    const double after =
        TimesLimitWith(PlaceAt(next->right_deg, next->up_deg, next->distance_mm), known_poses);
    fmt::print("{:.0f} degrees right, {:.0f} up: {:.2f} to {:.2f} times what is asked for\n",
               next->right_deg, next->up_deg, before, after);
    EXPECT_NEAR(after, next->next_times_limit, 0.15 * after);
    for (const auto& [right_deg, up_deg] : {std::pair{0.0, 0.0}, {4.0, 4.0}, {-8.0, 2.0}}) {
      const double other =
          TimesLimitWith(PlaceAt(right_deg, up_deg, next->distance_mm), known_poses);
      EXPECT_LT(after, 0.95 * other) << right_deg << ' ' << up_deg;
    }
  }
}

TEST(VarifocalProblem, HasTheSlopesOfItsResiduals) {
  VarifocalSceneOptions options = Few();
  options.num_planes = 2;
  options.num_views = 3;
  options.columns = options.rows = 3;
  options.known_camera = false;
  const VarifocalScene scene = MakeVarifocalScene(options);
  const auto planes = PlanesOf(DesignCalibration(scene.display));
  VarifocalState state = Initialise(scene.observations, planes);
  // Away from every special place.
  state.cameras[0].segment<5>(4) << -0.05, 0.02, 3e-4, -2e-4, 0.01;
  for (PlaneState& plane : state.planes) plane.shape << 0.02, 0.001, 0.002, 0.3, 0.004;
  for (Eigen::Vector2d& slip : state.slips_px) slip << 0.02, -0.01;
  VarifocalGroups free;
  free.bow = free.pincushion = true;
  const VarifocalColumns columns = ColumnsOf(scene.observations, planes.size(), free);
  const Weighting weighting;
  const NormalEquations equations =
      Linearise(state, planes, columns, scene.observations, weighting);
  for (int i = 0; i < columns.common.size; ++i) {
    const double step = 1e-4 / std::sqrt(equations.hessian(i, i));
    const auto cost = [&](double by) {
      return HalfCost(Stepped(state, columns, i, by), planes, scene.observations,
                      weighting.slip_sd_px);
    };
    const double slope = (cost(step) - cost(-step)) / (2 * step);
    const double scale = std::sqrt(equations.hessian(i, i) * equations.cost);
    EXPECT_NEAR(equations.gradient(i), slope, 1e-5 * scale)
        << columns.common.names[static_cast<std::size_t>(i)];
  }
}

TEST(MirrorModel, HasPhasesOfAMembrane) {
  Varifocal varifocal;
  varifocal.planes = 4;
  varifocal.spacing = Varifocal::Spacing::kSinusoidal;
  const std::vector<double> phases = MirrorPhases(varifocal);
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(phases[static_cast<std::size_t>(k)], std::numbers::pi * (k + 0.5) / 4, 1e-12);
  }
  varifocal.spacing = Varifocal::Spacing::kUniform;
  const std::vector<double> uniform = MirrorPhases(varifocal);
  EXPECT_NEAR(uniform[0], std::numbers::pi / 8, 1e-12);
  EXPECT_NEAR(std::cos(uniform[1]), std::cos(std::numbers::pi / 8) / 3, 1e-12);
}

// Numbers with a second harmonic and noise of which the covariance is known, correlated.
TEST(MirrorModel, FindsTheHarmonicsAndTheirProbability) {
  constexpr int kPlanes = 24;
  Varifocal varifocal;
  varifocal.planes = kPlanes;
  const std::vector<double> phases = MirrorPhases(varifocal);
  const Eigen::MatrixXd root = [] {
    Eigen::MatrixXd r = Eigen::MatrixXd::Identity(7 * kPlanes, 7 * kPlanes);
    for (int k = 0; k < kPlanes; ++k) {
      for (int i = 0; i < 7; ++i) r(7 * k + i, i) += 0.7;  // what all have from common views
      r(7 * k + 6, 7 * k + 5) += 0.8;
    }
    return Eigen::MatrixXd(0.01 * r);
  }();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double chi2 = 0, freedom = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd noise(7 * kPlanes);
    for (double& number : noise) number = normal(random);
    noise = root * noise;
    std::vector<PlaneNumbers> numbers;
    for (std::size_t k = 0; k < kPlanes; ++k) {
      numbers.emplace_back(noise.segment<7>(7 * static_cast<Eigen::Index>(k)));
      numbers.back()(5) += -90 * std::cos(phases[k]) + 0.5 * std::cos(2 * phases[k]);
    }
    const MirrorModel model = FitMirrorModel(numbers, root * root.transpose(), phases);
    EXPECT_EQ(model.harmonics, 2);
    EXPECT_TRUE(model.holds);
    EXPECT_EQ(model.freedom, 7 * (kPlanes - 3));
    chi2 += model.chi2;
    freedom += model.freedom;
    numbers[7](5) += 0.3;
    const MirrorModel off = FitMirrorModel(numbers, root * root.transpose(), phases);
    EXPECT_FALSE(off.holds);
    EXPECT_EQ(off.worst_plane, 7);
    EXPECT_NEAR(off.worst_depth_mm, 0.3, 0.1);
  }
  EXPECT_NEAR(chi2 / freedom, 1, 0.05);
}

}  // namespace
}  // namespace lamella
