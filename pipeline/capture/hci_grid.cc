#include "pipeline/capture/hci_grid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "pipeline/capture/pose_check.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr const char* kParameters = "parameters.cfg";
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
  const Parameters parameters(folder / kParameters);
  constexpr double kTiny = 1e-12, kHuge = 1e12;
  const int columns = static_cast<int>(parameters.Number("num_cams_x", 1, 1000));
  const int rows = static_cast<int>(parameters.Number("num_cams_y", 1, 1000));
  const int width = static_cast<int>(parameters.Number("image_resolution_x_px", 1, 1 << 20));
  const int height = static_cast<int>(parameters.Number("image_resolution_y_px", 1, 1 << 20));
  const double baseline = parameters.Number("baseline_mm", kTiny, kHuge) / 1000;
  const double focus = parameters.Number("focus_distance_m", kTiny, kHuge);
  const double focal_px = parameters.Number("focal_length_mm", kTiny, kHuge) /
                          parameters.Number("sensor_size_mm", kTiny, kHuge) *
                          std::max(width, height);
  const fs::path extension = AnyExtension(folder, columns * rows);
  std::vector<View> views;
  for (int i = 0; i < columns * rows; ++i) {
    View view;
    view.name = ViewName(i);
    view.image = folder / (view.name + extension.string());
    view.grid = GridPosition{i / columns, i % columns};
    const Eigen::Vector2d offset(view.grid->column - (columns - 1) / 2.0,
                                 view.grid->row - (rows - 1) / 2.0);
    const Eigen::Vector2d shift = offset * (focal_px * baseline / focus);
    view.camera = {.width = width,
                   .height = height,
                   .fx = focal_px,
                   .fy = focal_px,
                   .cx = width / 2.0 + shift.x(),
                   .cy = height / 2.0 + shift.y()};
    CheckCamera(view.camera, (folder / kParameters).string());
    view.camera_from_world.translation << -baseline * offset, 0;
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace lamella
