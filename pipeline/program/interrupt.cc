#include "pipeline/program/interrupt.h"

#include <csignal>
#include <string_view>
#include <thread>

#include <unistd.h>

#include "lightfield/error.h"

namespace lamella {

void EndAtOnceOnInterrupt() {
  static sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([] {
    int number = 0;
    sigwait(&signals, &number);
    constexpr std::string_view kLine = "\ninterrupted; the same command continues from here\n";
    [[maybe_unused]] const auto written = write(STDERR_FILENO, kLine.data(), kLine.size());
    _exit(static_cast<int>(ExitCode::kInterrupted));
  }).detach();
}

}  // namespace lamella
