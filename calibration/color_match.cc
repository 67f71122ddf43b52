#include "calibration/color_match.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/LU>
#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// normal . light <= bound
struct HalfSpace {
  Vector3d normal;
  double bound;
};

std::vector<HalfSpace> GamutsOf(const std::vector<Matrix3d>& camera_from_panel,
                                const std::string& display) {
  std::vector<HalfSpace> gamuts;
  for (std::size_t layer = 0; layer < camera_from_panel.size(); ++layer) {
    Eigen::FullPivLU<Matrix3d> lu(camera_from_panel[layer]);
    lu.setThreshold(1e-6);
    if (!lu.isInvertible()) {
      throw InputError(display, fmt::format("red, green and blue of layer {} look alike", layer),
                       "photograph its emitter full red, full green and full blue, in colour");
    }
    const Matrix3d panel_from_camera = lu.inverse();
    for (int channel = 0; channel < 3; ++channel) {
      const Vector3d normal = panel_from_camera.row(channel);
      gamuts.push_back({normal, 1});
      gamuts.push_back({-normal, 0});
    }
  }
  return gamuts;
}

// Where three planes meet, if that is in all half-spaces.
std::optional<Vector3d> Corner(const std::vector<HalfSpace>& spaces, std::size_t i, std::size_t j,
                               std::size_t k) {
  Matrix3d normals;
  normals << spaces[i].normal.normalized().transpose(), spaces[j].normal.normalized().transpose(),
      spaces[k].normal.normalized().transpose();
  if (std::abs(normals.determinant()) < 1e-9) return std::nullopt;
  const Vector3d bounds(spaces[i].bound / spaces[i].normal.norm(),
                        spaces[j].bound / spaces[j].normal.norm(),
                        spaces[k].bound / spaces[k].normal.norm());
  const Vector3d corner = normals.inverse() * bounds;
  for (const HalfSpace& space : spaces) {
    if (space.normal.dot(corner) > space.bound + 1e-9) return std::nullopt;
  }
  return corner;
}

double LuminanceOf(const Vector3d& light) {
  return 0.2126 * light.x() + 0.7152 * light.y() + 0.0722 * light.z();
}

}  // namespace

Vector3d BrightestCommonWhite(const std::vector<Matrix3d>& camera_from_panel,
                              const std::string& display) {
  const std::vector<HalfSpace> gamuts = GamutsOf(camera_from_panel, display);
  Vector3d brightest = Vector3d::Zero();
  for (std::size_t i = 0; i < gamuts.size(); ++i) {
    for (std::size_t j = i + 1; j < gamuts.size(); ++j) {
      for (std::size_t k = j + 1; k < gamuts.size(); ++k) {
        const std::optional<Vector3d> corner = Corner(gamuts, i, j, k);
        if (corner && corner->sum() > brightest.sum()) brightest = *corner;
      }
    }
  }
  if (!(brightest.minCoeff() > 0)) {
    throw UsageError(display, "its layers share no white that they can all show",
                     "exclude the layer whose colours differ, or mend its panel");
  }
  return brightest;
}

std::vector<LayerColors> MatchColors(const std::vector<Matrix3d>& camera_from_panel,
                                     const std::string& display) {
  const Vector3d white = BrightestCommonWhite(camera_from_panel, display);
  std::vector<LayerColors> layers;
  double sum = 0;
  for (const Matrix3d& camera : camera_from_panel) {
    const Matrix3d viewer = white.cwiseInverse().asDiagonal() * camera;
    const double luminance = LuminanceOf(viewer.rowwise().sum());
    layers.push_back({luminance, viewer / luminance});
    sum += luminance;
  }
  for (LayerColors& layer : layers) layer.gain /= sum;
  return layers;
}

}  // namespace lamella
