// The published test vectors of displays (displays.json: closed forms that agree with ray casting,
// counting and quadrature), against the program's own functions.
#include <cmath>
#include <fstream>
#include <functional>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/assign.h"
#include "distribute/displays.h"
#include "distribute/encode_barrier.h"
#include "distribute/panel_response.h"
#include "lightfield/bandwidth.h"
#include "lightfield/color.h"
#include "lightfield/display.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/lenticular_map.h"
#include "lightfield/looking_glass.h"
#include "lightfield/quilt.h"
#include "lightfield/ray_map.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

using Json = nlohmann::json;
using Numbers = std::vector<double>;

// A display of one layer, wide enough for every case.
Display OneLayer(double pitch, double d0, Barrier barrier = {1, 1, 1}, double position = 0,
                 int width = 1920) {
  Display display{"vector", width, 1080, pitch, 1, 1e4, false, 0, 0, {}};
  display.layers = {{position, d0, barrier, false}};
  return display;
}

Barrier BarrierOf(const Json& in) {
  const int period = in.at("P"), aperture = in.at("a");
  return {period, aperture, in.value("k", 1)};
}

AxisBeam BeamOf(double element, double emitter, double d0) {
  return {0, element, 0, emitter, 0, d0};
}

Numbers PixelCentre(const Json& in) {
  Display display = OneLayer(in.at("p"), 5, {1, 1, 1}, 0, in.at("w"));
  display.height_px = in.at("h");
  const RayMap map(display, 0);
  return {map.ColumnCentre(in.at("i")), map.RowCentre(in.at("r"))};
}

Numbers RayPair(const Json& in) {
  const double offset = in.at("zq").get<double>() - in.at("zl").get<double>(), d0 = in.at("d0");
  const AxisBeam x = BeamOf(in.at("xm"), in.at("xe"), d0), y = BeamOf(in.at("ym"), in.at("ye"), d0);
  return {x.slope() * d0, y.slope() * d0, x.At(offset), y.At(offset)};
}

// "lenslet" of the vectors has its focus on the emitters.
AxisBeam ModelBeam(const Json& in) {
  const double d0 = in.at("d0"), power = in.at("model") == "barrier" ? 0 : 1 / d0;
  return {0, 0, in.at("wx"), 0, in.at("wu"), d0, power};
}

Numbers BlurWidths(const Json& in) {
  const AxisBeam beam = ModelBeam(in);
  const double opening = beam.OpeningBlurMm(in.at("delta"));
  const double emitter = beam.EmitterBlurMm(in.at("delta"));
  return {opening, emitter, std::sqrt((opening * opening + emitter * emitter) / 12)};
}

AxisBeam ChainBeam(const Json& in) {
  const double d0 = in.at("d0");
  return {0, 0, in.at("dx"), 0, in.at("du"), d0, 1 / d0};
}

Numbers EmitterSeen(const Json& in) {
  const RayMap map(OneLayer(in.at("p"), in.at("d0"), {1, 1, 1}, in.at("zl"), in.at("w")), 0);
  const double x = in.at("xpin"), eye = in.at("ex");
  const double slope = (eye - x) / (in.at("D").get<double>() - in.at("zl").get<double>());
  return {static_cast<double>(map.SeenColumn(x, slope).value().emitter)};
}

Numbers BarrierRays(const Json& in) {
  const Barrier barrier = BarrierOf(in);
  const RayMap map(OneLayer(in.at("p"), 5, barrier), 0);
  Numbers rays;
  for (int column = 0; column < 1920; ++column) {  // all emitters of an opening in the middle
    const auto beam = map.Column(0, column);
    if (beam && beam->opening == 100) rays.push_back(beam->element_mm - beam->emitter_mm);
  }
  return rays;
}

Numbers BarrierSlot(const Json& in) {
  // Two periods more to each side, so that emitters beyond the panel's edge exist here.
  const Barrier barrier = BarrierOf(in);
  const int margin = 2 * barrier.period_px, slot = in.at("s"), opening = in.at("i");
  const Display display = OneLayer(0.3, 5, barrier, 0, 1920 + 2 * margin);
  const RayMap map(display, 0);
  Numbers result;
  for (int c = 0; c < display.width_px && result.empty(); ++c) {
    const bool starts = map.ColumnOpen(slot, c) && !(c > 0 && map.ColumnOpen(slot, c - 1));
    if (starts && c >= margin + barrier.period_px * opening) {
      result.push_back(c - margin);
    }
  }
  int first = -1, last = -1;
  for (int c = 0; c < display.width_px; ++c) {
    const auto beam = map.Column(slot, c);
    if (!beam || beam->opening != opening + 2) continue;
    first = first < 0 ? c : first;
    last = c;
  }
  result.insert(result.end(),
                {static_cast<double>(first - margin), static_cast<double>(last - margin)});
  return result;
}

Numbers BrightnessOf(const Json& in) {
  Display display = OneLayer(0.3, 5, BarrierOf(in));
  display.layers.resize(in.at("n").get<std::size_t>(), display.layers[0]);
  return {Brightness(display, display.layers[0])};
}

Numbers WindowPitch(const Json& in) {
  Display display = OneLayer(in.at("p"), in.at("d0"), {in.at("P"), in.at("P"), 1});
  display.viewing_distance_mm = in.at("D");
  display.shear = true;
  return {WindowPitchMm(display, display.layers[0])};
}

Numbers SlotOrderOf(const Json& in) {
  const int k = in.at("k");
  Numbers result;
  for (const int slot : SlotOrder(k)) {
    const int slot_x = slot % k, slot_y = slot / k;
    result.insert(result.end(), {1.0 * slot_x, 1.0 * slot_y});
  }
  return result;
}

Numbers FuzzyWeights(const Json& in) {
  const LayerWeights weights(in.at("layers").get<Numbers>(), in.at("w"));
  Numbers result;
  for (int l = 0; l < weights.num_layers(); ++l) {
    result.push_back(static_cast<double>(weights.Weight(l, in.at("z").get<float>())));
  }
  return result;
}

// A display whose lattice pitch is any multiple of the emitters'.
Display LatticeDisplay(const Json& in) {
  const double dx = in.at("dx"), du = in.at("du");
  Display display = OneLayer(du, in.at("d0"));
  display.layers[0].optics = LensletArray{LensletArray::Lattice::kSquare, dx / du, 1};
  return display;
}

LensletArray Hexagonal(const Json& in) {
  LensletArray lenses;
  lenses.pitch_px = in.at("Lx");
  lenses.rays = in.value("n", 1);
  return lenses;
}

Numbers HexCentre(const Json& in) {
  const Lens lens = LensOf(Hexagonal(in), in.at("row"), in.at("col"));
  return {lens.x_px, lens.y_px};
}

Numbers HexAssign(const Json& in) {
  const LensletArray lenses = Hexagonal(in);
  const double x = in.at("i").get<int>() + 0.5, y = in.at("j").get<int>() + 0.5;
  const Lens lens = NearestLens(lenses, x, y);
  const std::optional<int> a = RayIndex(x - lens.x_px, lenses.rays);
  const std::optional<int> b = RayIndex(y - lens.y_px, lenses.rays);
  const bool lit = a && b;
  Display display = OneLayer(0.163, 2.92, {1, 1, 1}, 0, 1024);
  display.layers[0].optics = lenses;
  EXPECT_EQ(LensletMap(display, 0).Pixel(in.at("i"), in.at("j")).has_value(), lit) << in;
  return {1.0 * lens.row, 1.0 * lens.column, lit ? *a : -1.0, lit ? *b : -1.0};
}

Numbers HexFill(const Json& in) {
  Layer layer;
  layer.optics = Hexagonal(in);
  return {1 - GuardShare(layer)};
}

Numbers LensSlope(const Json& in) {
  const double offset = in.at("off"), thickness = in.at("t"), index = in.at("n");
  return {ParaxialLensSlope(offset, thickness, index), ExactLensSlope(offset, thickness, index)};
}

Numbers VanBerkel(const Json& in) {
  const Lenticular lenses{in.at("X"), in.at("tan_a"), in.at("N"), in.at("koff")};
  const double view = VanBerkelView(lenses, in.at("k"), in.at("l"));
  return {view, std::floor(view)};
}

Numbers LkgProcessed(const Json& in) {
  LookingGlass calibration;
  calibration.pitch_per_in = in.at("pitch");
  calibration.slope = in.at("slope");
  calibration.dpi = in.at("dpi");
  calibration.width_px = in.at("W");
  calibration.height_px = in.at("H");
  calibration.flip_x = in.at("flip") == 1;
  const LookingGlassWeave weave = WeaveOf(calibration);
  return {weave.lenses, weave.tilt, weave.subpixel};
}

Numbers LkgView(const Json& in) {
  const Json& cal = in.at("cal");
  LookingGlass calibration;
  calibration.pitch_per_in = cal.at("pitch");
  calibration.slope = cal.at("slope");
  calibration.center = cal.at("center");
  calibration.dpi = cal.at("DPI");
  calibration.width_px = cal.at("screenW");
  calibration.height_px = cal.at("screenH");
  calibration.flip_x = cal.value("flipImageX", 0) == 1;
  calibration.cell_pattern = cal.value("CellPatternMode", 0);
  for (const Json& c : cal.value("cells", Json::array())) {
    calibration.cells.push_back({{{c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}}});
  }
  const double view = LookingGlassView(calibration, in.at("x"), in.at("y_top"), in.at("ch"));
  return {view, 1.0 * ViewIndex(view, in.at("N"))};
}

Numbers QuiltTileOf(const Json& in) {
  const Rect tile =
      QuiltTile(in.at("view"), in.at("cols"), in.at("rows"), in.at("qw"), in.at("qh"));
  return {1.0 * tile.x, 1.0 * tile.y, 1.0 * tile.width, 1.0 * tile.height};
}

QuiltCameras CamerasOf(const Json& in) {
  return {in.at("N"), in.at("cone_deg"), in.at("half_h"), in.at("aspect"), in.at("fov_v_deg")};
}

Numbers QuiltCameraOf(const Json& in) {
  const QuiltCamera camera = CameraOf(CamerasOf(in), in.at("i"));
  return {camera.distance, camera.x, camera.shift};
}

Numbers PlaneDepths(const Json& in) {
  Varifocal varifocal;
  varifocal.planes = in.at("N");
  varifocal.depth_mm = in.at("depth");
  if (in.at("mode") == "sinusoidal") varifocal.spacing = Varifocal::Spacing::kSinusoidal;
  return PlaneDepthsMm(varifocal);
}

Numbers PlaneMagnificationOf(const Json& in) {
  Varifocal varifocal;
  varifocal.relay_focal_mm = in.at("f");
  varifocal.magnification0 = in.at("M0");
  return {PlaneMagnification(varifocal, in.at("z"))};
}

Numbers PlaneBits(const Json& in) {
  std::uint32_t planes = 0;
  for (const int plane : in.at("planes")) planes |= 1U << plane;
  const auto codes = PackBitPlanes(planes, in.at("order").get<std::string>());
  return {1.0 * codes[0], 1.0 * codes[1], 1.0 * codes[2]};
}

Numbers SigmaDeltaOf(const Json& in) {
  Numbers bits;
  double accumulator = in.at("acc0");
  for (int t = 0; t < in.at("T"); ++t) bits.push_back(SigmaDelta(in.at("L"), accumulator) ? 1 : 0);
  return bits;
}

Numbers LinearMix(const Json& in) {
  const auto light = [&](const char* key) { return Srgb8ToLinear(in.at(key).get<std::uint8_t>()); };
  const float w = in.at("w");
  return {1.0 * PanelResponse::Srgb().Code(w * light("a8") + (1 - w) * light("b8"))};
}

const std::map<std::string, std::function<Numbers(const Json&)>>& Functions() {
  static const std::map<std::string, std::function<Numbers(const Json&)>> functions = {
      {"panel_pitch", [](const Json&) { return Numbers{FindDisplay("paper-two-layer").pitch_mm}; }},
      {"pixel_centre", PixelCentre},
      {"ray_pair", RayPair},
      {"blur_widths", BlurWidths},
      {"mtf_single",
       [](const Json& in) { return Numbers{Mtf(ModelBeam(in), in.at("delta"), in.at("f"))}; }},
      {"mtf_chain",
       [](const Json& in) { return Numbers{ChainMtf(ChainBeam(in), in.at("delta"), in.at("f"))}; }},
      {"mtf_chain_fixed_eye",
       [](const Json& in) {
         return Numbers{FixedEyeChainMtf(ChainBeam(in), in.at("delta"), in.at("f"))};
       }},
      {"eye_blur",
       [](const Json& in) {
         return Numbers{EyeBlurMm(in.at("A"), in.at("D"), in.at("zf"), in.at("z"))};
       }},
      {"hex_centre", HexCentre},
      {"hex_assign", HexAssign},
      {"hex_fill", HexFill},
      {"lens_slope", LensSlope},
      {"van_berkel", VanBerkel},
      {"lkg_processed", LkgProcessed},
      {"lkg_view", LkgView},
      {"quilt_tile", QuiltTileOf},
      {"quilt_camera", QuiltCameraOf},
      {"quilt_ndc",
       [](const Json& in) {
         return Numbers{QuiltPosition(CamerasOf(in), in.at("i"), in.at("X"), in.at("Z"))};
       }},
      {"plane_depths", PlaneDepths},
      {"plane_magnification", PlaneMagnificationOf},
      {"bitplanes", PlaneBits},
      {"sigma_delta", SigmaDeltaOf},
      {"layer_positions",
       [](const Json& in) { return EqualRangePositionsMm(in.at("n"), in.at("zm")); }},
      {"cutoff_multi",
       [](const Json& in) {
         return Numbers{
             CombinedCutoffPerMm(in.at("z"), in.at("n"), in.at("d0"), in.at("dx"), in.at("du"))};
       }},
      {"ray_ratio",
       [](const Json& in) { return Numbers{RayRatio(in.at("n"), in.at("parallax_axes"))}; }},
      {"emitter_seen", EmitterSeen},
      {"view_spacing",
       [](const Json& in) {
         const Display display = OneLayer(in.at("p"), in.at("d0"));
         return Numbers{ViewSpacingMm(display, display.layers[0], in.at("D"))};
       }},
      {"barrier_rays", BarrierRays},
      {"barrier_slot", BarrierSlot},
      {"barrier_brightness", BrightnessOf},
      {"window_pitch", WindowPitch},
      {"shear_shift_px",
       [](const Json& in) {
         return Numbers{1.0 * ShearShiftPx(in.at("x"), in.at("d0"), in.at("D"), in.at("p"))};
       }},
      {"slot_order", SlotOrderOf},
      {"fov_deg",
       [](const Json& in) {
         const Display display = OneLayer(in.at("extent"), in.at("d0"));
         return Numbers{FieldOfViewDeg(display, display.layers[0])};
       }},
      {"fuzzy_weights", FuzzyWeights},
      {"zmax",
       [](const Json& in) {
         const Display display = LatticeDisplay(in);
         return Numbers{SharpRangeMm(display, display.layers[0])};
       }},
      {"cutoff",
       [](const Json& in) {
         const Display display = LatticeDisplay(in);
         return Numbers{CutoffPerMm(display, display.layers[0], in.at("z"))};
       }},
      {"linear_mix", LinearMix}};
  return functions;
}

Numbers Flat(const Json& json) {
  if (!json.is_array()) return {json.get<double>()};
  Numbers numbers;
  for (const Json& part : json) {
    for (const double number : Flat(part)) numbers.push_back(number);
  }
  return numbers;
}

TEST(Vectors, AreMetByTheProgramsOwnFunctions) {
  std::ifstream file(LAMELLA_DISPLAY_VECTORS);
  const Json document = Json::parse(file);
  std::map<std::string, int> met;
  int all = 0;
  for (const Json& vector : document.at("cases")) {
    const std::string name = vector.at("fn");
    const auto function = Functions().find(name);
    ASSERT_NE(function, Functions().end()) << name;
    const Numbers expected = Flat(vector.at("expect")), got = function->second(vector.at("input"));
    double largest = 1;
    for (const double number : expected) largest = std::max(largest, std::abs(number));
    ASSERT_EQ(got.size(), expected.size()) << vector;
    for (std::size_t i = 0; i < got.size(); ++i) {
      const double rounding = 1e-10 * largest;  // expectations are printed with ten digits
      EXPECT_NEAR(got[i], expected[i], vector.at("tol").get<double>() * largest + rounding)
          << vector;
    }
    ++met[name];
    ++all;
  }
  EXPECT_EQ(all, 198);
  EXPECT_EQ(met.size(), Functions().size());
}

}  // namespace
}  // namespace lamella
