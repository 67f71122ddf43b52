// COLMAP's sparse models, text and binary (reconstruction.cc of COLMAP 3.8).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/view.h"

namespace lamella {

struct ColmapObservation {
  Eigen::Vector2d pixel{0, 0};
  std::int64_t point_id = -1;  // -1: of no point
};

struct ColmapImage {
  std::uint32_t id = 0;
  std::string name;
  std::uint32_t camera_id = 0;
  Rigid camera_from_world;
  std::vector<ColmapObservation> observations;
};

struct ColmapTrackElement {
  std::uint32_t image_id = 0, observation = 0;
};

struct ColmapPoint {
  Eigen::Vector3d position{0, 0, 0};
  Rgb8 color;
  double error_px = 0;
  std::vector<ColmapTrackElement> track;
};

struct ColmapModel {
  std::map<std::uint32_t, Camera> cameras;
  std::map<std::uint32_t, ColmapImage> images;
  std::map<std::int64_t, ColmapPoint> points;
};

// True where the folder has cameras, images and points3D as .txt or .bin.
bool IsColmapModel(const std::filesystem::path& folder);

// Binary where both forms are there. InputError where a file is broken or truncated, a camera model
// has no equal here (FOV, THIN_PRISM_FISHEYE), or an image names a camera that is not there.
ColmapModel ReadColmapModel(const std::filesystem::path& folder);

// cameras.txt, images.txt and points3D.txt, in the order of the ids. Numbers read back exactly.
void WriteColmapModel(const std::filesystem::path& folder, const ColmapModel& model);

// The model's images as views named by their file's stem.
std::vector<View> ViewsOf(const ColmapModel& model);

// Root mean square of the distance between observations and the projections of their points, px.
double ReprojectionErrorPx(const ColmapModel& model);

// COLMAP's name, number and parameters of a camera: PINHOLE, FULL_OPENCV or OPENCV_FISHEYE.
struct ColmapCamera {
  int model_id = 0;
  std::string model;
  std::vector<double> parameters;
};
ColmapCamera ToColmap(const Camera& camera);
int ColmapModelId(const std::string& name);  // -1 where it has no equal here
// InputError naming `where` for models that have no equal here and for a wrong parameter count.
Camera FromColmap(int model_id, int width, int height, const std::vector<double>& parameters,
                  const std::string& where);

}  // namespace lamella
