// What the two ways to estimate depth have in common.
#pragma once

#include <memory>

#include "depth/estimate.h"

namespace lamella {

class DepthMethod {
 public:
  virtual ~DepthMethod() = default;
  // Pass 0: from the view and its neighbours' photographs.
  virtual DepthMap Match(int view) = 0;
  // Pass 1 and up: from all that the store holds of the pass before.
  virtual DepthMap Refine(int pass, int view) = 0;
  virtual DepthReport Report() const = 0;
};

// `set`, `options` and `store` must outlive the method.
std::unique_ptr<DepthMethod> MakeGridMethod(const ViewSet& set, const RegularGrid& grid,
                                            const DepthOptions& options, DepthStore& store);
std::unique_ptr<DepthMethod> MakeSweepMethod(const ViewSet& set, const DepthOptions& options,
                                             DepthStore& store);

}  // namespace lamella
