// The inner loops of distribute/accumulate.h, one row of samples or emitters at a time, in vectors
// of the machine at hand. Sums have the same order, so the same bits, on every one.
#pragma once

#include <span>

#include "distribute/accumulate.h"

namespace lamella {

// What each of `layers` layers (1 or 2) from first_layer on shows of a row of samples: `count`
// lights of a layer after those of the one behind it.
void TakeRow(const RaySample* samples, int count, const LayerWeights& weights, int first_layer,
             int layers, Light* out);

// sums[i] += the sum over the taps t of weights[taps i + t] row[firsts[i] + t].
void AddFiltered(const Light* row, std::span<const int> firsts, const float* weights, int taps,
                 Light* sums);

// sums[x] += the sum over the taps t of weights[t] rows[t][x], 0 <= x < count.
void AddRows(const Light* const* rows, const float* weights, int taps, int count, Light* sums);

}  // namespace lamella
