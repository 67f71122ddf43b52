#include "pipeline/compare_depth.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "lightfield/view.h"
#include "pipeline/depth_record.h"
#include "pipeline/poses_record.h"
#include "pipeline/workspace.h"

namespace lamella {

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
      if (std::isnan(error))
        ++result.unknown;
      else
        squares += error * error;
    }
  }
  const auto percent = [&](std::int64_t count) {
    return result.pixels > 0
               ? 100.0 * static_cast<double>(count) / static_cast<double>(result.pixels)
               : 0.0;
  };
  result.bad_07 = percent(bad_07);
  result.bad_03 = percent(bad_03);
  result.bad_01 = percent(bad_01);
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

}  // namespace lamella
