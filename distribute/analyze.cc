#include "distribute/analyze.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "distribute/assign.h"
#include "lightfield/bandwidth.h"

namespace lamella {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kSteps = 200;
constexpr std::size_t kMostLayersWithBends = 64;  // beyond, equal steps are fine enough
constexpr double kTouching = 1e-6;                // of a layer's range: intervals without a gap
constexpr double kAlike = 1e-9;                   // relative

bool Alike(double a, double b) { return std::abs(a - b) <= kAlike * std::abs(a); }

// Half the width in which |e| must lie, by an axis's cell (of what an element can show at all).
double BoxOfAxis(const Display& display, const Layer& layer, double panel_mm, double cell_mm) {
  const AxisBeam beam = MiddleBeam(display, layer);
  const bool lenticular = std::holds_alternative<Lenticular>(layer.optics);
  const double fan = DirectionsPerAxis(layer) * DirectionStepMm(display, layer);
  const double spread = std::abs(beam.kappa_per_mm()) * beam.d0_mm * beam.aperture_mm;
  const double magnified = display.distance_mm(layer) / beam.d0_mm;
  // The panel as seen through the layer's relay.
  const double half_panel = panel_mm * layer.magnification / 2;
  double box = (fan - spread) / 2 * magnified - half_panel;
  if (display.shear && !lenticular) {
    box = (fan - spread - display.emitter_pitch_mm(layer)) / 2 * magnified;
  }
  box = std::min(box, (cell_mm - spread) / 2 * magnified - half_panel);
  return std::max(0.0, box);
}

std::vector<DepthInterval> SharpIntervals(const Display& display) {
  std::vector<DepthInterval> intervals;
  for (const Layer& layer : display.layers) {
    const double range = SharpRangeMm(display, layer);
    intervals.push_back({layer.position_mm - range, layer.position_mm + range});
  }
  std::sort(intervals.begin(), intervals.end(),
            [](const DepthInterval& a, const DepthInterval& b) { return a.from_mm < b.from_mm; });
  std::vector<DepthInterval> merged;
  for (const DepthInterval& interval : intervals) {
    const double touching = kTouching * (interval.to_mm - interval.from_mm);
    if (!merged.empty() && interval.from_mm <= merged.back().to_mm + touching) {
      merged.back().to_mm = std::max(merged.back().to_mm, interval.to_mm);
    } else {
      merged.push_back(interval);
    }
  }
  return merged;
}

LayerFigures FiguresOf(const Display& display, const Layer& layer) {
  LayerFigures f;
  f.position_mm = layer.position_mm;
  f.d0_mm = layer.seen_d0_mm();
  f.lattice_pitch_mm = LatticePitchMm(display, layer);
  f.direction_step_mm = DirectionStepMm(display, layer);
  f.sharp_range_mm = SharpRangeMm(display, layer);
  f.sharpest_mm = layer.position_mm + SharpestOffsetMm(layer);
  f.field_of_view_deg = FieldOfViewDeg(display, layer);
  f.directions_per_axis = DirectionsPerAxis(layer);
  f.view_spacing_mm = ViewSpacingMm(display, layer, display.distance_mm(layer));
  f.light_efficiency = Brightness(display, layer);
  f.guard_share = GuardShare(layer);
  f.rays = RaysOf(display, layer);
  f.clean_eye_box = CleanEyeBoxOf(display, layer);
  return f;
}

std::optional<double> RaysToOneLayer(const Analysis& analysis) {
  const LayerFigures& first = analysis.layers.front();
  for (const LayerFigures& layer : analysis.layers) {
    if (!Alike(first.lattice_pitch_mm, layer.lattice_pitch_mm) ||
        !Alike(first.direction_step_mm, layer.direction_step_mm) ||
        !Alike(first.d0_mm, layer.d0_mm) || !Alike(first.rays, layer.rays)) {
      return std::nullopt;
    }
  }
  if (analysis.sharp.size() != 1) return std::nullopt;
  const double half_range = (analysis.sharp[0].to_mm - analysis.sharp[0].from_mm) / 2;
  return static_cast<double>(analysis.layers.size()) *
         std::pow(first.sharp_range_mm / half_range, analysis.parallax_axes);
}

std::vector<double> DepthSamples(const Display& display, const DepthInterval& depths) {
  std::vector<double> samples;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    samples.push_back((1 - t) * depths.from_mm + t * depths.to_mm);
  }
  if (display.layers.size() <= kMostLayersWithBends) {
    for (std::size_t l = 0; l < display.layers.size(); ++l) {
      const double z = display.layers[l].position_mm;
      const double range = SharpRangeMm(display, display.layers[l]);
      samples.insert(samples.end(), {z - range, z, z + range});
      if (l > 0) samples.push_back((display.layers[l - 1].position_mm + z) / 2);
    }
  }
  std::erase_if(samples, [&](double z) { return !depths.Contains(z); });
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return samples;
}

void AddCutoffs(const Display& display, Analysis& analysis) {
  const std::size_t count = analysis.depths_mm.size();
  for (const Layer& layer : display.layers) {
    std::vector<double>& cutoff = analysis.cutoff.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i) {
      cutoff[i] = CutoffPerMm(display, layer, analysis.depths_mm[i] - layer.position_mm);
    }
  }
  for (const double z : analysis.depths_mm) {
    analysis.combined.push_back(CombinedCutoffPerMm(display, z));
    analysis.combined_beam.push_back(CombinedBeamCutoffPerMm(display, z));
  }
}

// One of the rows: the mean of a closed form over the layers that show a depth.
template <class Form>
std::vector<std::vector<double>> Row(const Display& display, const Analysis& analysis,
                                     const std::vector<AxisBeam>& beams, Form form) {
  const LayerWeights weights = WeightsOf(display);
  std::vector<std::vector<double>> row;
  for (const double frequency : analysis.frequencies) {
    std::vector<double>& values = row.emplace_back();
    for (const double z : analysis.depths_mm) {
      double sum = 0;
      for (std::size_t l = 0; l < beams.size(); ++l) {
        const double weight =
            static_cast<double>(weights.Weight(static_cast<int>(l), static_cast<float>(z)));
        if (weight == 0) continue;
        sum += weight * form(beams[l], z - display.layers[l].position_mm, frequency);
      }
      values.push_back(sum);
    }
  }
  return row;
}

MtfRows Rows(const Display& display, const Analysis& analysis, const std::vector<AxisBeam>& beams) {
  MtfRows rows;
  rows.single = Row(display, analysis, beams, Mtf);
  rows.both = Row(display, analysis, beams, ChainMtf);
  const bool collimated = std::all_of(beams.begin(), beams.end(), [](const AxisBeam& beam) {
    return std::abs(beam.kappa_per_mm() * beam.d0_mm) < kAlike;
  });
  if (collimated) rows.fixed_eye = Row(display, analysis, beams, FixedEyeChainMtf);
  return rows;
}

void AddMtf(const Display& display, Analysis& analysis) {
  double nyquist = 0;
  std::vector<AxisBeam> own, paper;
  for (const Layer& layer : display.layers) {
    const double pitch = LatticePitchMm(display, layer);
    nyquist = std::max(nyquist, 1 / (2 * pitch));
    own.push_back(MiddleBeam(display, layer));
    AxisBeam lens;
    lens.aperture_mm = pitch;
    lens.emitter_width_mm = DirectionStepMm(display, layer);
    lens.d0_mm = ReachMm(display, layer);
    lens.power_per_mm = 1 / lens.d0_mm;
    paper.push_back(lens);
  }
  analysis.frequencies = {nyquist / 4, nyquist / 2, nyquist};
  analysis.mtf = Rows(display, analysis, own);
  analysis.paper_mtf = Rows(display, analysis, paper);
}

}  // namespace

AxisBeam MiddleBeam(const Display& display, const Layer& layer) {
  AxisBeam beam;
  beam.d0_mm = layer.seen_d0_mm();
  beam.aperture_mm = LatticePitchMm(display, layer);  // lenses and bare pixels fill their lattice
  beam.emitter_width_mm = display.emitter_pitch_mm(layer);
  if (const auto* barrier = std::get_if<Barrier>(&layer.optics)) {
    beam.aperture_mm = barrier->aperture_px * display.emitter_pitch_mm(layer);
  } else if (const auto* lenslets = std::get_if<LensletArray>(&layer.optics)) {
    beam.power_per_mm = LensPowerPerMm(layer, lenslets->focal_mm);
  } else if (const auto* lenticular = std::get_if<Lenticular>(&layer.optics)) {
    beam.emitter_width_mm /= 3;
    beam.power_per_mm = LensPowerPerMm(layer, lenticular->focal_mm);
  } else if (const auto* bare = std::get_if<BarePanel>(&layer.optics)) {
    beam.d0_mm = -ReachMm(display, layer);  // its eye box is in front
    beam.emitter_width_mm = bare->eye_box_mm;
  }
  return beam;
}

Beam MiddleBeams(const Display& display, const Layer& layer) {
  Beam beams{MiddleBeam(display, layer), MiddleBeam(display, layer)};
  if (std::holds_alternative<Lenticular>(layer.optics)) {
    const double towards_viewer = display.shear ? 1 / display.distance_mm(layer) : 0;
    beams.y.aperture_mm = display.emitter_pitch_mm(layer);
    beams.y.emitter_width_mm = 0;
    beams.y.power_per_mm = 1 / beams.y.d0_mm + towards_viewer;
  }
  return beams;
}

EyeRectangle CleanEyeBoxOf(const Display& display, const Layer& layer) {
  if (const auto* bare = std::get_if<BarePanel>(&layer.optics)) {
    return {bare->eye_box_mm / 2, bare->eye_box_mm / 2};
  }
  const double pitch = display.emitter_pitch_mm(layer);
  EyeRectangle box;
  if (const auto* lenses = std::get_if<Lenticular>(&layer.optics)) {
    // A lens is shifted by the slant between the panel's middle and its upper edge, as seen.
    const double panel = display.width_mm() + std::abs(lenses->slant) * display.height_mm();
    box.x_mm = BoxOfAxis(display, layer, panel, kInfinity);
    box.y_mm = kInfinity;
    return box;
  }
  const auto* lenses = std::get_if<LensletArray>(&layer.optics);
  const double cell_x = lenses != nullptr ? lenses->pitch_px * pitch : kInfinity;
  const double cell_y = lenses != nullptr ? lenses->row_pitch_px() * pitch : kInfinity;
  box.x_mm = BoxOfAxis(display, layer, display.width_mm(), cell_x);
  box.y_mm = BoxOfAxis(display, layer, display.height_mm(), cell_y);
  return box;
}

double RaysOf(const Display& display, const Layer& layer) {
  const double emitters = 1.0 * display.emitter_columns() * display.emitter_rows();
  if (std::holds_alternative<Lenticular>(layer.optics)) return 3 * emitters;
  const int slots = SlotsPerAxis(layer);
  return emitters * (1 - GuardShare(layer)) * slots * slots;
}

DisplayTotals TotalsOf(const Display& display, const std::optional<int>& strokes) {
  constexpr double kBitsOfColors = 3 * 8;
  const double pixels = 1.0 * display.width_px * display.height_px;
  DisplayTotals totals;
  for (const Layer& layer : display.layers) {
    const double slots = 1.0 * SlotsPerAxis(layer) * SlotsPerAxis(layer);
    totals.rays += RaysOf(display, layer);
    totals.bits += pixels * slots * (strokes ? 1.0 * *strokes : kBitsOfColors);
    totals.light_efficiency +=
        Brightness(display, layer) / static_cast<double>(display.layers.size());
  }
  return totals;
}

DepthInterval DepthsWorthALook(const Display& display) {
  constexpr double kNearest = 0.9, kFarthest = 10;  // viewing distances
  const std::vector<DepthInterval> sharp = SharpIntervals(display);
  DepthInterval depths{sharp.front().from_mm, sharp.front().to_mm};
  for (const DepthInterval& interval : sharp) {
    depths.to_mm = std::max(depths.to_mm, interval.to_mm);
  }
  const double beside = (depths.to_mm - depths.from_mm) / 2;
  const double back = display.layers.front().position_mm, front = display.layers.back().position_mm;
  const double distance = display.viewing_distance_mm;
  depths.from_mm = std::min(back, std::max(depths.from_mm - beside, -kFarthest * distance));
  depths.to_mm = std::max(front, std::min(depths.to_mm + beside, kNearest * distance));
  return depths;
}

Analysis Analyze(const Display& display, const DepthInterval& depths,
                 const std::optional<int>& strokes) {
  Check(display, display.name);
  Analysis analysis;
  analysis.totals = TotalsOf(display, strokes);
  analysis.clean_eye_box = {kInfinity, kInfinity};
  for (const Layer& layer : display.layers) {
    const LayerFigures figures = FiguresOf(display, layer);
    if (std::holds_alternative<Lenticular>(layer.optics)) analysis.parallax_axes = 1;
    EyeRectangle& box = analysis.clean_eye_box;
    box.x_mm = std::min(box.x_mm, figures.clean_eye_box.x_mm);
    box.y_mm = std::min(box.y_mm, figures.clean_eye_box.y_mm);
    analysis.layers.push_back(figures);
  }
  analysis.sharp = SharpIntervals(display);
  analysis.rays_to_one_layer = RaysToOneLayer(analysis);
  analysis.depths_mm = DepthSamples(display, depths);
  AddCutoffs(display, analysis);
  AddMtf(display, analysis);
  return analysis;
}

double CombinedCutoffPerMm(const Display& display, double z_mm) {
  double best = 0;
  for (const Layer& layer : display.layers) {
    best = std::max(best, CutoffPerMm(display, layer, z_mm - layer.position_mm));
  }
  return best;
}

double CombinedBeamCutoffPerMm(const Display& display, double z_mm) {
  double best = 0;
  for (const Layer& layer : display.layers) {
    best = std::max(best, BeamCutoffPerMm(MiddleBeam(display, layer), z_mm - layer.position_mm,
                                          LatticePitchMm(display, layer)));
  }
  return best;
}

}  // namespace lamella
