#include "calibration/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <fmt/format.h>

#include "calibration/lattice_model.h"
#include "calibration/lattice_residuals.h"
#include "calibration/lattice_search.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTukey = 4.685;     // deviations: 95 % efficient where errors are normal
constexpr double kGapPriorSd = 0.1;  // of the gap, what a display builder would assume
constexpr double kMostOutliers = 0.35;
constexpr double kMostMisfitPx = 0.03;
constexpr double kLeastApartMm = 100;
constexpr double kShareWithGap = 0.7;  // of the drift, if the gap were known: it is the gap then
constexpr double kLeastScale = 1e-9;
constexpr int kMostIterations = 60;
constexpr int kMostRounds =
    8;                      // of fitting, then leaving out what is off by the deviation of the rest
constexpr int kCells = 12;  // per side of the sheet: errors of one are taken as correlated

// Tukey's weight (1 - d^2/c^2)^2 and its derivative by d^2.
struct TukeyWeight {
  double weight = 0, slope = 0;
  TukeyWeight(double d2, double c2) {
    if (d2 >= c2) return;
    const double rest = 1 - d2 / c2;
    weight = rest * rest;
    slope = -2 * rest / c2;
  }
};

// One sample's part of the equations, all families together.
struct Term {
  double d2 = 0;                            // squared distance from the lattice, deviations
  double nearest2 = 0;                      // half a lens, likewise
  Vector5d gradient = Vector5d::Zero();     // of d^2/2
  Matrix5d information = Matrix5d::Zero();  // of it, Gauss and Newton
};

class LatticeFit {
 public:
  LatticeFit(const std::vector<SheetRay>& rays, const LatticeModel& model, double gap)
      : rays_(rays), model_(model), gap_(gap) {}

  static Term TermOf(const SheetRay& ray, const LatticeModel& model) {
    Term term;
    term.nearest2 = std::numeric_limits<double>::infinity();
    const double half = model.SpacingMm() / 2;
    const Vector2d centre = model.CentreOf(ray);
    for (int a = 0; a < model.num_families(); ++a) {
      const LatticeModel::Residual r = model.ResidualOf(ray, centre, a);
      const double weight = model.FamilyWeight() / (r.sigma * r.sigma);
      term.d2 += weight * r.mm * r.mm;
      term.nearest2 = std::min(term.nearest2, half * half / (r.sigma * r.sigma));
      term.gradient += weight * r.mm * r.slopes;
      term.information += weight * r.slopes * r.slopes.transpose();
    }
    return term;
  }

  // The median deviation from a family's nearest lines, of samples that are off by less than `most`
  // of their own: as a standard deviation.
  double Scale(const Vector5d& at, double most) const {
    const LatticeModel model = model_.At(at);
    std::vector<double> deviations;
    for (const SheetRay& ray : rays_) {
      const LatticeModel::Residual r = model.ResidualOf(ray, model.CentreOf(ray), 0);
      const double deviation = std::abs(r.mm) / r.sigma;
      if (deviation < most) deviations.push_back(deviation);
    }
    if (deviations.empty()) return kLeastScale;
    const auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
    std::nth_element(deviations.begin(), middle, deviations.end());
    return std::max(*middle / 0.6745, kLeastScale);
  }

  // Least squares with Tukey's weights from `at`, samples that are off by `most` deviations, or by
  // half a lens, left out.
  Vector5d Minimise(Vector5d at, double scale, double most) const {
    for (int i = 0; i < kMostIterations; ++i) {
      Matrix5d normal = scale * scale * Prior();
      Vector5d right = scale * scale * PriorGradient(at);
      const LatticeModel model = model_.At(at);
      for (const SheetRay& ray : rays_) {
        const Term term = TermOf(ray, model);
        const double weight = TukeyWeight(term.d2, Bound2(term, most)).weight;
        if (weight == 0) continue;
        normal += weight * term.information;
        right += weight * term.gradient;
      }
      const Vector5d step = Solve(normal, right);
      at -= step;
      // In lenses at the ends of a thousand of them, and of the gap.
      const double change =
          std::max({1e3 * std::abs(step(kLatticePitch)) / at(kLatticePitch),
                    1e3 * std::abs(step(kLatticeRotation)), std::abs(step(kLatticePhase0)),
                    std::abs(step(kLatticePhase1)), std::abs(step(kLatticeGap)) / gap_});
      if (change < 1e-7) break;
    }
    return at;
  }

  // The smallest distance that still counts as off the lattice, squared.
  static double Bound2(const Term& term, double most) {
    return std::min(most * most, term.nearest2);
  }

  // What is known of the gap beforehand.
  Matrix5d Prior() const {
    Matrix5d prior = Matrix5d::Zero();
    prior(kLatticeGap, kLatticeGap) = 1 / (kGapPriorSd * gap_ * kGapPriorSd * gap_);
    if (model_.num_families() == 1) prior(kLatticePhase1, kLatticePhase1) = 1;  // there is none
    return prior;
  }

 private:
  Vector5d PriorGradient(const Vector5d& at) const {
    Vector5d gradient = Vector5d::Zero();
    gradient(kLatticeGap) = (at(kLatticeGap) - gap_) / (kGapPriorSd * gap_ * kGapPriorSd * gap_);
    return gradient;
  }

  // Scaled to a unit diagonal first: mm, radians and lenses differ by orders.
  static Vector5d Solve(const Matrix5d& normal, const Vector5d& right) {
    const Vector5d scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Matrix5d unit = scale.asDiagonal() * normal * scale.asDiagonal();
    return scale.asDiagonal() * unit.ldlt().solve(Vector5d(scale.asDiagonal() * right));
  }

  const std::vector<SheetRay>& rays_;
  const LatticeModel& model_;
  double gap_;
};

// Of an M-estimator: A^-1 B A^-1 with A the cost's second derivative and B the sum of squares of
// its gradients, of cells of the sheet: a camera's blur and the panel's staircase of pixels make
// the errors of neighbours alike.
struct Information {
  Matrix5d curvature;                             // A
  Matrix5d scatter;                               // B
  std::vector<Eigen::Matrix<double, 5, 3>> eyes;  // the gradient's change per mm of each camera
  int num_used = 0;
};

class CellOfSheet {
 public:
  explicit CellOfSheet(const std::vector<SheetRay>& rays) : low_(rays[0].sheet), high_(low_) {
    for (const SheetRay& ray : rays) {
      low_ = low_.cwiseMin(ray.sheet);
      high_ = high_.cwiseMax(ray.sheet);
    }
  }
  std::pair<int, int> operator()(const SheetRay& ray) const {
    const Eigen::Array2d share = (ray.sheet - low_).array() / (high_ - low_).array().max(1e-9);
    const auto cell = [](double s) { return std::min(kCells - 1, static_cast<int>(s * kCells)); };
    return {ray.view, cell(share.x()) * kCells + cell(share.y())};
  }

 private:
  Vector2d low_, high_;
};

Information InformationOf(const LatticeFit& fit, const LatticeModel& model,
                          const std::vector<SheetRay>& rays, const std::vector<Vector3d>& eyes,
                          double scale) {
  Information information{fit.Prior() * scale * scale, fit.Prior() * std::pow(scale, 4), {}, 0};
  information.eyes.assign(eyes.size(), Eigen::Matrix<double, 5, 3>::Zero());
  std::map<std::pair<int, int>, Vector5d> cells;
  const CellOfSheet cell(rays);
  const double dimensions = model.num_directions();
  for (const SheetRay& ray : rays) {
    const Term term = LatticeFit::TermOf(ray, model);
    const TukeyWeight tukey(term.d2, LatticeFit::Bound2(term, kTukey * scale));
    if (tukey.weight == 0) continue;
    ++information.num_used;
    information.curvature += tukey.weight * term.information +
                             2 * tukey.slope * term.gradient * term.gradient.transpose();
    const auto [place, is_new] = cells.try_emplace(cell(ray), Vector5d::Zero());
    place->second += tukey.weight * term.gradient;
    const auto view = static_cast<std::size_t>(ray.view);
    const Vector2d centre = model.CentreOf(ray);
    const double curvature = tukey.weight + 2 * tukey.slope * term.d2 / dimensions;
    for (int a = 0; a < model.num_families(); ++a) {
      const LatticeModel::Residual r = model.ResidualOf(ray, centre, a);
      information.eyes[view] += curvature * model.FamilyWeight() / (r.sigma * r.sigma) * r.slopes *
                                model.SlopesOfEye(ray, eyes[view], a).transpose();
    }
  }
  for (const auto& [place, gradient] : cells) {
    information.scatter += gradient * gradient.transpose();
  }
  return information;
}

Matrix5d CovarianceOf(const Information& information, double eye_sd_mm) {
  const Matrix5d& A = information.curvature;
  const Vector5d unit = A.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix5d scaled = unit.asDiagonal() * A * unit.asDiagonal();
  const Matrix5d inverse = unit.asDiagonal() * scaled.inverse() * unit.asDiagonal();
  Matrix5d scatter = information.scatter;
  for (const auto& eye : information.eyes) scatter += eye_sd_mm * eye_sd_mm * eye * eye.transpose();
  return inverse * scatter * inverse.transpose();
}

// As if the gap were given.
Information WithGap(Information information) {
  information.curvature(kLatticeGap, kLatticeGap) *= 1e12;
  return information;
}

struct Drift {
  double rms_px = 0, max_px = 0;
  Vector2d worst_px{0, 0};
  Vector3d worst_eye{0, 0, 0};
};

Drift DriftOf(const Matrix5d& covariance, const LatticeModel& model, const LayerCalibration& design,
              const EyeBox& box) {
  const Rigid stack_from_display = Inverse(design.display_from_stack);
  const PanelCalibration& panel = design.emitter;
  const double pixel = panel.pitch_mm * (1 + panel.scale);
  const Vector2d half = pixel / 2 * Vector2d(panel.width_px, panel.height_px);
  Drift drift;
  double sum = 0;
  int count = 0;
  for (const Vector3d& eye : box.Eyes()) {
    for (int place = 0; place < 9; ++place) {
      const Vector2d side(place % 3 - 1, place / 3 - 1);
      const Eigen::Matrix<double, 2, 5> slopes =
          model.SlopesOfDrift(half.cwiseProduct(side), stack_from_display * eye);
      const Eigen::Matrix2d of_point = slopes * covariance * slopes.transpose() / (pixel * pixel);
      // In the direction in which it is the largest.
      const double variance =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(of_point).eigenvalues()(1);
      sum += variance;
      ++count;
      if (!(variance > drift.max_px * drift.max_px)) continue;
      drift.max_px = std::sqrt(variance);
      drift.worst_px = half / pixel + Vector2d(side.x(), -side.y()).cwiseProduct(half / pixel);
      drift.worst_eye = eye;
    }
  }
  drift.rms_px = std::sqrt(std::max(0.0, sum / count));
  return drift;
}

// Of each family the distance across its lenses between the cameras that are furthest apart.
std::vector<double> ApartOf(const std::vector<Vector3d>& eyes, const std::vector<SheetRay>& rays,
                            const LatticeModel& model) {
  std::vector<bool> seen(eyes.size(), false);
  for (const SheetRay& ray : rays) seen[static_cast<std::size_t>(ray.view)] = true;
  std::vector<double> apart;
  for (int a = 0; a < model.num_directions(); ++a) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t view = 0; view < eyes.size(); ++view) {
      if (!seen[view]) continue;
      const double across = model.Normal(a).dot(eyes[view].head<2>());
      low = std::min(low, across);
      high = std::max(high, across);
    }
    apart.push_back(high - low);
  }
  return apart;
}

// Another place for the camera: across the lenses, beyond the middle of those it has been at.
Vector3d NextEye(const std::vector<Vector3d>& eyes, const Vector2d& normal) {
  Vector3d mean(0, 0, 0);
  for (const Vector3d& eye : eyes) mean += eye / static_cast<double>(eyes.size());
  const double across = normal.dot(mean.head<2>());
  const double step = std::max(2 * kLeastApartMm, 0.6 * mean.z()) * (across > 0 ? -1 : 1);
  mean.head<2>() += step * normal;
  return mean;
}

Weakness LostWithGap(const LatticeReport& report, const std::vector<Vector3d>& eyes,
                     const Rigid& display_from_stack, const Vector2d& normal, double limit_px) {
  const double apart = *std::max_element(report.apart_mm.begin(), report.apart_mm.end());
  const std::string cameras =
      eyes.size() < 2
          ? std::string("there is one camera position only")
          : fmt::format("camera positions are {:.0f} mm apart across the lenses", apart);
  const Vector3d next = display_from_stack * NextEye(eyes, normal);
  return {
      fmt::format("the lenses' pitch and phase cannot be told from their gap: {}; lenses at the "
                  "panel's edge are known to {:.3f} px, not {:g}",
                  cameras, report.drift_max_px, limit_px),
      fmt::format("photograph the patterns from a further position, {:.0f} mm and more away "
                  "across the lenses, for instance at ({:.0f}, {:.0f}, {:.0f}) mm",
                  kLeastApartMm, next.x(), next.y(), next.z())};
}

// A line has no second phase.
Matrix5d WithoutSecondPhase(Matrix5d covariance) {
  covariance.row(kLatticePhase1).setZero();
  covariance.col(kLatticePhase1).setZero();
  return covariance;
}

double MedianSigma(const std::vector<SheetRay>& rays, const LatticeModel& model) {
  std::vector<double> sigmas;
  sigmas.reserve(rays.size());
  for (const SheetRay& ray : rays) {
    sigmas.push_back(model.ResidualOf(ray, ray.sheet, 0).sigma);
  }
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return *middle;
}

LayerCalibration LayerWith(const LayerCalibration& design, const LensLattice& type,
                           const Vector5d& at) {
  LensLattice lattice = type;
  lattice.pitch_mm = at(kLatticePitch);
  lattice.rotation_rad = at(kLatticeRotation);
  lattice.phase = {at(kLatticePhase0), at(kLatticePhase1)};
  if (lattice.type == LensLattice::Type::kLine) lattice.phase.y() = 0;
  lattice.phase.array() -= lattice.phase.array().floor();
  LayerCalibration layer = design;
  layer.lattice = lattice;
  layer.gap_mm = at(kLatticeGap) * layer.index;
  return layer;
}

// One lattice does not describe the sheet as a whole.
void AddMisfit(const LatticeMisfit& misfit, LatticeReport& report) {
  const double pixel = report.layer.emitter.pitch_mm;
  if (misfit.largest_mm < kMostMisfitPx * pixel + 4.5 * misfit.deviation_mm) return;
  report.failures.push_back(
      {fmt::format(
           "lenses about ({:.0f}, {:.0f}) mm are off the lattice by {:.2f} px: the sheet or "
           "the panel is bent or stands askew, or a camera is elsewhere",
           misfit.place_mm.x(), misfit.place_mm.y(), misfit.largest_mm / pixel),
       "press the sheet flat onto the panel, and measure the cameras' positions again"});
}

void AddFailures(const Drift& with_gap_known, const std::vector<Vector3d>& eyes,
                 const Vector2d& normal, double limit_px, LatticeReport& report) {
  if (report.num_used < (1 - kMostOutliers) * report.num_samples) {
    report.failures.push_back(
        {fmt::format("{:.0f} % of the samples are off the lattice",
                     100 - 100.0 * report.num_used / report.num_samples),
         "check that the sheet lies flat, that the cameras are where they are said to be and that "
         "nothing is reflected"});
  }
  if (report.drift_max_px <= limit_px) return;
  if (with_gap_known.max_px < kShareWithGap * report.drift_max_px) {
    report.failures.push_back(
        LostWithGap(report, eyes, report.layer.display_from_stack, normal, limit_px));
    return;
  }
  report.failures.push_back(
      {fmt::format(
           "lenses at the panel's edge are known to {:.3f} px, not {:g}: of {} samples with "
           "a noise of {:.2f} px",
           report.drift_max_px, limit_px, report.num_used, report.noise_px),
       "photograph the whole panel, expose longer, and measure the cameras' positions better"});
}

}  // namespace

LatticeReport EstimateLattice(const LatticeObservations& observations,
                              const LayerCalibration& design, const LatticeOptions& options) {
  if (!design.lattice || !(design.gap_mm > 0)) {
    throw UsageError("lens sheet", "the layer has no lenses", "give a display with a lens sheet");
  }
  const std::vector<SheetRay> rays = SheetRaysOf(observations, design);
  const std::vector<Vector3d>& eyes = observations.eyes_mm;
  Vector5d nominal;
  nominal << design.lattice->pitch_mm, design.lattice->rotation_rad, design.lattice->phase,
      design.gap_mm / design.index;
  const LatticeModel sheet(*design.lattice, nominal);
  const LatticeFit fit(rays, sheet, nominal(kLatticeGap));
  Vector5d at = FindLattice(rays, eyes, sheet);
  double most = std::numeric_limits<double>::infinity(), scale = fit.Scale(at, most);
  at = fit.Minimise(at, scale, most);
  for (int i = 0; i < kMostRounds; ++i) {
    const double before = scale;
    scale = fit.Scale(at, most);
    most = kTukey * scale;
    at = fit.Minimise(at, scale, most);
    if (i > 0 && scale > 0.98 * before) break;
  }
  const LatticeModel model = sheet.At(at);
  const Information information = InformationOf(fit, model, rays, eyes, scale);
  const auto drift = [&](const Information& of) {
    return DriftOf(CovarianceOf(of, options.eye_sd_mm), model, design, options.eye_box);
  };
  LatticeReport report;
  report.layer = LayerWith(design, *design.lattice, at);
  report.covariance = CovarianceOf(information, options.eye_sd_mm);
  if (model.num_families() == 1) report.covariance = WithoutSecondPhase(report.covariance);
  const Drift known = drift(information);
  report.drift_rms_px = known.rms_px;
  report.drift_max_px = known.max_px;
  report.worst_px = known.worst_px;
  report.worst_eye = known.worst_eye;
  report.num_samples = static_cast<int>(rays.size());
  report.num_used = information.num_used;
  report.noise_px = scale * MedianSigma(rays, model) / design.emitter.pitch_mm;
  report.chi2 = scale * scale;
  report.apart_mm = ApartOf(eyes, rays, model);
  AddMisfit(MisfitOf(rays, model, kTukey * scale), report);
  AddFailures(drift(WithGap(information)), eyes, model.Normal(0), options.largest_drift_px, report);
  return report;
}

}  // namespace lamella
