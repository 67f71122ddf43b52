// How a long task says how far it is. Kernels are given a Progress&; the program decides what is
// shown (a bar, plain lines, JSON, nothing).
#pragma once

#include <cstdint>
#include <string_view>

namespace lamella {

class Progress {
 public:
  virtual ~Progress() = default;
  // A task of `total` units begins ("depth", 11, "views"); it ends where the next one begins.
  virtual void Start(std::string_view task, std::int64_t total, std::string_view unit) = 0;
  virtual void Advance(std::int64_t units = 1) = 0;  // from any thread
  virtual void Note(std::string_view line) = 0;      // for --verbose
  virtual void Warn(std::string_view line) = 0;      // shown unless --quiet
};

// Shows nothing; for tests and for callers of the library.
Progress& SilentProgress();

}  // namespace lamella
