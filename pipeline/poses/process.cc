#include "pipeline/poses/process.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "lightfield/error.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

Error CannotStart(const fs::path& program, int reason) {
  return MachineError(program.string(), fmt::format("can't be started ({})", std::strerror(reason)),
                      "check the program and the machine's limits");
}

class FileDescriptor {
 public:
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { Close(); }
  void Close() {
    if (number_ >= 0) close(number_);
    number_ = -1;
  }
  int get() const { return number_; }

 private:
  int number_;
};

// argv or envp: pointers into strings that outlive it.
std::vector<char*> Pointers(std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (std::string& text : strings) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> Environment(const Command& command) {
  std::vector<std::string> environment;
  const auto overridden = [&](std::string_view entry) {
    for (const auto& [name, value] : command.environment) {
      if (entry.substr(0, name.size() + 1) == name + "=") return true;
    }
    return false;
  };
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!overridden(*entry)) environment.emplace_back(*entry);
  }
  for (const auto& [name, value] : command.environment) {
    environment.push_back(fmt::format("{}={}", name, value));
  }
  return environment;
}

// The child between fork and exec: only calls that are safe after a fork of a threaded process.
// What fails is told to the parent through `report`, which closes by itself on success.
[[noreturn]] void BecomeProgram(const char* program, char* const* arguments,
                                char* const* environment, pid_t parent, int output, int report) {
  const auto fail = [&] {
    const int reason = errno;
    [[maybe_unused]] const auto written = write(report, &reason, sizeof reason);
    _exit(127);
  };
  if (setpgid(0, 0) != 0 || prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) fail();
  if (getppid() != parent) _exit(127);  // it died before prctl
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int input = open("/dev/null", O_RDONLY);
  if (input < 0 || dup2(input, 0) < 0 || dup2(output, 1) < 0 || dup2(output, 2) < 0) fail();
  execve(program, arguments, environment);
  fail();
  _exit(127);
}

// Kills the program's group where it was not waited for, i.e. where an exception passes by.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ <= 0) return;
    kill(-pid_, SIGKILL);
    kill(pid_, SIGKILL);  // where it had not made its group yet
    Wait();
  }
  ProcessResult Wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    if (WIFSIGNALED(status)) return {-1, WTERMSIG(status)};
    return {WEXITSTATUS(status), 0};
  }

 private:
  pid_t pid_;
};

void ForwardLines(int output, const std::function<void(std::string_view)>& on_line) {
  std::array<char, 4096> block;
  std::string line;
  for (;;) {
    const ssize_t count = read(output, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    for (ssize_t i = 0; i < count; ++i) {
      const char c = block[static_cast<std::size_t>(i)];
      if (c != '\n' && c != '\r') {
        line += c;
      } else if (!line.empty()) {
        on_line(line);
        line.clear();
      }
    }
  }
  if (!line.empty()) on_line(line);
}

}  // namespace

ProcessResult RunProcess(const Command& command,
                         const std::function<void(std::string_view)>& on_line) {
  std::vector<std::string> arguments = {command.program.string()};
  arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
  std::vector<std::string> environment = Environment(command);
  const std::vector<char*> argv = Pointers(arguments), envp = Pointers(environment);

  int output[2], report[2];
  if (pipe2(output, O_CLOEXEC) != 0) throw CannotStart(command.program, errno);
  FileDescriptor output_end(output[0]), output_begin(output[1]);
  if (pipe2(report, O_CLOEXEC) != 0) throw CannotStart(command.program, errno);
  FileDescriptor report_end(report[0]), report_begin(report[1]);

  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw CannotStart(command.program, errno);
  if (pid == 0) {
    BecomeProgram(argv[0], argv.data(), envp.data(), parent, output[1], report[1]);
  }
  Child child(pid);
  output_begin.Close();
  report_begin.Close();
  int reason = 0;
  if (read(report_end.get(), &reason, sizeof reason) == sizeof reason) {
    throw CannotStart(command.program, reason);
  }
  ForwardLines(output_end.get(), on_line);
  return child.Wait();
}

std::optional<fs::path> FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path program = fs::path(folder) / name;
    std::error_code error;
    if (fs::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0) return program;
  }
  return std::nullopt;
}

}  // namespace lamella
