#include "pipeline/make_quilt.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/image_folder.h"
#include "pipeline/visual_json.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr double kMaxPixels = 1 << 29;

std::vector<NamedFile> ViewsOf(const fs::path& folder, const MakeQuiltOptions& options) {
  std::vector<NamedFile> files = ImagesByNumber(folder);
  if (options.right_to_left) std::reverse(files.begin(), files.end());
  const QuiltLayout& layout = options.layout;
  const int tiles = layout.columns * layout.rows;
  if (files.size() > static_cast<std::size_t>(tiles)) {
    throw UsageError(folder.string(),
                     fmt::format("holds {} views, and {} x {} tiles take {}", files.size(),
                                 layout.columns, layout.rows, tiles),
                     "give more --columns or --rows");
  }
  return files;
}

// Of all views; checks that it is one.
ImageInfo SizeOf(const std::vector<NamedFile>& files) {
  ImageInfo first = ReadImageInfo(files.front().path);
  for (const NamedFile& file : files) {
    const ImageInfo info = ReadImageInfo(file.path);
    if (info.width == first.width && info.height == first.height) continue;
    throw InputError(file.path.string(),
                     fmt::format("has {} x {} px, and {} has {} x {}", info.width, info.height,
                                 files.front().path.filename().string(), first.width, first.height),
                     "make all views alike in size");
  }
  return first;
}

bool SameLayout(const QuiltLayout& a, const QuiltLayout& b) {
  return QuiltSuffix(a) == QuiltSuffix(b);
}

std::string NameOf(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path name = whole.has_filename() ? whole.filename() : whole.parent_path().filename();
  return name.empty() ? "quilt" : name.string();
}

QuiltLayout LayoutOf(const fs::path& quilt, const ReadQuiltOptions& options) {
  const std::optional<QuiltLayout> named = QuiltLayoutOf(quilt.filename().string());
  QuiltLayout layout = named.value_or(QuiltLayout{});
  if (options.columns > 0) layout.columns = options.columns;
  if (options.rows > 0) layout.rows = options.rows;
  if (options.aspect) layout.aspect = options.aspect;
  if (layout.columns < 1 || layout.rows < 1) {
    throw UsageError(quilt.string(), "its name has no layout like _qs8x6a0.75",
                     "give --columns and --rows");
  }
  return layout;
}

}  // namespace

fs::path QuiltFile(const fs::path& out, const fs::path& source, const QuiltLayout& layout) {
  const std::string suffix = QuiltSuffix(layout) + ".png";
  if (out.extension() == ".png") {
    const std::optional<QuiltLayout> named = QuiltLayoutOf(out.filename().string());
    if (!named) return out.parent_path() / (out.stem().string() + suffix);
    if (SameLayout(*named, layout)) return out;
    throw UsageError(out.string(), "its name tells another layout than " + QuiltSuffix(layout),
                     "name it so, or without a layout");
  }
  const std::optional<QuiltLayout> named = QuiltLayoutOf(out.filename().string());
  if (named || out.extension() == ".jpg" || out.extension() == ".jpeg") {
    throw UsageError(out.string(), "is no .png", "a quilt is written as PNG, without loss");
  }
  return out / (NameOf(source) + suffix);
}

void CheckQuiltSize(const QuiltLayout& layout, int tile_width_px, int tile_height_px) {
  if (1.0 * layout.columns * tile_width_px * layout.rows * tile_height_px <= kMaxPixels) return;
  throw UsageError("quilt",
                   fmt::format("{} x {} tiles of {} x {} px are more than 2^29 px", layout.columns,
                               layout.rows, tile_width_px, tile_height_px),
                   "give smaller views or fewer tiles");
}

ViewFilter ViewFilterOf(const std::string& name) {
  if (name == "nearest") return ViewFilter::kNearest;
  if (name == "linear") return ViewFilter::kLinear;
  if (name == "gaussian") return ViewFilter::kGaussian;
  if (name == "wide-gaussian") return ViewFilter::kWideGaussian;
  throw UsageError(
      "--filter", fmt::format("there is no filter \"{}\"", name),
      fmt::format("did you mean \"{}\"?",
                  NearestName(name, {"nearest", "linear", "gaussian", "wide-gaussian"})));
}

MadeQuilt MakeQuilt(const fs::path& views, const MakeQuiltOptions& options, const fs::path& out,
                    Progress& progress) {
  const std::vector<NamedFile> files = ViewsOf(views, options);
  const ImageInfo size = SizeOf(files);
  QuiltLayout layout = options.layout;
  if (!layout.aspect) layout.aspect = static_cast<double>(size.width) / size.height;
  CheckQuiltSize(layout, size.width, size.height);
  const fs::path file = QuiltFile(out, views, layout);
  Image<Rgb8> quilt(layout.columns * size.width, layout.rows * size.height);
  progress.Start("quilt", static_cast<std::int64_t>(files.size()), "views");
  ParallelForEach(0, static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    const Image<Rgb8> picture = ReadSrgb8(files[static_cast<std::size_t>(i)].path);
    PutQuiltView(quilt.span(), layout, static_cast<int>(i), picture.span());
    progress.Advance();
  });
  if (!file.parent_path().empty()) CreateFolder(file.parent_path());
  WriteCodes8(file, quilt.span());
  return {file, layout, static_cast<int>(files.size()), size.width, size.height};
}

ReadQuiltResult ReadQuilt(const fs::path& quilt, const ReadQuiltOptions& options) {
  ReadQuiltResult result;
  result.layout = LayoutOf(quilt, options);
  const auto& [columns, rows, aspect] = result.layout;
  if (options.views > columns * rows) {
    throw UsageError("--views",
                     fmt::format("{} x {} tiles hold no {} views", columns, rows, options.views),
                     "give fewer");
  }
  result.codes = ReadSrgb8(quilt);
  if (result.codes.width() < columns || result.codes.height() < rows) {
    throw InputError(quilt.string(),
                     fmt::format("has {} x {} px, too few for {} x {} tiles", result.codes.width(),
                                 result.codes.height(), columns, rows),
                     "give another quilt, or its --columns and --rows");
  }
  result.views = options.views > 0 ? options.views : QuiltViews(result.codes.span(), result.layout);
  if (result.views < 1) {
    throw InputError(quilt.string(), "is black",
                     "give another quilt, or the number of its --views");
  }
  return result;
}

std::vector<fs::path> SplitQuilt(const fs::path& quilt, const ReadQuiltOptions& options,
                                 const fs::path& out, Progress& progress) {
  const ReadQuiltResult read = ReadQuilt(quilt, options);
  CreateFolder(out);
  std::vector<fs::path> files;
  for (int view = 0; view < read.views; ++view) {
    files.push_back(out / fmt::format("view_{:03}.png", view));
  }
  progress.Start("views", read.views, "views");
  ParallelForEach(0, read.views, [&](std::int64_t i) {
    WriteCodes8(files[static_cast<std::size_t>(i)],
                QuiltView(read.codes.span(), read.layout, static_cast<int>(i)));
    progress.Advance();
  });
  return files;
}

NativeImage MakeNative(const fs::path& quilt, const fs::path& visual_json,
                       const NativeOptions& options) {
  const ViewFilter filter = ViewFilterOf(options.filter);
  VisualJson visual = ReadVisualJson(visual_json);
  if (options.center) visual.panel.center = *options.center;
  if (options.reverse_views) visual.panel.invert_views = !visual.panel.invert_views;
  const ReadQuiltResult read = ReadQuilt(quilt, options.quilt);
  return {WeaveQuilt(read.codes.span(), read.layout, read.views, visual.panel, filter),
          visual.serial, read.views};
}

}  // namespace lamella
