#include "pipeline/compare_depth.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/view.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace {

double Percent(std::int64_t count, std::int64_t of) {
  return of > 0 ? 100.0 * static_cast<double>(count) / static_cast<double>(of) : 0.0;
}

// The value below which `share` of them lie; they are reordered.
double Quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const std::ptrdiff_t rank = std::llround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(rank)]);
}

double RelativePercent(double depth, double truth) {
  if (std::isinf(depth) || std::isinf(truth)) {
    return depth == truth ? 0 : std::numeric_limits<double>::infinity();
  }
  return 100 * std::abs(depth - truth) / truth;
}

void CheckShapes(const Image<float>& estimate, const Image<float>& truth) {
  const double across = static_cast<double>(truth.width()) / estimate.width();
  if (std::abs(truth.height() / across - estimate.height()) <= 1) return;
  throw InputError("compare depth",
                   fmt::format("the estimate has {}x{} px, the truth {}x{}", estimate.width(),
                               estimate.height(), truth.width(), truth.height()),
                   "compare maps of one view");
}

// Appends the errors of a pair's known pixels; the number of all that can be compared.
std::int64_t AddErrors(const Image<float>& estimate, const Image<float>& truth,
                       std::vector<float>& errors) {
  CheckShapes(estimate, truth);
  std::int64_t pixels = 0;
  for (int y = 0; y < estimate.height(); ++y) {
    const int truth_y = static_cast<int>((y + 0.5) * truth.height() / estimate.height());
    for (int x = 0; x < estimate.width(); ++x) {
      const int truth_x = static_cast<int>((x + 0.5) * truth.width() / estimate.width());
      const double expected = static_cast<double>(truth(truth_x, truth_y));
      if (!(expected > 0)) continue;
      ++pixels;
      const double depth = static_cast<double>(estimate(x, y));
      if (depth > 0) errors.push_back(static_cast<float>(RelativePercent(depth, expected)));
    }
  }
  return pixels;
}

WorldDepthComparison Summarised(std::int64_t pixels, std::vector<float> errors) {
  WorldDepthComparison result;
  result.pixels = pixels;
  result.known = static_cast<std::int64_t>(errors.size());
  const std::int64_t good =
      std::count_if(errors.begin(), errors.end(), [](float error) { return error <= 1; });
  result.median = Quantile(errors, 0.5);
  result.p90 = Quantile(errors, 0.9);
  result.within_1 = Percent(good, result.known);
  result.within_1_of_all = Percent(good, pixels);
  return result;
}

// Sorted.
std::vector<std::string> ExrNames(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".exr") names.push_back(entry.path().filename().string());
  }
  if (error) throw InputError(folder.string(), error.message(), "give a folder of depth maps");
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

DepthComparison CompareDisparity(ImageSpan<const float> disparity, ImageSpan<const float> truth,
                                 int border) {
  if (disparity.width != truth.width || disparity.height != truth.height) {
    throw InputError("compare depth",
                     fmt::format("the estimate has {}x{} px, the truth {}x{}", disparity.width,
                                 disparity.height, truth.width, truth.height),
                     "compare maps of one view at one size");
  }
  DepthComparison result;
  double squares = 0;
  std::int64_t bad_07 = 0, bad_03 = 0, bad_01 = 0;
  for (int y = border; y < truth.height - border; ++y) {
    for (int x = border; x < truth.width - border; ++x) {
      if (!std::isfinite(truth(x, y))) continue;
      ++result.pixels;
      const double error =
          std::abs(static_cast<double>(disparity(x, y)) - static_cast<double>(truth(x, y)));
      // Unknown is NaN and compares as bad.
      bad_07 += !(error <= 0.07);
      bad_03 += !(error <= 0.03);
      bad_01 += !(error <= 0.01);
      if (std::isnan(error)) {
        ++result.unknown;
      } else {
        squares += error * error;
      }
    }
  }
  result.bad_07 = Percent(bad_07, result.pixels);
  result.bad_03 = Percent(bad_03, result.pixels);
  result.bad_01 = Percent(bad_01, result.pixels);
  const std::int64_t known = result.pixels - result.unknown;
  result.mse_x100 = known > 0 ? 100.0 * squares / static_cast<double>(known) : 0.0;
  return result;
}

DepthComparison CompareDepth(const std::filesystem::path& depth,
                             const std::filesystem::path& truth) {
  const DepthMap map = LoadDepthMap(depth);
  const Workspace workspace(std::filesystem::absolute(depth).parent_path().parent_path());
  const std::optional<RegularGrid> grid = FindRegularGrid(LoadViewSet(workspace).views);
  if (!grid) {
    throw InputError(depth.string(), "is not of a regular camera grid, so it has no disparity",
                     "compare the depth of a grid's view");
  }
  Image<float> disparity(map.depth.width(), map.depth.height());
  for (std::size_t i = 0; i < disparity.size(); ++i) {
    const double z = static_cast<double>(map.depth.data()[i]);
    disparity.data()[i] = z > 0 ? static_cast<float>(grid->DisparityFromInverseDepth(1 / z))
                                : std::numeric_limits<float>::quiet_NaN();
  }
  return CompareDisparity(disparity.span(), ReadPfm(truth).span());
}

WorldDepthComparison CompareWorldDepth(std::span<const DepthPair> pairs) {
  std::int64_t pixels = 0;
  std::vector<float> errors;
  for (const DepthPair& pair : pairs) {
    pixels += AddErrors(pair.estimate, pair.truth, errors);
  }
  WorldDepthComparison result = Summarised(pixels, std::move(errors));
  result.maps = static_cast<int>(pairs.size());
  return result;
}

WorldDepthComparison CompareWorldDepth(const std::filesystem::path& depth,
                                       const std::filesystem::path& truth) {
  const auto load = [](const std::filesystem::path& a, const std::filesystem::path& b) {
    return DepthPair{LoadDepth(a), LoadDepth(b)};
  };
  if (!std::filesystem::is_directory(depth)) {
    const DepthPair pair = load(depth, truth);
    return CompareWorldDepth(std::span(&pair, 1));
  }
  const std::vector<std::string> estimates = ExrNames(depth), truths = ExrNames(truth);
  std::vector<std::string> both, only_estimate, only_truth;
  std::set_intersection(estimates.begin(), estimates.end(), truths.begin(), truths.end(),
                        std::back_inserter(both));
  std::set_difference(estimates.begin(), estimates.end(), truths.begin(), truths.end(),
                      std::back_inserter(only_estimate));
  std::set_difference(truths.begin(), truths.end(), estimates.begin(), estimates.end(),
                      std::back_inserter(only_truth));
  if (both.empty()) {
    throw InputError(depth.string(), fmt::format("has no EXR of a name in {}", truth.string()),
                     "give two folders of depth maps of the same views");
  }
  std::int64_t pixels = 0;
  std::vector<float> errors;
  for (const std::string& name : both) {
    const DepthPair pair = load(depth / name, truth / name);
    pixels += AddErrors(pair.estimate, pair.truth, errors);
  }
  WorldDepthComparison result = Summarised(pixels, std::move(errors));
  result.maps = static_cast<int>(both.size());
  result.only_estimate = std::move(only_estimate);
  result.only_truth = std::move(only_truth);
  return result;
}

}  // namespace lamella
