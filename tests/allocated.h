// What a test program has allocated with new, counted: for promises about memory.
#pragma once

namespace lamella {

// From its construction on, above what was allocated then. One at a time.
class Allocated {
 public:
  Allocated();
  double PeakBytes() const;
};

}  // namespace lamella
