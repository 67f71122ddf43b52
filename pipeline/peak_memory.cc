#include "pipeline/peak_memory.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <malloc.h>
#include <sys/resource.h>

namespace lamella {
namespace {

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

double ResidentMib() {
  malloc_trim(0);
  return StatusMib("VmRSS:");
}

}  // namespace lamella
