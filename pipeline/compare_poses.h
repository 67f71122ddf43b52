// Poses against other poses, up to a similarity of the world.
#pragma once

#include <string>
#include <vector>

#include "lightfield/rigid.h"
#include "lightfield/view.h"

namespace lamella {

struct PoseError {
  std::string name;
  double centre = 0;  // distance of the centres after alignment, units of `truth`
  double rotation_deg = 0;
};

struct PoseComparison {
  std::vector<PoseError> views;  // those that both have, by name
  std::vector<std::string> only_estimate, only_truth;
  Similarity truth_from_estimate;
  double rmse = 0, mean = 0, max = 0;  // of the centres
  double mean_rotation_deg = 0;
};

// Views are matched by name. InputError where fewer than 3 names meet: the alignment is not unique
// (Umeyama 1991).
PoseComparison ComparePoses(const std::vector<View>& estimate, const std::vector<View>& truth);

}  // namespace lamella
