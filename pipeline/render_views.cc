#include "pipeline/render_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "depth/resize_area.h"
#include "distribute/metrics.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/ray_source.h"
#include "pipeline/capture/known_cameras.h"
#include "pipeline/capture/select_views.h"
#include "pipeline/capture_source.h"
#include "pipeline/image_folder.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

std::vector<View> ChooseCameras(const ViewsArguments& arguments) {
  std::vector<View> cameras = ReadKnownCameras(arguments.cameras);
  if (!arguments.views.empty()) {
    std::vector<std::string> names;
    for (const View& camera : cameras) names.push_back(camera.name);
    const std::vector<bool> chosen = SelectViews(names, arguments.views);
    std::vector<View> kept;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (chosen[i]) kept.push_back(std::move(cameras[i]));
    }
    cameras = std::move(kept);
  }
  for (View& view : cameras) {
    if (view.camera.model != CameraModel::kPinhole) {
      throw UsageError(arguments.cameras.string(), view.name + " has lens distortion",
                       "give undistorted cameras: views are rendered as pinholes see them");
    }
    if (arguments.size_px > 0) {
      const int longer = std::max(view.camera.width, view.camera.height);
      view.camera = Resized(view.camera, static_cast<double>(arguments.size_px) / longer);
    }
  }
  return cameras;
}

// The photograph of a view's name; empty where there is none.
fs::path PhotographOf(const View& view, const std::vector<NamedFile>& images) {
  const auto file = std::find_if(images.begin(), images.end(),
                                 [&](const NamedFile& f) { return f.name == view.name; });
  if (file != images.end()) return file->path;
  return !view.image.empty() && fs::is_regular_file(view.image) ? view.image : fs::path();
}

struct RenderedPicture {
  Image<Rgb> color;
  Image<float> coverage;
};

RenderedPicture Render(const RaySource& source, const View& view) {
  const RayBundle bundle = BundleOfCamera(view.camera, view.camera_from_world);
  Image<RaySample> samples(bundle.width, bundle.height);
  source.Query(bundle, {0, 0, bundle.width, bundle.height}, samples.span());
  RenderedPicture picture{Image<Rgb>(bundle.width, bundle.height),
                          Image<float>(bundle.width, bundle.height)};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    picture.color.data()[i] = samples.data()[i].color;
    picture.coverage.data()[i] = samples.data()[i].coverage;
  }
  return picture;
}

// The picture with each channel multiplied so that it fits the photograph best over seen pixels.
Image<Rgb> WithBestGain(const RenderedPicture& picture, const Image<Rgb>& photograph, int border) {
  std::array<double, 3> cross{}, square{};
  for (int y = border; y < picture.color.height() - border; ++y) {
    for (int x = border; x < picture.color.width() - border; ++x) {
      if (picture.coverage(x, y) < 0.5F) continue;
      const Rgb a = picture.color(x, y), b = photograph(x, y);
      const std::array<float, 3> of_picture{a.r, a.g, a.b}, of_photograph{b.r, b.g, b.b};
      for (std::size_t c = 0; c < 3; ++c) {
        const auto p = static_cast<double>(of_picture[c]),
                   q = static_cast<double>(of_photograph[c]);
        cross[c] += p * q;
        square[c] += p * p;
      }
    }
  }
  const auto gain = [&](std::size_t c) {
    return square[c] > 0 ? static_cast<float>(cross[c] / square[c]) : 1.0F;
  };
  const Rgb gains{gain(0), gain(1), gain(2)};
  Image<Rgb> fitted(picture.color.width(), picture.color.height());
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    const Rgb c = picture.color.data()[i];
    fitted.data()[i] = {gains.r * c.r, gains.g * c.g, gains.b * c.b};
  }
  return fitted;
}

void CompareWithPhotograph(const RenderedPicture& picture, const fs::path& path, int border,
                           RenderedView& result) {
  const int width = picture.color.width(), height = picture.color.height();
  Image<Rgb8> truth = ReadSrgb8(path);
  Image<Rgb> linear = ReadImage(path);
  if (truth.width() != width || truth.height() != height) {
    linear = ResizeArea(linear.span(), width, height);
    truth = EncodeSrgb8(linear.span());
  }
  const Image<Rgb8> rendered = EncodeSrgb8(picture.color.span());
  const MetricRegion seen{border, picture.coverage.span()};
  result.psnr = Psnr(rendered.span(), truth.span(), {border, {}});
  result.psnr_seen = Psnr(rendered.span(), truth.span(), seen);
  const Image<Rgb> fitted = WithBestGain(picture, linear, std::max(border, 0));
  result.psnr_seen_gain = Psnr(EncodeSrgb8(fitted.span()).span(), truth.span(), seen);
}

double ShareSeen(const Image<float>& coverage) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < coverage.size(); ++i) seen += coverage.data()[i] >= 0.5F;
  return static_cast<double>(seen) / static_cast<double>(coverage.size());
}

}  // namespace

std::vector<RenderedView> RenderViews(const ViewsArguments& arguments, Progress& progress) {
  const std::vector<View> cameras = ChooseCameras(arguments);
  const std::vector<NamedFile> images =
      arguments.images.empty() ? std::vector<NamedFile>() : ImagesOf(arguments.images);
  CreateFolder(arguments.out);
  const auto source = LoadCaptureSource(Workspace(arguments.workspace), arguments.render, progress);
  progress.Start("render", static_cast<std::int64_t>(cameras.size()), "views");
  std::vector<RenderedView> results;
  for (const View& view : cameras) {
    const RenderedPicture picture = Render(*source, view);
    WriteSrgb8(arguments.out / (view.name + ".png"), picture.color.span(), picture.coverage.span());
    RenderedView& result = results.emplace_back();
    result.name = view.name;
    result.seen = ShareSeen(picture.coverage);
    const fs::path photograph = PhotographOf(view, images);
    if (!photograph.empty()) {
      CompareWithPhotograph(picture, photograph, arguments.border_px, result);
    }
    progress.Advance();
  }
  return results;
}

}  // namespace lamella
