// What calibration promises, measured over seeded trials and printed. A short form runs with the
// tests; the figures of the long one come from
//   LAMELLA_TRIALS=200 LAMELLA_SEED=1 build/release/tests/calibration_accuracy_test
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <utility>

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calibration/calibrate.h"
#include "calibration/covariance.h"
#include "calibration/initialise.h"
#include "lightfield/error.h"
#include "tests/calibration/sheet_scene.h"
#include "tests/calibration/standard_scene.h"

namespace lamella {
namespace {

int Environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoi(text);
}
// Trials of the long form; 0: the short form, of fewer trials and corners.
int LongTrials() { return Environment("LAMELLA_TRIALS", 0); }
std::uint32_t Seed() { return static_cast<std::uint32_t>(Environment("LAMELLA_SEED", 1)); }
int Trials(int short_form, double share = 1) {
  return LongTrials() > 0 ? std::max(1, static_cast<int>(LongTrials() * share)) : short_form;
}

SceneOptions Standard() {
  SceneOptions options;
  options.misalign_mm = 20;
  options.misalign_deg = 5;
  if (LongTrials() == 0) {
    options.columns = 9;
    options.rows = 6;
  }
  return options;
}

// A scene with what trials compare against.
struct Bench {
  StandardScene scene;
  Structure structure;
  std::vector<ProbedRay> rays;
  Eigen::Matrix2Xd truth;

  explicit Bench(const SceneOptions& options)
      : scene(MakeStandardScene(options)),
        structure(StructureOf(scene.exact, scene.design)),
        rays(RaysToProbe(structure, {})),
        truth(PixelsOfRays(scene.truth, structure.reference, rays)) {}

  Fit Solved(const Observations& observations, const FreeGroups& free = {}) const {
    const Structure of = StructureOf(observations, structure.design);
    return Solve(Initialise(observations, of), of, observations, free);
  }
  double RayError(const Calibration& calibration) const {
    return CompareRays(truth, PixelsOfRays(calibration, structure.reference, rays)).rms_px;
  }
  double RayError(const Fit& fit) const { return RayError(CalibrationOf(fit.state, structure)); }

  // Errors of the display's parameters (stacks and relations) in the tangent space.
  Eigen::VectorXd DisplayErrors(const Fit& fit) const {
    Structure built = structure;
    built.design = scene.truth;
    const CalibrationState true_state = StateOfDesign(built, scene.exact);
    const int first = fit.columns.num_camera;
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(fit.columns.num_display - first);
    for (std::size_t i = 0; i < true_state.layers.size(); ++i) {
      const LayerState &is = fit.state.layers[i], &should = true_state.layers[i];
      if (fit.columns.relation[i] >= 0) {
        errors.segment<6>(fit.columns.relation[i] - first) = is.relation - should.relation;
      }
      if (fit.columns.stack[i] < 0) continue;
      const int at = fit.columns.stack[i] - first;
      const Eigen::AngleAxisd turn(is.world_from_stack.rotation *
                                   should.world_from_stack.rotation.inverse());
      errors.segment<3>(at) = turn.angle() * turn.axis();
      errors.segment<3>(at + 3) =
          is.world_from_stack.translation - should.world_from_stack.translation;
    }
    return errors;
  }
};

// Mean squares of errors over what was stated of them.
struct Honesty {
  double squares = 0, stated = 0, normalised = 0, covered = 0, parameters = 0;
  int trials = 0;

  void Add(const Bench& bench, const Fit& fit) {
    const Eigen::MatrixXd covariance = CovarianceOf(fit);
    const int first = fit.columns.num_camera, num = fit.columns.num_display - first;
    const Eigen::MatrixXd own = covariance.block(first, first, num, num);
    const Eigen::VectorXd errors = bench.DisplayErrors(fit);
    const double error = bench.RayError(fit);
    const double sd = UncertaintyOfRays(fit, bench.structure, covariance, {}).rms_sd_px;
    squares += error * error;
    stated += sd * sd;
    normalised += errors.dot(own.ldlt().solve(errors)) / num;
    for (int i = 0; i < num; ++i) covered += std::abs(errors(i)) < 1.96 * std::sqrt(own(i, i));
    parameters += num;
    ++trials;
  }
  double RayRms() const { return std::sqrt(squares / trials); }
  double OverStated() const { return std::sqrt(squares / stated); }
  double Normalised() const { return normalised / trials; }
  double Covered() const { return covered / parameters; }
};

// The bound of Cramer and Rao on the ray map's RMS error: no photograph slips, noise 0.1 px.
double CramerRao(const Bench& bench) {
  FreeGroups no_slip;
  no_slip.slip = false;
  const Fit fit = bench.Solved(bench.scene.exact, no_slip);
  return UncertaintyOfRays(fit, bench.structure, CovarianceOf(fit), {}).rms_sd_px;
}

TEST(Accuracy, ReachesTheCramerRaoBoundAndSaysSo) {
  const Bench bench(Standard());
  Honesty honesty;
  for (int i = 0; i < Trials(12); ++i) {
    honesty.Add(bench, bench.Solved(Noisy(bench.scene.exact, 0.1, Seed() + 100U + i)));
  }
  const double bound = CramerRao(bench);
  fmt::print(
      "exact points, 0.1 px noise, {} trials: rays {:.5f} px = {:.3f} of the Cramer-Rao "
      "bound; joint normalised error {:.3f}; 95 % regions cover {:.1f} % of {}\n",
      honesty.trials, honesty.RayRms(), honesty.RayRms() / bound, honesty.Normalised(),
      100 * honesty.Covered(), honesty.parameters);
  const bool whole = LongTrials() >= 200;
  EXPECT_LT(honesty.RayRms(), (whole ? 1.25 : 1.5) * bound);
  EXPECT_NEAR(honesty.Normalised(), 1, whole ? 0.15 : 0.4);
  EXPECT_NEAR(honesty.Covered(), 0.95, whole ? 0.02 : 0.06);
}

TEST(Accuracy, IsHonestWherePhotographsSlip) {
  const Bench bench(Standard());
  Honesty honesty;
  for (int i = 0; i < Trials(10); ++i) {
    Observations observations = Noisy(bench.scene.exact, 0.1, Seed() + 300U + i);
    AddSlips(observations, 0.05, Seed() + 500U + i);
    honesty.Add(bench, bench.Solved(observations));
  }
  fmt::print(
      "slips of 0.05 px, {} trials: rays {:.5f} px, {:.3f} of what is stated; joint "
      "normalised error {:.3f}; cover {:.1f} %\n",
      honesty.trials, honesty.RayRms(), honesty.OverStated(), honesty.Normalised(),
      100 * honesty.Covered());
  EXPECT_NEAR(honesty.Normalised(), 1, LongTrials() >= 100 ? 0.22 : 0.5);
}

// Sets of photographs that lose something (calibration.md section 8) and still determine a display.
struct PoorSet {
  const char* name;
  std::function<void(SceneOptions&)> options;
  std::function<bool(const PanelPhoto&, const Observation&)> seen;
  FreeGroups free = {};
};

// With the index free a gap is known through it alone.
std::vector<PoorSet> PoorSets() {
  const auto all = [](const PanelPhoto&, const Observation&) { return true; };
  const auto standard = [](SceneOptions&) {};
  FreeGroups index;
  index.index = true;
  return {
      {"hardly tilted", [](SceneOptions& o) { o.yaw_deg = o.pitch_deg = 2; }, all},
      {"from one side", [](SceneOptions& o) { o.one_side_deg = 20, o.yaw_deg = 4; }, all},
      {"left third", standard,
       [](const PanelPhoto&, const Observation& p) { return p.panel_px.x() < 640; }},
      {"an emitter in two views", standard,
       [](const PanelPhoto& photo, const Observation&) {
         return photo.panel != PanelId{1, PanelId::kEmitter} || photo.view == 2 || photo.view == 8;
       }},
      {"index free", standard, all, index},
      {"index free, within 10 degrees", [](SceneOptions& o) { o.yaw_deg = o.pitch_deg = 10; }, all,
       index}};
}

TEST(Accuracy, IsStatedHonestlyWherePhotographsLoseSomething) {
  for (const PoorSet& set : PoorSets()) {
    SceneOptions options = Standard();
    options.columns = std::max(options.columns, 15);
    options.rows = std::max(options.rows, 9);
    set.options(options);
    const Bench bench(options);
    double squares = 0, stated = 0;
    const int trials = Trials(4, 0.2);
    for (int i = 0; i < trials; ++i) {
      Observations observations = Noisy(bench.scene.exact, 0.1, Seed() + 1300U + i);
      for (PanelPhoto& photo : observations.photos) {
        std::erase_if(photo.points, [&](const Observation& p) { return !set.seen(photo, p); });
      }
      const Fit fit = bench.Solved(observations, set.free);
      const double error = bench.RayError(fit);
      const double sd = UncertaintyOfRays(fit, bench.structure, CovarianceOf(fit), {}).rms_sd_px;
      squares += error * error;
      stated += sd * sd;
    }
    const double ratio = std::sqrt(stated / squares);
    fmt::print("{}, {} trials: rays {:.4f} px, stated are {:.3f} of it\n", set.name, trials,
               std::sqrt(squares / trials), ratio);
    EXPECT_GT(ratio, LongTrials() > 0 ? 0.8 : 0.6) << set.name;
  }
}

// Spoils photographs; `good` keeps only what is right.
using Spoil = std::function<void(Observations& all, Observations& good, std::mt19937& random)>;

void CompareWithOracle(const char* name, int trials, const Spoil& spoil) {
  const Bench bench(Standard());
  double ours = 0, oracle = 0;
  for (int i = 0; i < trials; ++i) {
    std::mt19937 random(Seed() + 700U + i);
    Observations all = Noisy(bench.scene.exact, 0.1, Seed() + 900U + i);
    Observations good = all;
    spoil(all, good, random);
    const double error = bench.RayError(bench.Solved(all));
    const double best = bench.RayError(bench.Solved(good));
    ours += error * error;
    oracle += best * best;
  }
  const double ratio = std::sqrt(ours / oracle);
  fmt::print("{}, {} trials: rays {:.5f} px, {:.3f} of the solution from the right points\n", name,
             trials, std::sqrt(ours / trials), ratio);
  EXPECT_LT(ratio, LongTrials() > 0 ? 1.1 : 1.2) << name;
}

void ThirtyPercentWrong(Observations& all, Observations& good, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  for (std::size_t i = 0; i < all.photos.size(); ++i) {
    std::vector<Observation> right;
    for (Observation& point : all.photos[i].points) {
      if (random() % 10 >= 3) {
        right.push_back(point);
      } else {
        point.image_px += 20 * Eigen::Vector2d(number(random), number(random));
      }
    }
    good.photos[i].points = right;
  }
}

// All photographs of one view but the first are taken after the camera was knocked.
void OneMovedCamera(Observations& all, Observations& good, std::mt19937& random) {
  const auto view = static_cast<int>(random() % 12);
  std::normal_distribution<double> shift(0, 2);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < all.photos.size(); ++i) {
    if (all.photos[i].view != view || ++seen < 4) continue;
    const double x = shift(random), y = shift(random), turn = 1e-3 * shift(random);
    for (Observation& point : all.photos[i].points) {
      point.image_px +=
          Eigen::Vector2d(x - turn * point.image_px.y(), y + turn * point.image_px.x());
    }
    good.photos[i].points.clear();
  }
}

void OneOutOfFocus(Observations& all, Observations& good, std::mt19937& random) {
  const auto view = static_cast<int>(random() % 12);
  std::normal_distribution<double> blur(0, 0.8);
  for (std::size_t i = 0; i < all.photos.size(); ++i) {
    if (all.photos[i].view != view) continue;
    for (Observation& point : all.photos[i].points) {
      point.image_px += Eigen::Vector2d(blur(random), blur(random));
    }
    good.photos[i].points.clear();
  }
}

void SwappedNames(Observations& all, Observations& good, std::mt19937& random) {
  const std::size_t a = random() % all.photos.size();
  const std::size_t b = (a + 1 + random() % (all.photos.size() - 1)) % all.photos.size();
  std::swap(all.photos[a].points, all.photos[b].points);
  good.photos[a].points.clear();
  good.photos[b].points.clear();
}

void MissingInHalf(Observations& all, Observations& good, std::mt19937& random) {
  const PanelId panel = all.photos[random() % 4].panel;
  const auto missing = [&](const PanelPhoto& photo) {
    return photo.panel == panel && photo.view % 2 == 1;
  };
  ThirtyPercentWrong(all, good, random);
  std::erase_if(all.photos, missing);
  std::erase_if(good.photos, missing);
}

TEST(Accuracy, IsThatOfTheRightPointsAmongWrongOnes) {
  CompareWithOracle("30 % of the points wrong by up to 20 px", Trials(3, 0.2), ThirtyPercentWrong);
  CompareWithOracle("a camera moved in one view", Trials(3, 0.2), OneMovedCamera);
  CompareWithOracle("one view out of focus", Trials(3, 0.2), OneOutOfFocus);
  CompareWithOracle("two files' names swapped", Trials(3, 0.2), SwappedNames);
  CompareWithOracle("a panel missing in half of the views, 30 % wrong", Trials(3, 0.2),
                    MissingInHalf);
}

// Which groups are freed over seeded displays.
std::map<std::string, int> Freed(SceneOptions options, double index_error, int trials) {
  std::map<std::string, int> freed;
  for (int i = 0; i < trials; ++i) {
    options.seed = Seed() + static_cast<std::uint32_t>(i);
    Bench bench(options);
    for (LayerCalibration& layer : bench.structure.design.layers) layer.index += index_error;
    const Observations observations = Noisy(bench.scene.exact, 0.1, Seed() + 1100U + i);
    const Selection selection =
        SelectGroups(Initialise(observations, bench.structure), bench.structure, observations, {});
    const Calibration solved = CalibrationOf(selection.fit.state, bench.structure);
    EXPECT_NO_THROW(Check(solved, "solved"));
    EXPECT_LT(bench.RayError(solved), 0.05);
    for (const GroupVerdict& verdict : selection.verdicts) {
      freed[verdict.group] += verdict.freed;
      EXPECT_FALSE(verdict.reason.empty());
    }
  }
  return freed;
}

void ExpectFreed(const char* name, const SceneOptions& options, double index_error,
                 const std::vector<std::string>& wanted) {
  const int trials = Trials(1, 0.1);
  std::string counts;
  for (const auto& [group, count] : Freed(options, index_error, trials)) {
    counts += fmt::format(" {} {}", group, count);
    const bool want = std::find(wanted.begin(), wanted.end(), group) != wanted.end();
    if (want) {
      EXPECT_GE(count, 0.95 * trials) << name << ": " << group;
    } else {
      EXPECT_LE(count, 0.05 * trials) << name << ": " << group;
    }
  }
  fmt::print("freed of {}, {}:{}\n", trials, name, counts);
}

TEST(Accuracy, FreesTheGroupsThatTheDisplayHas) {
  SceneOptions options = Standard();
  ExpectFreed("as designed", options, 0, {});
  options.bow_mm = 0.2;
  ExpectFreed("bow 0.2 mm", options, 0, {"bow"});
  options.bow_mm = 0;
  options.plate_mm = options.design_plate_mm = 3;
  ExpectFreed("plate as designed", options, 0, {});
  options.plate_mm = 3;
  options.design_plate_mm = 1;
  ExpectFreed("plate 3 mm instead of 1", options, 0, {"plate thickness"});
  options.plate_mm = options.design_plate_mm = 0;
  ExpectFreed("index wrong by 0.01", options, 0.01, {});
  options.columns = 23;  // an index shows by little: all corners also in the short form
  options.rows = 12;
  ExpectFreed("index wrong by 0.1", options, 0.1, {"index"});
  ExpectFreed("spacers that the design does not know", options, 1 - options.index, {"index"});
  options.index = 1;
  ExpectFreed("air, as designed", options, 0, {});
  ExpectFreed("air for the design's acrylic", options, 0.49, {"index"});
}

// Sheets of 270 x 360 lenses photographed from two places at 6 dB, 100 000 pixels each (the short
// form: a quarter): an amplitude of 2 standard deviations of the photographs' noise. Designs are
// wrong by 1 % and a degree.
TEST(Accuracy, KnowsLensSheetsAtSixDecibels) {
  using Type = LensLattice::Type;
  const int trials = Trials(1, 0.2), pixels = LongTrials() > 0 ? 100000 : 25000;
  for (const auto& [name, type] : {std::pair{"line", Type::kLine},
                                   {"square", Type::kSquare},
                                   {"hexagonal", Type::kHexagonal}}) {
    Sheet sheet;
    sheet.type = type;
    double squares = 0, drift = 0, rotation = 0, phase = 0;
    for (int i = 0; i < trials; ++i) {
      const auto seen = PhotographSheet(sheet, TwoEyes(), pixels, {0, std::pow(10, -0.3), 0, 0, 0},
                                        Seed() + static_cast<std::uint32_t>(i));
      const LayerCalibration layer =
          EstimateLattice(seen, WrongDesign(sheet, i % 2 == 0 ? 1 : -1), SheetViewers()).layer;
      const double off = DriftOf(layer, sheet);
      squares += off * off / trials;
      drift = std::max(drift, off);
      rotation =
          std::max(rotation, std::abs(layer.lattice->rotation_rad - sheet.rotation) / kDegree);
      phase = std::max(phase, PhaseErrorPx(layer, sheet));
    }
    fmt::print(
        "lenses at 6 dB, {} of {}: edge drift {:.4f} px RMS, worst {:.4f}; worst rotation "
        "{:.5f} degrees, phase {:.4f} px\n",
        name, trials, std::sqrt(squares), drift, rotation, phase);
    EXPECT_LT(std::sqrt(squares), 0.02);
    EXPECT_LT(rotation, 0.001);
    EXPECT_LT(phase, 0.02);
  }
}

TEST(Accuracy, ComesWithinASecond) {
  SceneOptions options = Standard();
  options.columns = 23;
  options.rows = 12;
  const Bench bench(options);
  const Observations observations = Noisy(bench.scene.exact, 0.1, Seed());
  double fastest = 1e9;
  for (int i = 0; i < Trials(1, 0.03); ++i) {
    const auto before = std::chrono::steady_clock::now();
    bench.Solved(observations);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - before;
    fastest = std::min(fastest, time.count());
  }
  fmt::print("12 views, 4 panels, 276 corners: start and solution {:.3f} s\n", fastest);
}

}  // namespace
}  // namespace lamella
