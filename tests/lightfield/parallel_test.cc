#include "lightfield/parallel.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace lamella {
namespace {

// Waits for it as long as a busy machine may take; a machine with one thread never gets there.
void WaitFor(const std::atomic<bool>& flag) {
  for (int i = 0; i < 200 && !flag; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

// One iteration throws while the loop within another one runs: that one ends early, and what comes
// after it must not take its work for done.
TEST(ParallelFor, GoesNoFurtherWhereItsWorkIsNotDone) {
  std::atomic<bool> within = false, thrown = false, half_done = false;
  const auto outer = [&](std::int64_t i) {
    if (i == 0) {
      WaitFor(within);
      thrown = true;
      throw std::runtime_error("the first");
    }
    std::atomic<int> done = 0;
    ParallelForEach(0, 1000, [&](std::int64_t) {
      within = true;
      WaitFor(thrown);
      std::this_thread::sleep_for(std::chrono::microseconds(100));
      ++done;
    });
    if (done < 1000) half_done = true;
  };
  try {
    ParallelForEach(0, 2, outer);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::exception& error) {
    EXPECT_EQ(std::string(error.what()), "the first");
  }
  EXPECT_FALSE(half_done);
}

}  // namespace
}  // namespace lamella
