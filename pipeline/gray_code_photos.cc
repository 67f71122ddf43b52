#include "pipeline/gray_code_photos.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/image_folder.h"
#include "pipeline/photo_numbers.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

// A pattern in its inverse's place makes 1 of the finest bit and 1/2 of the next, any other order
// as much; edges of things before others make less.
constexpr double kMostStepsBack = 1.0 / 3;

std::string GrayCodeFile(const GrayCodePatterns& patterns, std::size_t i) {
  const auto num_columns = 2 * static_cast<std::size_t>(patterns.NumColumnBits());
  const std::size_t num_bits = patterns.Count() - 2;
  const std::string number = fmt::format("gray_{:03}", i + 1);
  if (i >= num_bits) return number + (i == num_bits ? "_white.png" : "_black.png");
  const bool is_column = i < num_columns;
  return fmt::format("{}_{}_bit_{}{}.png", number, is_column ? "column" : "row",
                     ((is_column ? num_columns : num_bits) - 1 - i) / 2,
                     i % 2 == 1 ? "_inverse" : "");
}

void CheckGrayCodeFiles(const std::vector<NamedFile>& files, const fs::path& folder,
                        const GrayCodePatterns& patterns) {
  if (files.size() != patterns.Count()) {
    throw InputError(
        folder.string(),
        fmt::format("holds {} photographs; {} x {} px in cells of {} px need {}", files.size(),
                    patterns.width_px, patterns.height_px, patterns.cell_px, patterns.Count()),
        "give every pattern with its inverse, then white and black, and the size of "
        "the screen and its cells as they were shown");
  }
  const ImageInfo first = ReadImageInfo(files.front().path);
  for (const NamedFile& file : files) {
    const ImageInfo info = ReadImageInfo(file.path);
    CheckSameSize({file.path.string(), info.width, info.height},
                  {files.front().path.filename().string(), first.width, first.height});
  }
}

Image<float> WhereValid(const Image<float>& values, const Image<std::uint8_t>& valid) {
  Image<float> known(values.width(), values.height());
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (valid.data()[i] != 0) known.data()[i] = values.data()[i];
  }
  return known;
}

}  // namespace

void WriteGrayCode(const fs::path& folder, const GrayCodePatterns& patterns, Progress& progress) {
  CreateFolder(folder);
  progress.Start("patterns", static_cast<std::int64_t>(patterns.Count()), "images");
  for (std::size_t i = 0; i < patterns.Count(); ++i) {
    WriteCodes8(folder / GrayCodeFile(patterns, i), DrawGrayCode(patterns, i).span());
    progress.Advance();
  }
}

ScreenMap ReadGrayCode(const fs::path& photos, const GrayCodePatterns& patterns,
                       double least_contrast, Progress& progress) {
  const std::vector<NamedFile> files = ImagesByNumber(photos);
  CheckGrayCodeFiles(files, photos, patterns);
  progress.Start("photographs", static_cast<std::int64_t>(files.size()), "photographs");
  ScreenMap map = DecodeGrayCode(
      patterns,
      [&](std::size_t i) {
        Image<float> numbers = ReadMeanNumbers(files[i].path);
        progress.Advance();
        return numbers;
      },
      least_contrast);
  if (SeenOf(map).num_valid == 0) {
    throw InputError(photos.string(),
                     fmt::format("no pixel's bits can be told; the last two photographs by name, "
                                 "{} and {}, must be of white and black",
                                 files[files.size() - 2].path.filename().string(),
                                 files.back().path.filename().string()),
                     "give them in the patterns' order, sharp and neither too dark nor "
                     "overexposed; wider cells are told from further off");
  }
  if (const double back = ShareOfStepsBack(map); back > kMostStepsBack) {
    throw InputError(photos.string(),
                     fmt::format("{:.0f} % of the steps from cell to cell go back: the photographs "
                                 "are not in the patterns' order",
                                 100 * back),
                     "name them so that they sort as the patterns do, each before its inverse");
  }
  return map;
}

void SaveScreenMap(const fs::path& file, const ScreenMap& map) {
  std::vector<Channel> channels;
  channels.push_back({"u", WhereValid(map.u_px, map.valid)});
  channels.push_back({"v", WhereValid(map.v_px, map.valid)});
  channels.push_back({"sd_u", WhereValid(map.sigma_u, map.valid)});
  channels.push_back({"sd_v", WhereValid(map.sigma_v, map.valid)});
  WriteExr(file, channels, ExrType::kFloat);
}

SeenOfScreen SeenOf(const ScreenMap& map) {
  constexpr float kFar = std::numeric_limits<float>::max();
  SeenOfScreen seen{0, kFar, 0, kFar, 0};
  for (std::size_t i = 0; i < map.valid.size(); ++i) {
    if (map.valid.data()[i] == 0) continue;
    const float u = map.u_px.data()[i], v = map.v_px.data()[i];
    ++seen.num_valid;
    seen.first_u = std::min(seen.first_u, u);
    seen.last_u = std::max(seen.last_u, u);
    seen.first_v = std::min(seen.first_v, v);
    seen.last_v = std::max(seen.last_v, v);
  }
  return seen.num_valid > 0 ? seen : SeenOfScreen{};
}

}  // namespace lamella
