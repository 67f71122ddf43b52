// A fresh folder for the running test. ctest runs cases in processes of their own, side by side, so
// the folder's name holds the case's name and the process.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace lamella {

inline std::filesystem::path ScratchFolder() {
  const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
  std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                 (std::string("lamella-") + test.test_suite_name() + "-" +
                                  test.name() + "-" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace lamella
