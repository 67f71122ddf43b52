#include "calibration/initialise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "calibration/homography.h"
#include "lightfield/error.h"
#include "lightfield/median.h"
#include "lightfield/panel_rays.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// One photograph on its own.
struct Guess {
  std::optional<Matrix3d> homography;  // image px from the panel's mm
  std::optional<Rigid> camera_from_panel;
};

Rigid MedianPose(const std::vector<Rigid>& poses) {
  // Signs and outliers are judged from the pose nearest to all others.
  std::size_t centre = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    double sum = 0;
    for (const Rigid& pose : poses) sum += poses[i].rotation.angularDistance(pose.rotation);
    if (sum < least) {
      least = sum;
      centre = i;
    }
  }
  const auto median = [&](const auto& part) {
    std::vector<double> values;
    for (const Rigid& pose : poses) values.push_back(part(pose));
    return Median(values);
  };
  Rigid result;
  for (int i = 0; i < 3; ++i) {
    result.translation(i) = median([i](const Rigid& pose) { return pose.translation(i); });
  }
  Eigen::Vector4d rotation;
  for (int i = 0; i < 4; ++i) {
    rotation(i) = median([&, i](const Rigid& pose) {
      const double sign = pose.rotation.dot(poses[centre].rotation) < 0 ? -1 : 1;
      return sign * pose.rotation.coeffs()(i);
    });
  }
  result.rotation = Eigen::Quaterniond(rotation.normalized());
  return result;
}

Eigen::Matrix2Xd PanelPointsOf(const PanelPhoto& photo, const PanelCalibration& panel) {
  Eigen::Matrix2Xd points(2, static_cast<Eigen::Index>(photo.points.size()));
  for (std::size_t i = 0; i < photo.points.size(); ++i) {
    points.col(static_cast<Eigen::Index>(i)) =
        PanelPoint(panel, photo.points[i].panel_px).head<2>();
  }
  return points;
}

Eigen::Matrix2Xd ImagePointsOf(const PanelPhoto& photo) {
  Eigen::Matrix2Xd points(2, static_cast<Eigen::Index>(photo.points.size()));
  for (std::size_t i = 0; i < photo.points.size(); ++i) {
    points.col(static_cast<Eigen::Index>(i)) = photo.points[i].image_px;
  }
  return points;
}

Matrix3d CameraMatrix(const PhotoCamera& camera, double focal) {
  Matrix3d k = Matrix3d::Identity();
  k(0, 0) = k(1, 1) = focal;
  k(0, 2) = camera.width / 2.0;
  k(1, 2) = camera.height / 2.0;
  return k;
}

double FocalOf(const Observations& observations, const std::vector<Guess>& guesses, int camera) {
  const PhotoCamera& body = observations.cameras[static_cast<std::size_t>(camera)];
  if (body.focal_px > 0) return body.focal_px;
  std::vector<Matrix3d> homographies;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    if (observations.photos[i].camera != camera || !guesses[i].homography) continue;
    homographies.push_back(*guesses[i].homography);
  }
  return FocalOfHomographies(homographies, body.width, body.height);
}

std::vector<Guess> GuessHomographies(const Observations& observations, const Structure& structure) {
  std::vector<Guess> guesses;
  for (const PanelPhoto& photo : observations.photos) {
    const PanelCalibration& panel = structure.Panel(photo.panel);
    guesses.push_back({FitHomography(PanelPointsOf(photo, panel), ImagePointsOf(photo)), {}});
  }
  return guesses;
}

// Poses from homographies; those of panels that seem to be seen from behind are dropped.
void GuessPoses(const Observations& observations, const std::vector<double>& focals,
                std::vector<Guess>& guesses) {
  std::map<PanelId, int> behind, in_front;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    if (!guesses[i].homography) continue;
    const PanelPhoto& photo = observations.photos[i];
    const auto camera = static_cast<std::size_t>(photo.camera);
    const Matrix3d k = CameraMatrix(observations.cameras[camera], focals[camera]);
    const Rigid pose = PoseOfHomography(k.inverse() * *guesses[i].homography);
    const bool front = Centre(pose).z() > 0;
    ++(front ? in_front : behind)[photo.panel];
    if (front) guesses[i].camera_from_panel = pose;
  }
  for (const auto& [panel, count] : behind) {
    if (count <= in_front[panel]) continue;
    throw InputError(kSolveWhere,
                     fmt::format("{} is mirrored in its photographs, in the display's file it is "
                                 "the other way round",
                                 NameOf(panel)),
                     "turn mirror_x of its layer over");
  }
}

// world_from_panel of every panel: the reference's, then whatever shares views with the known.
std::map<PanelId, Rigid> RelatePanels(const Observations& observations, const Structure& structure,
                                      const std::vector<Guess>& guesses,
                                      const Rigid& world_from_reference) {
  std::map<PanelId, Rigid> known{{structure.reference, world_from_reference}};
  while (known.size() < structure.panels.size()) {
    std::map<PanelId, std::vector<Rigid>> votes;
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      const auto from = known.find(observations.photos[i].panel);
      if (from == known.end() || !guesses[i].camera_from_panel) continue;
      for (std::size_t j = 0; j < guesses.size(); ++j) {
        const PanelId& to = observations.photos[j].panel;
        if (structure.view_of_photo[i] != structure.view_of_photo[j] || known.count(to) > 0 ||
            !guesses[j].camera_from_panel) {
          continue;
        }
        votes[to].push_back(from->second * Inverse(*guesses[i].camera_from_panel) *
                            *guesses[j].camera_from_panel);
      }
    }
    const auto best = std::max_element(
        votes.begin(), votes.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    if (best == votes.end()) break;
    known[best->first] = MedianPose(best->second);
  }
  for (const PanelId& panel : structure.panels) {
    if (known.count(panel) > 0) continue;
    throw InputError(kSolveWhere,
                     fmt::format("the place of {} is lost: no camera position shows it together "
                                 "with {} with enough points off a line",
                                 NameOf(panel), NameOf(structure.reference)),
                     "photograph both panels from one unmoved camera");
  }
  return known;
}

// The median distance between a panel's points as seen from a pose and as measured.
double MedianError(const PanelPhoto& photo, const PanelCalibration& panel, const Matrix3d& k,
                   const Rigid& camera_from_panel) {
  std::vector<double> errors;
  for (const Observation& point : photo.points) {
    const Vector3d seen = k * (camera_from_panel * PanelPoint(panel, point.panel_px));
    errors.push_back(seen.z() > 0 ? (seen.hnormalized() - point.image_px).norm() : 1e9);
  }
  return errors.empty() ? 0 : Median(errors);
}

// The pose of a view that most of its photographs agree with.
std::optional<Rigid> PoseOfView(const Observations& observations, const Structure& structure,
                                const std::vector<Guess>& guesses,
                                const std::map<PanelId, Rigid>& world_from_panel,
                                const std::vector<double>& focals, int view) {
  constexpr double kFarPx = 100;  // errors beyond say only that a photograph disagrees
  std::optional<Rigid> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    if (structure.view_of_photo[i] != view || !guesses[i].camera_from_panel) continue;
    const Rigid camera_from_world =
        *guesses[i].camera_from_panel * Inverse(world_from_panel.at(observations.photos[i].panel));
    double cost = 0;
    for (std::size_t j = 0; j < guesses.size(); ++j) {
      if (structure.view_of_photo[j] != view) continue;
      const PanelPhoto& photo = observations.photos[j];
      const auto camera = static_cast<std::size_t>(photo.camera);
      cost +=
          std::min(kFarPx, MedianError(photo, structure.Panel(photo.panel),
                                       CameraMatrix(observations.cameras[camera], focals[camera]),
                                       camera_from_world * world_from_panel.at(photo.panel)));
    }
    if (cost < least) {
      least = cost;
      best = camera_from_world;
    }
  }
  return best;
}

void PlaceLayers(const std::map<PanelId, Rigid>& world_from_panel, const Structure& structure,
                 CalibrationState& state) {
  for (std::size_t i = 0; i < state.layers.size(); ++i) {
    LayerState& layer = state.layers[i];
    const auto modulator = world_from_panel.find({static_cast<int>(i), PanelId::kModulator});
    const auto emitter = world_from_panel.find({static_cast<int>(i), PanelId::kEmitter});
    const Rigid designed = StackFromEmitter(structure.design.layers[i]);
    if (modulator != world_from_panel.end()) {
      layer.world_from_stack = modulator->second;
      if (emitter == world_from_panel.end()) continue;
      // Gap and tilt look different through the glass: those stay as designed.
      const Rigid seen = Inverse(modulator->second) * emitter->second;
      layer.relation.head<2>() = seen.translation.head<2>();
      layer.relation(5) = std::atan2(seen.Matrix()(1, 0), seen.Matrix()(0, 0));
    } else if (emitter != world_from_panel.end()) {
      layer.world_from_stack = emitter->second * Inverse(designed);
    }
  }
}

}  // namespace

CalibrationState Initialise(const Observations& observations, const Structure& structure) {
  std::vector<Guess> guesses = GuessHomographies(observations, structure);
  std::vector<double> focals;
  for (std::size_t i = 0; i < observations.cameras.size(); ++i) {
    focals.push_back(FocalOf(observations, guesses, static_cast<int>(i)));
  }
  GuessPoses(observations, focals, guesses);
  CalibrationState state = StateOfDesign(structure, observations);
  const bool behind = structure.reference.role == PanelId::kEmitter;
  const auto reference = static_cast<std::size_t>(structure.reference.layer);
  const Rigid world_from_reference =
      behind ? StackFromEmitter(structure.design.layers[reference]) : Rigid{};
  const auto world_from_panel =
      RelatePanels(observations, structure, guesses, world_from_reference);
  PlaceLayers(world_from_panel, structure, state);
  for (std::size_t i = 0; i < focals.size(); ++i) {
    const PhotoCamera& camera = observations.cameras[i];
    state.cameras[i].head<4>() << focals[i], focals[i], camera.width / 2.0, camera.height / 2.0;
  }
  for (std::size_t i = 0; i < structure.views.size(); ++i) {
    const auto pose =
        PoseOfView(observations, structure, guesses, world_from_panel, focals, static_cast<int>(i));
    if (pose) state.camera_from_world[i] = *pose;
  }
  return state;
}

}  // namespace lamella
