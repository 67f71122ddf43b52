// A tile of thresholds whose every level set is spread evenly: blue noise by void and cluster
// (Ulichney 1993), made, not stored, and the same on every machine.
#pragma once

#include "lightfield/display.h"
#include "lightfield/image.h"

namespace lamella {

constexpr int kBlueNoiseSize = 64;  // columns and rows of a tile

// The ranks 0 ... size^2 - 1, each once, over a tile that repeats in both directions. Columns and
// rows are those of the lattice's points: a hexagonal one's are sqrt(3)/2 apart and its odd rows
// lie half a column further right, so that it repeats by even numbers of rows. `size` is even.
// Ties go to the first point in reading order.
Image<int> MakeBlueNoise(int size, LensletArray::Lattice lattice);

// (rank + 1/2) / size^2 of a tile of kBlueNoiseSize, in (0, 1); made once a process.
const Image<float>& BlueNoise(LensletArray::Lattice lattice);

}  // namespace lamella
