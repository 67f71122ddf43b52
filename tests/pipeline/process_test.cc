#include "pipeline/poses/process.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {
namespace fs = std::filesystem;

Command Shell(const std::string& script) { return {"/bin/sh", {"-c", script}, {}}; }

// True where the process is there and no zombie.
bool IsAlive(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string id, name, state;
  return (stat >> id >> name >> state) && state != "Z";
}

bool DiesSoon(pid_t pid) {
  for (int i = 0; i < 200 && IsAlive(pid); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return !IsAlive(pid);
}

TEST(RunProcess, GivesTheLinesOfBothOutputsAndTheExitCode) {
  std::vector<std::string> lines;
  const ProcessResult result =
      RunProcess(Shell("echo one; echo two >&2; printf 'three\\rfour'; exit 7"),
                 [&](std::string_view line) { lines.emplace_back(line); });
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two", "three", "four"}));
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_FALSE(result.Succeeded());
}

TEST(RunProcess, TellsTheSignalThatEndedTheProgram) {
  const ProcessResult result = RunProcess(Shell("kill -ABRT $$"), [](std::string_view) {});
  EXPECT_EQ(result.signal, SIGABRT);
}

TEST(RunProcess, SetsVariablesOnTopOfTheEnvironment) {
  setenv("LAMELLA_TEST_KEPT", "kept", 1);
  setenv("LAMELLA_TEST_CHANGED", "old", 1);
  Command command = Shell("echo $LAMELLA_TEST_KEPT $LAMELLA_TEST_CHANGED");
  command.environment = {{"LAMELLA_TEST_CHANGED", "new"}};
  std::string seen;
  RunProcess(command, [&](std::string_view line) { seen = line; });
  EXPECT_EQ(seen, "kept new");
}

TEST(RunProcess, CanNotStartWhatIsNoProgram) {
  try {
    RunProcess({"/no/such/program", {}, {}}, [](std::string_view) {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kMachine);
  }
}

TEST(RunProcess, ResetsTheSignalMask) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::string mask;
  RunProcess(Shell("grep SigBlk /proc/self/status"), [&](std::string_view line) { mask = line; });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_NE(mask.find("0000000000000000"), std::string::npos) << mask;
}

TEST(RunProcess, KillsTheProgramWhereTheCallbackThrows) {
  pid_t pid = 0;
  EXPECT_THROW(RunProcess(Shell("echo $$; exec sleep 60"),
                          [&](std::string_view line) {
                            pid = std::stoi(std::string(line));
                            throw std::runtime_error("stop");
                          }),
               std::runtime_error);
  EXPECT_GT(pid, 0);
  EXPECT_TRUE(DiesSoon(pid));
}

TEST(RunProcess, LeavesNoProgramBehindWhenItsOwnProcessIsKilled) {
  const fs::path file = ScratchFolder() / "pid";
  const pid_t runner = fork();
  if (runner == 0) {
    RunProcess(Shell("echo $$ > '" + file.string() + ".new'; mv '" + file.string() + ".new' '" +
                     file.string() + "'; exec sleep 60"),
               [](std::string_view) {});
    _exit(0);
  }
  for (int i = 0; i < 500 && !fs::exists(file); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  pid_t program = 0;
  std::ifstream(file) >> program;
  ASSERT_GT(program, 0);
  EXPECT_TRUE(IsAlive(program));
  kill(runner, SIGKILL);
  waitpid(runner, nullptr, 0);
  EXPECT_TRUE(DiesSoon(program));
}

TEST(FindProgram, LooksInThePath) {
  EXPECT_TRUE(FindProgram("sh"));
  EXPECT_FALSE(FindProgram("no-such-program-of-lamella"));
}

}  // namespace
}  // namespace lamella
