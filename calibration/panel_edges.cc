#include "calibration/panel_edges.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/detect_board.h"
#include "calibration/residuals.h"

namespace lamella {
namespace {

using Eigen::Vector2d;

static_assert(kPanelEdgePx > 1.415 * kMostHalfWindow + 2, "a diagonal and the edge's blur");

constexpr int kPiecesOfSide = 16;  // straight, of a border that lens and bow bend

PanelId OtherOf(const PanelId& panel) {
  return {panel.layer, panel.role == PanelId::kEmitter ? PanelId::kModulator : PanelId::kEmitter};
}

// Once around, from the top left corner; to be predicted, so nothing is measured.
std::vector<Observation> BorderOf(const PanelCalibration& panel) {
  const Vector2d corners[] = {
      {0, 0}, {panel.width_px, 0}, {panel.width_px, panel.height_px}, {0, panel.height_px}, {0, 0}};
  std::vector<Observation> border;
  for (std::size_t side = 0; side < 4; ++side) {
    for (int i = 0; i < kPiecesOfSide; ++i) {
      const double t = static_cast<double>(i) / kPiecesOfSide;
      border.push_back({(1 - t) * corners[side] + t * corners[side + 1], Vector2d::Zero()});
    }
  }
  return border;
}

// How far inside of the polygon; negative: outside.
double DepthInside(const Vector2d& point, const Eigen::Matrix2Xd& polygon) {
  double squared = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (Eigen::Index i = 0; i < polygon.cols(); ++i) {
    const Vector2d a = polygon.col(i), b = polygon.col((i + 1) % polygon.cols());
    const Vector2d side = b - a, from_a = point - a;
    const double t = std::clamp(from_a.dot(side) / std::max(side.squaredNorm(), 1e-12), 0.0, 1.0);
    squared = std::min(squared, (from_a - t * side).squaredNorm());
    // A ray along x crosses the border an odd number of times.
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (from_a.x() < side.x() * from_a.y() / side.y()) inside = !inside;
  }
  return inside ? std::sqrt(squared) : -std::sqrt(squared);
}

}  // namespace

ClearOfEdges WithoutPanelEdges(const CalibrationState& state, const Structure& structure,
                               const Observations& observations) {
  // The border of the other panel in every photograph is what it would show with nothing measured:
  // residuals are predicted minus measured.
  Observations borders = observations;
  for (PanelPhoto& photo : borders.photos) {
    photo.panel = OtherOf(photo.panel);
    photo.points.clear();
    if (!std::binary_search(structure.panels.begin(), structure.panels.end(), photo.panel))
      continue;
    photo.points = BorderOf(structure.Panel(photo.panel));
  }
  const std::vector<Eigen::Matrix2Xd> predicted = WhitenedResiduals(state, structure, borders);
  ClearOfEdges clear{observations, {}};
  std::map<PanelId, std::size_t> cut;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    PanelPhoto& photo = clear.observations.photos[i];
    if (predicted[i].cols() == 0) continue;
    cut[photo.panel] += std::erase_if(photo.points, [&](const Observation& point) {
      return DepthInside(point.image_px, predicted[i]) < kPanelEdgePx;
    });
  }
  for (const auto& [panel, num] : cut) {
    if (num == 0) continue;
    clear.left_out.push_back(
        fmt::format("{}: {} points, seen within {} px of an edge of {} or beyond it", NameOf(panel),
                    num, kPanelEdgePx, NameOf(OtherOf(panel))));
  }
  return clear;
}

}  // namespace lamella
