// The inner loops of distribute/accumulate.h, one row of samples or emitters at a time, in vectors
// of the machine at hand. Sums have the same order, so the same bits, on every one.
#pragma once

#include <vector>

#include "distribute/accumulate.h"

namespace lamella {

// What a layer shows of a row of samples.
void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int layer,
             Light* out);

// out[i] = overlap i's sum of weighted samples of a row whose first sample has the index first_x.
void FilterRow(const Light* row, int first_x, const std::vector<Overlap>& overlaps,
               const float* weights, Light* out);

// sums[x] += the sum over the taps t of weights[t] rows[t][x], 0 <= x < count.
void AddRows(const Light* const* rows, const float* weights, int taps, int count, Light* sums);

}  // namespace lamella
