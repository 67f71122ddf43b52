#include "distribute/place.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

constexpr double kUnboundedMm = std::numeric_limits<double>::infinity();
constexpr double kRangeQuantile = 0.01;

std::optional<double> ParseNumber(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || std::isnan(number)) {
    return std::nullopt;
  }
  return number;
}

// "A,B"
std::pair<double, double> ParsePair(const std::string& text, const std::string& flag) {
  const std::size_t comma = text.find(',');
  if (comma != std::string::npos) {
    const std::optional<double> first = ParseNumber(std::string_view(text).substr(0, comma));
    const std::optional<double> second = ParseNumber(std::string_view(text).substr(comma + 1));
    if (first && second) return {*first, *second};
  }
  throw UsageError(flag, fmt::format("\"{}\" is not two numbers", text), "give NEAR,FAR");
}

struct Hyperbola {  // Z' = 1/(a/Z + b)
  double a = 0, b = 0;
};

// Near to +budget and far to -budget.
Hyperbola FromRange(const DepthRange& range, double distance, double budget) {
  const double near = 1 / (distance - budget), far = 1 / (distance + budget);
  const double a = (near - far) / (1 / range.near - 1 / range.far);
  return {a, far - a / range.far};
}

// The similarity that has near and far equally far before and behind z = 0.
Hyperbola Similar(const DepthRange& range, double distance) {
  return {(range.near + range.far) / (2 * distance), 0};
}

// The focus to 0, near and far within the budget.
Hyperbola FromFocus(const DepthRange& range, double focus, double distance, double budget) {
  double a = kUnboundedMm;
  if (range.near < focus) {
    a = std::min(a, (1 / (distance - budget) - 1 / distance) / (1 / range.near - 1 / focus));
  }
  if (range.far > focus) {
    a = std::min(a, (1 / distance - 1 / (distance + budget)) / (1 / focus - 1 / range.far));
  }
  return {a, 1 / distance - a / focus};
}

Hyperbola PlaceRange(const DepthRange& range, const PlacementOptions& options, double distance,
                     double budget, std::string* note) {
  Hyperbola h;
  if (options.focus) {
    h = FromFocus(range, *options.focus, distance, budget);
    if (h.b >= 0) return h;
    h = {*options.focus / distance, 0};
  } else {
    if (range.near < range.far) h = FromRange(range, distance, budget);
    if (range.near < range.far && h.b >= 0) return h;
    h = Similar(range, distance);
  }
  if (note) {
    *note = fmt::format(
        "the scene is shallower than the depth budget of {:g} mm: it keeps its proportions "
        "and uses {:.3g} mm in front and {:.3g} mm behind",
        budget, distance - range.near / h.a, range.far / h.a - distance);
  }
  return h;
}

void CheckRange(const DepthRange& range, const PlacementOptions& options, double distance,
                double budget) {
  if (!(range.near > 0 && std::isfinite(range.near) && range.far >= range.near)) {
    throw UsageError("--depth-range",
                     fmt::format("{:g} to {:g} is no range", range.near, range.far),
                     "give 0 < NEAR <= FAR; FAR may be inf");
  }
  if (!(std::isfinite(distance) && distance > 0)) {
    throw UsageError("--viewing-distance", fmt::format("{:g} mm", distance), "give millimetres");
  }
  if (!(budget > 0 && budget < distance)) {
    throw UsageError("--depth-budget",
                     fmt::format("{:g} mm at a viewing distance of {:g} mm", budget, distance),
                     "give millimetres between 0 and the viewing distance");
  }
  if (options.focus && !(*options.focus > 0 && std::isfinite(*options.focus))) {
    throw UsageError("--focus", fmt::format("{:g} is no depth", *options.focus),
                     "give a positive depth in world units");
  }
}

// display_from_camera as a projective map: with s = a + b Z,
//   x = k f (X - t_x Z)/s,  y = -k f (Y - t_y Z)/s,  z = D - Z/s.
Eigen::Matrix4d DisplayFromCamera(const Placement& p) {
  const double kf = p.mm_per_view_px / p.viewing_distance_mm * p.focal_px;
  Eigen::Matrix4d m;
  m << kf, 0, -kf * p.middle.x(), 0,                                       //
      0, -kf, kf * p.middle.y(), 0,                                        //
      0, 0, p.viewing_distance_mm * p.b - 1, p.viewing_distance_mm * p.a,  //
      0, 0, p.b, p.a;
  return m;
}

// Its inverse, written out since the product's numeric inverse loses digits for far-off worlds:
// a homogeneous display point (x, y, z, h) has Z = D h - z, W = (h - b Z)/a.
Eigen::Vector4d CameraFromDisplay(const Placement& p, const Eigen::Vector4d& display) {
  const double kf = p.mm_per_view_px / p.viewing_distance_mm * p.focal_px;
  const double z = p.viewing_distance_mm * display.w() - display.z();
  return {display.x() / kf + p.middle.x() * z, -display.y() / kf + p.middle.y() * z, z,
          (display.w() - p.b * z) / p.a};
}

// Bundles of the display's frame in the world.
class BundlePlacer {
 public:
  explicit BundlePlacer(const Placement& placement)
      : placement_(placement), world_from_camera_(Inverse(placement.camera_from_world)) {}

  // The same rays, crossing a plane that is in front of the reference camera and not at infinity.
  // Only a focus beyond the scene puts z = 0 there.
  RayBundle OnVisiblePlane(const RayBundle& bundle) const {
    if (bundle.dx.z() != 0 || bundle.dy.z() != 0) {
      throw std::invalid_argument("a placed bundle's plane must be parallel to z = 0");
    }
    const double furthest = placement_.b > 0 ? 1 / placement_.b : kUnboundedMm;  // Z' of infinity
    const double z = bundle.origin.z();
    if (placement_.viewing_distance_mm - z < 0.999 * furthest) return bundle;
    RayBundle moved = bundle;
    const double plane = placement_.viewing_distance_mm - furthest / 2;
    if (bundle.centre.w() == 0) {
      moved.origin += bundle.centre.head<3>() * ((plane - z) / bundle.centre.z());
      return moved;
    }
    const Eigen::Vector3d centre = bundle.centre.head<3>() / bundle.centre.w();
    const double scale = (centre.z() - plane) / (centre.z() - z);
    moved.origin = centre + scale * (bundle.origin - centre);
    moved.dx *= scale;
    moved.dy *= scale;
    return moved;
  }

  RayBundle InWorld(const RayBundle& display) const {
    RayBundle world = display;
    const Eigen::Vector4d centre = CameraFromDisplay(placement_, display.centre);
    const Eigen::Vector4d origin = CameraFromDisplay(
        placement_, {display.origin.x(), display.origin.y(), display.origin.z(), 1});
    const double kf =
        placement_.mm_per_view_px / placement_.viewing_distance_mm * placement_.focal_px;
    const auto turn = [&](double x, double y) -> Eigen::Vector3d {
      return world_from_camera_.rotation * Eigen::Vector3d(x, -y, 0) / (kf * origin.w());
    };
    world.origin = world_from_camera_ * (origin.head<3>() / origin.w()).eval();
    world.dx = turn(display.dx.x(), display.dx.y());
    world.dy = turn(display.dy.x(), display.dy.y());
    // A centre a billion times further off than the plane is a direction.
    const bool far_off =
        std::abs(centre.w()) * 1e9 * origin.z() < std::abs(origin.w()) * centre.head<3>().norm();
    if (far_off) {
      const double sign = centre.z() > 0 ? -1 : 1;  // towards the viewer
      world.centre << world_from_camera_.rotation * (sign * centre.head<3>().normalized()), 0;
    } else {
      world.centre << world_from_camera_ * (centre.head<3>() / centre.w()).eval(), 1;
    }
    return world;
  }

 private:
  const Placement placement_;
  const Rigid world_from_camera_;
};

// Bundles go into the world, and z comes back.
class PlacedSource final : public RaySource {
 public:
  PlacedSource(const RaySource& world, const Placement& placement)
      : world_(world), placement_(placement), placer_(placement) {}

  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    const RayBundle display = placer_.OnVisiblePlane(bundle);
    world_.Query(placer_.InWorld(display), rectangle, samples);
    const double plane_depth = Depth(display.origin.z());
    ParallelFor(0, rectangle.height, 64, [&](std::int64_t first, std::int64_t last) {
      for (int y = static_cast<int>(first); y < last; ++y) {
        for (int x = 0; x < rectangle.width; ++x) {
          float& z = samples(x, y).z;
          z = static_cast<float>(placement_.ZFromDepth(plane_depth - static_cast<double>(z)) -
                                 bundle.origin.z());
        }
      }
    });
  }

  double QueryBytes(int width, int height) const override {
    return world_.QueryBytes(width, height);
  }

 private:
  double Depth(double z) const {
    const double distance = placement_.viewing_distance_mm - z;
    return placement_.a / (1 / distance - placement_.b);
  }

  const RaySource& world_;
  const Placement placement_;
  const BundlePlacer placer_;
};

}  // namespace

std::vector<OptionField> Describe(PlacementOptions& o) {
  return {
      {"depth_range",
       "NEAR,FAR: world depths that go to the ends of the depth budget; FAR may be "
       "inf (default: 1 % and 99 % quantiles of the capture's depth)",
       &o.depth_range,
       {},
       {},
       {},
       "--depth-range"},
      {"disparity_range",
       "NEAR,FAR: the same as disparities, px per step of a camera grid",
       &o.disparity_range,
       {},
       {},
       {},
       "--disparity-range"},
      {"depth_budget_mm",
       "near goes this far in front of z = 0 and far as far behind "
       "(default: as deep as the layers are sharp)",
       &o.depth_budget_mm,
       1e-6,
       1e6,
       {},
       "--depth-budget"},
      {"mm_per_view_px",
       "size of a pixel of the reference view on z = 0, mm "
       "(default: the whole picture fits the panel)",
       &o.mm_per_view_px,
       1e-9,
       1e6,
       {},
       "--mm-per-view-px"},
      {"viewing_distance_mm",
       "from the viewer to z = 0, mm (default: the display's)",
       &o.viewing_distance_mm,
       1e-3,
       1e6,
       {},
       "--viewing-distance"},
      {"focus",
       "world depth that is shown on z = 0 (default: follows from the range)",
       &o.focus,
       0,
       1e300,
       {},
       "--focus"},
      {"reference_view",
       "the view that an eye in the middle sees (default: the most central)",
       &o.reference_view,
       {},
       {},
       {},
       "--reference-view"},
  };
}

double Placement::ZFromDepth(double depth) const {
  if (std::isinf(depth)) return b > 0 ? viewing_distance_mm - 1 / b : -kUnboundedMm;
  return viewing_distance_mm - depth / (a + b * depth);
}

const View& ReferenceView(const std::vector<View>& views, const std::string& name) {
  if (!name.empty()) {
    std::vector<std::string> names;
    for (const View& view : views) {
      if (view.name == name) return view;
      names.push_back(view.name);
    }
    throw UsageError("--reference-view", fmt::format("no view is called \"{}\"", name),
                     fmt::format("did you mean \"{}\"?", NearestName(name, names)));
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : views) mean += Centre(view.camera_from_world);
  mean /= static_cast<double>(views.size());
  const auto distance = [&](const View& v) { return (Centre(v.camera_from_world) - mean).norm(); };
  const View* nearest = &views.at(0);
  for (const View& view : views) {
    if (distance(view) < (1 - 1e-9) * distance(*nearest)) nearest = &view;
  }
  return *nearest;
}

DepthRange DepthRangeOf(std::vector<double> inverse_depths) {
  const auto quantile = [&](double share) {
    const auto rank = static_cast<std::ptrdiff_t>(
        std::floor(share * static_cast<double>(inverse_depths.size() - 1) + 0.5));
    std::nth_element(inverse_depths.begin(), inverse_depths.begin() + rank, inverse_depths.end());
    return inverse_depths[static_cast<std::size_t>(rank)];
  };
  const double near = inverse_depths.empty() ? 0 : quantile(1 - kRangeQuantile);
  if (!(near > 0)) {
    throw InputError("depth", "no known depth of the capture is finite",
                     "give the range with --depth-range NEAR,FAR");
  }
  return {1 / near, 1 / quantile(kRangeQuantile)};
}

DepthRange ChooseDepthRange(const PlacementOptions& options, const std::optional<RegularGrid>& grid,
                            const std::function<DepthRange()>& of_capture) {
  if (!options.depth_range.empty() && !options.disparity_range.empty()) {
    throw UsageError("--disparity-range", "was given beside --depth-range", "give one of them");
  }
  if (!options.depth_range.empty()) {
    const auto [near, far] = ParsePair(options.depth_range, "--depth-range");
    return {near, far};
  }
  if (options.disparity_range.empty()) return of_capture();
  if (!grid) {
    throw UsageError("--disparity-range", "the capture is no camera grid",
                     "give the range with --depth-range NEAR,FAR");
  }
  // Near is the larger disparity, in whichever order the two are given.
  const auto [first, second] = ParsePair(options.disparity_range, "--disparity-range");
  const double near = grid->InverseDepthFromDisparity(std::max(first, second));
  const double far = grid->InverseDepthFromDisparity(std::min(first, second));
  if (!(near > 0 && far >= 0)) {
    throw UsageError("--disparity-range",
                     fmt::format("a disparity of {:g} px lies beyond infinity, which is at {:g} px",
                                 std::min(first, second), grid->DisparityFromInverseDepth(0)),
                     "give disparities above that");
  }
  return {1 / near, 1 / far};
}

Placement Place(const View& reference, double near, double far, const Display& display,
                const PlacementOptions& options, std::string* note) {
  const DepthRange range{near, far};
  Placement p;
  p.reference_view = reference.name;
  p.camera_from_world = reference.camera_from_world;
  p.viewing_distance_mm = options.viewing_distance_mm.value_or(display.viewing_distance_mm);
  // Content must stay well in front of the viewer, however deep the display is sharp.
  const double budget =
      options.depth_budget_mm.value_or(std::min(DepthBudgetMm(display), p.viewing_distance_mm / 2));
  CheckRange(range, options, p.viewing_distance_mm, budget);
  const Hyperbola h = PlaceRange(range, options, p.viewing_distance_mm, budget, note);
  p.a = h.a;
  p.b = h.b;
  const Camera& camera = reference.camera;
  p.focal_px = camera.fx;
  p.middle = {(camera.width / 2.0 - camera.cx) / camera.fx,
              (camera.height / 2.0 - camera.cy) / camera.fy};
  const double height_px = camera.height * camera.fx / camera.fy;  // in pixels as wide as fx says
  p.mm_per_view_px = options.mm_per_view_px.value_or(
      std::min(display.width_mm() / camera.width, display.height_mm() / height_px));
  p.picture_width_mm = p.mm_per_view_px * camera.width;
  p.picture_height_mm = p.mm_per_view_px * height_px;
  p.near = near;
  p.far = far;
  p.near_mm = p.ZFromDepth(near);
  p.far_mm = p.ZFromDepth(far);
  Eigen::Matrix4d camera_from_world = Eigen::Matrix4d::Identity();
  camera_from_world.topRows<3>() = reference.camera_from_world.Matrix();
  p.display_from_world = DisplayFromCamera(p) * camera_from_world;
  return p;
}

std::unique_ptr<RaySource> Placed(const RaySource& world, const Placement& placement) {
  return std::make_unique<PlacedSource>(world, placement);
}

RayBundle InWorld(const RayBundle& bundle, const Placement& placement) {
  const BundlePlacer placer(placement);
  return placer.InWorld(placer.OnVisiblePlane(bundle));
}

Eigen::Vector3d EyeOfCamera(const Placement& placement, const Rigid& camera_from_world) {
  const Eigen::Vector3d centre = placement.camera_from_world * Centre(camera_from_world);
  const Eigen::Vector4d eye =
      DisplayFromCamera(placement) * Eigen::Vector4d(centre.x(), centre.y(), centre.z(), 1);
  return eye.head<3>() / eye.w();
}

}  // namespace lamella
