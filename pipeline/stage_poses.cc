// The stage poses: cameras and poses of all views, their undistorted images, sparse points.
#include <algorithm>
#include <functional>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/capture_record.h"
#include "pipeline/poses/reconstruct.h"
#include "pipeline/poses/undistort.h"
#include "pipeline/poses_record.h"
#include "pipeline/stages.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// A registered view: as it was taken, and as it will be seen by a pinhole.
struct PosedView {
  const CapturedView* captured;
  const ColmapImage* image;
  Camera camera, pinhole;
  bool IsOriginal() const {  // the photograph itself is what the pinhole sees
    return camera.model == CameraModel::kPinhole && captured->orientation == 1 &&
           camera.width == pinhole.width && camera.height == pinhole.height;
  }
};

// By name, as the capture is.
std::vector<PosedView> PosedViews(const CaptureRecord& capture, const ColmapModel& model,
                                  const PosesOptions& options) {
  std::map<std::string, const ColmapImage*> images;
  for (const auto& [id, image] : model.images) images[image.name] = &image;
  std::vector<PosedView> posed;
  for (const CapturedView& view : capture.views) {
    const auto image = images.find(view.name);
    if (image == images.end()) continue;
    const Camera& camera = model.cameras.at(image->second->camera_id);
    posed.push_back(
        {&view, image->second, camera, UndistortedCamera(camera, options.undistorted_size_px)});
  }
  return posed;
}

std::string UndistortedFile(const std::string& name) { return "colmap/images/" + name + ".png"; }

// In strips: a photograph of floats is large, and this one is done with as soon as it is encoded.
Image<Rgb8> UndistortedCodes(const Image<Rgb>& image, const PosedView& view) {
  const int width = view.pinhole.width, height = view.pinhole.height;
  Image<Rgb8> codes(width, height);
  ParallelFor(0, height, 16, [&](std::int64_t first, std::int64_t last) {
    const int y = static_cast<int>(first);
    Image<Rgb> strip(width, static_cast<int>(last - first));
    UndistortRows(image, view.camera, view.pinhole, y, strip.span());
    const Image<Rgb8> encoded = EncodeSrgb8(strip.span());
    std::copy_n(encoded.data(), encoded.size(), codes.row(y));
  });
  return codes;
}

void WriteUndistorted(const std::vector<PosedView>& posed, const StageRun& run,
                      PhotographStore& photographs, Progress& progress) {
  if (std::all_of(posed.begin(), posed.end(), std::mem_fn(&PosedView::IsOriginal))) return;
  progress.Start("undistort", static_cast<std::int64_t>(posed.size()), "views");
  CreateFolder(run.folder() / "colmap" / "images");
  ParallelForEach(0, static_cast<std::int64_t>(posed.size()), [&](std::int64_t i) {
    const PosedView& view = posed[static_cast<std::size_t>(i)];
    const std::string file = UndistortedFile(view.captured->name);
    if (!view.IsOriginal() && !run.Finished(file)) {
      const Image<Rgb> image = ReadImage(view.captured->file);
      Image<Rgb8> codes = UndistortedCodes(image, view);
      WriteCodes8(run.folder() / file, codes.span(), /*jpeg_quality=*/95, PngCoding::kPhotograph);
      photographs.Add(run.folder() / file, std::move(codes));
    }
    progress.Advance();
  });
}

std::vector<View> UndistortedViews(const std::vector<PosedView>& posed, const fs::path& folder) {
  std::vector<View> views;
  for (const PosedView& view : posed) {
    const CapturedView& captured = *view.captured;
    // Depth that came with the capture is of its pixels and its units.
    const bool has_depth = view.IsOriginal() && captured.camera_from_world;
    views.push_back({captured.name,
                     view.IsOriginal() ? captured.file : folder / UndistortedFile(captured.name),
                     view.pinhole, view.image->camera_from_world, captured.grid,
                     has_depth ? captured.depth : fs::path()});
  }
  return views;
}

// COLMAP's points as seen in the undistorted images.
void AddPoints(const ColmapModel& model, const std::vector<PosedView>& posed, ViewSet& set,
               std::vector<PointDetail>& details) {
  std::map<std::uint32_t, int> view_of_image;
  for (std::size_t v = 0; v < posed.size(); ++v)
    view_of_image[posed[v].image->id] = static_cast<int>(v);
  for (const auto& [id, point] : model.points) {
    SparsePoint sparse{point.position, {}};
    PointDetail detail{point.color, point.error_px, {}};
    for (const ColmapTrackElement& element : point.track) {
      const int v = view_of_image.at(element.image_id);
      const PosedView& view = posed[static_cast<std::size_t>(v)];
      const auto pixel = UndistortPixel(view.camera, view.pinhole,
                                        view.image->observations[element.observation].pixel);
      const bool twice =
          std::find(sparse.views.begin(), sparse.views.end(), v) != sparse.views.end();
      if (!pixel || twice) continue;
      sparse.views.push_back(v);
      detail.pixels.push_back(*pixel);
    }
    if (sparse.views.size() < 2) continue;
    set.points.push_back(std::move(sparse));
    details.push_back(std::move(detail));
  }
}

std::string Listed(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

StageReport ReportOf(Reconstruction& reconstruction, const std::vector<PosedView>& posed) {
  const std::size_t lost = reconstruction.lost.size(), all = posed.size() + lost;
  StageReport report;
  report.summary = {{"registered", fmt::format("{} of {}", posed.size(), all)}};
  if (lost > 0) report.summary.emplace_back("lost", Listed(reconstruction.lost));
  const Camera& camera = posed[0].camera;
  report.summary.emplace_back("focal length", fmt::format("{:.1f} px of {}", camera.fx,
                                                          std::max(camera.width, camera.height)));
  report.summary.insert(report.summary.end(), reconstruction.summary.begin(),
                        reconstruction.summary.end());
  report.warnings = std::move(reconstruction.warnings);
  if (lost > 0) {
    report.missed_gate = fmt::format(
        "{} of {} views lost: {}; leave them out with --views or take photographs between them",
        lost, all, Listed(reconstruction.lost));
  }
  return report;
}

StageReport PosePhotographs(const CaptureRecord& capture, const PosesOptions& options,
                            PhotographStore& photographs, StageRun& run, Progress& progress) {
  Reconstruction reconstruction =
      Reconstruct(capture,
                  {{options.image_size_px, options.features, options.first_octave},
                   options.refine_principal_point},
                  run.folder() / "scratch", progress);
  const std::vector<PosedView> posed = PosedViews(capture, reconstruction.model, options);
  WriteUndistorted(posed, run, photographs, progress);
  ViewSet set;
  set.views = UndistortedViews(posed, run.folder());
  std::vector<PointDetail> details;
  AddPoints(reconstruction.model, posed, set, details);
  SaveViewSet(run.folder(), set, reconstruction.lost, details);
  return ReportOf(reconstruction, posed);
}

}  // namespace

OptionTable Describe(PosesOptions& options) {
  return {"poses",
          {{"image_size_px", "longer side of the images in which features are found",
            &options.image_size_px, 16, 100000},
           {"features", "features per image, the largest", &options.features, 16, 100000},
           {"first_octave", "scale at which features start; -1 doubles the image",
            &options.first_octave, -1, 4},
           {"undistorted_size_px", "longer side of the undistorted images; 0: as captured",
            &options.undistorted_size_px, 0, 100000},
           {"refine_principal_point",
            "where all of at least 8 views are registered, map again with the principal point free",
            &options.refine_principal_point}}};
}

void ApplyQuality(Quality quality, PosesOptions& options) {
  options = {};
  options.refine_principal_point = quality != Quality::kDraft;
  if (quality == Quality::kBest) {
    options.image_size_px = 1600;
    options.features = 4000;
  }
}

StageReport RunPoses(const Workspace& workspace, const PosesOptions& options, StageRun& run,
                     Progress& progress) {
  const CaptureRecord capture = LoadCapture(workspace);
  const std::optional<std::vector<View>> known = KnownViews(capture);
  if (!known || !FindRegularGrid(*known))
    return PosePhotographs(capture, options, workspace.photographs(), run, progress);
  SaveViewSet(run.folder(), {*known, {}}, {});
  StageReport report;
  report.summary = {{"registered", fmt::format("{0} of {0}", known->size())},
                    {"cameras", "a regular grid, as given: no structure from motion"}};
  return report;
}

}  // namespace lamella
