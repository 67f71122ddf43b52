#include "pipeline/panel_region.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/LU>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCells = kGainColumns * kGainRows;
constexpr double kBorder = 0.05;  // of the panel's sides
constexpr double kMostPatchHeightPx = 32;
constexpr float kFullScale = 0.98F;

std::size_t ToSize(int value) { return static_cast<std::size_t>(value); }

int CellOf(const Vector2d& panel_px, const PanelSize& panel) {
  const double x = panel_px.x() / panel.width_px, y = panel_px.y() / panel.height_px;
  if (!(std::min({x, y, 1 - x, 1 - y}) >= kBorder)) return -1;
  return static_cast<int>(y * kGainRows) * kGainColumns + static_cast<int>(x * kGainColumns);
}

// A period wide, its sides half-way between openings, so that blur takes nothing out of it; of one
// opening, since lines of sight through the next one meet the emitters at another place.
bool IsInPatch(const Vector2d& panel_px, int cell, const PanelSize& panel) {
  const int column = cell % kGainColumns, row = cell / kGainColumns;
  const double middle_x = (column + 0.5) * panel.width_px / kGainColumns;
  const double middle_y = (row + 0.5) * panel.height_px / kGainRows;
  const double period = kLinesPeriodPx;
  const double opening = std::round((middle_x - kOpeningPx) / period) * period + kOpeningPx + 0.5;
  return std::abs(panel_px.x() - opening) < period / 2 &&
         std::abs(panel_px.y() - middle_y) < PatchHeightPx(panel) / 2;
}

Vector3d Channels(const Rgb& light) {
  return {static_cast<double>(light.r), static_cast<double>(light.g), static_cast<double>(light.b)};
}

bool IsSaturated(const Rgb& light) { return std::max({light.r, light.g, light.b}) >= kFullScale; }

}  // namespace

double PatchHeightPx(const PanelSize& panel) {
  return std::min(kMostPatchHeightPx, 0.8 * panel.height_px / kGainRows);
}

PanelRegion RegionOf(const Eigen::Matrix3d& image_from_panel, const PanelSize& panel, int width,
                     int height) {
  const Eigen::Matrix3d panel_from_image = image_from_panel.inverse();
  PanelRegion region{Image<std::int16_t>(width, height, -1),
                     Image<std::int16_t>(width, height, -1),
                     0,
                     std::vector<int>(kCells, 0),
                     std::vector<int>(kCells, 0),
                     std::vector<Vector2d>(kCells, Vector2d::Zero()),
                     std::vector<Vector2d>(kCells, Vector2d::Zero())};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vector2d at(x + 0.5, y + 0.5);
      const Vector2d panel_px = (panel_from_image * at.homogeneous()).hnormalized();
      const int cell = CellOf(panel_px, panel);
      if (cell < 0) continue;
      const std::size_t c = ToSize(cell);
      region.cell(x, y) = static_cast<std::int16_t>(cell);
      ++region.num_px;
      ++region.cell_px[c];
      region.cell_image[c] += at;
      region.cell_panel[c] += panel_px;
      if (!IsInPatch(panel_px, cell, panel)) continue;
      region.patch(x, y) = static_cast<std::int16_t>(cell);
      ++region.patch_px[c];
    }
  }
  for (std::size_t c = 0; c < kCells; ++c) {
    region.cell_image[c] /= std::max(1, region.cell_px[c]);
    region.cell_panel[c] /= std::max(1, region.cell_px[c]);
  }
  return region;
}

RegionLight LightOf(ImageSpan<const Rgb> photo, ImageSpan<const Rgb> dark,
                    const PanelRegion& region) {
  RegionLight light;
  light.cells.assign(kCells, Vector3d::Zero());
  double squares = 0, pairs = 0, saturated = 0;
  for (int y = 0; y < photo.height; ++y) {
    double before = 0;
    bool has_before = false;
    for (int x = 0; x < photo.width; ++x) {
      const int cell = region.cell(x, y);
      if (cell < 0) {
        has_before = false;
        continue;
      }
      const Vector3d own = Channels(photo(x, y) - dark(x, y));
      light.cells[ToSize(cell)] += own;
      if (IsSaturated(photo(x, y))) ++saturated;
      if (has_before) {
        squares += (own.sum() - before) * (own.sum() - before);
        ++pairs;
      }
      before = own.sum();
      has_before = true;
    }
  }
  const double count = std::max(1, region.num_px);
  for (std::size_t c = 0; c < kCells; ++c) {
    light.mean += light.cells[c] / count;
    light.cells[c] /= std::max(1, region.cell_px[c]);
  }
  light.sum = light.mean.sum();
  light.variance = squares / (2 * std::max(1.0, pairs)) / count;
  light.saturated = saturated / count;
  return light;
}

std::vector<double> PatchLightOf(ImageSpan<const Rgb> photo, ImageSpan<const Rgb> dark,
                                 const PanelRegion& region) {
  std::vector<double> light(kCells, 0.0);
  for (int y = 0; y < photo.height; ++y) {
    for (int x = 0; x < photo.width; ++x) {
      const int patch = region.patch(x, y);
      if (patch >= 0) light[ToSize(patch)] += Channels(photo(x, y) - dark(x, y)).sum();
    }
  }
  for (std::size_t c = 0; c < kCells; ++c) light[c] /= std::max(1, region.patch_px[c]);
  return light;
}

}  // namespace lamella
