// Distribution against many rays a beam, and the display seen by a simulated eye against the scene.
#include "distribute/distribute.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "distribute/assign.h"
#include "distribute/depth_blur.h"
#include "distribute/displays.h"
#include "distribute/simulate_eye.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "lightfield/ray_map.h"
#include "tests/reference/distribute_reference.h"

namespace lamella {
namespace {

constexpr double kWholeAxis = 1e9;

// Waves of up to `finest` cycles/mm, between 0.1 and 0.9.
std::function<Rgb(double, double)> Waves(double finest) {
  return [finest](double x, double y) {
    const auto wave = [&](double f, double angle, double phase) {
      return std::cos(2 * M_PI * f * (x * std::cos(angle) + y * std::sin(angle)) + phase);
    };
    const double a = wave(finest, 0.3, 1), b = wave(finest * 0.6, 1.9, 2), c = wave(0.1, 1.2, 0);
    return Rgb{static_cast<float>(0.5 + 0.13 * (a + b + c)),
               static_cast<float>(0.5 + 0.2 * (b - c)), static_cast<float>(0.5 + 0.2 * a)};
  };
}

Rectangle Plane(double z, std::function<Rgb(double, double)> color) {
  return {z, -kWholeAxis, kWholeAxis, -kWholeAxis, kWholeAxis, std::move(color)};
}

std::function<Rgb(double, double)> Constant(float value) {
  return [value](double, double) { return Rgb{value, value, value}; };
}

Display CutTo(const std::string& name, int width, int height) {
  Display display = FindDisplay(name);
  display.width_px = width;
  display.height_px = height;
  return display;
}

LayersOptions Options(int nodes_per_step, int samples_per_pixel) {
  LayersOptions options;
  options.nodes_per_step = nodes_per_step;
  options.samples_per_pixel = samples_per_pixel;
  return options;
}

struct AgreementCase {
  const char* display;
  double z;
  int nodes, samples;
  double least_db;
};

class BarrierReference : public ::testing::TestWithParam<AgreementCase> {};

TEST_P(BarrierReference, AgreesWithManyRaysABeam) {
  const AgreementCase& p = GetParam();
  const Display display = CutTo(p.display, 36, 24);
  AnalyticScene scene;
  scene.rectangles = {Plane(p.z, Waves(0.4))};
  const LayerImages images =
      Distribute(scene, display, Options(p.nodes, p.samples), SilentProgress());
  for (int layer = 0; layer < static_cast<int>(display.layers.size()); ++layer) {
    if (ReferenceWeight(display, layer, p.z) == 0) continue;
    const EmitterImage truth = ReferenceEmitters(scene, display, layer, 5, 6);
    const EmitterImage& image = images.slots[static_cast<std::size_t>(layer)][5];
    EXPECT_GE(EmitterPsnr(image, truth), p.least_db) << "layer " << layer;
    for (std::size_t i = 0; i < truth.coverage.size(); ++i) {
      EXPECT_NEAR(image.coverage.data()[i], truth.coverage.data()[i], 1e-5F);
    }
  }
}

// What a display shows of such planes is 20 to 40 dB from the planes themselves.
INSTANTIATE_TEST_SUITE_P(Planes, BarrierReference,
                         ::testing::Values(AgreementCase{"paper-two-layer", -20, 1, 1, 37},
                                           AgreementCase{"paper-two-layer", -10, 1, 1, 48},
                                           AgreementCase{"paper-two-layer", -4, 1, 1, 39},
                                           AgreementCase{"paper-two-layer", 6, 1, 1, 46},
                                           AgreementCase{"paper-two-layer", 20, 1, 1, 43},
                                           AgreementCase{"paper-two-layer", 6, 2, 2, 58},
                                           AgreementCase{"paper-two-layer", -20, 2, 2, 49},
                                           AgreementCase{"paper-two-layer", -20, 4, 3, 55},
                                           AgreementCase{"paper-two-layer-half", 3, 1, 1, 38},
                                           AgreementCase{"paper-two-layer-half", 3, 4, 4, 56},
                                           AgreementCase{"paper-one-layer", -4, 2, 2, 56}));

TEST(Distribute, AgreesWithManyRaysWhereThingsHideOthers) {
  const Display display = CutTo("paper-two-layer", 42, 24);
  AnalyticScene scene;
  scene.rectangles = {
      Plane(-12, Waves(0.3)), {9, -3, 2, -1, 4, Waves(0.4)}, {-1, 1, 6, -3, 2, Constant(0.9F)}};
  const LayerImages draft = Distribute(scene, display, Options(1, 1), SilentProgress());
  const LayerImages fine = Distribute(scene, display, Options(3, 3), SilentProgress());
  for (int layer = 0; layer < 2; ++layer) {
    const EmitterImage truth = ReferenceEmitters(scene, display, layer, 4, 6);
    EXPECT_GE(EmitterPsnr(draft.slots[static_cast<std::size_t>(layer)][4], truth), 27);
    EXPECT_GE(EmitterPsnr(fine.slots[static_cast<std::size_t>(layer)][4], truth), 37);
  }
}

TEST(Distribute, AgreesWithManyRaysWithoutShear) {
  Display display = CutTo("paper-two-layer", 48, 24);
  display.shear = false;
  AnalyticScene scene;
  scene.rectangles = {Plane(7, Waves(0.4))};
  const LayerImages images = Distribute(scene, display, Options(2, 2), SilentProgress());
  EXPECT_GE(EmitterPsnr(images.slots[1][3], ReferenceEmitters(scene, display, 1, 3, 6)), 56);
}

// Emitters with beams of their own, and products of axes: two ways to the same light.
TEST(Distribute, AsCalibratedIsAsDesignedWhereNothingIsAskew) {
  const Display display = CutTo("paper-two-layer", 72, 48);
  AnalyticScene scene;
  scene.rectangles = {Plane(-12, Waves(0.3)), {9, -4, 5, -3, 4, Waves(0.4)}};
  const Calibration design = DesignCalibration(display);
  const LayerImages expected = Distribute(scene, display, Options(1, 2), SilentProgress());
  const LayerImages images = Distribute(scene, display, Options(1, 2), SilentProgress(), &design);
  EXPECT_NEAR(images.seen_share, expected.seen_share, 1e-4);
  for (std::size_t layer = 0; layer < 2; ++layer) {
    for (std::size_t slot = 0; slot < 9; ++slot) {
      const EmitterImage &a = images.slots[layer][slot], &b = expected.slots[layer][slot];
      int same = 0;
      for (std::size_t i = 0; i < a.color.size(); ++i) {
        const Rgb d = a.color.data()[i] - b.color.data()[i];
        const float most = std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b),
                                     std::abs(a.coverage.data()[i] - b.coverage.data()[i])});
        same += most < 1e-5F ? 1 : 0;
      }
      // All but those on a border of two windows, whose shift is rounded in the design's map.
      EXPECT_GT(same, 0.995 * static_cast<double>(a.color.size())) << layer << " " << slot;
    }
  }
}

// A source that knows how many rays were asked for at a time, at most.
class Watched final : public RaySource {
 public:
  explicit Watched(const RaySource& source) : source_(source) {}
  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    int most = most_rows.load();
    while (rectangle.height > most && !most_rows.compare_exchange_weak(most, rectangle.height)) {
    }
    source_.Query(bundle, rectangle, samples);
  }
  mutable std::atomic<int> most_rows{0};

 private:
  const RaySource& source_;
};

// A panel whose pixels are nowhere near a lattice, by other threads and in strips.
TEST(Distribute, AsCalibratedDependsOnNeitherThreadsNorStrips) {
  const Display display = CutTo("paper-two-layer", 24, 200);
  Calibration calibration = DesignCalibration(display);
  calibration.layers[1].display_from_stack.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.08, Eigen::Vector3d(0.2, 0.1, 1).normalized()));
  calibration.layers[1].offset_mm = {1.2, -0.7};
  calibration.layers[1].index = 1.49;
  calibration.layers[1].gap_mm = 6;
  AnalyticScene scene;
  scene.rectangles = {Plane(7, Waves(0.3))};
  const LayerImages all = Distribute(scene, display, Options(1, 1), SilentProgress(), &calibration);
  LayersOptions options = Options(1, 1);
  options.memory_gib = 1e-4;
  const ThreadLimit limit(2);
  const Watched watched(scene);
  const SeenShares seen = Distribute(
      watched, display, options, {},
      [&](const EmitterRows& rows) {
        const EmitterImage& of =
            all.slots[static_cast<std::size_t>(rows.layer)][static_cast<std::size_t>(rows.slot)];
        for (int y = 0; y < rows.emitters.color.height(); ++y) {
          const Rgb* expected = of.color.row(rows.first_row + y);
          EXPECT_TRUE(std::equal(expected, expected + 24, rows.emitters.color.row(y)));
        }
      },
      SilentProgress(), &calibration);
  EXPECT_LT(watched.most_rows, 180) << "there are strips";
  EXPECT_EQ(seen.of_all, all.seen_share);
  EXPECT_GT(seen.of_all, 1 - 1e-5);  // no part of a beam is lost
}

// Emitters of a plane with a wave along x, in closed form: S(f) of the beam's section there
// (displays.md section 1.3), at its central ray.
double LargestErrorOnAPlane(const Display& display, int layer, double z, double f,
                            const EmitterImage& image, int slot) {
  const RayMap map(display, layer);
  const double offset = z - map.position_mm(), weight = ReferenceWeight(display, layer, z);
  const auto sinc = [](double t) { return t == 0 ? 1 : std::sin(M_PI * t) / (M_PI * t); };
  double largest = 0;
  for (int column = 0; column < map.columns(); ++column) {
    const std::optional<AxisBeam> beam = map.Column(slot, column);
    if (!beam || !map.Row(0, map.rows() / 2)) continue;
    const double expected = 0.5 + 0.4 * sinc(f * beam->OpeningBlurMm(offset)) *
                                      sinc(f * beam->EmitterBlurMm(offset)) *
                                      std::cos(2 * M_PI * f * beam->At(offset));
    const double light = static_cast<double>(image.color(column, map.rows() / 2).g);
    largest = std::max(largest, std::abs(light - weight * expected));
  }
  return largest;
}

TEST(Blur, OfAPlaneIsTheBeam) {
  const Display display = CutTo("paper-two-layer", 48, 12);
  std::vector<LayerBeams> beams;
  for (int layer = 0; layer < 2; ++layer) beams.push_back(EnclosingBeamsOf(display, layer));
  const std::vector<double> planes = DepthBlurPlanes(display, beams);
  for (const double depth : {-35.0, 2.0}) {
    const auto next = std::upper_bound(planes.begin(), planes.end(), depth);
    // On a plane of the blur, and farthest from any.
    for (const double z : {*next, (*next + *(next - 1)) / 2}) {
      AnalyticScene scene;
      const double f = 0.3;
      scene.rectangles = {Plane(z, [f](double x, double) {
        const float light = static_cast<float>(0.5 + 0.4 * std::cos(2 * M_PI * f * x));
        return Rgb{light, light, light};
      })};
      LayersOptions options = Options(1, 2);
      options.prefilter = "blur";
      const LayerImages images = Distribute(scene, display, options, SilentProgress());
      for (int layer = 0; layer < 2; ++layer) {
        const EmitterImage& image = images.slots[static_cast<std::size_t>(layer)][1];
        const double error = LargestErrorOnAPlane(display, layer, z, f, image, 1);
        EXPECT_LT(error, z == *next ? 0.004 : 0.025) << "z = " << z << ", layer " << layer;
      }
    }
  }
}

// What it gets wrong: its pictures hide what a wide beam's outer lines see.
TEST(Blur, IsNearTheBeamWhereThingsHideOthers) {
  const Display display = CutTo("paper-two-layer", 42, 24);
  AnalyticScene scene;
  scene.rectangles = {
      Plane(-12, Waves(0.3)), {9, -3, 2, -1, 4, Waves(0.4)}, {-1, 1, 6, -3, 2, Constant(0.9F)}};
  LayersOptions options = Options(1, 2);
  const LayerImages gathered = Distribute(scene, display, options, SilentProgress());
  options.prefilter = "blur";
  const LayerImages blurred = Distribute(scene, display, options, SilentProgress());
  EXPECT_EQ(blurred.seen_share, 1) << "nothing is unknown";
  for (std::size_t layer = 0; layer < 2; ++layer) {
    const EmitterImage truth = ReferenceEmitters(scene, display, static_cast<int>(layer), 4, 6);
    const double db = EmitterPsnr(blurred.slots[layer][4], truth);
    EXPECT_GE(db, 23) << layer;
    EXPECT_LE(db, EmitterPsnr(gathered.slots[layer][4], truth)) << layer;
  }
}

TEST(Blur, TellsShadowsFromTheUnknown) {
  const Display display = CutTo("paper-two-layer", 90, 12);
  AnalyticScene scene;  // a plane that ends at x = 0, and nothing is known beside it
  scene.rectangles = {{-10, -kWholeAxis, 0, -kWholeAxis, kWholeAxis, Constant(1)}};
  scene.background_known = false;
  LayersOptions options = Options(1, 1);
  options.prefilter = "blur";
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  const EmitterImage &back = images.slots[0][4], &front = images.slots[1][4];
  EXPECT_EQ(back.coverage(20, 6), 1);
  EXPECT_NEAR(back.color(20, 6).g, 1, 1e-6);
  EXPECT_EQ(front.coverage(20, 6), 1) << "a shadow";
  EXPECT_EQ(front.color(20, 6), Rgb());
  EXPECT_EQ(back.coverage(70, 6), 0);
  EXPECT_EQ(front.coverage(70, 6), 0);
}

TEST(Blur, IsRefusedWhereItCannotBe) {
  Display display = CutTo("paper-two-layer", 42, 24);
  LayersOptions options = Options(1, 1);
  options.prefilter = "blur";
  EXPECT_NO_THROW(CheckOptions(options, display, false));
  EXPECT_THROW(CheckOptions(options, display, true), Error);
  options.scatter = true;
  EXPECT_THROW(CheckOptions(options, display, false), Error);
  options.scatter = false;
  display.layers[1].optics = Lenticular{7.5, 0.17, 9, 0.3};
  EXPECT_THROW(Distribute(AnalyticScene(), display, options, SilentProgress()), Error);
}

TEST(Distribute, FiltersWithALensBeam) {
  const Display display = CutTo("paper-two-layer", 36, 24);
  AnalyticScene scene;
  scene.rectangles = {Plane(6, Waves(0.4))};
  LayersOptions options = Options(2, 2);
  options.kernel = "lens";
  const EmitterImage lens = ReferenceEmitters(scene, display, 1, 5, 6, true);
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  EXPECT_GE(EmitterPsnr(images.slots[1][5], lens), 56);
  // The two beams differ by more than the reference's error.
  EXPECT_LE(EmitterPsnr(ReferenceEmitters(scene, display, 1, 5, 6), lens), 50);
}

TEST(Distribute, TakesTheCentralRayAlone) {
  const Display display = CutTo("paper-two-layer", 36, 24);
  AnalyticScene scene;
  scene.rectangles = {Plane(10, Waves(0.4))};  // in the layer: direction doesn't matter
  LayersOptions options = Options(2, 4);
  options.kernel = "ray";
  const LayerImages images = Distribute(scene, display, options, SilentProgress());
  EXPECT_GE(EmitterPsnr(images.slots[1][5], ReferenceEmitters(scene, display, 1, 5, 1)), 38);
}

// A fine grating on which a lattice of rays finds moire; scattered rays find noise, and both come
// nearer the truth with more of them.
TEST(Distribute, ScattersRaysWithoutBias) {
  const Display display = CutTo("paper-two-layer", 42, 30);
  AnalyticScene scene;
  scene.rectangles = {Plane(-20, Waves(1.5))};
  const EmitterImage truth = ReferenceEmitters(scene, display, 0, 4, 10);
  double before = 0;
  for (const int nodes : {1, 2, 4}) {
    LayersOptions options = Options(nodes, 2);
    options.scatter = true;
    const LayerImages images = Distribute(scene, display, options, SilentProgress());
    const double db = EmitterPsnr(images.slots[0][4], truth);
    RecordProperty("psnr_" + std::to_string(nodes), std::to_string(db));
    EXPECT_GE(db, before + 2) << nodes;
    before = db;
  }
  EXPECT_GE(before, 38);
}

TEST(Distribute, GivesTheWholeLightOfAPlaneToItsLayersTogether) {
  const Display display = CutTo("paper-two-layer", 48, 36);
  for (const double z : {-25.0, -5.5, -4.0, -3.3, -2.0, 30.0}) {
    AnalyticScene scene;
    scene.rectangles = {Plane(z, Constant(0.7F))};
    const LayerImages images = Distribute(scene, display, Options(1, 1), SilentProgress());
    for (int slot = 0; slot < 9; ++slot) {
      const Image<Rgb>& back = images.slots[0][static_cast<std::size_t>(slot)].color;
      const Image<Rgb>& front = images.slots[1][static_cast<std::size_t>(slot)].color;
      EXPECT_NEAR(back(20, 15).g + front(20, 15).g, 0.7F, 1e-6F);
      EXPECT_NEAR(back(20, 15).g, 0.7 * ReferenceWeight(display, 0, z), 1e-6);
    }
  }
}

TEST(Distribute, TellsShadowsFromTheUnknown) {
  const Display display = CutTo("paper-two-layer", 90, 60);
  AnalyticScene scene;  // an occluder in the front layer before a plane that ends at x = 0
  scene.rectangles = {{-10, -kWholeAxis, 0, -kWholeAxis, kWholeAxis, Constant(1)},
                      {10, -10, -2, -9, 9, Constant(0.5F)}};
  scene.background_known = false;
  const LayerImages images = Distribute(scene, display, Options(1, 1), SilentProgress());
  const EmitterImage& emitters = images.slots[0][4];
  const RayMap back(display, 0);
  int shadows = 0, unknown = 0, seen = 0, partly = 0;
  for (int column = 0; column < 90; ++column) {
    const auto x = back.Column(1, column);
    if (!x) continue;
    // The beam is 0.6 mm wide in the back layer and 4.4 mm in the front one.
    const double at_front = x->At(20), at_back = x->At(0);
    const Rgb color = emitters.color(column, 30);
    const float coverage = emitters.coverage(column, 30);
    if (at_front > -7.5 && at_front < -4.5) {  // surely behind the occluder
      ++shadows;
      EXPECT_NEAR(color.g, 0, 1e-6F);
      EXPECT_NEAR(coverage, 1, 1e-6F);
    } else if (at_back > 0.5 && at_front > 0.7) {  // beside everything
      ++unknown;
      EXPECT_EQ(color, Rgb());
      EXPECT_EQ(coverage, 0);
    } else if (at_back < -0.5 && at_front > 0.7) {
      ++seen;
      EXPECT_NEAR(color.g, 1, 1e-5F);
    } else if (coverage > 0 && coverage < 1 && at_front > 0.7) {
      ++partly;
      EXPECT_NEAR(color.g, 1, 1e-3F);  // the known part's colour, not darkened by the unknown
    }
  }
  EXPECT_GT(std::min({shadows, unknown, seen, partly}), 0);
  EXPECT_GT(images.seen_share, 0.3);
  EXPECT_LT(images.seen_share, 0.7);
}

// Counts what it is asked.
class Counter final : public RaySource {
 public:
  void Query(const RayBundle&, const Rect& rect, ImageSpan<RaySample> samples) const override {
    ++queries;
    rays += static_cast<double>(rect.width) * rect.height;
    for (int y = 0; y < samples.height; ++y) {
      for (int x = 0; x < samples.width; ++x) samples(x, y) = sample;
    }
  }
  RaySample sample;
  mutable int queries = 0;
  mutable double rays = 0;
};

TEST(Distribute, AsksOnceForAllLayersAndSlotsAndNoMoreThanIsNeeded) {
  const Counter source;
  Distribute(source, CutTo("paper-two-layer", 180, 120), Options(1, 1), SilentProgress());
  EXPECT_LE(source.queries, 100);
  EXPECT_LE(source.rays / source.queries, 190 * 130);
}

TEST(Distribute, TakesLightThatIsNotFiniteAsUnknown) {
  for (const float light : {std::nanf(""), INFINITY, -INFINITY}) {
    Counter source;
    source.sample.color = {0, light, 0};
    source.sample.coverage = 1;
    const LayerImages images =
        Distribute(source, CutTo("paper-one-layer", 24, 18), Options(1, 1), SilentProgress());
    EXPECT_EQ(images.seen_share, 0);
    EXPECT_EQ(images.slots[0][4].color(12, 9), Rgb());
  }
  Counter source;
  source.sample.coverage = 1;
  source.sample.z = std::nanf("");
  source.sample.color = {1e8F, 1e-8F, 0};
  const LayerImages images =
      Distribute(source, CutTo("paper-two-layer", 24, 18), Options(1, 1), SilentProgress());
  EXPECT_TRUE(std::isfinite(images.slots[1][4].color(12, 9).r));
  EXPECT_TRUE(std::isfinite(images.slots[0][4].color(12, 9).r));
}

TEST(Distribute, DoesNotDependOnTheNumberOfThreads) {
  const Display display = CutTo("paper-two-layer", 96, 60);
  AnalyticScene scene;
  scene.rectangles = {Plane(-12, Waves(0.3)), {9, -3, 2, -1, 4, Waves(0.4)}};
  const auto run = [&](int threads) {
    const ThreadLimit limit(threads);
    return Distribute(scene, display, Options(1, 1), SilentProgress());
  };
  const LayerImages one = run(1), two = run(2);
  for (std::size_t layer = 0; layer < 2; ++layer) {
    for (std::size_t slot = 0; slot < 9; ++slot) {
      const Image<Rgb>&a = one.slots[layer][slot].color, &b = two.slots[layer][slot].color;
      EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Rgb)), 0);
    }
  }
}

// Eyes at some places see the display; the scene is seen from there directly.
double SeenPsnr(const AnalyticScene& scene, const Display& display, const LayerImages& images,
                const Eigen::Vector3d& position) {
  Eye eye;
  eye.position = position;
  eye.pixel_mm = display.pitch_mm;
  eye.width = display.width_px - 40;
  eye.height = display.height_px - 40;
  eye.left_mm = -eye.width * eye.pixel_mm / 2;
  eye.top_mm = eye.height * eye.pixel_mm / 2;
  const EyePicture seen = SimulateEye(images, display, eye);
  const RayBundle rays = BundleOfEye(eye, 3);
  double sum = 0;
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      double direct = 0;
      for (int i = 0; i < 9; ++i) {
        const int u = 3 * x + i % 3, v = 3 * y + i / 3;
        const RaySample sample = scene.Trace(rays.RayAt(u + 0.5, v + 0.5));
        direct += static_cast<double>(sample.color.g) / 9;
      }
      sum += std::pow(direct - static_cast<double>(seen.color(x, y).g), 2);
    }
  }
  return 10 * std::log10(eye.width * eye.height / sum);
}

TEST(Distribute, ShowsEyesTheSceneWithItsParallax) {
  const Display display = CutTo("paper-two-layer", 240, 180);
  AnalyticScene scene;  // both in emissive planes, where pinhole layers are sharpest
  scene.rectangles = {Plane(-15, Waves(0.4)), {5, -8, 4, -5, 6, Waves(0.4)}};
  const LayerImages images = Distribute(scene, display, Options(1, 1), SilentProgress());
  for (const double x : {-54.0, 0.0, 27.0}) {
    EXPECT_GE(SeenPsnr(scene, display, images, {x, 0.4 * x, 600}), 25) << x;
  }
  // An eye on the other side sees something else.
  AnalyticScene mirrored;
  mirrored.rectangles = {Plane(15, Waves(0.4)), {-5, -8, 4, -5, 6, Waves(0.5)}};
  EXPECT_LT(SeenPsnr(mirrored, display, images, {54, 20, 600}), 20);
}

TEST(Distribute, ShowsAPlaneInEitherLayerSharply) {
  const Display display = CutTo("paper-two-layer", 144, 108);
  for (const double z : {-14.0, 6.0}) {
    AnalyticScene scene;
    scene.rectangles = {Plane(z, Waves(0.4))};
    const LayerImages images = Distribute(scene, display, Options(1, 2), SilentProgress());
    EXPECT_GE(SeenPsnr(scene, display, images, {20, -30, 600}), 36) << z;
  }
}

TEST(Distribute, HoldsAtTheExtremesOfDisplays) {
  AnalyticScene scene;
  scene.rectangles = {Plane(0, Constant(0.5F))};
  std::vector<Display> displays;
  Display display = CutTo("paper-one-layer", 24, 24);
  display.layers[0].optics = Barrier{1, 1, 1};  // every emitter behind its own opening
  displays.push_back(display);
  display = CutTo("paper-two-layer", 24, 24);
  display.layers[0].position_mm = 10 - 1e-6;
  display.border_mm = 1e-7;
  displays.push_back(display);
  display = CutTo("paper-two-layer", 24, 24);
  display.layers[0].d0_mm = 0.05;  // another gap than the front layer's: 173 degrees
  displays.push_back(display);
  display = CutTo("paper-two-layer", 24, 24);
  display.viewing_distance_mm = 15.001;
  displays.push_back(display);
  display = CutTo("paper-one-layer", 24, 24);
  display.layers.assign(64, display.layers[0]);
  for (std::size_t i = 0; i < 64; ++i) display.layers[i].position_mm = static_cast<double>(i) - 32;
  displays.push_back(display);
  display = CutTo("paper-one-layer", 6, 2);  // one opening in one slot
  displays.push_back(display);
  for (const Display& d : displays) {
    Check(d, "test");
    const LayerImages images = Distribute(scene, d, Options(1, 1), SilentProgress());
    EXPECT_GT(images.seen_share, 0.99);
    std::vector<double> positions;
    for (const Layer& layer : d.layers) positions.push_back(layer.position_mm + d.border_offset_mm);
    const LayerWeights weights(positions, d.border_mm);
    for (std::size_t layer = 0; layer < d.layers.size(); ++layer) {
      for (const EmitterImage& image : images.slots[layer]) {
        const double weight = static_cast<double>(weights.Weight(static_cast<int>(layer), 0));
        for (std::size_t i = 0; i < image.color.size(); ++i) {
          if (image.coverage.data()[i] == 0) continue;
          EXPECT_NEAR(static_cast<double>(image.color.data()[i].g), 0.5 * weight, 1e-5);
        }
      }
    }
  }
}

TEST(Distribute, PutsBordersWhereTheDisplayOrTheOptionHasThem) {
  Display display = CutTo("paper-two-layer", 48, 36);
  EXPECT_EQ(display.border_offset_mm, 0);  // the paper's display, the paper's rule
  AnalyticScene scene;
  scene.rectangles = {Plane(-1, Constant(1))};
  LayersOptions options = Options(1, 1);
  const auto back_share = [&] {
    const LayerImages images = Distribute(scene, display, options, SilentProgress());
    const float back = images.slots[0][4].color(20, 15).g;
    EXPECT_NEAR(images.slots[1][4].color(20, 15).g, 1 - back, 1e-5F);
    return back;
  };
  EXPECT_NEAR(back_share(), 0.75F, 1e-5F);
  options.border_offset_mm = -1;
  EXPECT_NEAR(back_share(), 0.5F, 1e-5F);
  options.border_offset_mm.reset();
  display.border_offset_mm = -4;
  EXPECT_NEAR(back_share(), 0, 1e-5F);
}

TEST(Distribute, RefusesABorderWiderThanTheSpacing) {
  LayersOptions options = Options(1, 1);
  options.border_mm = 20.5;
  EXPECT_THROW(Distribute(Counter(), CutTo("paper-two-layer", 24, 24), options, SilentProgress()),
               Error);
}

}  // namespace
}  // namespace lamella
