#include "pipeline/capture/known_cameras.h"

#include <cstdlib>
#include <fstream>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"
#include "lightfield/image.h"
#include "pipeline/capture/hci_grid.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/poses/model.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

void WriteFile(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

// A camera at (1, 2, 3) that looks along the world's -x axis, its x axis along the world's +y.
// World z is up: the camera's y (down) is -z.
Eigen::Vector2d ProjectByHand(const Eigen::Vector3d& world, double f, double cx, double cy) {
  const Eigen::Vector3d d = world - Eigen::Vector3d(1, 2, 3);
  const double right = d.y(), down = -d.z(), forward = -d.x();
  return {f * right / forward + cx, f * down / forward + cy};
}

const Eigen::Vector3d kPoint(-4, 2.5, 3.25);

void ExpectSeesThePointRight(const View& view, double half_pixel) {
  const auto pixel = Project(view.camera, view.camera_from_world * kPoint);
  ASSERT_TRUE(pixel);
  const Eigen::Vector2d expected = ProjectByHand(kPoint, 500, 310 + half_pixel, 250 + half_pixel);
  EXPECT_NEAR(pixel->x(), expected.x(), 1e-9);
  EXPECT_NEAR(pixel->y(), expected.y(), 1e-9);
}

TEST(TransformsJson, HoldsOpenGlAxesAndCameraToWorldPoses) {
  const fs::path folder = ScratchFolder();
  // Columns of the camera's axes in the world: right = +y, up = +z, back = +x.
  WriteFile(folder / "transforms.json", R"({"fl_x": 500, "cx": 310, "cy": 250, "w": 640, "h": 480,
    "frames": [{"file_path": "./images/b.jpg",
      "transform_matrix": [[0,0,1,1],[1,0,0,2],[0,1,0,3],[0,0,0,1]]}]})");
  const std::vector<View> views = ReadKnownCameras(folder);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].name, "b");
  EXPECT_EQ(views[0].image, folder / "images/b.jpg");
  ExpectSeesThePointRight(views[0], 0);
}

TEST(TransformsJson, TakesTheFieldOfViewForTheFocalLength) {
  const fs::path folder = ScratchFolder();
  WriteFile(folder / "t.json", R"({"camera_angle_x": 1.5707963267948966, "w": 640, "h": 480,
    "frames": [{"file_path": "r_0", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
  const std::vector<View> views = ReadKnownCameras(folder / "t.json");
  EXPECT_NEAR(views.at(0).camera.fx, 320, 1e-9);
  EXPECT_NEAR(views.at(0).camera.fy, 320, 1e-9);
  EXPECT_EQ(views.at(0).camera.cx, 320);
}

TEST(TransformsJson, IsReadBackAsItWasWritten) {
  const fs::path folder = ScratchFolder();
  View view;
  view.name = "name with blank";
  view.image = folder / "images" / "x.png";
  view.camera = {.width = 33, .height = 17, .fx = 41.25, .fy = 40.1, .cx = 16.7, .cy = 8.1};
  view.camera_from_world = {Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized(), {0.1, -5, 1e7}};
  view.grid = GridPosition{-2, 5};
  WriteTransformsJson(folder / "transforms.json", {{view}, {"lost one"}});
  const TransformsJson back = ReadTransformsJson(folder);
  ASSERT_EQ(back.views.size(), 1U);
  EXPECT_EQ(back.lost, std::vector<std::string>{"lost one"});
  EXPECT_EQ(back.views[0].name, view.name);
  EXPECT_EQ(back.views[0].image, view.image);
  EXPECT_EQ(back.views[0].grid, view.grid);
  EXPECT_EQ(back.views[0].camera.fx, view.camera.fx);
  EXPECT_EQ(back.views[0].camera.cy, view.camera.cy);
  EXPECT_LT(
      back.views[0].camera_from_world.rotation.angularDistance(view.camera_from_world.rotation),
      1e-14);
  EXPECT_LT(
      (back.views[0].camera_from_world.translation - view.camera_from_world.translation).norm(),
      1e-8);
  // A path below the file's folder stands in it as a relative one.
  std::ifstream text(folder / "transforms.json");
  EXPECT_NE(std::string(std::istreambuf_iterator<char>(text), {}).find("\"images/x.png\""),
            std::string::npos);
}

void ExpectRefused(const std::string& json, const std::string& words) {
  const fs::path file = ScratchFolder() / "transforms.json";
  WriteFile(file, json);
  try {
    ReadKnownCameras(file);
    FAIL() << "was taken: " << json;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("transforms.json"), std::string::npos) << error.what();
  }
}

TEST(TransformsJson, RefusesWhatItCanNotUseInOneLineThatNamesTheField) {
  const std::string start = R"({"fl_x": 5, "w": 6, "h": 4, "frames": [{"file_path": "a.png", )";
  const std::string identity = R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
  ExpectRefused("not json", "JSON");
  ExpectRefused("[1]", "object");
  ExpectRefused("{}", "frames");
  ExpectRefused(R"({"format_version": 999, "frames": []})", "newer");
  ExpectRefused(start + R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]})",
                "transform_matrix");
  ExpectRefused(start + R"("transform_matrix": [[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})",
                "mirrors");
  ExpectRefused(start + R"("transform_matrix": [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})",
                "rotation");
  ExpectRefused(start + identity + R"(, "fl_x": -1}]})", "focal");
  ExpectRefused(start + identity + R"(, "fl_x": "five"}]})", "fl_x");
  ExpectRefused(start + identity + R"(, "w": 0}]})", "\"w\"");
  ExpectRefused(start + identity + R"(, "camera_model": "EQUIRECTANGULAR"}]})", "camera_model");
  ExpectRefused(start + identity + "}, {\"file_path\": \"b/a.jpg\", " + identity + "}]}",
                "two cameras");
}

TEST(StrechaCamera, HoldsCameraToWorldRotationAndCentre) {
  const fs::path folder = ScratchFolder();
  // R's columns: the camera's x, y, z axes in the world: +y, -z, -x. Pixels from integer centres.
  WriteFile(folder / "0007.jpg.camera",
            "500 0 310\n0 500 250\n0 0 1\n0 0 0\n0 0 -1\n1 0 0\n0 -1 0\n1 2 3\n640 480\n");
  const std::vector<View> views = ReadKnownCameras(folder);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].name, "0007");
  EXPECT_EQ(views[0].camera.width, 640);
  ExpectSeesThePointRight(views[0], 0.5);
}

TEST(HciGrid, MovesAPointByItsDisparityAndNotAtAllOnTheFocusPlane) {
  const fs::path folder = ScratchFolder();
  WriteFile(folder / "parameters.cfg",
            "[intrinsics]\nfocal_length_mm = 100.0\nimage_resolution_x_px = 512\n"
            "image_resolution_y_px = 256\nsensor_size_mm = 35.0\n[extrinsics]\nnum_cams_x = 5\n"
            "num_cams_y = 3\nbaseline_mm = 25.0\nfocus_distance_m = 4.0\n[meta]\nscene = x\n");
  WriteFile(folder / "input_Cam003.png", "");
  const std::vector<View> views = ReadKnownCameras(folder);
  ASSERT_EQ(views.size(), 15U);
  EXPECT_EQ(views[7].name, "input_Cam007");
  EXPECT_EQ(views[7].grid, (GridPosition{1, 2}));
  const double z = 2.5, f = 100.0 / 35 * 512;
  const double disparity = 0.025 * f * (1 / z - 1 / 4.0);  // the benchmark's formula
  const Eigen::Vector3d point(0.2, -0.1, z);
  const Eigen::Vector2d centre = *Project(views[7].camera, views[7].camera_from_world * point);
  for (const View& view : views) {
    const double columns = view.grid->column - 2, rows = view.grid->row - 1;
    const Eigen::Vector2d pixel = *Project(view.camera, view.camera_from_world * point);
    EXPECT_NEAR(pixel.x(), centre.x() - disparity * columns, 1e-9);
    EXPECT_NEAR(pixel.y(), centre.y() - disparity * rows, 1e-9);
    const Eigen::Vector3d focus(0.3, 0.2, 4);
    EXPECT_NEAR((*Project(view.camera, view.camera_from_world * focus)).x(), 256 + f * 0.3 / 4,
                1e-9);
  }
  const auto grid = FindRegularGrid({views[0], views[2], views[4], views[12]});
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->DisparityFromInverseDepth(1 / z), disparity, 1e-9);
  EXPECT_NEAR(grid->inverse_depth_of_zero_disparity, 0.25, 1e-12);
}

// A grid of 3 x 3 views of 4 x 2 px, f = 8 px, B = 0.5 m, focus at 4 m; disparities (px) of the
// centre view from the top row on.
fs::path SmallGridWithDisparity(const std::vector<float>& disparities, int width = 4) {
  fs::path folder = ScratchFolder();
  WriteFile(folder / "parameters.cfg",
            "[intrinsics]\nfocal_length_mm = 70\nimage_resolution_x_px = 4\n"
            "image_resolution_y_px = 2\nsensor_size_mm = 35\n[extrinsics]\nnum_cams_x = 3\n"
            "num_cams_y = 3\nbaseline_mm = 500\nfocus_distance_m = 4\n");
  WriteFile(folder / "input_Cam004.png", "");
  const int height = static_cast<int>(disparities.size()) / width;
  std::string pfm = "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1\n";
  for (int y = height - 1; y >= 0; --y) {
    pfm.append(reinterpret_cast<const char*>(disparities.data() + y * width),
               static_cast<std::size_t>(width) * sizeof(float));
  }
  WriteFile(folder / "gt_disp_lowres.pfm", pfm);
  return folder;
}

TEST(HciGrid, HasItsTrueDisparityAsDepthOfTheCentreView) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // d = f B (1/Z - 1/Zf) = 4 (1/Z - 1/4): at Z = 4, 2, 1, 8; -1 is infinity.
  const fs::path folder = SmallGridWithDisparity({0, 1, 3, -0.5F, -1, -1.5F, nan, 7});
  for (const View& view : ReadKnownCameras(folder)) {
    EXPECT_EQ(view.depth.empty(), view.name != "input_Cam004") << view.name;
  }
  const Image<float> depth = ReadHciDepth(folder / "gt_disp_lowres.pfm");
  const float infinite = std::numeric_limits<float>::infinity();
  const float expected[] = {4, 2, 1, 8, infinite, infinite, 0, 0.5F};
  for (std::size_t i = 0; i < depth.size(); ++i) EXPECT_FLOAT_EQ(depth.data()[i], expected[i]) << i;
}

TEST(HciGrid, RefusesDisparityOfAnotherSize) {
  const fs::path folder = SmallGridWithDisparity({0, 1, 3, 4, 5, 6}, 3);
  EXPECT_THROW(ReadHciDepth(folder / "gt_disp_lowres.pfm"), Error);
}

TEST(KnownCameras, OfAFolderWithoutAnyAreRefused) {
  EXPECT_THROW(ReadKnownCameras(ScratchFolder()), Error);
  EXPECT_THROW(ReadKnownCameras("/no/such/folder"), Error);
}

ColmapModel SmallModel() {
  ColmapModel model;
  model.cameras[3] = {.model = CameraModel::kBrown,
                      .width = 64,
                      .height = 48,
                      .fx = 50,
                      .fy = 51,
                      .cx = 31.5,
                      .cy = 24.25,
                      .distortion = {0.1, 0.02, 1e-3, -2e-3}};
  model.cameras[4] = {.width = 10, .height = 20, .fx = 11, .fy = 11.5, .cx = 5, .cy = 10};
  ColmapImage image{
      7, "a.png", 3, {Eigen::Quaterniond(0.1, 0.2, 0.3, 0.4).normalized(), {1, 2, 3}}, {}};
  image.observations = {{{1.25, 1.0 / 3}, -1}, {{7, 8}, 12}};
  model.images[7] = image;
  model.images[9] = {9, "b.png", 4, {}, {}};
  model.points[12] = {{0.1, -1e-7, 1e9}, {1, 2, 255}, 0.25, {{7, 1}}};
  return model;
}

TEST(ColmapModel, IsReadBackAsItWasWritten) {
  const fs::path folder = ScratchFolder();
  const ColmapModel model = SmallModel();
  WriteColmapModel(folder, model);
  const ColmapModel back = ReadColmapModel(folder);
  ASSERT_EQ(back.cameras.size(), 2U);
  EXPECT_EQ(back.cameras.at(3).model, CameraModel::kBrown);
  EXPECT_EQ(back.cameras.at(3).distortion, model.cameras.at(3).distortion);
  EXPECT_EQ(back.cameras.at(4).fy, 11.5);
  ASSERT_EQ(back.images.size(), 2U);
  EXPECT_EQ(back.images.at(7).name, "a.png");
  EXPECT_EQ(back.images.at(7).observations.at(0).pixel.y(), 1.0 / 3);
  EXPECT_EQ(back.images.at(7).observations.at(0).point_id, -1);
  EXPECT_TRUE(back.images.at(9).observations.empty());
  EXPECT_EQ(back.points.at(12).position, model.points.at(12).position);
  EXPECT_EQ(back.points.at(12).color.b, 255);
  EXPECT_EQ(back.points.at(12).track.at(0).observation, 1U);
}

TEST(ColmapModel, CutAnywhereIsRefusedOrWholeButNeverACrash) {
  const fs::path folder = ScratchFolder();
  WriteColmapModel(folder, SmallModel());
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    std::ifstream file(folder / name);
    const std::string whole(std::istreambuf_iterator<char>(file), {});
    for (std::size_t length = 0; length < whole.size(); ++length) {
      WriteFile(folder / name, whole.substr(0, length));
      try {
        ReadColmapModel(folder);
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::kInput);
      }
    }
    WriteFile(folder / name, whole);
  }
}

// ---- real files ----

std::optional<fs::path> RealData() {
  const char* place = std::getenv("LAMELLA_DATA");
  return place && *place != '\0' ? std::optional<fs::path>(place) : std::nullopt;
}

TEST(RealFiles, OfEveryKnownFormatAreRead) {
  const auto data = RealData();
  if (!data) GTEST_SKIP() << "LAMELLA_DATA is not set";
  EXPECT_EQ(ReadKnownCameras(*data / "handheld_gt/fountain-P11/gt_dense_cameras").size(), 11U);
  EXPECT_EQ(ReadKnownCameras(*data / "formats/transforms_json/object80_transforms.json").size(),
            80U);
  EXPECT_EQ(ReadKnownCameras(*data / "formats/colmap_text_maupertuis/reconstruction").size(), 4U);
  const std::vector<View> grid = ReadKnownCameras(*data / "lightfield/hci_antinous");
  EXPECT_EQ(grid.size(), 81U);
  ASSERT_TRUE(FindRegularGrid(grid));
  const ColmapModel model =
      ReadColmapModel(*data / "formats/colmap_text_maupertuis/reconstruction");
  EXPECT_EQ(model.points.size(), 1039U);
  EXPECT_LT(ReprojectionErrorPx(model), 2);
}

}  // namespace
}  // namespace lamella
