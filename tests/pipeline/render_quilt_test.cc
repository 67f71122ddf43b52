// Quilts of a capture: against the published cameras' formula, against Embree's pictures of cameras
// derived from the placement's formula, and against the weave's.
#include "pipeline/render_quilt.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets_synthetic/recipe.h"
#include "datasets_synthetic/scene.h"
#include "distribute/metrics.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/visual_json.h"
#include "tests/pipeline/card_scene.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr double kHalfTurn = 3.14159265358979323846;

// A world that is dark but for a round spot, a Gaussian on a plane before the camera at the origin.
class SpotWorld final : public RaySource {
 public:
  SpotWorld(const Eigen::Vector3d& at, double sigma) : at_(at), sigma_(sigma) {}
  void Query(const RayBundle& bundle, const Rect& rectangle,
             ImageSpan<RaySample> samples) const override {
    for (int y = 0; y < rectangle.height; ++y) {
      for (int x = 0; x < rectangle.width; ++x) {
        const Ray ray = bundle.RayAt(rectangle.x + x + 0.5, rectangle.y + y + 0.5);
        const double t = (at_.z() - ray.origin.z()) / ray.direction.z();
        const double distance = (ray.origin + t * ray.direction - at_).norm() / sigma_;
        const auto light = static_cast<float>(std::exp(-distance * distance / 2));
        samples(x, y).color = {light, light, light};
        samples(x, y).coverage = 1;
      }
    }
  }

 private:
  const Eigen::Vector3d at_;
  const double sigma_;
};

// The centre of a tile's light, px.
Eigen::Vector2d CentreOfLight(ImageSpan<const Rgb8> tile) {
  const Image<Rgb> light = DecodeSrgb8(tile);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double total = 0;
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      const auto g = static_cast<double>(light(x, y).g);
      sum += g * Eigen::Vector2d(x + 0.5, y + 0.5);
      total += g;
    }
  }
  return sum / total;
}

TEST(DrawQuilt, PutsPointsWherePublishedCamerasSeeThem) {
  View reference;
  reference.camera = {CameraModel::kPinhole, 300, 400, 500, 500, 160, 190, {}};
  Display display;
  display.width_px = 120;
  display.height_px = 160;
  display.pitch_mm = 1;
  display.viewing_distance_mm = 600;
  PlacementOptions options;
  options.depth_budget_mm = 30;
  const Placement placement = Place(reference, 2, 5, display, options, nullptr);
  QuiltCameras cameras;
  cameras.views = 7;
  cameras.vertical_deg = 2 * std::atan(80.0 / 600) * 180 / kHalfTurn;
  const QuiltLayout layout{4, 2, 0.75};
  const int width = 4 * 180 + 3, height = 2 * 240 + 1;  // that tiles don't divide
  for (const double depth : {2.0, 2.6, 5.0}) {
    const Eigen::Vector4d world(0.11 * depth, -0.2 * depth, depth, 1);
    const Eigen::Vector4d shown = placement.display_from_world * world;
    const Eigen::Vector3d at = shown.head<3>() / shown.w();
    const SpotWorld spot(world.head<3>(), 0.012 * depth);
    const DrawnQuilt drawn = DrawQuilt(*Placed(spot, placement), cameras, layout, width, height,
                                       {100, 100}, SilentProgress());
    double before = 0;
    for (int view = 0; view < cameras.views; ++view) {
      SCOPED_TRACE(testing::Message() << "depth " << depth << ", view " << view);
      const Eigen::Vector2d centre =
          CentreOfLight(drawn.codes.span().Sub(QuiltTile(view, 4, 2, width, height)));
      EXPECT_NEAR(centre.x(), 90 * (1 + QuiltPosition(cameras, view, at.x(), at.z())), 0.02);
      EXPECT_NEAR(centre.y(), 120 - 120 * at.y() * 600 / (600 - at.z()) / 80, 0.02);
      // View 0 is the leftmost camera's: from it, what is near stands far right.
      const double moved = view > 0 ? centre.x() - before : 0;
      if (view > 0 && depth != 2.6) {
        EXPECT_GT(depth == 2 ? -moved : moved, 2);
      }
      before = centre.x();
    }
    const auto spare = drawn.codes.span().Sub(QuiltTile(7, 4, 2, width, height));
    EXPECT_EQ(spare(90, 120), Rgb8());
  }
}

// More rays than are asked for at once.
TEST(DrawQuilt, DrawsLargeTilesInStrips) {
  QuiltCameras cameras;
  cameras.views = 1;
  const SpotWorld spot({10, -40, -20}, 4);  // in the display's frame
  const DrawnQuilt drawn =
      DrawQuilt(spot, cameras, {1, 1, 0.75}, 2100, 2800, {1, 1}, SilentProgress());
  EXPECT_EQ(drawn.seen, std::vector<double>{1});
  const Eigen::Vector2d centre = CentreOfLight(drawn.codes.span());
  const double scale = CameraOf(cameras, 0).distance / (CameraOf(cameras, 0).distance + 20);
  EXPECT_NEAR(centre.x(), 1050 + scale * 10 / 60 * 1050, 0.02);
  EXPECT_NEAR(centre.y(), 1400 + scale * 40 / 80 * 1400, 0.02);
}

// Of a tile's shape.
constexpr CardScene kQuiltCards = {
    .views = 9, .width_px = 120, .height_px = 160, .wall_height = 12, .card_width = 0.7};

// A panel of as many pixels as a tile has, with cells.
VisualJson SmallPanel() {
  VisualJson visual;
  visual.serial = "TEST-1";
  visual.view_cone_deg = 6;
  visual.panel.pitch_per_in = 11;
  visual.panel.slope = -6.5;
  visual.panel.center = 0.3;
  visual.panel.dpi = 40;
  visual.panel.width_px = 120;
  visual.panel.height_px = 160;
  visual.panel.cell_pattern = 4;
  visual.panel.cells = {{{{-0.3, 0.2}, {0.0, -0.2}, {0.3, 0.2}}},
                        {{{-0.2, -0.1}, {0.1, 0.3}, {0.4, -0.1}}}};
  return visual;
}

class RenderQuiltTest : public testing::Test {
 protected:
  RenderQuiltTest()
      : root_(ScratchFolder()),
        workspace_(RunWithExactDepth(WriteCards(kQuiltCards, root_), "depth")) {
    small_.columns = 3;
    small_.rows = 2;
    small_.cone_deg = 6;
    small_.width_px = 360;
    small_.height_px = 320;
  }
  RenderedQuilt Render(const RenderQuiltOptions& options, const char* out = "q.png") const {
    return RenderQuilt(workspace_, options, root_ / out, SilentProgress());
  }
  std::string ErrorOf(const RenderQuiltOptions& options, ExitCode code,
                      const char* out = "q.png") const {
    try {
      Render(options, out);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    return "no error";
  }
  fs::path root_;
  Workspace workspace_;
  RenderQuiltOptions small_;  // 6 tiles of 120 x 160 px that all see what the capture does
};

// The camera of the world whose picture is the view's tile, after the formulas of
// distribute/place.h alone: the eye (x, 0, D) is the camera at X = x a/(k f), the screen the plane
// Z = a/(1/D - b).
View CameraOfTile(const RenderedQuilt& quilt, const View& reference, int view, int width,
                  int height) {
  const Placement& p = quilt.placement;
  const double distance = p.viewing_distance_mm, kfd = p.mm_per_view_px * p.focal_px;
  const double across = CameraOf(quilt.cameras, view).x * p.a / (kfd / distance);
  const double depth = p.a / (1 / distance - p.b);
  const double screen_height = 2 * quilt.cameras.half_height;
  const double per_x = width / (screen_height * quilt.cameras.aspect),
               per_y = height / screen_height;
  View camera = reference;
  camera.camera_from_world.translation.x() -= across;
  camera.camera = {CameraModel::kPinhole, width,       height,
                   kfd * per_x,           kfd * per_y, width / 2.0 + kfd * per_x * across / depth,
                   height / 2.0,          {}};
  return camera;
}

TEST_F(RenderQuiltTest, ShowsWhatEmbreeSeesFromTheSameCameras) {
  const RenderedQuilt quilt = Render(small_);
  EXPECT_EQ(quilt.file.filename(), "q_qs3x2a0.75.png");
  EXPECT_GT(quilt.placement.b, 0);  // no mere similarity
  EXPECT_NEAR(quilt.placement.viewing_distance_mm,
              quilt.cameras.half_height / std::tan(7 * kHalfTurn / 180), 1e-9);
  // One lens of the 52 per inch, that lean by 1 in 7, from view to view.
  const double lens_mm = 25.4 / 52 / std::cos(std::atan(1.0 / 7));
  EXPECT_NEAR(quilt.placement.near_mm, 6 * lens_mm / (2 * std::tan(3 * kHalfTurn / 180)), 1e-6);
  const Recipe recipe = ReadRecipe(root_ / "cards.toml");
  const std::vector<View> views = CamerasOf(recipe.layout, recipe.seed, "cards");
  const View& reference = ReferenceView(views, quilt.placement.reference_view);
  const SceneSource scene(recipe.scene);
  const Image<Rgb8> codes = ReadSrgb8(quilt.file);
  for (int view = 0; view < 6; ++view) {
    const View camera = CameraOfTile(quilt, reference, view, 120, 160);
    const RayBundle rays = BundleOfCamera(camera.camera, camera.camera_from_world);
    Image<RaySample> samples(120, 160);
    scene.Query(rays, {0, 0, 120, 160}, samples.span());
    Image<Rgb> light(120, 160);
    for (std::size_t i = 0; i < light.size(); ++i) light.data()[i] = samples.data()[i].color;
    const Image<Rgb8> truth = EncodeSrgb8(light.span());
    const auto tile = QuiltView(codes.span(), quilt.layout, view);
    const double psnr = *Psnr(tile, truth.span(), {8, {}});
    RecordProperty("psnr_db_" + std::to_string(view), std::to_string(psnr));
    EXPECT_GT(psnr, 41) << view;
    EXPECT_GT(quilt.seen_in_picture[static_cast<std::size_t>(view)], 0.99);
  }
}

TEST_F(RenderQuiltTest, LeavesWhatNoPhotographSawBlackAndCountsIt) {
  RenderQuiltOptions options = small_;
  options.views = 5;
  options.placement.mm_per_view_px = 0.25;  // the picture is half as large as the screen
  const RenderedQuilt quilt = Render(options);
  const Image<Rgb8> codes = ReadSrgb8(quilt.file);
  ASSERT_EQ(quilt.seen.size(), 5U);
  for (int view = 0; view < 5; ++view) {
    const auto tile = QuiltView(codes.span(), quilt.layout, view);
    int lit = 0;
    for (int y = 0; y < tile.height; ++y) {
      for (int x = 0; x < tile.width; ++x) lit += tile(x, y) != Rgb8();
    }
    const double share = lit / (120.0 * 160);
    EXPECT_NEAR(quilt.seen[static_cast<std::size_t>(view)], share, 0.02);
    EXPECT_LT(share, 0.5);
    EXPECT_GT(quilt.seen_in_picture[static_cast<std::size_t>(view)], 0.94);
  }
  EXPECT_EQ(QuiltViews(codes.span(), quilt.layout), 5);
  options.guess_unseen = true;
  const RenderedQuilt guessed = Render(options, "guessed.png");
  EXPECT_EQ(guessed.seen, quilt.seen);
  const Image<Rgb8> filled = ReadSrgb8(guessed.file);
  const Rect middle{30, 40, 60, 80};  // the picture
  for (int y = middle.y; y < middle.y + middle.height; ++y) {
    for (int x = middle.x; x < middle.x + middle.width; ++x) {
      EXPECT_NE(QuiltView(filled.span(), guessed.layout, 0)(x, y), Rgb8()) << x << "," << y;
    }
  }
}

// view = 1 - fract((U + V tilt) lenses - center) of displays.md, written out.
TEST_F(RenderQuiltTest, WeavesTheDevicesImageOfItsOwnTiles) {
  const VisualJson visual = SmallPanel();
  WriteVisualJson(root_ / "visual.json", visual);
  RenderQuiltOptions options = small_;
  options.cone_deg.reset();
  options.visual = root_ / "visual.json";
  const RenderedQuilt quilt = Render(options);
  EXPECT_EQ(quilt.native.filename(), "q_native.png");
  EXPECT_EQ(quilt.cameras.cone_deg, 6);
  EXPECT_NEAR(2 * quilt.cameras.half_height, 160 * 25.4 / 40, 1e-9);
  const Image<Rgb8> codes = ReadSrgb8(quilt.file), native = ReadSrgb8(quilt.native);
  ASSERT_EQ(native.width(), 120);
  ASSERT_EQ(native.height(), 160);
  const double lenses = 11.0 * 120 / 40 * std::cos(std::atan(1 / -6.5));
  const double tilt = 160 / (120 * -6.5);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 120; ++x) {
      const int up = 159 - y;
      const LookingGlass::Cell& cell = visual.panel.cells[static_cast<std::size_t>(up % 2)];
      for (std::size_t c = 0; c < 3; ++c) {
        const double phase =
            ((x + 0.5 + cell[c][0]) / 120 + (up + 0.5 + cell[c][1]) / 160 * tilt) * lenses - 0.3;
        const int view = std::min(5, static_cast<int>(6 * (1 - (phase - std::floor(phase)))));
        const Rgb8 of_tile = QuiltView(codes.span(), quilt.layout, view)(x, y),
                   shown = native(x, y);
        const int expected[] = {of_tile.r, of_tile.g, of_tile.b};
        const int found[] = {shown.r, shown.g, shown.b};
        ASSERT_EQ(found[c], expected[c]) << x << "," << y << " channel " << c;
      }
    }
  }
}

TEST_F(RenderQuiltTest, IsThePortraitsUnlessToldOtherwise) {
  RenderQuiltOptions options;
  options.views = 1;
  const RenderedQuilt portrait = Render(options, "");
  EXPECT_EQ(portrait.file.filename(), "W_qs8x6a0.75.png");
  const Image<Rgb8> codes = ReadSrgb8(portrait.file);
  EXPECT_EQ(codes.width(), 3360);
  EXPECT_EQ(codes.height(), 3360);
  options.aspect = 16.0 / 9;
  options.columns = 3;
  options.rows = 4;
  options.width_px = 480;
  const RenderedQuilt wide = Render(options, "wide.png");
  EXPECT_EQ(wide.file.filename(), "wide_qs3x4a1.7778.png");
  EXPECT_EQ(ReadSrgb8(wide.file).height(), 4 * 90);  // square pixels
}

TEST_F(RenderQuiltTest, AreTheSameBytesForAnyNumberOfThreads) {
  std::string bytes[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    bytes[threads - 1] = ReadText(Render(small_).file);
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(RenderQuiltTest, MistakesAreOneLine) {
  RenderQuiltOptions options = small_;
  options.width_px = options.height_px = kMaxQuiltPx;
  EXPECT_THAT(ErrorOf(options, ExitCode::kUsage), HasSubstr("more than 2^29 px"));
  options = small_;
  options.width_px = 2;
  EXPECT_THAT(ErrorOf(options, ExitCode::kUsage), HasSubstr("2 x 320 px are too few for 3 x 2"));
  options = small_;
  options.views = 7;
  EXPECT_THAT(ErrorOf(options, ExitCode::kUsage), HasSubstr("3 x 2 tiles hold no 7 views"));
  EXPECT_THAT(ErrorOf(small_, ExitCode::kUsage, "q_qs8x6a0.75.png"),
              HasSubstr("its name tells another layout than _qs3x2a0.75"));
  options = small_;
  options.visual = root_ / "visual.json";
  EXPECT_THAT(ErrorOf(options, ExitCode::kInput), HasSubstr("visual.json"));
  WriteTextAtomically(options.visual, R"({"configVersion": "4.0", "serial": "x"})");
  EXPECT_THAT(ErrorOf(options, ExitCode::kInput), HasSubstr("newer than 3.0"));
  fs::remove_all(workspace_.Stage("depth"));
  EXPECT_THAT(ErrorOf(small_, ExitCode::kInput),
              HasSubstr("a quilt needs depth, which has not been run; run `lamella depth`"));
  EXPECT_FALSE(fs::exists(root_ / "q_qs3x2a0.75.png"));
}

}  // namespace
}  // namespace lamella
