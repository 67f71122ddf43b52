// A capture's quilt and its image for one Looking Glass panel (displays.md section 4): the capture,
// placed in the screen's volume as in a display's, is asked for one bundle of rays a tile.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "depth/render.h"
#include "distribute/place.h"
#include "lightfield/image.h"
#include "lightfield/progress.h"
#include "lightfield/quilt.h"
#include "lightfield/ray_source.h"
#include "pipeline/workspace.h"

namespace lamella {

constexpr int kMaxQuiltPx = 1 << 17;  // along a side
constexpr double kLeastConeDeg = 0.1, kMostConeDeg = 170;

struct RenderQuiltOptions {
  // 0 and nothing: what visual.json tells and the published quilt of its device, else the
  // Portrait's.
  int columns = 0, rows = 0;
  int views = 0;                           // of the tiles; 0: all
  int width_px = 0, height_px = 0;         // of the quilt
  std::optional<double> aspect;            // of the screen; not with visual.json
  std::optional<double> screen_height_mm;  // likewise
  std::optional<double> cone_deg;
  std::filesystem::path visual;    // visual.json of the device; empty: no native image
  std::string filter = "nearest";  // of the native image: linear, gaussian, wide-gaussian
  bool guess_unseen = false;       // colours rays that no photograph saw; they count as unseen
  PlacementOptions placement;
  RenderOptions render;  // guess_unseen and rays are not read
};

struct DrawnQuilt {
  Image<Rgb8> codes;  // as the source colours rays; black in tiles without a view
  // Of each view's rays, the mean coverage: of all, and of those through the picture (a rectangle
  // in the middle of z = 0).
  std::vector<double> seen, seen_in_picture;
};
// `source` is placed: it answers in the display's frame. Tile by tile, tall ones in strips of rows.
DrawnQuilt DrawQuilt(const RaySource& source, const QuiltCameras& cameras,
                     const QuiltLayout& layout, int width_px, int height_px,
                     const Eigen::Vector2d& picture_mm, Progress& progress);

struct RenderedQuilt {
  std::filesystem::path file;    // NAME_qsCxRaA.png
  std::filesystem::path native;  // NAME_native.png; empty where no visual.json is given
  QuiltLayout layout;
  QuiltCameras cameras;  // mm
  Placement placement;
  std::vector<double> seen, seen_in_picture;                 // of views, as DrawnQuilt
  std::vector<std::pair<std::string, std::string>> summary;  // what, value
};

// Needs the stage depth of the workspace, in which it changes nothing. `out` as QuiltFile has it.
// By default near and far are shown where a point moves by one lens from a view to the next, since
// beyond that views fall apart; the viewing distance is that at which the screen is 14 degrees
// high. UsageError where options don't fit together or the quilt is too large, InputError where the
// depth is missing or visual.json can't be used.
RenderedQuilt RenderQuilt(const Workspace& workspace, const RenderQuiltOptions& options,
                          const std::filesystem::path& out, Progress& progress);

}  // namespace lamella
