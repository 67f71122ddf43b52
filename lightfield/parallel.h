// Parallel loops on oneTBB. A loop's body owns what it writes, so results never depend on the
// number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace lamella {

// Calls body(first, last) on disjoint ranges that cover [begin, end), each at most `grain` long.
// An exception of a body is rethrown. It stops the loop; loops within it throw, which is dropped.
void ParallelFor(std::int64_t begin, std::int64_t end, std::int64_t grain,
                 const std::function<void(std::int64_t first, std::int64_t last)>& body);

// body(i) for every i in [begin, end), one at a time.
void ParallelForEach(std::int64_t begin, std::int64_t end,
                     const std::function<void(std::int64_t i)>& body);

// Runs `work`; a thread that waits for a loop within it takes up nothing from outside of it, so
// `work` may hold a lock that other iterations of an outer loop wait for.
void Isolated(const std::function<void()>& work);

// While it lives, loops use at most `threads` threads (0: as many as the machine has).
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

int NumThreads();  // that a loop started now would use

}  // namespace lamella
