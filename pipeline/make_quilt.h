// Quilts of folders of views and back, and a quilt's native image for one Looking Glass panel.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lightfield/image.h"
#include "lightfield/progress.h"
#include "lightfield/quilt.h"
#include "lightfield/weave_quilt.h"

namespace lamella {

// Where the quilt of `source` (a folder) goes. `out` is a folder, where the quilt takes the
// source's name, or a .png, to whose name the layout is added where it is not there. UsageError
// where `out` names another format or layout.
std::filesystem::path QuiltFile(const std::filesystem::path& out,
                                const std::filesystem::path& source, const QuiltLayout& layout);
// UsageError where the quilt has more than 2^29 pixels.
void CheckQuiltSize(const QuiltLayout& layout, int tile_width_px, int tile_height_px);
// Of nearest, linear, gaussian and wide-gaussian; UsageError with the nearest name otherwise.
ViewFilter ViewFilterOf(const std::string& name);

struct MakeQuiltOptions {
  QuiltLayout layout;          // without an aspect: that of the views
  bool right_to_left = false;  // the last file is the leftmost camera's
};
struct MadeQuilt {
  std::filesystem::path file;  // its name tells the layout
  QuiltLayout layout;
  int views = 0, tile_width = 0, tile_height = 0;
};

// The pictures of a folder in the order of their names, numbers in them by their value, as 8-bit
// sRGB codes; tiles without a view are black. `out` as QuiltFile has it. InputError where pictures
// differ in size; UsageError where there are more than tiles, or as QuiltFile and CheckQuiltSize.
MadeQuilt MakeQuilt(const std::filesystem::path& views, const MakeQuiltOptions& options,
                    const std::filesystem::path& out, Progress& progress);

// What the quilt's name does not tell, or tells wrongly; 0: as the name has it.
struct ReadQuiltOptions {
  int columns = 0, rows = 0;
  std::optional<double> aspect;
  int views = 0;  // 0: all tiles but the last black ones
};
struct ReadQuiltResult {
  Image<Rgb8> codes;
  QuiltLayout layout;
  int views = 0;
};
// UsageError where neither name nor options tell the layout, or there are more views than tiles;
// InputError where the picture is smaller than its grid or wholly black.
ReadQuiltResult ReadQuilt(const std::filesystem::path& quilt, const ReadQuiltOptions& options);

// Writes view 0, the leftmost camera's, to OUT/view_000.png and so on.
std::vector<std::filesystem::path> SplitQuilt(const std::filesystem::path& quilt,
                                              const ReadQuiltOptions& options,
                                              const std::filesystem::path& out, Progress& progress);

struct NativeOptions {
  ReadQuiltOptions quilt;
  std::string filter = "nearest";  // linear, gaussian, wide-gaussian
  std::optional<double> center;    // instead of the calibration's
  bool reverse_views = false;      // shows view 0 where the last one belongs
};
struct NativeImage {
  Image<Rgb8> codes;
  std::string serial;
  int views = 0;
};
NativeImage MakeNative(const std::filesystem::path& quilt, const std::filesystem::path& visual_json,
                       const NativeOptions& options);

}  // namespace lamella
