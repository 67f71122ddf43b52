#include "calibration/lattice_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTukey = 4.685;     // deviations: 95 % efficient where errors are normal
constexpr double kGapPriorSd = 0.1;  // of the gap, what a display builder would assume
constexpr double kLeastScale = 1e-9;
constexpr int kMostIterations = 60;
// Of fitting, then leaving out what is off by the deviation of the rest.
constexpr int kMostRounds = 8;
constexpr int kCells = 12;  // per side of the sheet

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

class Minimiser {
 public:
  Minimiser(const std::vector<SheetRay>& rays, const LatticeModel& model, double gap)
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

// Of the cost against a residual of the term, on the mean over its families.
double CurvatureOf(const TukeyWeight& tukey, const Term& term, const LatticeModel& model) {
  return tukey.weight + 2 * tukey.slope * term.d2 / model.num_directions();
}

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

// Fills in what is known at the model's parameters.
void AddInformation(const std::vector<SheetRay>& rays, const std::vector<Vector3d>& eyes,
                    LatticeFit& fit) {
  fit.eyes.assign(eyes.size(), Eigen::Matrix<double, 5, 3>::Zero());
  std::map<std::pair<int, int>, Vector5d> cells;
  const CellOfSheet cell(rays);
  const LatticeModel& model = fit.model;
  for (const SheetRay& ray : rays) {
    const Term term = Minimiser::TermOf(ray, model);
    const TukeyWeight tukey(term.d2, Minimiser::Bound2(term, fit.most));
    if (tukey.weight == 0) continue;
    ++fit.num_used;
    fit.curvature += tukey.weight * term.information +
                     2 * tukey.slope * term.gradient * term.gradient.transpose();
    const auto [place, is_new] = cells.try_emplace(cell(ray), Vector5d::Zero());
    place->second += tukey.weight * term.gradient;
    const auto view = static_cast<std::size_t>(ray.view);
    const Vector2d centre = model.CentreOf(ray);
    const double curvature = CurvatureOf(tukey, term, model);
    for (int a = 0; a < model.num_families(); ++a) {
      const LatticeModel::Residual r = model.ResidualOf(ray, centre, a);
      fit.eyes[view] += curvature * model.FamilyWeight() / (r.sigma * r.sigma) * r.slopes *
                        model.SlopesOfEye(ray, eyes[view], a).transpose();
    }
  }
  for (const auto& [place, gradient] : cells) fit.scatter += gradient * gradient.transpose();
}

}  // namespace

Matrix5d LatticeFit::Covariance(double eye_sd_mm) const {
  // Scaled to a unit diagonal first.
  const Vector5d unit = curvature.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix5d scaled = unit.asDiagonal() * curvature * unit.asDiagonal();
  const Matrix5d inverse = unit.asDiagonal() * scaled.inverse() * unit.asDiagonal();
  Matrix5d all = scatter;
  for (const auto& eye : eyes) all += eye_sd_mm * eye_sd_mm * eye * eye.transpose();
  for (const Vector5d& change : together) all += change * change.transpose();
  Matrix5d covariance = inverse * all * inverse.transpose();
  if (model.num_families() == 1) {  // a line has no second phase
    covariance.row(kLatticePhase1).setZero();
    covariance.col(kLatticePhase1).setZero();
  }
  return covariance;
}

LatticeFit LatticeFit::WithGapKnown() const {
  LatticeFit fit = *this;
  fit.curvature(kLatticeGap, kLatticeGap) *= 1e12;
  return fit;
}

LatticeFit FitLattice(const std::vector<SheetRay>& rays, const std::vector<Vector3d>& eyes,
                      const LatticeModel& start, double gap_mm) {
  const Minimiser minimiser(rays, start, gap_mm);
  Vector5d at = start.parameters();
  double most = std::numeric_limits<double>::infinity(), scale = minimiser.Scale(at, most);
  at = minimiser.Minimise(at, scale, most);
  for (int i = 0; i < kMostRounds; ++i) {
    const double before = scale;
    scale = minimiser.Scale(at, most);
    most = kTukey * scale;
    at = minimiser.Minimise(at, scale, most);
    if (i > 0 && scale > 0.98 * before) break;
  }
  // What was assumed counts as an observation.
  const Matrix5d prior = minimiser.Prior();
  LatticeFit fit{start.At(at), scale, most, 0, scale * scale * prior, std::pow(scale, 4) * prior,
                 {},           {}};
  AddInformation(rays, eyes, fit);
  return fit;
}

Vector5d GradientChange(const std::vector<SheetRay>& rays, const std::vector<SheetRay>& moved,
                        const LatticeFit& fit) {
  if (rays.size() != moved.size()) {
    return Vector5d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  Vector5d change = Vector5d::Zero();
  const LatticeModel& model = fit.model;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Term term = Minimiser::TermOf(rays[i], model);
    const TukeyWeight tukey(term.d2, Minimiser::Bound2(term, fit.most));
    if (tukey.weight == 0) continue;
    const Vector2d centre = model.CentreOf(rays[i]);
    const Vector2d step = model.CentreOf(moved[i]) - centre;
    for (int a = 0; a < model.num_families(); ++a) {
      const LatticeModel::Residual r = model.ResidualOf(rays[i], centre, a);
      change += CurvatureOf(tukey, term, model) * model.FamilyWeight() / (r.sigma * r.sigma) *
                model.Normal(a).dot(step) * r.slopes;
    }
  }
  return change;
}

}  // namespace lamella
