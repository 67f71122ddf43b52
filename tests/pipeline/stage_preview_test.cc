// The stage preview on a workspace whose earlier stages left the truth of a known scene.
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "distribute/displays.h"
#include "distribute/metrics.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/depth_record.h"
#include "pipeline/layers_record.h"
#include "pipeline/panel_images.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"
#include "tests/depth/analytic_scene.h"
#include "tests/pipeline/data_uri.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing_scene::PinholeOf;
using testing_scene::PlaneScene;
using testing_scene::PoseAt;

constexpr int kPanel = 240;  // px, square; a view's pixel is a panel's on z = 0
constexpr double kStepMm = 25;

// A wall at the back and a smaller rectangle in front of it, of smooth textures.
PlaneScene WallAndCard() {
  testing_scene::TexturedRectangle wall, card;
  wall.centre = {0, 0, 9.5};
  wall.wavelength = 1.2;
  card.centre = {0.2, -0.1, 7};
  card.half_u = 0.6;
  card.half_v = 0.5;
  card.wavelength = 0.8;
  card.phase = 1;
  card.brightness = 0.25;
  return PlaneScene({wall, card});
}

// Built once: five views (a cross of neighbours kStepMm apart as eyes), exact depth, layers made
// of the scene itself, frames.
class StagePreviewTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = fs::path(testing::TempDir()) / ("lamella-stage-preview-" + std::to_string(getpid()));
    fs::remove_all(root_);
    const Workspace workspace(root_ / "W");
    for (const char* stage : {"poses", "depth", "layers"}) CreateFolder(workspace.Stage(stage));
    CreateFolder(root_ / "photos");
    LayersRecord record;
    record.display = FindDisplay("paper-two-layer");
    record.display.width_px = record.display.height_px = kPanel;
    const PlaneScene scene = WallAndCard();
    ViewSet set;
    set.views.push_back(Add(scene, "middle", {0, 0, 0}));
    PlacementOptions options;
    options.mm_per_view_px = record.display.pitch_mm;
    options.depth_budget_mm = 12;
    record.placement = Place(set.views[0], 7, 9.5, record.display, options, nullptr);
    const Placement& p = record.placement;
    const double step = kStepMm * p.a / (p.mm_per_view_px / p.viewing_distance_mm * p.focal_px);
    set.views.push_back(Add(scene, "right", {step, 0, 0}));
    set.views.push_back(Add(scene, "left", {-step, 0, 0}));
    set.views.push_back(Add(scene, "low", {0, step, 0}));
    set.views.push_back(Add(scene, "high", {0, -step, 0}));
    SaveViewSet(workspace.Stage("poses"), set, {});
    const LayerImages images =
        Distribute(*Placed(scene, p), record.display, LayersOptions(), SilentProgress());
    record.seen_share = images.seen_share;
    for (int layer = 0; layer < 2; ++layer) {
      for (int slot = 0; slot < 9; ++slot) {
        SaveEmitterImage(
            workspace.Stage("layers"), layer, slot,
            images.slots[static_cast<std::size_t>(layer)][static_cast<std::size_t>(slot)]);
      }
    }
    SaveLayersRecord(workspace.Stage("layers"), record);
    StageRun frames(workspace, "frames", "in", "options");
    frames.Commit(RunFrames(workspace, {}, frames, SilentProgress()), 1.5, 100);
    Preview(Small());
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  static View Add(const PlaneScene& scene, const std::string& name, const Eigen::Vector3d& centre) {
    DepthView truth = scene.Capture(PinholeOf(kPanel, kPanel, 600), PoseAt(centre));
    truth.view.name = name;
    truth.view.image = root_ / "photos" / (name + ".png");
    WriteSrgb8(truth.view.image, truth.color.span());
    SaveDepthMap(root_ / "W/depth" / (name + ".exr"), truth.depth);
    return truth.view;
  }

  static PreviewOptions Small() {
    PreviewOptions options;
    options.positions = 3;
    options.eye_box_mm = kStepMm;
    options.eyes = "10,-5";
    options.border_px = 20;
    return options;
  }

  static std::string Preview(const PreviewOptions& options) {
    const Workspace workspace(root_ / "W");
    StageRun run(workspace, "preview", "in", "options");
    run.Commit(RunPreview(workspace, options, {}, run, SilentProgress()), 0, 0);
    std::string hashes;
    const std::optional<StageRecord> record = LoadStageRecord(workspace, "preview");
    for (const OutputFile& file : record->outputs) {
      if (file.file != "index.html") hashes += file.file + " " + file.hash + "\n";
    }
    return hashes;
  }

  // Those of the last preview that say so.
  static std::vector<std::string> Warnings(const std::string& what) {
    std::vector<std::string> warnings =
        LoadStageRecord(Workspace(root_ / "W"), "preview")->report.warnings;
    std::erase_if(warnings, [&](const std::string& w) { return w.find(what) == w.npos; });
    return warnings;
  }

  static fs::path Folder() { return root_ / "W/preview"; }
  static nlohmann::json Metrics() {
    return nlohmann::json::parse(ReadText(Folder() / "metrics.json"));
  }

  static void ExpectTheSceneAtEveryEye() {
    const nlohmann::json json = Metrics();
    EXPECT_EQ(json.at("format_version"), 1);
    ASSERT_EQ(json.at("eyes").size(), 9U);
    ASSERT_EQ(json.at("further_eyes").size(), 1U);
    for (const auto& eye : json.at("eyes")) {
      // Layers 20 mm apart blur the silhouette of a card in front of a wall: simulation.md
      // section 3.
      EXPECT_GT(eye.at("psnr_srgb_db"), 25) << eye;
      EXPECT_GT(eye.at("ssim"), 0.84) << eye;
      EXPECT_GT(eye.at("known"), 0.9) << eye;
      const Image<Rgb8> picture = ReadSrgb8(Folder() / eye.at("simulated").get<std::string>());
      ASSERT_EQ(picture.width(), kPanel);
      const Image<Rgb8> target = ReadSrgb8(Folder() / eye.at("target").get<std::string>());
      for (const Rect& away : {Rect{24, 24, 40, 190}, Rect{100, 95, 50, 30}}) {  // wall, card
        EXPECT_GT(*Psnr(picture.span().Sub(away), target.span().Sub(away)), 37) << eye;
      }
      EXPECT_FALSE(ReadAlpha(Folder() / eye.at("target").get<std::string>()).empty());
    }
    EXPECT_EQ(json.at("eyes")[2].at("position_mm"), (std::vector<double>{25, 25, 600}));
    EXPECT_EQ(json.at("further_eyes")[0].at("position_mm"), (std::vector<double>{10, -5, 600}));
  }

  static void ExpectTheBandLimitToExplainPartOfTheError() {
    const nlohmann::json json = Metrics();
    double sum = 0;
    for (const char* eyes : {"eyes", "further_eyes"}) {
      for (const auto& eye : json.at(eyes)) {
        const auto& limited = eye.at("to_band_limited");
        EXPECT_GT(limited.at("psnr_srgb_seen_db"), eye.at("psnr_srgb_seen_db")) << eye;
        EXPECT_GT(limited.at("ssim_seen"), eye.at("ssim_seen")) << eye;
        EXPECT_GT(eye.at("band_limited_to_target").at("psnr_srgb_seen_db"),
                  eye.at("psnr_srgb_seen_db"))
            << eye;
        EXPECT_FALSE(eye.at("band_limited_to_target").contains("ssim"));
        if (std::string(eyes) == "eyes") sum += limited.at("psnr_srgb_seen_db").get<double>();
      }
    }
    EXPECT_NEAR(json.at("mean").at("to_band_limited").at("psnr_srgb_seen_db"), sum / 9, 1e-3);
    const nlohmann::json tables = PageData().at("metrics").at("tables");
    EXPECT_EQ(tables.at(0).at("rows").size(), 3U);
    EXPECT_EQ(tables.at(2).at("rows").at(0).size(), 7U);
  }

  // Of the card in front of the wall, whose layers are 20 mm apart.
  static void ExpectHalosAroundTheCard() {
    const nlohmann::json json = Metrics();
    for (const auto& eye : json.at("eyes")) {
      const auto& halo = eye.at("halo");
      // 4.4 mm to both sides of an outline of a fifth of the panel's width and more.
      EXPECT_GT(halo.at("share_of_pixels"), 0.03) << eye;
      EXPECT_LT(halo.at("share_of_pixels"), 0.5) << eye;
      EXPECT_GT(halo.at("share_of_squared_error"), 2 * halo.at("share_of_pixels").get<double>());
      // The wall is the brighter one: its light is missing outside and leaks onto the card.
      EXPECT_LT(halo.at("relative_error_behind"), 0) << eye;
      EXPECT_GT(halo.at("relative_error_before"), 0) << eye;
    }
    const nlohmann::json& mean = json.at("mean");
    EXPECT_LT(mean.at("halo").at("relative_error_behind"), 0);
    EXPECT_NEAR(mean.at("angular_aliasing").at("step_mm"), 9.18, 0.01);
    EXPECT_LT(mean.at("angular_aliasing").at("db"), -20);
    EXPECT_GT(mean.at("angular_aliasing").at("db"), -70);
    EXPECT_EQ(json.at("totals").at("rays"), 2 * kPanel * kPanel * 9);
    EXPECT_EQ(json.at("totals").at("bits"), 2 * kPanel * kPanel * 9 * 24);
    EXPECT_NEAR(json.at("totals").at("light_efficiency"), 1.0 / 18, 1e-9);
    EXPECT_EQ(PageData().at("metrics").at("tables").at(1).at("rows").size(), 4U);
  }

  static void ExpectCapturedViewsCompared() {
    const nlohmann::json captured = Metrics().at("captured_views");
    ASSERT_EQ(captured.size(), 5U);
    for (const auto& view : captured) {
      EXPECT_GT(view.at("simulated_to_captured").at("psnr_srgb_db"), 25) << view;
      const auto& direct = view.at("direct_to_captured").at("psnr_srgb_db");
      EXPECT_TRUE(direct.is_null() || direct > 42) << view;  // null: equal
    }
  }

  // The eye's picture from the PNG files alone: modulator times emitter, slot by slot, the
  // reflected panel turned back.
  static void ExpectWhatThePanelsFilesShow() {
    const nlohmann::json json = Metrics();
    const double pixel = json.at("pixel_mm"), left = json.at("left_mm"), top = json.at("top_mm");
    const double pitch = FindDisplay("paper-two-layer").pitch_mm;
    const Eigen::Vector3d eye(10, -5, 600);
    const Rect part{90, 100, 40, 30};
    Image<Rgb> picture(part.width, part.height);
    for (int layer = 0; layer < 2; ++layer) {
      const double z = layer == 0 ? -10 : 10;
      for (int slot = 0; slot < 9; ++slot) {
        const std::string name =
            "W/frames/layer_" + std::to_string(layer) + "_slot_" + std::to_string(slot);
        const Image<Rgb> emitter = ReadImage(root_ / (name + "_emitter.png"));
        const Image<Rgb> modulator = ReadImage(root_ / (name + "_modulator.png"));
        const auto at = [&](const Image<Rgb>& frame, double x0, double y0, double depth) {
          const double x = x0 + (eye.x() - x0) * depth / 600, y = y0 + (eye.y() - y0) * depth / 600;
          const int column = static_cast<int>(std::floor(x / pitch + kPanel / 2.0));
          const int row = static_cast<int>(std::floor(kPanel / 2.0 - y / pitch));
          return frame(layer == 0 ? kPanel - 1 - column : column, row);
        };
        constexpr int kLines = 16;  // of sight, per pixel and axis
        for (int i = 0; i < kLines * kLines * part.width * part.height; ++i) {
          const int line = i % (kLines * kLines), pixel_index = i / (kLines * kLines);
          const int x = pixel_index % part.width, y = pixel_index / part.width;
          const int u = line % kLines, v = line / kLines;
          const double x0 = left + (part.x + x + (u + 0.5) / kLines) * pixel;
          const double y0 = top - (part.y + y + (v + 0.5) / kLines) * pixel;
          // Mean of 9 slots over the brightness (2/6)^2; the mirror's 1/2 is in both.
          picture(x, y) +=
              at(modulator, x0, y0, z).g / (kLines * kLines) * at(emitter, x0, y0, z - 5);
        }
      }
    }
    const Image<Rgb8> seen = ReadSrgb8(Folder() / "views/eye_further_00.png");
    for (int y = 0; y < part.height; ++y) {
      for (int x = 0; x < part.width; ++x) {
        const Rgb8 code = seen(part.x + x, part.y + y);
        EXPECT_NEAR(code.r, LinearToSrgb8(picture(x, y).r), 1) << x << " " << y;
        EXPECT_NEAR(code.b, LinearToSrgb8(picture(x, y).b), 1) << x << " " << y;
      }
    }
  }

  static void ExpectTheNearCardToMoveAgainstTheEye() {
    // The column of the card's middle: darker than the wall; weighted mean of what is dark.
    const auto middle = [](const std::string& file) {
      const Image<Rgb> picture = ReadImage(Folder() / "views" / file);
      double sum = 0, x_sum = 0;
      for (int y = 100; y < 130; ++y) {
        for (int x = 70; x < 180; ++x) {
          const double dark = picture(x, y).g < 0.3F ? 1 : 0;
          sum += dark;
          x_sum += dark * x;
        }
      }
      return x_sum / sum;
    };
    for (const std::string kind : {"eye_", "target_"}) {
      const double left = middle(kind + "01_00.png"), right = middle(kind + "01_02.png");
      EXPECT_LT(right, left - 1) << kind;
    }
    EXPECT_NEAR(middle("eye_01_02.png") - middle("eye_01_00.png"),
                middle("target_01_02.png") - middle("target_01_00.png"), 0.7);
  }

  // Five panes of 270 px and gaps of 6: photograph, depth, two layers, eye.
  static void ExpectAnOverviewOfTheWholeChain() {
    const Image<Rgb8> overview = ReadSrgb8(Folder() / "overview.jpg");
    ASSERT_EQ(overview.height(), 270);
    const Image<Rgb8> eye = ReadSrgb8(Folder() / "views/eye_01_01.png");
    const int seen_width = static_cast<int>(std::lround(270.0 * eye.width() / eye.height()));
    ASSERT_GE(overview.width(), 270 + seen_width);
    const auto near = [&](Rgb8 a, Rgb8 b) {
      return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) < 40;
    };
    // The wall's middle left: the same place of the photograph and of the eye's picture.
    const Image<Rgb8> photo = ReadSrgb8(root_ / "photos/middle.png");
    EXPECT_TRUE(near(overview(60, 135), photo(53, 120)));
    EXPECT_TRUE(near(overview(overview.width() - seen_width + 60, 135),
                     eye(60 * eye.width() / seen_width, 120)));
    EXPECT_TRUE(near(overview(272, 100), Rgb8{255, 255, 255}));
  }

  static void ExpectOneSelfContainedPage() {
    const std::string html = ReadText(Folder() / "index.html");
    EXPECT_LT(html.size(), 20U << 20U);
    EXPECT_EQ(html.find("http"), html.find("http-equiv"));
    for (const char* part : {"data:image/jpeg;base64,", "captured", "frames"}) {
      EXPECT_NE(html.find(part), std::string::npos) << part;
    }
  }

  static nlohmann::json PageData() {
    const std::string html = ReadText(Folder() / "index.html");
    const std::string mark = "<script type=\"application/json\" id=\"data\">";
    const std::size_t first = html.find(mark) + mark.size();
    return nlohmann::json::parse(html.substr(first, html.find("</script>", first) - first));
  }

  // The parts that the page shows pixel by pixel are those of the frames' files.
  static void ExpectThePageToStepThroughTheFrames() {
    const nlohmann::json steps = PageData().at("steps");
    ASSERT_EQ(steps.at("layers").size(), 2U);
    for (std::size_t layer = 0; layer < 2; ++layer) {
      const nlohmann::json& at = steps.at("layers")[layer].at("part");
      const Rect part{at.at("x"), at.at("y"), at.at("width"), at.at("height")};
      const nlohmann::json& slots = steps.at("layers")[layer].at("slots");
      ASSERT_EQ(slots.size(), 10U);  // the first is the sum
      for (std::size_t slot = 0; slot < 9; ++slot) {
        const std::string name =
            "W/frames/layer_" + std::to_string(layer) + "_slot_" + std::to_string(slot);
        std::size_t picture = 1;  // 0: of the whole emitter
        for (const char* role : {"_emitter.png", "_modulator.png"}) {
          const Image<Rgb8> file = ReadSrgb8(root_ / (name + role));
          const nlohmann::json& of = slots[slot + 1].at("pictures").at(picture++);
          const Image<Rgb8> shown = PictureOfUri(of.at("picture"), root_);
          ASSERT_EQ(shown.width(), part.width);
          for (int y = 0; y < part.height; ++y) {
            for (int x = 0; x < part.width; ++x) {
              ASSERT_EQ(shown(x, y), file(part.x + x, part.y + y)) << name << role;
            }
          }
        }
      }
    }
  }

  static void ExpectPanelsToDecodeBackToTheirEmitters() {
    const Workspace workspace(root_ / "W");
    const LayersRecord record = LoadLayersRecord(workspace);
    const LayerImages layers = LoadLayerImages(workspace, record);
    const LayerImages panels = ReadWhole(OpenPanelImages(workspace, record).open, record.display);
    for (std::size_t l = 0; l < 2; ++l) {
      for (std::size_t slot = 0; slot < 9; ++slot) {
        const EmitterImage &a = layers.slots[l][slot], &b = panels.slots[l][slot];
        for (std::size_t i = 0; i < a.color.size(); ++i) {
          // Half a code of sRGB is at most 0.0045 of linear light.
          ASSERT_NEAR(a.color.data()[i].g, b.color.data()[i].g, 0.0046F);
          ASSERT_EQ(a.coverage.data()[i], b.coverage.data()[i]);
        }
      }
    }
  }

  static fs::path root_;
};
fs::path StagePreviewTest::root_;

// One case, since ctest runs every case in a process of its own, which makes the workspace anew.
TEST_F(StagePreviewTest, ShowsTheSceneAndTellsHowFarItIsFromTheCapture) {
  ExpectTheSceneAtEveryEye();
  ExpectTheBandLimitToExplainPartOfTheError();
  ExpectHalosAroundTheCard();
  ExpectCapturedViewsCompared();
  ExpectWhatThePanelsFilesShow();
  ExpectTheNearCardToMoveAgainstTheEye();
  ExpectAnOverviewOfTheWholeChain();
  ExpectOneSelfContainedPage();
  ExpectThePageToStepThroughTheFrames();
  ExpectPanelsToDecodeBackToTheirEmitters();
}

// The steepest step from a pixel to the next one between two columns, in rows 100 to 130.
double SteepestStep(const Image<Rgb>& picture, int first_column, int end_column) {
  double steepest = 0;
  for (int y = 100; y < 130; ++y) {
    for (int x = first_column; x < end_column; ++x) {
      steepest = std::max(steepest, std::abs(static_cast<double>(picture(x + 1, y).g) -
                                             static_cast<double>(picture(x, y).g)));
    }
  }
  return steepest;
}

// Focused 20 mm before or behind a thing, at 1/30 of its distance, a pupil of 60 mm blurs it by
// 2 mm or 8 px.
TEST_F(StagePreviewTest, FocusesOnTheWallAndOnTheCard) {
  PreviewOptions options = Small();
  options.positions = 1;
  options.eyes = "";
  options.focus_planes = 2;
  options.pupil_mm = 60;
  Preview(options);
  const nlohmann::json focus = Metrics().at("focus");
  ASSERT_EQ(focus.size(), 2U);
  for (const auto& eye : focus) {
    EXPECT_GT(eye.at("to_band_limited").at("psnr_srgb_seen_db"), eye.at("psnr_srgb_seen_db"));
  }
  EXPECT_EQ(focus[0].at("plane_mm"), -10);  // the layers
  EXPECT_EQ(focus[1].at("plane_mm"), 10);
  const auto step = [&](const char* kind, std::size_t i, int first_column, int end_column) {
    const fs::path file = Folder() / focus[i].at(kind).get<std::string>();
    return SteepestStep(ReadImage(file), first_column, end_column);
  };
  // The card, at 12 mm, is sharp from the front layer; the backmost panel's left edge from its own.
  EXPECT_GT(step("target", 1, 60, 180), 2 * step("target", 0, 60, 180));
  EXPECT_GT(step("simulated", 0, 0, 12), 2 * step("simulated", 1, 0, 12));
}

TEST_F(StagePreviewTest, ShowsTheLayersWhereItIsSimulatedFromThem) {
  const fs::path frames = root_ / "W/frames", away = root_ / "frames";
  fs::rename(frames, away);
  PreviewOptions options = Small();
  options.positions = 1;
  options.source = "layers";
  Preview(options);
  fs::rename(away, frames);
  const nlohmann::json steps = PageData().at("steps");
  EXPECT_EQ(steps.at("layers").at(1).at("slots").size(), 9U);
  EXPECT_NE(steps.at("note").get<std::string>().find("before it becomes frames"),
            std::string::npos);
}

TEST_F(StagePreviewTest, WritesTheSameBytesWithAnyNumberOfThreads) {
  std::string hashes[2];
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    hashes[threads - 1] = Preview(Small());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST_F(StagePreviewTest, ShowsTheSamePicturesWithAnyMemoryAndSaysHowMuchItNeeds) {
  for (const char* source : {"frames", "layers"}) {
    PreviewOptions options = Small();
    options.positions = 2;  // the middle one, right of the middle, looks to the left for aliasing
    options.focus_planes = 2;
    options.source = source;
    const std::string whole = Preview(options);
    EXPECT_NEAR(Metrics().at("mean").at("angular_aliasing").at("step_mm"), -9.18, 0.01);
    EXPECT_TRUE(Warnings("cannot be held").empty());
    const nlohmann::json page = PageData();
    options.memory_gib = 0.01;  // less than the program itself takes
    EXPECT_EQ(Preview(options), whole);
    ASSERT_EQ(Warnings("--memory 0.01 cannot be held").size(), 1U);
    EXPECT_EQ(Warnings("and the page or the lowest strip of emitters").size(), 1U);
    for (const char* part : {"layers", "steps"}) EXPECT_EQ(PageData().at(part), page.at(part));
  }
}

}  // namespace
}  // namespace lamella
