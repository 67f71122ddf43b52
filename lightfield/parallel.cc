#include "lightfield/parallel.h"

#include <algorithm>
#include <exception>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace lamella {
namespace {

// An outer loop was called off by another iteration's exception, which is the one that is rethrown.
struct CalledOff : std::exception {
  const char* what() const noexcept override { return "a loop was called off"; }
};

}  // namespace

void ParallelFor(std::int64_t begin, std::int64_t end, std::int64_t grain,
                 const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (begin >= end) return;
  // Calling an outer loop off ends this one, too, without an exception of its own.
  tbb::task_group_context context;
  // simple_partitioner: the ranges depend on the grain alone, not on the machine.
  tbb::parallel_for(
      tbb::blocked_range<std::int64_t>(begin, end, std::max<std::int64_t>(grain, 1)),
      [&](const tbb::blocked_range<std::int64_t>& range) { body(range.begin(), range.end()); },
      tbb::simple_partitioner(), context);
  if (context.is_group_execution_cancelled()) throw CalledOff();
}

void ParallelForEach(std::int64_t begin, std::int64_t end,
                     const std::function<void(std::int64_t)>& body) {
  ParallelFor(begin, end, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) body(i);
  });
}

void Isolated(const std::function<void()>& work) { tbb::this_task_arena::isolate(work); }

struct ThreadLimit::Impl {
  explicit Impl(int threads)
      : control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : impl_(threads > 0 ? std::make_unique<Impl>(threads) : nullptr) {}
ThreadLimit::~ThreadLimit() = default;

int NumThreads() {
  const auto limit =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(std::min<std::size_t>(
      limit, static_cast<std::size_t>(tbb::this_task_arena::max_concurrency())));
}

}  // namespace lamella
