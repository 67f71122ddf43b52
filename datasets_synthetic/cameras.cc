#include "datasets_synthetic/cameras.h"

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

constexpr double kRadians = std::numbers::pi / 180;

struct Shape2 {
  int rows, columns;
};

Shape2 GridShape(const CameraLayout& layout, const std::string& where) {
  if (layout.rows > 0 && layout.columns > 0) return {layout.rows, layout.columns};
  const int known = std::max(layout.rows, layout.columns);
  if (known > 0) {
    if (layout.views % known != 0) {
      throw UsageError(where,
                       fmt::format("{} views do not fill {} {}", layout.views, known,
                                   layout.rows > 0 ? "rows" : "columns"),
                       "give rows and columns");
    }
    const int other = layout.views / known;
    return layout.rows > 0 ? Shape2{known, other} : Shape2{other, known};
  }
  const int side = static_cast<int>(std::lround(std::sqrt(layout.views)));
  if (side * side != layout.views) {
    throw UsageError(where, fmt::format("{} views are no square grid", layout.views),
                     fmt::format("give views = {}, or rows and columns", side * side));
  }
  return {side, side};
}

Camera CameraOf(const CameraLayout& layout) {
  Camera camera;
  camera.width = layout.width_px;
  camera.height = layout.height_px > 0 ? layout.height_px : (layout.width_px * 3 + 2) / 4;
  camera.fx = camera.fy = layout.focal_per_width * camera.width;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  return camera;
}

Vector3d MiddleCentre(const CameraLayout& layout) {
  return layout.target + Vector3d(0, layout.height, layout.distance);
}

View ViewAt(const Camera& camera, const Rigid& camera_from_world) {
  View view;
  view.camera = camera;
  view.camera_from_world = camera_from_world;
  return view;
}

// A camera `x` to the right of the middle one and `y` below it.
View Displaced(const CameraLayout& layout, const Camera& camera, const Rigid& middle, double x,
               double y) {
  const Vector3d centre = Inverse(middle) * Vector3d(x, y, 0);
  if (layout.aim == "converged") {
    return ViewAt(camera, LookAt(centre, layout.target, Vector3d::UnitY()));
  }
  Rigid pose = middle;
  pose.translation -= Vector3d(x, y, 0);
  View view = ViewAt(camera, pose);
  if (layout.aim == "off-axis") {
    // The target's plane at Z = zero_depth: a point at X is seen at cx + f (X - x)/Z, the same
    // in all views where cx grows by f x/Z.
    const double zero_depth = (middle * layout.target).z();
    view.camera.cx += camera.fx * x / zero_depth;
    view.camera.cy += camera.fy * y / zero_depth;
  }
  return view;
}

std::vector<View> Grid(const CameraLayout& layout, const Camera& camera, Shape2 shape,
                       NormalSequence* jitter) {
  const Rigid middle = LookAt(MiddleCentre(layout), layout.target, Vector3d::UnitY());
  std::vector<View> views;
  for (int row = 0; row < shape.rows; ++row) {
    for (int column = 0; column < shape.columns; ++column) {
      double x = column - 0.5 * (shape.columns - 1), y = row - 0.5 * (shape.rows - 1);
      if (jitter) {
        x += layout.place_jitter * (*jitter)();
        y += layout.place_jitter * (*jitter)();
      }
      views.push_back(Displaced(layout, camera, middle, layout.spacing * x, layout.spacing * y));
      if (!jitter && layout.aim != "converged") views.back().grid = GridPosition{row, column};
    }
  }
  return views;
}

// A spiral with the golden angle from the middle of the cap outwards: equal areas per view.
std::vector<View> Dome(const CameraLayout& layout, const Camera& camera) {
  const Vector3d offset = MiddleCentre(layout) - layout.target;
  const double radius = offset.norm();
  const Rigid middle = LookAt(MiddleCentre(layout), layout.target, Vector3d::UnitY());
  const double depth_of_cap = 1 - std::cos(0.5 * layout.angle_deg * kRadians);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<View> views;
  for (int i = 0; i < layout.views; ++i) {
    const double cosine = 1 - depth_of_cap * (i + 0.5) / layout.views;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const Vector3d in_middle(sine * std::cos(i * golden), sine * std::sin(i * golden), -cosine);
    const Vector3d centre =
        layout.target + radius * (middle.rotation.conjugate() * in_middle).normalized();
    views.push_back(ViewAt(camera, LookAt(centre, layout.target, Vector3d::UnitY())));
  }
  return views;
}

std::vector<View> Arc(const CameraLayout& layout, const Camera& camera, std::uint32_t seed) {
  const double unsteady = layout.layout == "handheld" ? 1 : 0;
  HandheldArc arc;
  arc.target = layout.target;
  arc.radius = layout.distance;
  arc.height = layout.height;
  arc.angle_deg = layout.angle_deg;
  arc.place_jitter = unsteady * layout.place_jitter;
  arc.aim_jitter_deg = unsteady * layout.aim_jitter_deg;
  arc.roll_jitter_deg = unsteady * layout.roll_jitter_deg;
  std::vector<View> views;
  for (const Rigid& pose : CamerasOnArc(arc, layout.views, seed)) {
    views.push_back(ViewAt(camera, pose));
  }
  return views;
}

}  // namespace

Rigid LookAt(const Vector3d& centre, const Vector3d& target, const Vector3d& up) {
  const Vector3d z = (target - centre).normalized();
  Vector3d across = z.cross(up);
  if (across.norm() < 1e-9 * up.norm()) across = z.cross(Vector3d(up.y(), up.z(), up.x()));
  const Vector3d x = across.normalized();
  Eigen::Matrix3d camera_from_world;
  camera_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
  Rigid pose;
  pose.rotation = Eigen::Quaterniond(camera_from_world);
  pose.translation = -(pose.rotation * centre);
  return pose;
}

std::vector<Rigid> CamerasOnArc(const HandheldArc& arc, int num_views, std::uint32_t seed) {
  NormalSequence normal(seed);
  std::vector<Rigid> cameras;
  for (int i = 0; i < num_views; ++i) {
    const double share = num_views > 1 ? static_cast<double>(i) / (num_views - 1) - 0.5 : 0.0;
    const double angle = share * arc.angle_deg * kRadians;
    Vector3d centre = arc.target + Vector3d(arc.radius * std::sin(angle), arc.height,
                                            arc.radius * std::cos(angle));
    for (int axis = 0; axis < 3; ++axis) centre(axis) += arc.place_jitter * arc.radius * normal();
    Vector3d aim = arc.target;
    for (int axis = 0; axis < 3; ++axis) {
      aim(axis) += std::tan(arc.aim_jitter_deg * kRadians) * arc.radius * normal();
    }
    const double roll = arc.roll_jitter_deg * kRadians * normal();
    cameras.push_back(LookAt(centre, aim, {std::sin(roll), std::cos(roll), 0}));
  }
  return cameras;
}

OptionTable Describe(CameraLayout& l) {
  const double inf = std::numeric_limits<double>::infinity();
  const double tiny = 1e-12;
  return {
      "cameras",
      {{"layout",
        "how the cameras stand",
        &l.layout,
        -inf,
        inf,
        {"handheld", "arc", "line", "grid", "jittered-grid", "dome"},
        "--layout"},
       {"views", "number of photographs", &l.views, 1, 10000, {}, "--views"},
       {"rows", "of a grid; 0: follows from views", &l.rows, 0, 1000, {}, "--rows"},
       {"columns", "of a grid; 0: follows from views", &l.columns, 0, 1000, {}, "--columns"},
       {"aim",
        "of lines and grids; off-axis: parallel, with shifted pictures",
        &l.aim,
        -inf,
        inf,
        {"off-axis", "converged", "parallel"},
        "--aim"},
       {"distance", "of the middle camera from the target, world units", &l.distance, tiny},
       {"height", "of the middle camera above the target, world units", &l.height},
       {"angle_deg", "of arcs, from first to last view; of a dome, across", &l.angle_deg, 0, 360},
       {"spacing", "from camera to camera of lines and grids, world units", &l.spacing, 0},
       {"place_jitter", "handheld: share of the distance; jittered-grid: of the spacing",
        &l.place_jitter, 0, 10},
       {"aim_jitter_deg", "of handheld", &l.aim_jitter_deg, 0, 45},
       {"roll_jitter_deg", "of handheld", &l.roll_jitter_deg, 0, 180},
       {"width_px", "width of the photographs, px", &l.width_px, 16, 16384, {}, "--width-px"},
       {"height_px",
        "their height, px; 0: three quarters of the width",
        &l.height_px,
        0,
        16384,
        {},
        "--height-px"},
       {"focal_per_width", "focal length of the camera, in widths of the picture",
        &l.focal_per_width, 1e-5, 1e5}}};
}

std::vector<View> CamerasOf(const CameraLayout& layout, std::uint32_t seed,
                            const std::string& where) {
  const Camera camera = CameraOf(layout);
  std::vector<View> views;
  if (layout.layout == "grid") {
    views = Grid(layout, camera, GridShape(layout, where), nullptr);
  } else if (layout.layout == "jittered-grid") {
    NormalSequence jitter(seed);
    views = Grid(layout, camera, GridShape(layout, where), &jitter);
  } else if (layout.layout == "line") {
    views = Grid(layout, camera, {1, layout.views}, nullptr);
    for (View& view : views) view.grid.reset();
  } else if (layout.layout == "dome") {
    views = Dome(layout, camera);
  } else {
    views = Arc(layout, camera, seed);
  }
  for (std::size_t i = 0; i < views.size(); ++i) views[i].name = fmt::format("view_{:03}", i + 1);
  return views;
}

}  // namespace lamella
