// A camera calibrated from OpenCV's photographs of a chessboard, against OpenCV's published
// calibration from them. Needs the folder of test data that LAMELLA_DATA names.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/initialise.h"
#include "calibration/saddle.h"
#include "calibration/solve.h"
#include "lightfield/atomic_file.h"
#include "lightfield/color.h"
#include "lightfield/image_io.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

constexpr int kColumns = 9, kRows = 6;
constexpr double kSquareMm = 25;
constexpr int kPhotos[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14};
constexpr PanelId kBoard{0, PanelId::kModulator};

// The board as a panel whose pixels are squares.
Calibration Design() {
  PanelCalibration panel;
  panel.width_px = kColumns + 1;
  panel.height_px = kRows + 1;
  panel.pitch_mm = kSquareMm;
  LayerCalibration layer;
  layer.emitter = panel;
  layer.modulator = panel;
  return {"chessboard", {layer}};
}

std::vector<double> NumbersOf(const std::string& text, const std::string& key) {
  const std::size_t begin = text.find('[', text.find("\n" + key)) + 1;
  std::string list = text.substr(begin, text.find(']', begin) - begin);
  std::replace(list.begin(), list.end(), ',', ' ');
  std::istringstream stream(list);
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  return numbers;
}

class RealChessboard : public testing::Test {
 protected:
  void SetUp() override {
    const char* place = std::getenv("LAMELLA_DATA");
    if (place == nullptr || *place == '\0') GTEST_SKIP() << "LAMELLA_DATA is not set";
    folder_ = fs::path(place) / "calibration/opencv_chessboard";
  }

  cv::Mat Photo(int number) const {
    const Image<Rgb> light = ReadImage(folder_ / fmt::format("left{:02}.jpg", number));
    cv::Mat grey(light.height(), light.width(), CV_8UC1);
    for (int y = 0; y < light.height(); ++y) {
      for (int x = 0; x < light.width(); ++x) {
        grey.at<std::uint8_t>(y, x) =
            static_cast<std::uint8_t>(std::lround(255 * LinearToSrgb(Luminance(light(x, y)))));
      }
    }
    return grey;
  }

  static std::vector<cv::Point2f> RoughCorners(const cv::Mat& photo) {
    std::vector<cv::Point2f> corners;
    EXPECT_TRUE(cv::findChessboardCorners(photo, {kColumns, kRows}, corners));
    return corners;
  }

  // `refine` takes OpenCV's corners, in its pixels, to observations.
  template <class Refine>
  Observations Observe(Refine refine) const {
    Observations observations;
    observations.cameras.push_back({"left", 640, 480, 0});
    for (std::size_t view = 0; view < std::size(kPhotos); ++view) {
      const cv::Mat photo = Photo(kPhotos[view]);
      PanelPhoto seen{kBoard, static_cast<int>(view), 0, fmt::format("left{:02}", kPhotos[view]),
                      refine(photo, RoughCorners(photo))};
      for (std::size_t c = 0; c < seen.points.size(); ++c) {
        const auto i = static_cast<int>(c);
        seen.points[c].panel_px = Vector2d(i % kColumns + 1, i / kColumns + 1);
      }
      observations.photos.push_back(seen);
    }
    return observations;
  }

  fs::path folder_;
};

// OpenCV's first pixel has its centre at (0, 0).
Vector2d InOurPixels(const cv::Point2f& corner) {
  return {static_cast<double>(corner.x) + 0.5, static_cast<double>(corner.y) + 0.5};
}

FreeGroups CameraOnly() {
  FreeGroups free;
  free.k3 = true;
  free.slip = false;
  return free;
}

// Gauss-Newton on all points, with fx = fy, as the published calibration was made.
CalibrationState WithFixedAspect(CalibrationState state, const Structure& structure,
                                 const Observations& observations) {
  const Columns columns = ColumnsOf(structure, CameraOnly(), observations);
  const auto fx = static_cast<Eigen::Index>(columns.camera[0]);
  state.cameras[0](0) = state.cameras[0](1) = state.cameras[0].head<2>().mean();
  Eigen::MatrixXd tied = Eigen::MatrixXd::Identity(columns.size, columns.size);
  tied(fx, fx + 1) = 1;  // a step of fy's column moves both
  tied(fx, fx) = 0;
  for (int i = 0; i < 20; ++i) {
    const NormalEquations equations =
        Linearise(state, structure, columns, observations, Weighting());
    Eigen::MatrixXd hessian = tied.transpose() * equations.hessian * tied;
    hessian(fx, fx) = 1;  // of the column that is gone
    const Eigen::VectorXd step = hessian.ldlt().solve(-tied.transpose() * equations.gradient);
    state = Plus(state, columns, tied * step);
  }
  return state;
}

double RmsOf(const CalibrationState& state, const Structure& structure,
             const Observations& observations) {
  double sum = 0, count = 0;  // covariances are unity
  for (const auto& residuals : WhitenedResiduals(state, structure, observations)) {
    sum += residuals.squaredNorm();
    count += static_cast<double>(residuals.cols());
  }
  return std::sqrt(sum / count);
}

// Corners of the same detector, windows of 23 x 23 px, equal focal lengths: the published numbers.
TEST_F(RealChessboard, GivesThePublishedCameraFromThePublishedCorners) {
  const Observations observations =
      Observe([](const cv::Mat& photo, std::vector<cv::Point2f> corners) {
        cv::cornerSubPix(photo, corners, {11, 11}, {-1, -1},
                         {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 30, 0.1});
        std::vector<Observation> points;
        for (const cv::Point2f& corner : corners) {
          points.push_back({{0, 0}, InOurPixels(corner), Eigen::Matrix2d::Identity()});
        }
        return points;
      });
  const Structure structure = StructureOf(observations, Design());
  const Fit fit = Solve(Initialise(observations, structure), structure, observations, CameraOnly());
  const CalibrationState state = WithFixedAspect(fit.state, structure, observations);
  const std::string text = ReadText(folder_ / "left_intrinsics.yml");
  const auto k = NumbersOf(text, "camera_matrix"), d = NumbersOf(text, "distortion_coefficients");
  const LensParameters& camera = state.cameras[0];
  EXPECT_NEAR(camera(0) / k[0], 1, 1e-4);
  EXPECT_NEAR(camera(2), k[2] + 0.5, 0.05);
  EXPECT_NEAR(camera(3), k[5] + 0.5, 0.05);
  EXPECT_NEAR(camera(4), d[0], 1e-3);
  EXPECT_NEAR(camera(5), d[1], 5e-3);
  const std::size_t error = text.find("avg_reprojection_error:") + 23;
  EXPECT_NEAR(RmsOf(state, structure, observations), std::stod(text.substr(error)), 1e-3);
}

// Windows that end before the next corner, and the noise's own covariance.
std::vector<Observation> OwnCorners(const cv::Mat& photo, const std::vector<cv::Point2f>& corners) {
  Image<float> grey(photo.cols, photo.rows);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    grey.data()[i] = static_cast<float>(photo.data[i]) / 255;
  }
  const NoiseCurve noise(grey.span());
  std::vector<Observation> points;
  for (const cv::Point2f& corner : corners) {
    const auto saddle = RefineSaddle(grey.span(), InOurPixels(corner), 5, noise);
    EXPECT_TRUE(saddle);
    if (saddle) points.push_back({{0, 0}, saddle->position_px, saddle->covariance_px2});
  }
  return points;
}

struct Focal {
  double px = 0, sd_px = 0;
};

Focal FocalOf(const Fit& fit) {
  const auto fx = static_cast<Eigen::Index>(fit.columns.camera[0]);
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(fit.columns.size);
  unit(fx) = 1;
  return {fit.state.cameras[0](0),
          std::sqrt(fit.variance * fit.equations.hessian.ldlt().solve(unit)(fx))};
}

Fit SolveCamera(const Observations& observations) {
  const Structure structure = StructureOf(observations, Design());
  return Solve(Initialise(observations, structure), structure, observations, CameraOnly());
}

// The stated deviation is that of the jackknife over the photographs (Efron 1979), which knows
// nothing of the corners' covariances.
TEST_F(RealChessboard, IsFittedBetterByOwnCornersWithAnHonestDeviation) {
  const Observations observations = Observe(OwnCorners);
  const Fit fit = SolveCamera(observations);
  EXPECT_TRUE(fit.rejected.empty());
  Observations plain = observations;
  for (PanelPhoto& photo : plain.photos) {
    for (Observation& point : photo.points) point.covariance_px2.setIdentity();
  }
  EXPECT_LT(RmsOf(fit.state, StructureOf(plain, Design()), plain), 0.22);
  const Focal focal = FocalOf(fit);
  EXPECT_NEAR(focal.px / 535.916, 1, 0.01);
  double sum = 0, squares = 0;
  const auto n = static_cast<double>(observations.photos.size());
  for (std::size_t out = 0; out < observations.photos.size(); ++out) {
    Observations rest = observations;
    rest.photos.erase(rest.photos.begin() + static_cast<std::ptrdiff_t>(out));
    const double px = FocalOf(SolveCamera(rest)).px;
    sum += px;
    squares += px * px;
  }
  const double jackknife = std::sqrt((n - 1) / n * (squares - sum * sum / n));
  EXPECT_GT(focal.sd_px / jackknife, 0.5);
  EXPECT_LT(focal.sd_px / jackknife, 2);
}

}  // namespace
}  // namespace lamella
