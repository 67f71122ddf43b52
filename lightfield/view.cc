#include "lightfield/view.h"

#include <cmath>

namespace lamella {
namespace {

// Least squares through the origin: y = slope * x. Where all x are 0, nothing.
struct Slope {
  double xy = 0, xx = 0;
  void Add(double x, double y) {
    xy += x * y;
    xx += x * x;
  }
  std::optional<double> Value() const {
    return xx > 0 ? std::optional<double>(xy / xx) : std::nullopt;
  }
};

struct Offset {  // of a view from the first one, in the first one's camera frame
  double columns, rows;
  Eigen::Vector3d centre;
  Eigen::Vector2d principal_point;
};

bool SameOptics(const View& a, const View& b) {
  const double angle = a.camera_from_world.rotation.angularDistance(b.camera_from_world.rotation);
  const double f = a.camera.fx;
  return a.camera.model == CameraModel::kPinhole && b.camera.model == CameraModel::kPinhole &&
         a.camera.width == b.camera.width && a.camera.height == b.camera.height && angle < 1e-6 &&
         std::abs(b.camera.fx - f) < 1e-6 * f && std::abs(b.camera.fy - f) < 1e-6 * f;
}

}  // namespace

std::optional<RegularGrid> FindRegularGrid(const std::vector<View>& views) {
  if (views.size() < 2 || !views[0].grid) return std::nullopt;
  const View& first = views[0];
  std::vector<Offset> offsets;
  Slope baseline, shift;
  for (const View& view : views) {
    if (!view.grid || !SameOptics(first, view)) return std::nullopt;
    const Offset o{static_cast<double>(view.grid->column - first.grid->column),
                   static_cast<double>(view.grid->row - first.grid->row),
                   first.camera_from_world * Centre(view.camera_from_world),
                   {view.camera.cx - first.camera.cx, view.camera.cy - first.camera.cy}};
    baseline.Add(o.columns, o.centre.x());
    baseline.Add(o.rows, o.centre.y());
    shift.Add(o.columns, o.principal_point.x());
    shift.Add(o.rows, o.principal_point.y());
    offsets.push_back(o);
  }
  const std::optional<double> step = baseline.Value();
  if (!step || !(*step > 0)) return std::nullopt;
  for (const Offset& o : offsets) {
    const Eigen::Vector3d lattice(o.columns * *step, o.rows * *step, 0);
    const Eigen::Vector2d sensor(o.columns * *shift.Value(), o.rows * *shift.Value());
    if ((o.centre - lattice).norm() > 1e-3 * *step) return std::nullopt;
    if ((o.principal_point - sensor).norm() > 1e-2) return std::nullopt;
  }
  const double f = first.camera.fx;
  return RegularGrid{*step * f, *shift.Value() / (*step * f)};
}

}  // namespace lamella
