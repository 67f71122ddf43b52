#include "pipeline/compare_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {

PoseComparison ComparePoses(const std::vector<View>& estimate, const std::vector<View>& truth) {
  PoseComparison result;
  std::map<std::string, std::pair<const View*, const View*>> by_name;
  for (const View& view : estimate) by_name[view.name].first = &view;
  for (const View& view : truth) by_name[view.name].second = &view;
  std::vector<std::pair<const View*, const View*>> pairs;
  for (const auto& [name, pair] : by_name) {
    if (pair.first && pair.second) {
      pairs.push_back(pair);
    } else {
      (pair.first ? result.only_estimate : result.only_truth).push_back(name);
    }
  }
  if (pairs.size() < 3) {
    throw InputError("", fmt::format("only {} views have a name in both", pairs.size()),
                     "give two files with at least 3 common view names (a file's stem)");
  }
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd from(3, n), to(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    from.col(i) = Centre(pairs[static_cast<std::size_t>(i)].first->camera_from_world);
    to.col(i) = Centre(pairs[static_cast<std::size_t>(i)].second->camera_from_world);
  }
  result.truth_from_estimate = AlignSimilarity(from, to);
  const Eigen::Quaterniond turn(result.truth_from_estimate.rotation);
  double squares = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& [view, truth_view] = pairs[static_cast<std::size_t>(i)];
    // camera_from_truth_world of the estimate = camera_from_world * turn^-1.
    const Eigen::Quaterniond rotation = view->camera_from_world.rotation * turn.conjugate();
    PoseError error;
    error.name = view->name;
    error.centre = (result.truth_from_estimate * from.col(i) - to.col(i)).norm();
    error.rotation_deg =
        rotation.angularDistance(truth_view->camera_from_world.rotation) * 180 / std::numbers::pi;
    squares += error.centre * error.centre;
    result.mean += error.centre / static_cast<double>(n);
    result.mean_rotation_deg += error.rotation_deg / static_cast<double>(n);
    result.max = std::max(result.max, error.centre);
    result.views.push_back(error);
  }
  result.rmse = std::sqrt(squares / static_cast<double>(n));
  return result;
}

}  // namespace lamella
