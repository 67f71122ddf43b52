#include "pipeline/preview_eyes.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

constexpr double kSamePlaceMm = 0.05;      // an eye's position and a camera's
constexpr double kRasterTolerance = 0.02;  // px, over the whole picture

// Where the ray of a view's pixel meets z = 0.
Eigen::Vector2d OnReferencePlane(const View& view, const Placement& placement, double px,
                                 double py) {
  const Rigid world_from_camera = Inverse(view.camera_from_world);
  const Camera& camera = view.camera;
  const Eigen::Vector3d direction((px - camera.cx) / camera.fx, (py - camera.cy) / camera.fy, 1);
  const auto mapped = [&](const Eigen::Vector4d& world) -> Eigen::Vector4d {
    return placement.display_from_world * world;
  };
  Eigen::Vector4d centre, at_infinity;
  centre << world_from_camera.translation, 1;
  at_infinity << world_from_camera.rotation * direction, 0;
  // The line c + t a of homogeneous points; z = 0 of their sum.
  const Eigen::Vector4d c = mapped(centre), a = mapped(at_infinity);
  const Eigen::Vector4d point = a.z() * c - c.z() * a;
  return point.head<2>() / point.w();
}

// The first and last whole steps of `pixel` from `first` on that lie within +-half.
struct Range {
  int begin = 0, end = 0;
};
Range Within(double first, double pixel, int count, double half) {
  const auto step = [&](double at) { return (at - first) / pixel; };
  return {std::max(0, static_cast<int>(std::ceil(step(-half) - 1e-6))),
          std::min(count, static_cast<int>(std::floor(step(half) + 1e-6)))};
}

}  // namespace

Eye CentralEye(const Display& display, const Placement& placement, const View& reference,
               const PreviewOptions& options) {
  const int width = reference.camera.width, height = reference.camera.height;
  const Eigen::Vector2d top_left = OnReferencePlane(reference, placement, 0, 0);
  const Eigen::Vector2d size =
      (OnReferencePlane(reference, placement, width, height) - top_left).cwiseAbs();
  Eye eye;
  eye.position = {0, 0, placement.viewing_distance_mm};
  eye.pixel_mm =
      options.eye_pixel_mm
          ? *options.eye_pixel_mm
          : std::max(display.pitch_mm, std::min(size.x(), display.width_mm()) / options.width_px);
  const auto count = [&](double mm) {
    return static_cast<int>(std::floor(mm / eye.pixel_mm + 1e-6));
  };
  const Range columns = Within(top_left.x(), eye.pixel_mm, count(size.x()), display.width_mm() / 2);
  const Range rows = Within(-top_left.y(), eye.pixel_mm, count(size.y()), display.height_mm() / 2);
  if (columns.end <= columns.begin || rows.end <= rows.begin) {
    throw InputError("preview", "the placed picture has no whole eye pixel on the panel",
                     "choose a smaller --preview-eye-pixel-mm or another --layers-mm-per-view-px");
  }
  eye.left_mm = top_left.x() + columns.begin * eye.pixel_mm;
  eye.top_mm = top_left.y() - rows.begin * eye.pixel_mm;
  eye.width = columns.end - columns.begin;
  eye.height = rows.end - rows.begin;
  return eye;
}

std::vector<Eigen::Vector2d> EyeGrid(const PreviewOptions& options) {
  const int n = options.positions;
  const auto at = [&](int i) {
    // Symmetric to the last bit, with an exact 0 in the middle.
    return n == 1 ? 0.0 : options.eye_box_mm * ((2.0 * i - (n - 1)) / (n - 1));
  };
  std::vector<Eigen::Vector2d> eyes;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) eyes.emplace_back(at(column), at(n - 1 - row));
  }
  return eyes;
}

std::vector<double> FocusPlanes(const Display& display, int count) {
  double back = display.layers.front().position_mm, front = display.layers.back().position_mm;
  if (display.layers.size() == 1) {
    back -= DepthBudgetMm(display);
    front += DepthBudgetMm(display);
  }
  std::vector<double> planes;
  for (int i = 0; i < count; ++i) {
    planes.push_back(count == 1 ? (back + front) / 2 : back + (front - back) * i / (count - 1));
  }
  return planes;
}

Eye FocusedOn(const Eye& eye, double plane_mm) {
  const double scale = (eye.position.z() - plane_mm) / (eye.position.z() - eye.plane_mm);
  Eye focused = eye;
  focused.plane_mm = plane_mm;
  focused.left_mm = eye.position.x() + scale * (eye.left_mm - eye.position.x());
  focused.top_mm = eye.position.y() + scale * (eye.top_mm - eye.position.y());
  focused.pixel_mm = scale * eye.pixel_mm;
  return focused;
}

std::vector<Eigen::Vector2d> ParseEyes(const std::string& text) {
  std::vector<Eigen::Vector2d> eyes;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ';');) {
    std::istringstream pair(item);
    Eigen::Vector2d eye;
    char comma = 0;
    if (!(pair >> eye.x() >> comma >> eye.y()) || comma != ',' || !(pair >> std::ws).eof() ||
        !eye.allFinite()) {
      throw UsageError("--preview-eyes", fmt::format("\"{}\" is no eye position", item),
                       "give X,Y in mm, several of them with ; between");
    }
    eyes.push_back(eye);
  }
  return eyes;
}

std::vector<CapturedEye> CapturedEyes(const std::vector<View>& views, const Placement& placement,
                                      const Display& display,
                                      const std::vector<Eigen::Vector2d>& positions,
                                      double pixel_mm) {
  std::vector<CapturedEye> eyes;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const View& view = views[v];
    const Eigen::Vector3d at = EyeOfCamera(placement, view.camera_from_world);
    const bool wanted = std::any_of(positions.begin(), positions.end(), [&](const auto& position) {
      return (at.head<2>() - position).norm() < kSamePlaceMm;
    });
    if (!wanted || !(std::abs(at.z() - placement.viewing_distance_mm) < kSamePlaceMm)) continue;
    const int width = view.camera.width, height = view.camera.height;
    const Eigen::Vector2d origin = OnReferencePlane(view, placement, 0, 0);
    const Eigen::Vector2d right = OnReferencePlane(view, placement, width, 0) - origin;
    const Eigen::Vector2d down = OnReferencePlane(view, placement, 0, height) - origin;
    const double pixel = right.x() / width;
    const double tolerance = kRasterTolerance * pixel;
    if (!(pixel > 0) || std::abs(right.y()) > tolerance || std::abs(down.x()) > tolerance ||
        std::abs(-down.y() - pixel * height) > tolerance) {
      continue;
    }
    CapturedEye captured;
    captured.view = static_cast<int>(v);
    captured.shrink = std::max(1, static_cast<int>(std::lround(pixel_mm / pixel)));
    const int s = captured.shrink;
    const Range columns = Within(origin.x(), s * pixel, width / s, display.width_mm() / 2);
    const Range rows = Within(-origin.y(), s * pixel, height / s, display.height_mm() / 2);
    if (columns.end <= columns.begin || rows.end <= rows.begin) continue;
    captured.pixels = {columns.begin * s, rows.begin * s, (columns.end - columns.begin) * s,
                       (rows.end - rows.begin) * s};
    captured.eye.position = at;
    captured.eye.left_mm = origin.x() + captured.pixels.x * pixel;
    captured.eye.top_mm = origin.y() - captured.pixels.y * pixel;
    captured.eye.pixel_mm = s * pixel;
    captured.eye.width = columns.end - columns.begin;
    captured.eye.height = rows.end - rows.begin;
    eyes.push_back(captured);
  }
  return eyes;
}

}  // namespace lamella
