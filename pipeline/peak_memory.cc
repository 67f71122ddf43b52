#include "pipeline/peak_memory.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include <malloc.h>
#include <sys/resource.h>

namespace lamella {
namespace {

// Of all memory, what the allocator takes beyond what is asked of it: fragments, large pages.
constexpr double kAllocatorShare = 0.06;
// Pages of code that a stage's work brings in: 25 MiB were seen beyond those of loading.
constexpr double kCodeToComeGib = 32.0 / 1024;

double LargestChildMib() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// A line of the kernel's account of this process.
double StatusMib(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name)) return std::stod(line.substr(name.size())) / 1024;
  }
  return 0;
}

}  // namespace

// getrusage's mark for children can't be reset, so that only its growth says something of this
// stretch.
PeakMemory::PeakMemory() : children_before_mib_(LargestChildMib()) {
  std::ofstream("/proc/self/clear_refs") << "5";  // sets VmHWM back to what is resident now
}

double PeakMemory::OwnMib() { return StatusMib("VmHWM:"); }

double PeakMemory::Mib() const {
  const double own = OwnMib();
  const double child = LargestChildMib();
  return child > children_before_mib_ ? std::max(own, child) : own;
}

MemoryLeft MemoryLeftOf(double bound_gib, double to_come_bytes) {
  MemoryLeft left;
  left.held = ResidentMib() / 1024 + kCodeToComeGib + std::ldexp(to_come_bytes, -30);
  left.room = std::max((1 - kAllocatorShare) * bound_gib - left.held, 0.0);
  return left;
}

double LeastBound(const MemoryLeft& left, double room_gib) {
  return (left.held + room_gib) / (1 - kAllocatorShare);
}

double ResidentMib() {
  malloc_trim(0);
  return StatusMib("VmRSS:");
}

}  // namespace lamella
