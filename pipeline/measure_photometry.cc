#include "pipeline/measure_photometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/LU>
#include <fmt/format.h>

#include "calibration/color_difference.h"
#include "calibration/color_match.h"
#include "calibration/covariance.h"
#include "calibration/crosstalk.h"
#include "calibration/initialise.h"
#include "calibration/response_fit.h"
#include "calibration/solve.h"
#include "calibration/state.h"
#include "calibration/vignetting.h"
#include "distribute/displays.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/calibration_record.h"
#include "pipeline/calibration_set_up.h"
#include "pipeline/panel_region.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kLeastViews = 3;
constexpr double kMostMixing = 0.01;  // between two panels of a layer
constexpr double kMostExposureError =
    0.25;                               // of a shutter's times; tone curves make 1 : 8 a 1 : 2.6
constexpr double kGivenFocalSd = 0.03;  // of a focal length as lenses are engraved: a share of it

Calibration GivenCalibration(const MeasurePhotometryOptions& options) {
  if (options.calibration.empty()) return LoadCalibrationSetUp(options.patterns, "").design;
  Calibration calibration = LoadCalibration(options.calibration);
  CheckDesign(calibration, LoadShotList(options.patterns), options.calibration.string());
  return calibration;
}

// Where cameras and layers stood: good to a per cent, which angles and pupils need no better.
struct Standing {
  Structure structure;
  CalibrationState state;
  double distance_sd = 0;  // of the camera's distances: a share of them, as of its focal length

  const LayerState& Layer(int layer) const { return state.layers[static_cast<std::size_t>(layer)]; }
  Vector3d Camera(int view) const {
    return Centre(state.camera_from_world[static_cast<std::size_t>(view)]);
  }
  // From the layer's stack to the camera, of a pixel of its emitter, mm.
  Vector3d ToCamera(int layer, int view, const Eigen::Vector2d& panel_px) const {
    const LayerCalibration& design = structure.design.layers[static_cast<std::size_t>(layer)];
    return Inverse(Layer(layer).world_from_stack) * Camera(view) -
           PanelPoint(design.emitter, panel_px);
  }
};

// In least squares: homographies of boards in small photographs tell it to a tenth only, and with
// it the distance by which a pupil is thrown. Poses are not taken from there: the distortion that
// is fitted along would turn them.
struct SolvedFocal {
  double px = 0, sd = 0;  // sd: a share of it
};
SolvedFocal SolveFocal(const CalibrationState& start, const Structure& structure,
                       const Observations& boards) {
  FreeGroups free;
  free.slip = false;
  const Fit fit = Solve(start, structure, boards, free);
  const LensParameters& lens = fit.state.cameras.front();
  const double focal_px = (lens(0) + lens(1)) / 2;
  const Eigen::MatrixXd covariance = CovarianceOf(fit);
  if (covariance.size() == 0) return {focal_px, 1};
  const Eigen::Index first = fit.columns.camera.front();
  return {focal_px, std::sqrt(covariance.block<2, 2>(first, first).sum()) / 2 / focal_px};
}

std::optional<Standing> FindStanding(const PhotometricLight& light, const Calibration& calibration,
                                     double focal_px) {
  if (light.num_views < kLeastViews && focal_px == 0) return std::nullopt;
  Observations boards = light.boards;
  boards.cameras[0].focal_px = focal_px;
  Structure structure = StructureOf(boards, calibration);
  CalibrationState state = Initialise(boards, structure);
  double distance_sd = kGivenFocalSd;
  if (focal_px == 0) {
    const SolvedFocal focal = SolveFocal(state, structure, boards);
    boards.cameras[0].focal_px = focal.px;
    distance_sd = focal.sd;
    state = Initialise(boards, structure);
  }
  return Standing{std::move(structure), std::move(state), distance_sd};
}

double RadiusOf(const WhiteCell& cell, const PhotometricLight& light) {
  const Eigen::Vector2d half(light.width / 2.0, light.height / 2.0);
  return (cell.image_px - half).squaredNorm() / half.squaredNorm();
}

// Measures layer by layer into a calibration and tells of it.
class Measuring {
 public:
  Measuring(const MeasurePhotometryOptions& options, const PhotometricLight& light,
            MeasuredPhotometry& measured)
      : options_(options),
        light_(light),
        measured_(measured),
        standing_(FindStanding(light, measured.calibration, options.focal_px)) {}

  void Run() {
    for (const std::string& line : light_.left_out) Tell("{} left out", line);
    if (options_.curve == PhotoCurve::kEstimated) {
      Warn(
          "the camera's tone curve was estimated from its exposures, which then differ by {:.1f} "
          "%: "
          "gamma is known to 0.02 at best, and to 0.015 less for every 2 % that they are off",
          100 * light_.curve_rms);
    }
    for (const LayerLight& layer : light_.layers) MeasureResponses(layer);
    MeasureEvenness();
    MeasureColors();
    for (const LayerLight& layer : light_.layers) MeasureCrosstalk(layer);
    WarnOfLenses();
  }

 private:
  template <class... Args>
  void Tell(fmt::format_string<Args...> form, Args&&... args) {
    measured_.lines.push_back(fmt::format(form, std::forward<Args>(args)...));
  }
  template <class... Args>
  void Warn(fmt::format_string<Args...> form, Args&&... args) {
    measured_.warnings.push_back(fmt::format(form, std::forward<Args>(args)...));
  }
  void State(const std::string& of, const char* name, const char* unit, double sd) {
    measured_.deviations.push_back({fmt::format("{} {}", of, name), unit, sd});
  }
  LayerCalibration& Of(const LayerLight& layer) {
    return measured_.calibration.layers[static_cast<std::size_t>(layer.layer)];
  }

  ResponseFit Fit(const std::vector<FlatReading>& readings, const PanelId& panel) const {
    ResponseFit fit = FitResponse(readings, NameOf(panel));
    for (std::size_t e = 1; e < fit.white_light.size(); ++e) {
      const double factor = fit.white_light[e] / fit.white_light[0] / light_.exposures[e];
      if (fit.white_light[e] == 0 || std::abs(factor - 1) <= kMostExposureError) continue;
      throw InputError(NameOf(panel),
                       fmt::format("exposures of 1 : {} come out as 1 : {:.3g}",
                                   light_.exposures[e], factor * light_.exposures[e]),
                       "give linear photographs, whose shutter alone was changed");
    }
    return fit;
  }

  // The dark photographs hold what both closed panels let through, a share s = b_e b_m of white:
  // light L shows as r = (L - s)/(1 - s).
  void MeasureResponses(const LayerLight& layer) {
    const PanelId emitter{layer.layer, PanelId::kEmitter},
        modulator{layer.layer, PanelId::kModulator};
    const ResponseFit emitted = Fit(layer.emitter, emitter),
                      passed = Fit(layer.modulator, modulator);
    double both = 0;
    for (int i = 0; i < 20; ++i) {
      both =
          (emitted.black + (1 - emitted.black) * both) * (passed.black + (1 - passed.black) * both);
    }
    Put(emitted, both, emitter, Of(layer).emitter.photometry);
    Put(passed, both, modulator, Of(layer).modulator->photometry);
    CheckMixing(layer, emitted, passed, both);
  }

  void Put(const ResponseFit& fit, double both, const PanelId& panel, Photometry& photometry) {
    photometry.curve = fit.curve;
    photometry.black = fit.black + (1 - fit.black) * both;
    State(NameOf(panel), "gamma", "", fit.gamma_sd);
    State(NameOf(panel), "black", "", fit.black_sd);
    Tell("{}: gamma {:.4f} (sd {:.4f}), black {:.6f} (sd {:.6f}) of white{}", NameOf(panel),
         fit.gamma, fit.gamma_sd, photometry.black, fit.black_sd,
         fit.curve.kind == ToneCurve::Kind::kTable
             ? fmt::format("; a level is {:.1f} % of white off it, so a table of {} is stored",
                           100 * fit.gamma_residual, fit.curve.table.size())
             : std::string());
  }

  // Light of two panels one before the other is the product of theirs.
  void CheckMixing(const LayerLight& layer, const ResponseFit& emitter,
                   const ResponseFit& modulator, double both) {
    const PatternShot* mixed = nullptr;
    for (const PatternShot& shot : light_.list.shots) {
      if (shot.kind == PatternShot::Kind::kMixed && shot.panel.layer == layer.layer) mixed = &shot;
    }
    if (mixed == nullptr) return;
    const auto level = [&](const ResponseFit& fit) {
      const double code = mixed->pattern.color.g / 255.0;
      const auto at = std::find(fit.levels.begin(), fit.levels.end(), code);
      if (at == fit.levels.end()) return 0.0;
      const double light = fit.light[static_cast<std::size_t>(at - fit.levels.begin())];
      return light + (1 - light) * both;
    };
    const double expected = (level(emitter) * level(modulator) - both) / (1 - both);
    if (!(expected > 0)) return;
    const double off = layer.mixed / layer.white / expected - 1;
    Tell("layer {}: half on half is {:+.2f} % off the product of its panels", layer.layer,
         100 * off);
    if (std::abs(off) > kMostMixing) {
      Warn(
          "layer {}'s panels change each other's light by {:+.1f} %: as polarisers that are not "
          "crossed do, which no response of either can mend",
          layer.layer, 100 * off);
    }
  }

  void MeasureEvenness() {
    if (options_.curve == PhotoCurve::kEstimated) {
      Warn(
          "an estimated tone curve does not tell white from nearly white: fall-off and evenness "
          "stay "
          "as they were, the layers' colours are as they were seen");
      return;
    }
    if (!standing_ || light_.num_views < kLeastViews) {
      Warn(
          "white was photographed from {} position{}: vignetting and fall-off are not told apart, "
          "the layers' colours are as they were seen; 3 or more would do",
          light_.num_views, light_.num_views == 1 ? "" : "s");
      return;
    }
    std::vector<WhiteReading> readings;
    for (const WhiteCell& cell : light_.whites) {
      const Eigen::Vector2d place = PlaceOf(cell);
      readings.push_back({IndexOf(cell.layer), cell.view, place.x(), place.y(), cell.light,
                          cell.variance, RadiusOf(cell, light_), CosineOf(cell)});
    }
    evenness_ = FitEvenness(readings, static_cast<int>(light_.layers.size()),
                            measured_.calibration.display);
    Tell("camera: {:.1f} % of the light is lost in the corners; white fits to {:.2f} % RMS",
         100 * (1 - VignettingAt(*evenness_, 1)), 100 * evenness_->rms);
    for (std::size_t i = 0; i < light_.layers.size(); ++i) {
      const LayerEvenness& even = evenness_->layers[i];
      LayerCalibration& layer = Of(light_.layers[i]);
      layer.emitter.photometry.falloff = std::max(0.0, even.falloff);
      layer.modulator->photometry.falloff = 0;  // the layer's is the sum of both
      layer.emitter.photometry.evenness = even.gains;
      const std::string name = fmt::format("layer {}", light_.layers[i].layer);
      State(name, "fall-off", "", even.falloff_sd);
      State(name, "evenness", "", even.largest_gain_sd);
      const std::vector<double>& gains = even.gains.gains;
      const auto [least, most] = std::minmax_element(gains.begin(), gains.end());
      Tell(
          "layer {}: light falls as cos^{:.3f} (sd {:.3f}); cells of 8 x 5 have {:.1f} to {:.1f} % "
          "of their mean",
          light_.layers[i].layer, even.falloff, even.falloff_sd, 100 * *least, 100 * *most);
    }
  }

  int IndexOf(int layer) const {
    const auto at = std::find_if(light_.layers.begin(), light_.layers.end(),
                                 [&](const LayerLight& light) { return light.layer == layer; });
    return static_cast<int>(at - light_.layers.begin());
  }
  double CosineOf(const WhiteCell& cell) const {
    return standing_->ToCamera(cell.layer, cell.view, cell.panel_px).normalized().z();
  }

  Eigen::Vector2d PlaceOf(const WhiteCell& cell) const {
    const PanelCalibration& panel =
        measured_.calibration.layers[static_cast<std::size_t>(cell.layer)].emitter;
    return {cell.panel_px.x() / panel.width_px, cell.panel_px.y() / panel.height_px};
  }

  // What a viewer straight before an even panel would see of a cell, by what the first position
  // saw.
  double Straightened(const WhiteCell& cell) const {
    if (!evenness_) return 1;
    const auto i = static_cast<std::size_t>(IndexOf(cell.layer));
    const LayerEvenness& even = evenness_->layers[i];
    const Eigen::Vector2d place = PlaceOf(cell);
    return 1 / (VignettingAt(*evenness_, RadiusOf(cell, light_)) *
                std::pow(CosineOf(cell), even.falloff) * GainAt(even.gains, place.x(), place.y()));
  }

  // Columns: the camera's light of full red, green and blue alone. Each was shown with the others
  // at black, and less what closed panels let through.
  Matrix3d ColorsOf(const LayerLight& layer) {
    Matrix3d sum = Matrix3d::Zero();
    int num_cells = 0;  // a panel may be cut off by the picture's edge
    for (const WhiteCell& cell : light_.whites) {
      if (cell.layer != layer.layer || cell.view != 0) continue;
      sum += Straightened(cell) * layer.colors[static_cast<std::size_t>(cell.cell)];
      ++num_cells;
    }
    const double black = Of(layer).emitter.photometry.black;
    const double both = black * Of(layer).modulator->photometry.black;
    const Matrix3d shown = (1 - black) * Matrix3d::Identity() + (black - both) * Matrix3d::Ones();
    return sum / std::max(1, num_cells) * shown.inverse();
  }

  void MeasureColors() {
    std::vector<Matrix3d> colors;
    double gains = 0;
    for (const LayerLight& layer : light_.layers) {
      colors.push_back(ColorsOf(layer));
      gains += Of(layer).gain;
    }
    const std::vector<LayerColors> matched = MatchColors(colors, measured_.calibration.display);
    double brightest = 0;
    for (std::size_t i = 0; i < matched.size(); ++i) {
      LayerCalibration& layer = Of(light_.layers[i]);
      layer.gain = gains * matched[i].gain;
      layer.emitter.photometry.primaries = matched[i].primaries;
      brightest = std::max(brightest, matched[i].gain);
    }
    double difference = 0;
    for (const LayerColors& first : matched) {
      for (const LayerColors& second : matched) {
        const auto lab = [&](const LayerColors& layer) {
          return LabOf(layer.gain / brightest * layer.primaries.rowwise().sum());
        };
        difference = std::max(difference, ColorDifference(lab(first), lab(second)));
      }
    }
    for (std::size_t i = 0; i < matched.size(); ++i) {
      Tell("layer {}: {:.1f} % of the layers' light", light_.layers[i].layer,
           100 * matched[i].gain);
    }
    Tell("whites of the layers differ by {:.1f} (CIEDE2000) before they are matched", difference);
  }

  // Openings are thrown larger on emitters behind them, and so is the camera's pupil through them.
  CrosstalkSetup LinesSetup(int layer, const LayerCalibration& of) const {
    CrosstalkSetup setup{kLinesPeriodPx, of.modulator->pitch_mm / of.emitter.pitch_mm, 0, 0};
    setup.drift_px = std::abs(std::tan(of.rotation_rad.z())) *
                     PatchHeightPx({of.emitter.width_px, of.emitter.height_px});
    if (!standing_) return setup;
    const Eigen::Vector2d middle(of.emitter.width_px / 2.0, of.emitter.height_px / 2.0);
    const double thrown = of.gap_mm / of.index / standing_->ToCamera(layer, 0, middle).z();
    setup.opening_px *= 1 + thrown;
    setup.pupil_px = options_.pupil_mm * thrown / of.emitter.pitch_mm;
    setup.pupil_sd_px = setup.pupil_px * std::hypot(options_.pupil_sd, standing_->distance_sd);
    return setup;
  }

  void MeasureCrosstalk(const LayerLight& layer) {
    if (layer.lines.empty()) {
      Warn("layer {}'s lines are too small in the picture: crosstalk stays as it was", layer.layer);
      return;
    }
    LayerCalibration& of = Of(layer);
    const CrosstalkSetup setup = LinesSetup(layer.layer, of);
    if (setup.pupil_px == 0) {
      Warn(
          "layer {}'s crosstalk holds the camera's pupil: give --pupil-mm, and --focal-px or three "
          "positions",
          layer.layer);
    }
    const PanelId emitter{layer.layer, PanelId::kEmitter};
    const CrosstalkFit fit = FitCrosstalk(layer.lines, setup, NameOf(emitter));
    of.emitter.photometry.crosstalk = fit.kernel;
    State(NameOf(emitter), "spread", "px", fit.spread_sd_px);
    State(NameOf(emitter), "own light", "", fit.own_sd);
    State(NameOf(emitter), "neighbour's light", "", fit.neighbour_sd);
    measured_.crosstalk.push_back({layer.layer, setup.pupil_px, fit.without_pupil, fit.with_pupil});
    Tell(
        "{}: light spreads by {:.3f} px (sd {:.3f}); a neighbouring emitter gives {:.4f} (sd "
        "{:.4f}) of what an eye sees, {:.4f} with the camera's pupil of {:.2f} px (sd {:.2f})",
        NameOf(emitter), fit.spread_px, fit.spread_sd_px, fit.without_pupil(0, 1), fit.neighbour_sd,
        fit.with_pupil(0, 1), setup.pupil_px, setup.pupil_sd_px);
    if (setup.pupil_px > 0) {
      TellShares(layer.layer, "without the camera's pupil", fit.without_pupil);
    }
    TellShares(layer.layer, "with the camera's pupil", fit.with_pupil);
  }

  // Lines tell a spread where all openings of a patch meet the row at one place. Lenses are no
  // whole number of emitters apart: those of a patch see all places, and all lines equally bright.
  void WarnOfLenses() {
    for (std::size_t i = 0; i < measured_.calibration.layers.size(); ++i) {
      const LayerCalibration& layer = measured_.calibration.layers[i];
      const bool is_given = layer.emitter.photometry.crosstalk != SpreadKernel();
      if (!layer.lattice || is_given) continue;
      Warn(
          "layer {}'s crosstalk is not measured, since its lenses show all places of the emitters "
          "side by side: photograph one lit column without the lens sheet and give `crosstalk`",
          i);
    }
  }

  void TellShares(int layer, const char* how, const Eigen::MatrixXd& shares) {
    Tell("layer {}: views (columns) in what an eye before each of them sees (rows), {}, %:", layer,
         how);
    for (Eigen::Index j = 0; j < shares.rows(); ++j) {
      const Eigen::RowVectorXd row = 100 * shares.row(j);
      Tell("  {:2}:{:7.2f}", j, fmt::join(row.begin(), row.end(), ""));
    }
  }

  const MeasurePhotometryOptions& options_;
  const PhotometricLight& light_;
  MeasuredPhotometry& measured_;
  std::optional<Standing> standing_;
  std::optional<Evenness> evenness_;
};

}  // namespace

MeasuredPhotometry MeasurePhotometry(const MeasurePhotometryOptions& options, Progress& progress) {
  MeasuredPhotometry measured;
  measured.calibration = GivenCalibration(options);
  const PhotometricLight light =
      ReadPhotometricPhotos(options.patterns, options.photos, options.curve, progress);
  Measuring(options, light, measured).Run();
  Check(measured.calibration, options.photos.string());
  return measured;
}

}  // namespace lamella
