// What distribution allocates against what it was allowed, counted at operator new.
#include "distribute/strips.h"

#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/emitter_beams.h"
#include "tests/allocated.h"

namespace lamella {
namespace {

constexpr double kGib = 1073741824;

// Everything is seen, and an answer takes so many bytes a ray.
class Everything final : public RaySource {
 public:
  explicit Everything(int bytes_per_ray = 0) : bytes_per_ray_(bytes_per_ray) {}
  void Query(const RayBundle&, const Rect&, ImageSpan<RaySample> samples) const override {
    const Image<char> room(bytes_per_ray_ * samples.width, samples.height);
    for (int y = 0; y < samples.height; ++y) {
      for (int x = 0; x < samples.width; ++x) samples(x, y) = {{0.5F, 0.5F, 0.5F}, -3, 1, 1};
    }
  }
  double QueryBytes(int width, int height) const override {
    return static_cast<double>(bytes_per_ray_) * width * height;
  }

 private:
  int bytes_per_ray_;
};

Display Panel(const std::string& name, int width, int height) {
  Display display = FindDisplay(name);
  display.width_px = width;
  display.height_px = height;
  return display;
}

Display WithOptics(const Optics& optics, int width, int height) {
  Display display = Panel("paper-one-layer", width, height);
  display.name = "test";
  display.layers[0].optics = optics;
  display.border_offset_mm = 0;
  return display;
}

double AllocatedFor(const RaySource& source, const Display& display, const LayersOptions& options,
                    const Calibration* calibration, int* rows_of_a_slot) {
  *rows_of_a_slot = 0;
  const Allocated allocated;
  Distribute(
      source, display, options, {},
      [&](const EmitterRows& rows) {
        if (rows.layer == 0 && rows.slot == 0) *rows_of_a_slot += rows.emitters.color.height();
      },
      SilentProgress(), calibration);
  return allocated.PeakBytes();
}

struct MemoryCase {
  const char* name;
  Display display;
  int nodes_per_step = 1;
};

// One display a process: threads keep the rooms for rows that they once had.
class StripsMemory : public testing::TestWithParam<MemoryCase> {};

TEST_P(StripsMemory, IsNoMoreThanItMayBe) {
  const Display& display = GetParam().display;
  for (const int bytes_per_ray : {40, 0}) {
    const Everything source(bytes_per_ray);
    LayersOptions options;
    options.nodes_per_step = GetParam().nodes_per_step;
    const double least = LeastBytes(source, display, options);
    for (const double times : {1.0, 100.0}) {
      options.memory_gib = times * least / kGib;
      int rows = 0;
      const double taken = AllocatedFor(source, display, options, nullptr, &rows);
      EXPECT_LE(taken, times * least) << times;
      if (times == 1) {
        EXPECT_GE(taken, 0.25 * least);
      }
      EXPECT_EQ(rows, display.emitter_rows());
    }
  }
}

Display TwoHexagonalSheets() {
  Display display = Panel("paper-two-layer", 240, 320);
  for (Layer& layer : display.layers) {
    layer.optics = LensletArray{LensletArray::Lattice::kHexagonal, 8, 6};
  }
  return display;
}

INSTANTIATE_TEST_SUITE_P(
    Displays, StripsMemory,
    testing::Values(MemoryCase{"two_barriers", Panel("paper-two-layer", 240, 320)},
                    MemoryCase{"one_barrier", Panel("paper-one-layer", 480, 480)},
                    MemoryCase{"hexagonal",
                               WithOptics(LensletArray{LensletArray::Lattice::kHexagonal, 8, 6},
                                          240, 320)},
                    MemoryCase{"slanted", WithOptics(Lenticular{7.5, 0.17, 9, 0.3}, 60, 320)},
                    MemoryCase{"two_hexagonal", TwoHexagonalSheets()},
                    MemoryCase{"two_barriers_many_nodes", Panel("paper-two-layer", 240, 160), 3},
                    MemoryCase{"two_hexagonal_many_nodes", TwoHexagonalSheets(), 3}),
    [](const auto& memory_case) { return std::string(memory_case.param.name); });

TEST(Strips, TakeNoMoreMemoryThanTheyMayForTheBlur) {
  const Display display = Panel("paper-two-layer", 120, 320);
  const Everything source;
  LayersOptions options;
  options.prefilter = "blur";
  const double least = LeastBytes(source, display, options);
  for (const double times : {1.0, 100.0}) {
    options.memory_gib = times * least / kGib;
    int rows = 0;
    const double taken = AllocatedFor(source, display, options, nullptr, &rows);
    EXPECT_LE(taken, times * least) << times;
    if (times == 1) {
      EXPECT_GE(taken, 0.25 * least);
    }
    EXPECT_EQ(rows, display.emitter_rows());
  }
}

// Emitters of a panel that is askew have beams of their own, which take most of the memory.
TEST(Strips, TakeNoMoreMemoryThanTheyMayForACalibratedDisplay) {
  for (const auto& [display, turn_rad] :
       {std::pair(Panel("paper-two-layer", 36, 200), 0.03),
        {Panel("paper-two-layer", 320, 120), 0.1},  // its rows lean over 32 others
        {WithOptics(LensletArray{LensletArray::Lattice::kHexagonal, 8, 6}, 64, 200), 0.03}}) {
    Calibration calibration = DesignCalibration(display);
    calibration.layers[0].display_from_stack.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    const Everything source;
    LayersOptions options;
    const double least = LeastBytes(source, display, options, &calibration);
    for (const double times : {1.0, 100.0}) {
      options.memory_gib = times * least / kGib;
      int rows = 0;
      const double taken = AllocatedFor(source, display, options, &calibration, &rows);
      EXPECT_LE(taken, times * least) << display.name << " " << times;
      if (times == 1) {
        EXPECT_GE(taken, 0.25 * least) << display.name;
      }
      EXPECT_EQ(rows, display.emitter_rows());
    }
  }
}

TEST(Strips, AreEvenWholeBlocksAndAsFewAsFit) {
  const Display display = Panel("paper-two-layer", 480, 1080);
  std::vector<LayerBeams> beams;
  for (int layer = 0; layer < 2; ++layer) beams.push_back(EnclosingBeamsOf(display, layer));
  const NodeLattice nodes = NodesFor(display, beams, 1, 1, Kernel::kBeam);
  const Everything source;
  const double all = BytesOfStrips(display, nodes, source, false, 1080);
  EXPECT_EQ(StripsOf(display, nodes, source, false, all).size(), 1U);
  for (const double share : {0.95, 0.6, 0.4, 0.25, 0.0}) {
    const std::vector<Strip> strips = StripsOf(display, nodes, source, false, share * all);
    int row = 0;
    for (const Strip& strip : strips) {
      EXPECT_EQ(strip.first_row, row);
      EXPECT_LE(strip.rows(), strips[0].rows());
      row = strip.end_row;
    }
    EXPECT_EQ(row, 1080);
    EXPECT_EQ(strips[0].rows() % kBlockRows, 0);
    const int count = static_cast<int>(strips.size());
    EXPECT_LT(strips[0].rows(), 1080 / count + kBlockRows);
    if (share == 0) {
      EXPECT_EQ(strips[0].rows(), kBlockRows);
      continue;
    }
    EXPECT_LE(BytesOfStrips(display, nodes, source, false, strips[0].rows()), share * all);
    const int fewer = (1080 / (count - 1) + kBlockRows - 1) / kBlockRows * kBlockRows;
    EXPECT_GT(BytesOfStrips(display, nodes, source, false, fewer), share * all);
  }
}

}  // namespace
}  // namespace lamella
