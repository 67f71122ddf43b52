// Peak memory of a stretch of the program and of the programs that it ran.
#pragma once

namespace lamella {

// Measures from its construction on. One at a time: the kernel keeps one high-water mark a process.
class PeakMemory {
 public:
  PeakMemory();
  double Mib() const;  // of this process, or of its largest finished child where that is more
  // Of this process alone, since the last PeakMemory was made: while a stretch still runs.
  static double OwnMib();

 private:
  double children_before_mib_;
};

// What a bound leaves a piece of work beside what this process holds and what will come, its code
// and `to_come_bytes`. GiB.
struct MemoryLeft {
  double held = 0, room = 0;
};
MemoryLeft MemoryLeftOf(double bound_gib, double to_come_bytes);
// The least bound that leaves so much room. GiB.
double LeastBound(const MemoryLeft& left, double room_gib);

// What this process holds now; memory that was freed is given back before.
double ResidentMib();

}  // namespace lamella
