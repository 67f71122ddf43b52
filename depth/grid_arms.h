// Which views of a camera grid a view is matched with.
#pragma once

#include <vector>

#include "lightfield/view.h"

namespace lamella {

// Sources by the side of the reference on which they lie, 4 or 8 sides going around it, some of
// them empty. Each side's views are in order of distance.
using GridArms = std::vector<std::vector<int>>;

// Sources at most `reach` steps away in row and in column (or as near as the nearest view is, where
// the grid is sparser), at most `per_arm` on a side, spread over the side's distances. The four
// sides of the reference's own row and column where these hold 8 views or more, else the 8 sides
// that include the diagonals. Near sources see nearly the same surfaces; far ones only add
// occlusions.
GridArms ChooseGridArms(const std::vector<View>& views, int reference, int reach, int per_arm);

// The largest number of steps, in row or column, between the reference and a source.
int ReachOf(const std::vector<View>& views, int reference, const GridArms& arms);

}  // namespace lamella
