#include "pipeline/capture/hci_grid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/capture/pose_check.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr const char* kParameters = "parameters.cfg";
constexpr const char* kTrueDisparity = "gt_disp_lowres.pfm";  // of the centre view
constexpr const char* kMend = "mend the file (HCI 4D light field benchmark)";

std::string Trimmed(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), blank));
  text.erase(std::find_if_not(text.rbegin(), text.rend(), blank).base(), text.end());
  return text;
}

// The keys of an INI file; the benchmark uses each key in one section only.
class Parameters {
 public:
  explicit Parameters(const fs::path& path) : path_(path) {
    std::istringstream text(ReadText(path));
    for (std::string line; std::getline(text, line);) {
      const std::size_t equals = line.find('=');
      if (equals == std::string::npos || line[0] == ';' || line[0] == '#') continue;
      values_[Trimmed(line.substr(0, equals))] = Trimmed(line.substr(equals + 1));
    }
  }
  double Number(const std::string& key, double min, double max) const {
    const auto value = values_.find(key);
    if (value == values_.end()) throw InputError(path_.string(), "has no " + key, kMend);
    std::istringstream text(value->second);
    double number = 0;
    if (!(text >> number) || !(number >= min && number <= max)) {
      throw InputError(
          path_.string(),
          fmt::format("{} = {} is no number from {:g} to {:g}", key, value->second, min, max),
          kMend);
    }
    return number;
  }

 private:
  fs::path path_;
  std::map<std::string, std::string> values_;
};

// What parameters.cfg says of the cameras; lengths in metres.
struct Grid {
  int columns = 0, rows = 0, width = 0, height = 0;
  double baseline = 0, focus = 0, focal_px = 0;
};

Grid ReadGrid(const fs::path& path) {
  const Parameters parameters(path);
  constexpr double kTiny = 1e-12, kHuge = 1e12;
  Grid grid;
  grid.columns = static_cast<int>(parameters.Number("num_cams_x", 1, 1000));
  grid.rows = static_cast<int>(parameters.Number("num_cams_y", 1, 1000));
  grid.width = static_cast<int>(parameters.Number("image_resolution_x_px", 1, 1 << 20));
  grid.height = static_cast<int>(parameters.Number("image_resolution_y_px", 1, 1 << 20));
  grid.baseline = parameters.Number("baseline_mm", kTiny, kHuge) / 1000;
  grid.focus = parameters.Number("focus_distance_m", kTiny, kHuge);
  grid.focal_px = parameters.Number("focal_length_mm", kTiny, kHuge) /
                  parameters.Number("sensor_size_mm", kTiny, kHuge) *
                  std::max(grid.width, grid.height);
  return grid;
}

std::string ViewName(int index) { return fmt::format("input_Cam{:03}", index); }

// Of the first image that is there, for the views whose image is not.
fs::path AnyExtension(const fs::path& folder, int count) {
  for (const char* extension : {".png", ".exr", ".tif", ".tiff", ".jpg"}) {
    for (int i = 0; i < count; ++i) {
      if (fs::exists(folder / (ViewName(i) + extension))) return extension;
    }
  }
  throw InputError(folder.string(), "has a parameters.cfg but no image input_Cam000.png and on",
                   "put the grid's images beside parameters.cfg");
}

}  // namespace

bool IsHciGrid(const fs::path& folder) { return fs::is_regular_file(folder / kParameters); }

// Parallel cameras whose sensors are shifted so that the focus plane has zero disparity:
//   centre = offset * B,  principal point = centre of the image + offset * f_px * B / Zf.
std::vector<View> ReadHciGrid(const fs::path& folder) {
  const Grid grid = ReadGrid(folder / kParameters);
  const fs::path extension = AnyExtension(folder, grid.columns * grid.rows);
  const bool has_disparity = fs::is_regular_file(folder / kTrueDisparity);
  std::vector<View> views;
  for (int i = 0; i < grid.columns * grid.rows; ++i) {
    View view;
    view.name = ViewName(i);
    view.image = folder / (view.name + extension.string());
    view.grid = GridPosition{i / grid.columns, i % grid.columns};
    const Eigen::Vector2d offset(view.grid->column - (grid.columns - 1) / 2.0,
                                 view.grid->row - (grid.rows - 1) / 2.0);
    const Eigen::Vector2d shift = offset * (grid.focal_px * grid.baseline / grid.focus);
    view.camera = {.width = grid.width,
                   .height = grid.height,
                   .fx = grid.focal_px,
                   .fy = grid.focal_px,
                   .cx = grid.width / 2.0 + shift.x(),
                   .cy = grid.height / 2.0 + shift.y()};
    CheckCamera(view.camera, (folder / kParameters).string());
    view.camera_from_world.translation << -grid.baseline * offset, 0;
    if (has_disparity && offset.isZero()) view.depth = folder / kTrueDisparity;
    views.push_back(std::move(view));
  }
  return views;
}

bool IsHciDisparity(const fs::path& path) { return path.filename() == kTrueDisparity; }

// 1/Z = d / (f_px B) + 1/Zf; d in px per step of the grid.
Image<float> ReadHciDepth(const fs::path& disparity) {
  const Grid grid = ReadGrid(disparity.parent_path() / kParameters);
  Image<float> depth = ReadPfm(disparity);
  if (depth.width() != grid.width || depth.height() != grid.height) {
    throw InputError(disparity.string(),
                     fmt::format("is {}x{} px, the grid's views {}x{} px", depth.width(),
                                 depth.height(), grid.width, grid.height),
                     "give disparity of the views' size");
  }
  for (std::size_t i = 0; i < depth.size(); ++i) {
    float& pixel = depth.data()[i];
    const double inverse_depth =
        static_cast<double>(pixel) / (grid.focal_px * grid.baseline) + 1 / grid.focus;
    pixel = std::isfinite(pixel) ? static_cast<float>(1 / std::max(inverse_depth, 0.0)) : 0.0F;
  }
  return depth;
}

}  // namespace lamella
