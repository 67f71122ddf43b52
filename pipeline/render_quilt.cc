#include "pipeline/render_quilt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/display.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/looking_glass.h"
#include "lightfield/published_quilts.h"
#include "lightfield/weave_quilt.h"
#include "pipeline/capture_source.h"
#include "pipeline/make_quilt.h"
#include "pipeline/pipeline.h"
#include "pipeline/place_capture.h"
#include "pipeline/poses_record.h"
#include "pipeline/visual_json.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr double kScreenDeg = 14;       // vertical field of view of published cameras
constexpr int kStripSamples = 1 << 22;  // rays that are asked for at once
constexpr double kWellSeen = 0.9;       // of the picture, in every view

// A panel under its sheet of lenses. The gap is what gives the lenses the cone, and so the depth to
// which the display is sharp by the paper's box is that at which a point moves by one lens from a
// view to the next: beyond it views fall apart.
Display DisplayOf(const LookingGlass& panel, double cone_deg, int views) {
  const double half_cone = cone_deg / 2 * std::numbers::pi / 180;
  const double half_screen = kScreenDeg / 2 * std::numbers::pi / 180;
  Display display;
  display.width_px = panel.width_px;
  display.height_px = panel.height_px;
  display.pitch_mm = 25.4 / panel.dpi;
  display.viewing_distance_mm = display.height_mm() / 2 / std::tan(half_screen);
  Lenticular lenses;
  lenses.subpixels_per_lens = 3 * panel.width_px / WeaveOf(panel).lenses;
  lenses.slant = 1 / panel.slope;
  lenses.views = views;
  Layer layer;
  layer.optics = lenses;
  layer.d0_mm = display.width_mm() / WeaveOf(panel).lenses / (2 * std::tan(half_cone));
  display.layers.push_back(layer);
  return display;
}

// The device's numbers, or the Portrait's with the aspect and the height that the options want.
LookingGlass PanelFor(const RenderQuiltOptions& options, const std::optional<VisualJson>& visual) {
  if (visual) return visual->panel;
  LookingGlass panel = NominalPortrait();
  if (options.aspect) {
    panel.width_px = std::max(1, static_cast<int>(std::lround(panel.height_px * *options.aspect)));
  }
  if (options.screen_height_mm) panel.dpi = 25.4 * panel.height_px / *options.screen_height_mm;
  return panel;
}

struct QuiltShape {
  QuiltLayout layout;
  int views = 0, width_px = 0, height_px = 0;

  int tile_width_px() const { return width_px / layout.columns; }
  int tile_height_px() const { return height_px / layout.rows; }
};

// As the options have it. A size that they leave open is the published one where the grid and the
// aspect are, else that of square pixels, as many as the published quilt's.
QuiltShape ShapeFor(const RenderQuiltOptions& options, double aspect,
                    const PublishedQuilt& published) {
  QuiltShape shape;
  QuiltLayout& layout = shape.layout;
  layout = {options.columns > 0 ? options.columns : published.columns,
            options.rows > 0 ? options.rows : published.rows, aspect};
  const bool is_published = layout.columns == published.columns && layout.rows == published.rows &&
                            !options.aspect && options.width_px == 0 && options.height_px == 0;
  if (is_published) {
    shape.width_px = published.width_px;
    shape.height_px = published.height_px;
  } else {
    const double tile_px =
        1.0 * published.width_px * published.height_px / (1.0 * layout.columns * layout.rows);
    const double tile_height = options.height_px > 0 ? 1.0 * options.height_px / layout.rows
                               : options.width_px > 0
                                   ? 1.0 * options.width_px / layout.columns / aspect
                                   : std::sqrt(tile_px / aspect);
    const auto whole = [](double px) { return std::max(1, static_cast<int>(std::lround(px))); };
    shape.width_px =
        options.width_px > 0 ? options.width_px : layout.columns * whole(aspect * tile_height);
    shape.height_px = options.height_px > 0 ? options.height_px : layout.rows * whole(tile_height);
  }
  shape.views = options.views > 0 ? options.views : layout.columns * layout.rows;
  return shape;
}

void CheckShape(const QuiltShape& shape) {
  const auto& [columns, rows, aspect] = shape.layout;
  if (shape.tile_width_px() < 1 || shape.tile_height_px() < 1) {
    throw UsageError("quilt",
                     fmt::format("{} x {} px are too few for {} x {} tiles", shape.width_px,
                                 shape.height_px, columns, rows),
                     "give a larger --width and --height, or fewer tiles");
  }
  CheckQuiltSize(shape.layout, shape.tile_width_px(), shape.tile_height_px());
  if (shape.views > columns * rows) {
    throw UsageError("--views",
                     fmt::format("{} x {} tiles hold no {} views", columns, rows, shape.views),
                     "give fewer, or more --columns or --rows");
  }
}

// What follows from the options alone.
struct QuiltPlan {
  std::optional<VisualJson> visual;
  ViewFilter filter = ViewFilter::kNearest;
  double cone_deg = 0;
  QuiltShape shape;
  Display display;
};

QuiltPlan PlanFor(const RenderQuiltOptions& options) {
  QuiltPlan plan;
  if (!options.visual.empty()) plan.visual = ReadVisualJson(options.visual);
  plan.filter = ViewFilterOf(options.filter);
  const LookingGlass panel = PanelFor(options, plan.visual);
  const double aspect = options.aspect.value_or(1.0 * panel.width_px / panel.height_px);
  plan.shape = ShapeFor(options, aspect,
                        PublishedQuiltFor(plan.visual ? plan.visual->serial : "", aspect < 1));
  CheckShape(plan.shape);
  plan.cone_deg =
      options.cone_deg.value_or(plan.visual ? plan.visual->view_cone_deg : kNominalConeDeg);
  plan.display = DisplayOf(panel, plan.cone_deg, plan.shape.views);
  return plan;
}

QuiltCameras CamerasFor(const Display& display, const QuiltShape& shape, double cone_deg,
                        double viewing_distance_mm) {
  QuiltCameras cameras;
  cameras.views = shape.views;
  cameras.cone_deg = cone_deg;
  cameras.half_height = display.height_mm() / 2;
  cameras.aspect = *shape.layout.aspect;
  cameras.vertical_deg =
      2 * std::atan(cameras.half_height / viewing_distance_mm) * 180 / std::numbers::pi;
  return cameras;
}

// Sums of coverage over rays.
struct Coverage {
  double sum = 0;
  std::int64_t rays = 0;
  void Add(float coverage) {
    sum += static_cast<double>(coverage);
    ++rays;
  }
  double Mean() const { return rays > 0 ? sum / static_cast<double>(rays) : 0; }
};

// A view's tile, drawn into `tile`.
class TileDrawer {
 public:
  TileDrawer(const RaySource& source, const RayBundle& rays, const Eigen::Vector2d& picture_mm)
      : source_(source), rays_(rays), half_picture_(picture_mm / 2) {}

  void Draw(ImageSpan<Rgb8> tile) {
    const int strip = std::max(1, kStripSamples / rays_.width);
    for (int row = 0; row < rays_.height; row += strip) {
      DrawRows(row, std::min(strip, rays_.height - row), tile);
    }
  }
  double Seen() const { return all_.Mean(); }
  double SeenInPicture() const { return in_picture_.Mean(); }

 private:
  void DrawRows(int first, int count, ImageSpan<Rgb8> tile) {
    Image<RaySample> samples(rays_.width, count);
    source_.Query(rays_, {0, first, rays_.width, count}, samples.span());
    Image<Rgb> light(rays_.width, count);
    for (int y = 0; y < count; ++y) {
      for (int x = 0; x < rays_.width; ++x) {
        const RaySample& sample = samples(x, y);
        light(x, y) = sample.color;
        all_.Add(sample.coverage);
        const Eigen::Vector3d at = rays_.PlanePoint(x + 0.5, first + y + 0.5);
        if (std::abs(at.x()) < half_picture_.x() && std::abs(at.y()) < half_picture_.y()) {
          in_picture_.Add(sample.coverage);
        }
      }
    }
    const Image<Rgb8> codes = EncodeSrgb8(light.span());
    for (int y = 0; y < count; ++y) {
      std::copy_n(codes.span().row(y), rays_.width, tile.row(first + y));
    }
  }

  const RaySource& source_;
  const RayBundle rays_;
  const Eigen::Vector2d half_picture_;
  Coverage all_, in_picture_;
};

// How far left and right the capture's cameras stand among the quilt's, in the same directions from
// the middle of the screen.
struct Reach {
  double left_mm = 0, right_mm = 0;  // <= 0, >= 0
};
Reach ReachOf(const std::vector<View>& views, const Placement& placement) {
  Reach reach;
  for (const View& view : views) {
    const Eigen::Vector3d eye = EyeOfCamera(placement, view.camera_from_world);
    if (!(eye.z() > 0)) continue;  // behind the screen
    const double x = eye.x() * placement.viewing_distance_mm / eye.z();
    reach.left_mm = std::min(reach.left_mm, x);
    reach.right_mm = std::max(reach.right_mm, x);
  }
  return reach;
}

// The depth budget B with which a reach that is `share` of what a view needs is as far as that: it
// goes as 1/a of Z' = 1/(a/Z + b), and a as B/(D^2 - B^2).
double BudgetWithin(const Placement& placement, double share) {
  const double distance = placement.viewing_distance_mm;
  const double budget = (placement.near_mm - placement.far_mm) / 2;
  const double wanted = share * budget / (distance * distance - budget * budget);
  return (std::sqrt(1 + 4 * wanted * wanted * distance * distance) - 1) / (2 * wanted);
}

// What to do where a view is badly seen; nothing where all are well seen.
std::string UnseenNote(const RenderedQuilt& quilt, const Reach& reach) {
  const std::vector<double>& seen = quilt.seen_in_picture;
  const auto worst = std::min_element(seen.begin(), seen.end());
  if (*worst >= kWellSeen) return "";
  const auto view = static_cast<int>(worst - seen.begin());
  std::string note = fmt::format(
      "the capture saw {:.0f} % of the picture of view {} and {:.0f} % of the middle one's",
      100 * *worst, view, 100 * seen[seen.size() / 2]);
  const double camera_mm = CameraOf(quilt.cameras, view).x;
  const double reach_mm = camera_mm < 0 ? -reach.left_mm : reach.right_mm;
  const double needed_mm = std::abs(camera_mm);
  if (reach_mm >= needed_mm) return note;
  note += fmt::format("; that view is from {:.0f} mm aside, the capture's cameras reach {:.0f} mm",
                      needed_mm, reach_mm);
  if (const double budget = BudgetWithin(quilt.placement, reach_mm / needed_mm); budget > 0) {
    note += fmt::format(": --depth-budget {:.2g} brings it between them", budget);
  }
  return note;
}

std::vector<std::pair<std::string, std::string>> SummaryOf(const RenderedQuilt& quilt,
                                                           const RenderQuiltOptions& options,
                                                           const QuiltPlan& plan,
                                                           const Reach& reach) {
  auto summary = SummaryOf(quilt.placement);
  const Placement& p = quilt.placement;
  const Display& display = plan.display;
  const QuiltShape& shape = plan.shape;
  const double fill =
      std::max(display.width_mm() / p.picture_width_mm, display.height_mm() / p.picture_height_mm);
  std::string of_screen =
      fmt::format("{:.1f} x {:.1f} mm", display.width_mm(), display.height_mm());
  if (fill > 1.005) {
    of_screen += fmt::format("; --mm-per-view-px {:.4g} fills it", fill * p.mm_per_view_px);
  }
  summary.emplace_back("screen", of_screen);
  summary.emplace_back(
      "views", fmt::format("{} of {} x {} px, over {:g} degrees", shape.views,
                           shape.tile_width_px(), shape.tile_height_px(), quilt.cameras.cone_deg));
  summary.emplace_back(
      "cameras",
      fmt::format("of the quilt {:+.0f} to {:+.0f} mm, of the capture {:+.0f} to {:+.0f} mm",
                  CameraOf(quilt.cameras, 0).x, CameraOf(quilt.cameras, shape.views - 1).x,
                  reach.left_mm, reach.right_mm));
  const auto mean = [](const std::vector<double>& shares) {
    double sum = 0;
    for (const double share : shares) sum += share;
    return 100 * sum / static_cast<double>(shares.size());
  };
  summary.emplace_back(
      "rays seen", fmt::format("{:.1f} % of the quilt's, {:.1f} % of the picture's; others are {}",
                               mean(quilt.seen), mean(quilt.seen_in_picture),
                               options.guess_unseen ? "guessed" : "black"));
  return summary;
}

std::unique_ptr<RaySource> LoadSource(const Workspace& workspace, const RenderQuiltOptions& options,
                                      const QuiltShape& shape, const RenderedQuilt& quilt,
                                      Progress& progress) {
  const RayBundle middle =
      QuiltRays(quilt.cameras, shape.views / 2, shape.tile_width_px(), shape.tile_height_px());
  RenderOptions render = options.render;
  render.guess_unseen = options.guess_unseen;
  render.rays = InWorld(middle, quilt.placement);
  return LoadCaptureSource(workspace, render, progress);
}

// NAME_native.png beside NAME_qsCxRaA.png.
fs::path NativeFile(const fs::path& quilt) {
  const std::string stem = quilt.stem().string();
  return quilt.parent_path() / (stem.substr(0, stem.rfind("_qs")) + "_native.png");
}

// Where it goes, checked before the work.
void PlanFiles(const fs::path& file, const QuiltPlan& plan, RenderedQuilt& quilt) {
  quilt.file = file;
  if (!file.parent_path().empty()) CreateFolder(file.parent_path());
  CheckWritable(file);
  if (!plan.visual) return;
  quilt.native = NativeFile(file);
  CheckWritable(quilt.native);
}

// The quilt to quilt.file and, where the plan has a device, what that shows to quilt.native.
void WriteQuilt(const Image<Rgb8>& codes, const QuiltPlan& plan, const RenderedQuilt& quilt) {
  WriteCodes8(quilt.file, codes.span());
  if (!plan.visual) return;
  WriteCodes8(quilt.native, WeaveQuilt(codes.span(), quilt.layout, plan.shape.views,
                                       plan.visual->panel, plan.filter)
                                .span());
}

}  // namespace

DrawnQuilt DrawQuilt(const RaySource& source, const QuiltCameras& cameras,
                     const QuiltLayout& layout, int width_px, int height_px,
                     const Eigen::Vector2d& picture_mm, Progress& progress) {
  DrawnQuilt drawn{Image<Rgb8>(width_px, height_px), {}, {}};
  progress.Start("quilt", cameras.views, "views");
  for (int view = 0; view < cameras.views; ++view) {
    const Rect tile = QuiltTile(view, layout.columns, layout.rows, width_px, height_px);
    TileDrawer drawer(source, QuiltRays(cameras, view, tile.width, tile.height), picture_mm);
    drawer.Draw(drawn.codes.span().Sub(tile));
    drawn.seen.push_back(drawer.Seen());
    drawn.seen_in_picture.push_back(drawer.SeenInPicture());
    progress.Advance();
  }
  return drawn;
}

RenderedQuilt RenderQuilt(const Workspace& workspace, const RenderQuiltOptions& options,
                          const fs::path& out, Progress& progress) {
  const QuiltPlan plan = PlanFor(options);
  const QuiltShape& shape = plan.shape;
  RenderedQuilt quilt;
  quilt.layout = shape.layout;
  const fs::path file = QuiltFile(out, workspace.root(), shape.layout);
  for (const char* stage : {"poses", "depth"}) FinishedStage(workspace, stage, "a quilt");
  PlanFiles(file, plan, quilt);

  const std::vector<View> views = LoadViewSet(workspace).views;
  std::string note;
  quilt.placement = PlaceCapture(workspace, views, plan.display, options.placement, &note);
  if (!note.empty()) progress.Warn(note);
  quilt.cameras =
      CamerasFor(plan.display, shape, plan.cone_deg, quilt.placement.viewing_distance_mm);
  const auto source = LoadSource(workspace, options, shape, quilt, progress);
  DrawnQuilt drawn =
      DrawQuilt(*Placed(*source, quilt.placement), quilt.cameras, quilt.layout, shape.width_px,
                shape.height_px,
                {quilt.placement.picture_width_mm, quilt.placement.picture_height_mm}, progress);
  WriteQuilt(drawn.codes, plan, quilt);
  quilt.seen = std::move(drawn.seen);
  quilt.seen_in_picture = std::move(drawn.seen_in_picture);
  const Reach reach = ReachOf(views, quilt.placement);
  if (const std::string unseen = UnseenNote(quilt, reach); !unseen.empty()) progress.Warn(unseen);
  quilt.summary = SummaryOf(quilt, options, plan, reach);
  return quilt;
}

}  // namespace lamella
