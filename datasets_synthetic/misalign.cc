#include "datasets_synthetic/misalign.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "datasets_synthetic/random.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector3d;

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

class Deviations {
 public:
  explicit Deviations(std::uint32_t seed) : random_(MixSeeds(seed, 0x6d697361)) {}
  double Within(double most) { return most * (2 * random_.Uniform() - 1); }
  double Between(double low, double high) { return low + (high - low) * random_.Uniform(); }
  Vector3d Vector(double most) {
    const double x = Within(most), y = Within(most), z = Within(most);
    return {x, y, z};
  }

 private:
  NormalSequence random_;
};

void Require(bool holds, const char* flag, const std::string& what, const char* fix) {
  if (!holds) throw UsageError(flag, what, fix);
}

void CheckMisalignment(const Misalignment& by) {
  Require(by.shift_mm >= 0 && by.shift_mm <= 1e6, "shift", fmt::format("{} mm", by.shift_mm),
          "give 0 or more");
  Require(by.turn_deg >= 0 && by.turn_deg <= 45, "turn", fmt::format("{} degrees", by.turn_deg),
          "give 0 to 45");
  Require(by.scale >= 0 && by.scale <= 0.1, "scale", fmt::format("{}", by.scale), "give 0 to 0.1");
  Require(by.least_gap_mm >= 0 && by.most_gap_mm >= by.least_gap_mm && by.most_gap_mm <= 1e6, "gap",
          fmt::format("{} to {} mm", by.least_gap_mm, by.most_gap_mm),
          "give the smaller one first, neither below 0");
}

// The scale of a panel that is larger by a share.
double Rescaled(double scale, double share) { return (1 + scale) * (1 + share) - 1; }

void MisalignEmitter(const Misalignment& by, Deviations& random, LayerCalibration& layer) {
  if (by.most_gap_mm > 0) layer.gap_mm = random.Between(by.least_gap_mm, by.most_gap_mm);
  const double turn = by.turn_deg * kRadiansPerDegree, rise = layer.gap_mm / 3;
  const double half_width = layer.emitter.pitch_mm * layer.emitter.width_px / 2;
  const double half_height = layer.emitter.pitch_mm * layer.emitter.height_px / 2;
  for (double& offset : layer.offset_mm) offset += random.Within(by.shift_mm);
  layer.rotation_rad.x() += random.Within(std::min(turn, rise / half_height));
  layer.rotation_rad.y() += random.Within(std::min(turn, rise / half_width));
  layer.rotation_rad.z() += random.Within(turn);
}

void MisalignStack(const Misalignment& by, Deviations& random, LayerCalibration& layer) {
  const Vector3d shift = random.Vector(by.shift_mm),
                 turn = random.Vector(by.turn_deg * kRadiansPerDegree);
  Rigid& pose = layer.display_from_stack;
  pose.translation += shift;
  pose.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized())) * pose.rotation;
  pose.rotation.normalize();
}

// The layer that stands still: the first one seen directly, else the first.
std::size_t StillLayer(const Calibration& design) {
  for (std::size_t i = 0; i < design.layers.size(); ++i) {
    const LayerCalibration& layer = design.layers[i];
    if (!(layer.modulator ? *layer.modulator : layer.emitter).mirror_x) return i;
  }
  return 0;
}

void MisalignPlane(const Misalignment& by, Deviations& random, LayerCalibration& layer) {
  const double share = random.Within(by.scale);
  layer.emitter.scale = Rescaled(layer.emitter.scale, share);
  MagnifyOptics(layer, 1 + share);
  MisalignStack(by, random, layer);
}

void MisalignPlanes(const Misalignment& by, Deviations& random, Calibration& built) {
  Require(by.most_gap_mm == 0, "gap", "the planes of a varifocal display share one gap",
          "leave it out");
  double before_mm = -std::numeric_limits<double>::infinity();
  for (LayerCalibration& plane : built.layers) {
    MisalignPlane(by, random, plane);
    const double z = plane.display_from_stack.translation.z();
    Require(z > before_mm, "shift", fmt::format("{} mm puts a plane behind the next", by.shift_mm),
            "give less than half of the planes' distance");
    before_mm = z;
  }
}

}  // namespace

Calibration Misaligned(const Calibration& design, const Misalignment& by, std::uint32_t seed,
                       bool varifocal) {
  Check(design, design.display);
  CheckMisalignment(by);
  Deviations random(seed);
  Calibration built = design;
  if (varifocal) {
    MisalignPlanes(by, random, built);
    Check(built, design.display);
    return built;
  }
  const std::size_t still = StillLayer(design);
  for (std::size_t i = 0; i < built.layers.size(); ++i) {
    LayerCalibration& layer = built.layers[i];
    const double scale = random.Within(by.scale), emitter_scale = random.Within(by.scale);
    if (layer.modulator || layer.lattice) MisalignEmitter(by, random, layer);
    if (layer.modulator || i != still) {
      layer.emitter.scale = Rescaled(layer.emitter.scale, emitter_scale);
    }
    if (i == still) continue;
    MisalignStack(by, random, layer);
    if (layer.modulator) layer.modulator->scale = Rescaled(layer.modulator->scale, scale);
  }
  Check(built, design.display);
  return built;
}

}  // namespace lamella
