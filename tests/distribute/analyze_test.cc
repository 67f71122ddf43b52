#include "distribute/analyze.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/analyze_scene.h"
#include "distribute/displays.h"
#include "lightfield/bandwidth.h"
#include "lightfield/error.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/parallel.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

Display Preset(const char* name) { return FindDisplay(name); }

Analysis Of(const Display& display) { return Analyze(display, DepthsWorthALook(display)); }

std::size_t IndexOf(const Analysis& analysis, double z) {
  const auto at =
      std::min_element(analysis.depths_mm.begin(), analysis.depths_mm.end(),
                       [&](double a, double b) { return std::abs(a - z) < std::abs(b - z); });
  EXPECT_NEAR(*at, z, 1e-9);
  return static_cast<std::size_t>(at - analysis.depths_mm.begin());
}

// One layer with 12 directions and a lattice of 6 px, or `layers` of the same lattice and field of
// view with `layers` times the emitters' pitch that share its range.
Display EqualRange(int layers) {
  Display display = FindDisplay("paper-one-layer");
  const Layer layer = display.layers[0];
  const double range = 6 * layer.d0_mm;
  display.layers.clear();
  display.binning_px = layers;
  display.border_mm = 0;
  for (int l = 0; l < layers; ++l) {
    Layer& one = display.layers.emplace_back(layer);
    one.optics = Barrier{12 / layers, 2, 2};
    one.position_mm = -range + (2 * l + 1) * range / layers;
  }
  return display;
}

TEST(Analyze, CountsRaysBitsAndLight) {
  const DisplayTotals two = TotalsOf(Preset("paper-two-layer"), std::nullopt);
  EXPECT_EQ(two.rays, 2.0 * 1920 * 1080 * 9);
  EXPECT_EQ(two.bits, 2.0 * 1920 * 1080 * 24 * 9);
  EXPECT_NEAR(two.light_efficiency, 1.0 / 18, 1e-12);
  // Its projector shows 24 planes as the bits of one RGB frame a stroke.
  const DisplayTotals varifocal = TotalsOf(Preset("paper-varifocal"), 16);
  EXPECT_EQ(varifocal.bits, 1024.0 * 768 * 24 * 16);
  EXPECT_NEAR(varifocal.light_efficiency, 1.0 / 24, 1e-12);
  EXPECT_EQ(Analyze(Preset("paper-varifocal"), {-100, 100}, 16).totals.bits, varifocal.bits);
}

TEST(Analyze, HasTheNumbersOfTheReferenceForThePapersTwoLayers) {
  const Analysis analysis = Of(Preset("paper-two-layer"));
  ASSERT_EQ(analysis.layers.size(), 2U);
  for (const LayerFigures& layer : analysis.layers) {
    EXPECT_NEAR(layer.field_of_view_deg, 21.16065183, 1e-7);
    EXPECT_NEAR(layer.sharp_range_mm, 10, 1e-9);
    EXPECT_NEAR(layer.sharpest_mm - layer.position_mm, -4, 1e-9);
    EXPECT_NEAR(layer.light_efficiency, 1.0 / 18, 1e-12);
    EXPECT_EQ(layer.directions_per_axis, 6);
    EXPECT_EQ(layer.rays, 1920.0 * 1080 * 9);
  }
  // view_spacing of the vectors is 37.35790646 at 600 mm from the modulating plane.
  EXPECT_NEAR(analysis.layers[0].view_spacing_mm, 37.35790646 * 610 / 600, 1e-7);
  EXPECT_NEAR(analysis.layers[1].view_spacing_mm, 37.35790646 * 590 / 600, 1e-7);
  // simulation.md section 5 has 56 mm at 600 mm.
  EXPECT_NEAR(analysis.clean_eye_box.x_mm, 56.0369 * 590 / 600, 1e-3);
  ASSERT_EQ(analysis.sharp.size(), 1U);
  EXPECT_NEAR(analysis.sharp[0].from_mm, -20, 1e-9);
  EXPECT_NEAR(analysis.sharp[0].to_mm, 20, 1e-9);
}

TEST(Analyze, CutoffIsThatOfTheVectors) {
  // Cases `cutoff` and `cutoff_multi` with z = 20.
  const Analysis one = Of(Preset("paper-one-layer"));
  EXPECT_NEAR(one.combined[IndexOf(one, 20)], .4015214294, 1e-9);
  const Analysis half = Of(Preset("paper-two-layer-half"));
  EXPECT_NEAR(half.combined[IndexOf(half, 20)], .2676809529, 1e-9);
  for (double z = -10; z <= 10; z += 0.5) {
    EXPECT_NEAR(CombinedCutoffPerMm(Preset("paper-two-layer-half"), z),
                1 / (4 * 0.3113158871666749), 1e-9);
  }
  EXPECT_EQ(
      CombinedCutoffPerMm(Preset("paper-one-layer"), -std::numeric_limits<double>::infinity()), 0);
}

TEST(Analyze, RaysFollowThePapersLaw) {
  const double rays_of_one = Of(EqualRange(1)).totals.rays;
  for (const int layers : {1, 2, 3, 6}) {
    const Analysis analysis = Of(EqualRange(layers));
    ASSERT_TRUE(analysis.rays_to_one_layer);
    EXPECT_NEAR(*analysis.rays_to_one_layer, 1.0 / layers, 1e-9);
    EXPECT_NEAR(analysis.totals.rays / rays_of_one, 1.0 / layers, 1e-9);  // counted
    EXPECT_NEAR(analysis.sharp[0].from_mm, -30, 1e-9);
    EXPECT_NEAR(analysis.sharp[0].to_mm, 30, 1e-9);
    EXPECT_NEAR(analysis.layers[0].lattice_pitch_mm, 6 * 0.3113158871666749, 1e-9);
  }
  // Twice the range with as many rays per layer: half of what one layer would need.
  EXPECT_NEAR(*Of(Preset("paper-two-layer")).rays_to_one_layer, 0.5, 1e-9);
  // One axis of parallax saves nothing.
  Display lenticular{"l", 300, 200, 0.1, 1, 600, false, 0, 0, {}};
  lenticular.layers = {{-1, 2, Lenticular{6, 0.1, 6}, false}, {1, 2, Lenticular{6, 0.1, 6}, false}};
  const double range = SharpRangeMm(lenticular, lenticular.layers[0]);
  lenticular.layers[0].position_mm = -range;
  lenticular.layers[1].position_mm = range;
  const Analysis analysis = Of(lenticular);
  EXPECT_EQ(analysis.parallax_axes, 1);
  EXPECT_NEAR(*analysis.rays_to_one_layer, 1, 1e-9);
  // Gaps leave no such number.
  lenticular.layers[1].position_mm = 4 * range;
  EXPECT_FALSE(Of(lenticular).rays_to_one_layer);
}

TEST(Analyze, MtfIsThatOfTheVectors) {
  // Cases `mtf_single`, `blur_widths` of a 27" panel, w_x = 2p, w_u = p, d0 = 5, one layer.
  Display display = Preset("paper-one-layer");
  const Analysis analysis = Of(display);
  const auto sinc = [](double t) {
    return t == 0 ? 1.0 : std::sin(std::numbers::pi * t) / (std::numbers::pi * t);
  };
  const double p = display.pitch_mm;
  for (std::size_t i = 0; i < analysis.depths_mm.size(); ++i) {
    const double z = analysis.depths_mm[i];
    for (std::size_t f = 0; f < 3; ++f) {
      const double c = analysis.frequencies[f];
      const double barrier = std::abs(sinc(c * 2 * p * std::abs(1 + z / 5)) * sinc(c * p * z / 5));
      const double lens = std::abs(sinc(c * 2 * p) * sinc(c * p * z / 5));
      EXPECT_NEAR(analysis.mtf.single[f][i], barrier, 1e-9);
      EXPECT_NEAR(analysis.mtf.both[f][i], barrier * barrier, 1e-9);
      EXPECT_NEAR(analysis.paper_mtf.single[f][i], lens, 1e-9);
      EXPECT_NEAR(analysis.paper_mtf.fixed_eye[f][i], lens * std::abs(sinc(c * 2 * p)), 1e-9);
    }
  }
  EXPECT_TRUE(analysis.mtf.fixed_eye.empty());
  EXPECT_NEAR(analysis.frequencies[2], 1 / (4 * p), 1e-12);
}

TEST(Analyze, BeamsCutOffIsTheFrequencyOfHalfACyclePerWidth) {
  // Lenses with their focus on the emitters and as wide as the lattice: Eq. 1 itself.
  const Analysis lenses = Of(Preset("paper-varifocal"));
  for (std::size_t i = 0; i < lenses.depths_mm.size(); ++i) {
    EXPECT_NEAR(lenses.combined_beam[i], lenses.combined[i], 1e-9);
  }
  // 2-px pinholes: as fine as the lattice from z_l - 10 to z_l, a third of it at z_l + 10.
  const Analysis barrier = Of(Preset("paper-one-layer"));
  const double lattice = barrier.frequencies[2];
  EXPECT_NEAR(barrier.combined_beam[IndexOf(barrier, -10)], lattice, 1e-9);
  EXPECT_NEAR(barrier.combined_beam[IndexOf(barrier, 0)], lattice, 1e-9);
  EXPECT_NEAR(barrier.combined_beam[IndexOf(barrier, 10)], lattice / 3, 1e-9);
}

// The farthest eye from which every line of sight through an opening meets a window of that very
// opening, found by trying: steps of 0.1 mm.
double BoxByTrying(const Display& display, int layer) {
  const RayMap map(display, layer);
  const double pitch = display.emitter_pitch_mm(),
               distance = display.distance_mm(display.layers[0]);
  for (double e = 0; e < 200; e += 0.1) {
    for (int column = 0; column < map.columns(); ++column) {
      for (const double part : {-0.499, 0.499}) {
        const double x = map.ColumnCentre(column) + part * pitch;
        const auto hit = map.SeenColumn(x, (e - x) / distance);
        if (!hit) continue;
        const auto beam = map.Column(hit->slot, hit->emitter);
        // An emitter that no window claims is missed at a shear's step, not a neighbour's.
        if (beam && std::abs(beam->element_mm - x) > beam->aperture_mm / 2) return e;
      }
    }
  }
  return 200;
}

TEST(CleanEyeBoxOf, IsWhereNoNeighboursWindowIsSeenThroughABarrier) {
  Display display = Preset("paper-one-layer");
  display.width_px = 600;
  display.height_px = 60;
  const double tried = BoxByTrying(display, 0);
  const double box = CleanEyeBoxOf(display, display.layers[0]).x_mm;
  EXPECT_NEAR(box, 56.04, 0.01);
  // The rounding's half is the worst case.
  EXPECT_GE(tried, box);
  EXPECT_LT(tried, box + 19);
  display.shear = false;
  display.width_px = 120;
  // No whole opening is centred at the panel's very edge.
  const double parallel = CleanEyeBoxOf(display, display.layers[0]).x_mm;
  EXPECT_GT(parallel, 50);
  EXPECT_GE(BoxByTrying(display, 0), parallel);
  EXPECT_LT(BoxByTrying(display, 0), parallel + 7 * display.pitch_mm);
}

TEST(CleanEyeBoxOf, IsWhereLensesShowTheirOwnLitPixels) {
  Display display = Preset("paper-varifocal");
  display.width_px = 520;  // the whole panel leaves next to nothing
  display.height_px = 390;
  const LensletMap map(display, 12);
  const Layer& layer = display.layers[12];
  const double half = display.width_mm() / 2, distance = display.distance_mm(layer);
  double tried = 0;
  for (bool clean = true; clean && tried < 200; tried += 0.1) {
    for (double x = -half; x < half; x += 0.2) {
      const auto hit = map.See(x, 0, (tried - x) / distance, 0);
      if (hit && hit->guard) clean = false;
    }
  }
  const double box = CleanEyeBoxOf(display, layer).x_mm;
  EXPECT_NEAR(box, tried, 2.5);  // no lens's centre is at the panel's very edge
  EXPECT_GT(box, 20);
  EXPECT_GE(tried, box);
}

TEST(Analyze, TakesEveryKindOfDisplayAndRefusesBrokenOnes) {
  for (const std::string& name : DisplayNames()) {
    const Analysis analysis = Of(FindDisplay(name));
    EXPECT_TRUE(std::is_sorted(analysis.depths_mm.begin(), analysis.depths_mm.end()));
    for (const double cutoff : analysis.combined) EXPECT_GT(cutoff, 0);
    for (const auto& row : analysis.mtf.both) {
      for (const double value : row) EXPECT_TRUE(value >= 0 && value <= 1 + 1e-6) << value;
    }
  }
  Display relay = Preset("paper-varifocal");
  relay.varifocal->relay_focal_mm = 300;
  relay.layers = PlanesOf(*relay.varifocal, relay.layers[0]);
  EXPECT_FALSE(Of(relay).rays_to_one_layer);
  Display broken = Preset("paper-one-layer");
  broken.layers[0].d0_mm = -1;
  EXPECT_THROW(Analyze(broken, {-1, 1}), Error);
}

// A picture of two gratings with whole periods in a block, at one depth or at two.
struct Gratings {
  double coarse, fine;            // cycles per 32 px
  double coarse_half, fine_half;  // amplitudes
};

Image<Rgb> Picture(const Gratings& g, bool upright = false) {
  Image<Rgb> picture(128, 96);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      const double t = 2 * std::numbers::pi * ((upright ? y : x) + 0.5) / 32;
      const auto v = static_cast<float>(0.5 + g.coarse_half * std::cos(g.coarse * t) +
                                        g.fine_half * std::cos(g.fine * t));
      picture(x, y) = {v, v, v};
    }
  }
  return picture;
}

// A view whose pixel is 0.2 mm on z = 0, with z = 600 - Z.
Placement Plain() {
  Placement placement;
  placement.viewing_distance_mm = 600;
  placement.a = 1;
  placement.mm_per_view_px = 0.2;
  return placement;
}

SceneFigures FiguresOf(const Display& display, const Image<Rgb>& picture,
                       const Image<float>& depth) {
  return AnalyzeScene(display, Of(display), Plain(), picture.span(), depth.span());
}

double Kept(const Display& display, const Image<Rgb>& picture, const Image<float>& depth) {
  return FiguresOf(display, picture, depth).detail_kept.value();
}

TEST(AnalyzeScene, DetailKeptIsTheShareOfTheGratingsEnergyBelowTheCutOff) {
  // On z = 0 the cut-off is 0.803 c/mm = 5.14 cycles per 32 px of 0.2 mm; at z = 40 a quarter of
  // that: 0.2008 c/mm, 1.2 cycles per 32 px of 0.1867 mm.
  const Display display = Preset("paper-one-layer");
  const Gratings gratings{3, 10, 0.2, 0.1};
  const Image<Rgb> picture = Picture(gratings);
  const Image<float> at_0(64, 48, 600.0F), at_40(64, 48, 560.0F);
  EXPECT_NEAR(Kept(display, picture, at_0), 0.8, 1e-5);
  EXPECT_NEAR(Kept(display, picture, at_40), 0, 1e-5);
  // The pinholes' own beams: at z = 10 three lattices wide. Under the window a sixth of the coarse
  // grating's energy falls into bin 2, which begins at 1.5.
  const Image<float> at_10(64, 48, 590.0F);
  const double limit = 32 * 0.2 * (590.0 / 600) / (2 * 6 * 0.3113158871666749);
  EXPECT_NEAR(Kept(display, picture, at_10), 0.8, 1e-5);
  EXPECT_NEAR(FiguresOf(display, picture, at_10).detail_kept_beam.value(), 0.8 / 6 * (limit - 1.5),
              1e-5);
  EXPECT_NEAR(FiguresOf(display, picture, at_0).detail_kept_beam.value(), 0.8, 1e-5);
  // Two thirds of the columns unknown, the rest at z = 0; then half known at 40, half at 0.
  Image<float> part(128, 96, 0.0F), mixed(128, 96, 600.0F);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; x += 3) part(x, y) = 600;
    for (int x = 0; x < 128; x += 2) mixed(x, y) = 560;
  }
  EXPECT_NEAR(Kept(display, picture, part), 0.8, 1e-5);
  EXPECT_NEAR(Kept(display, picture, mixed), 0.4, 1e-5);
}

TEST(AnalyzeScene, OneAxisOfParallaxLimitsDetailAlongItOnly) {
  Display display{"l", 300, 200, 0.2, 1, 600, false, 0, 0, {}};
  display.layers = {{0, 2, Lenticular{6, 0, 6}, false}};  // lenses of 0.4 mm: 1.25 c/mm, 8 bins
  const Image<float> depth(16, 16, 600.0F);
  EXPECT_NEAR(Kept(display, Picture({4, 12, 0.1, 0.1}), depth), 0.5, 1e-5);
  EXPECT_NEAR(Kept(display, Picture({4, 12, 0.1, 0.1}, true), depth), 1, 1e-5);
}

TEST(AnalyzeScene, CountsPixelsByTheirDepthInTheDisplay) {
  const Display display = Preset("paper-one-layer");
  const Analysis analysis = Of(display);  // -20 to 20 mm
  Image<float> depth(10, 10, 0.0F);
  for (int x = 0; x < 10; ++x) {
    depth(x, 0) = 600;                                     // z = 0
    depth(x, 1) = 585;                                     // z = 15
    depth(x, 2) = 500;                                     // z = 100
    depth(x, 3) = std::numeric_limits<float>::infinity();  // behind all
  }
  const Image<Rgb> picture(40, 40, {0.5F, 0.5F, 0.5F});
  const SceneFigures f = AnalyzeScene(display, analysis, Plain(), picture.span(), depth.span());
  EXPECT_NEAR(f.known_share, 0.4, 1e-12);
  EXPECT_NEAR(f.sharp_share, 0.25, 1e-12);
  EXPECT_NEAR(f.share_before, 0.25, 1e-12);
  EXPECT_NEAR(f.share_behind, 0.25, 1e-12);
  double sum = 0;
  for (std::size_t i = 0; i < f.share.size(); ++i) {
    sum += f.share[i];
    const bool is_filled = (f.edges_mm[i] <= 0 && 0 < f.edges_mm[i + 1]) ||
                           (f.edges_mm[i] <= 15 && 15 < f.edges_mm[i + 1]);
    EXPECT_NEAR(f.share[i], is_filled ? 0.25 : 0, 1e-12);
  }
  EXPECT_NEAR(sum, 0.5, 1e-12);
  EXPECT_FALSE(f.detail_kept);  // a grey picture has none
  const SceneFigures none =
      AnalyzeScene(display, analysis, Plain(), picture.span(), Image<float>(4, 4, 0.0F).span());
  EXPECT_EQ(none.known_share, 0);
}

TEST(AnalyzeScene, IsTheSameForAnyNumberOfThreads) {
  const Display display = Preset("paper-two-layer");
  const Image<Rgb> picture = Picture({3.3, 10.7, 0.2, 0.1});
  const Image<float> depth(64, 48, 580.0F);
  const double all = Kept(display, picture, depth);
  const ThreadLimit one(1);
  EXPECT_EQ(Kept(display, picture, depth), all);
}

}  // namespace
}  // namespace lamella
