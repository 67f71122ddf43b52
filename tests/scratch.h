// A fresh folder for the running test. ctest runs cases in processes of their own, side by side, so
// the folder's name holds the case's name and the process. It goes when the test has not failed.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <unistd.h>

namespace lamella {

// That of a failed test stays, to be looked into.
class ScratchRemover : public testing::EmptyTestEventListener {
 public:
  void OnTestEnd(const testing::TestInfo& test) override {
    std::error_code ignored;  // a folder that stays is no failure
    if (!folder.empty() && !test.result()->Failed()) std::filesystem::remove_all(folder, ignored);
    folder.clear();
  }

  std::filesystem::path folder;
};

inline std::filesystem::path ScratchFolder() {
  static ScratchRemover* const remover = [] {
    auto* listener = new ScratchRemover;  // gtest deletes it
    testing::UnitTest::GetInstance()->listeners().Append(listener);
    return listener;
  }();
  const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
  std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                 (std::string("lamella-") + test.test_suite_name() + "-" +
                                  test.name() + "-" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  remover->folder = folder;
  return folder;
}

}  // namespace lamella
