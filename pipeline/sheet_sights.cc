#include "pipeline/sheet_sights.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostSamples = 100000;  // of a position
constexpr std::size_t kMostOff = 20000;       // samples that show what cameras' errors do
// A lens magnifies the panel's pixels, within which there is one phase.
constexpr double kPixelSigma = 0.2887;  // px: 1/sqrt(12)
// Of the pixels that see a faint sinusoid, those to be unwrapped one by one; else none are.
constexpr double kLeastUnwrapped = 0.2;
constexpr int kFinePeriod = 16, kMiddlePeriod = 128;  // px

// Every so many-th known pixel.
void AddPixels(const ScreenMap& map, int view, SightedPixels& seen) {
  std::vector<std::pair<int, int>> known;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.valid(x, y) != 0) known.emplace_back(x, y);
    }
  }
  const std::size_t count = std::min(kMostSamples, known.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto [x, y] = known[i * known.size() / count];
    SightedPixel pixel;
    pixel.view = view;
    pixel.image_px = {x + 0.5, y + 0.5};
    pixel.panel_px = {static_cast<double>(map.u_px(x, y)), static_cast<double>(map.v_px(x, y))};
    pixel.sigma_px = {std::hypot(static_cast<double>(map.sigma_u(x, y)), kPixelSigma),
                      std::hypot(static_cast<double>(map.sigma_v(x, y)), kPixelSigma)};
    seen.pixels.push_back(pixel);
  }
}

int CoarsestPeriod(const PhaseCapture& capture) {
  int coarsest = 0;
  for (const PhasePhotos& photos : capture.series) {
    coarsest = std::max(coarsest, photos.series.period_px);
  }
  return coarsest;
}

// Nothing where the pixel does not look at the sheet.
std::optional<LatticeSample> SampleOf(const SightedPixel& pixel, const Camera& camera,
                                      const Rigid& stack_from_camera) {
  const std::optional<Vector3d> ray = Unproject(camera, pixel.image_px);
  if (!ray) return std::nullopt;
  const Vector3d& eye = stack_from_camera.translation;
  const Vector3d direction = stack_from_camera.rotation * *ray;
  if (!(direction.z() < 0)) return std::nullopt;
  return LatticeSample{pixel.view, (eye - eye.z() / direction.z() * direction).head<2>(),
                       pixel.panel_px, pixel.sigma_px};
}

}  // namespace

void SheetSights::Add(const PhaseCapture& capture, int view) {
  AddPixels(DecodePhase(capture), view, whole);
  AddPixels(DecodePeriod(capture, kFinePeriod), view, fine);
  AddPixels(DecodePeriod(capture, kMiddlePeriod), view, middle);
  AddPixels(DecodePeriod(capture, CoarsestPeriod(capture)), view, coarse);
  fine.period_px = kFinePeriod;
  middle.period_px = kMiddlePeriod;
  ++num_views;
}

bool SheetSights::IsFaint() const {
  return static_cast<double>(whole.pixels.size()) <
         kLeastUnwrapped * static_cast<double>(fine.pixels.size());
}

LatticeObservations Through(SightedPixels& pixels, const std::vector<View>& cameras,
                            const Rigid& stack_from_world) {
  LatticeObservations observations;
  observations.period_px = pixels.period_px;
  std::vector<Rigid> stack_from_camera;
  for (const View& camera : cameras) {
    stack_from_camera.push_back(stack_from_world * Inverse(camera.camera_from_world));
    observations.eyes_mm.push_back(stack_from_camera.back().translation);
  }
  std::erase_if(pixels.pixels, [&](const SightedPixel& pixel) {
    const auto view = static_cast<std::size_t>(pixel.view);
    const auto sample = SampleOf(pixel, cameras[view].camera, stack_from_camera[view]);
    if (sample) observations.samples.push_back(*sample);
    return !sample;
  });
  return observations;
}

CameraErrors ErrorsOf(const BoardCameras& board, const SightedPixels& pixels,
                      const std::vector<int>& positions, const LatticeObservations& observations,
                      const Rigid& stack_from_board) {
  CameraErrors errors;
  errors.num_ways = static_cast<int>(board.off.size());
  errors.every = std::max<std::size_t>(1, pixels.pixels.size() / kMostOff);
  errors.off = [&board, &pixels, positions, &observations, stack_from_board,
                every = errors.every](int way) {
    const CameraPoses& poses = board.off[static_cast<std::size_t>(way)];
    LatticeObservations off;
    off.period_px = observations.period_px;
    std::vector<Rigid> stack_from_camera;
    for (const int position : positions) {
      const auto found = std::lower_bound(board.views.begin(), board.views.end(), position);
      const auto i = static_cast<std::size_t>(found - board.views.begin());
      stack_from_camera.push_back(stack_from_board * Inverse(poses.camera_from_board[i]));
      off.eyes_mm.push_back(stack_from_camera.back().translation);
    }
    for (std::size_t i = 0; i < pixels.pixels.size(); i += every) {
      const SightedPixel& pixel = pixels.pixels[i];
      const auto sample =
          SampleOf(pixel, poses.camera, stack_from_camera[static_cast<std::size_t>(pixel.view)]);
      off.samples.push_back(sample.value_or(observations.samples[i]));
    }
    return off;
  };
  return errors;
}

}  // namespace lamella
