#include "pipeline/errors_of_each.h"

#include <cstdint>

#include "lightfield/parallel.h"

namespace lamella {

std::vector<std::optional<Error>> ErrorsOfEach(std::size_t num,
                                               const std::function<void(std::size_t i)>& body) {
  std::vector<std::optional<Error>> errors(num);
  ParallelForEach(0, static_cast<std::int64_t>(num), [&](std::int64_t i) {
    const auto index = static_cast<std::size_t>(i);
    try {
      body(index);
    } catch (const Error& error) {
      errors[index] = error;
    }
  });
  return errors;
}

void ThrowFirst(const std::vector<std::optional<Error>>& errors) {
  for (const std::optional<Error>& error : errors) {
    if (error) throw *error;
  }
}

}  // namespace lamella
