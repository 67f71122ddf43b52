// Files read side by side, of which several may be unreadable: the first of them is told, whatever
// the number of threads.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "lightfield/error.h"

namespace lamella {

// body(i) for every i below `num`, one at a time on each thread; what each ended with, if with an
// Error. All run nevertheless; an exception that is no Error ends all at once.
std::vector<std::optional<Error>> ErrorsOfEach(std::size_t num,
                                               const std::function<void(std::size_t i)>& body);
void ThrowFirst(const std::vector<std::optional<Error>>& errors);

}  // namespace lamella
