#include "pipeline/errors_of_each.h"

#include <atomic>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace lamella {
namespace {

TEST(ErrorsOfEach, RunsAllAndTellsTheFirst) {
  std::atomic<int> ran = 0;
  const auto errors = ErrorsOfEach(9, [&](std::size_t i) {
    ++ran;
    if (i == 4 || i == 7) throw InputError(std::to_string(i), "is no photograph", "take it again");
  });
  EXPECT_EQ(ran, 9);
  ASSERT_EQ(errors.size(), 9U);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    EXPECT_EQ(errors[i].has_value(), i == 4 || i == 7) << i;
  }
  try {
    ThrowFirst(errors);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).front(), '4') << error.what();
  }
}

TEST(ErrorsOfEach, IsSilentWhereAllWentWell) {
  EXPECT_NO_THROW(ThrowFirst(ErrorsOfEach(3, [](std::size_t) {})));
  EXPECT_NO_THROW(ThrowFirst(ErrorsOfEach(0, [](std::size_t) { throw std::logic_error(""); })));
}

TEST(ErrorsOfEach, LetsWhatIsNoErrorPass) {
  EXPECT_THROW(ErrorsOfEach(3, [](std::size_t) { throw std::runtime_error("memory"); }),
               std::runtime_error);
}

}  // namespace
}  // namespace lamella
