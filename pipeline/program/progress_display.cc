#include "pipeline/program/progress_display.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/ioctl.h>
#include <unistd.h>

namespace lamella {
namespace {

using Clock = std::chrono::steady_clock;

std::string Duration(double seconds) {
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  return fmt::format("{}:{:02} min", whole / 60, whole % 60);
}

// The state that all styles share, behind one lock: Advance comes from any thread.
class ShownProgress : public Progress {
 public:
  explicit ShownProgress(Verbosity verbosity) : verbosity_(verbosity) {}

  void Start(std::string_view task, std::int64_t total, std::string_view unit) override {
    const std::lock_guard lock(mutex_);
    Finish();
    task_ = task;
    unit_ = unit;
    total_ = total;
    done_ = 0;
    start_ = shown_ = Clock::now();
    if (verbosity_ != Verbosity::kQuiet) Show(true);
  }
  void Advance(std::int64_t units) override {
    const std::lock_guard lock(mutex_);
    if (task_.empty()) return;
    done_ += units;
    if (done_ >= total_) return Finish();  // before what the program prints of the result
    const std::chrono::duration<double> since = Clock::now() - shown_;
    if (verbosity_ == Verbosity::kQuiet || since.count() < Interval()) return;
    shown_ = Clock::now();
    Show(false);
  }
  void Note(std::string_view line) override {
    const std::lock_guard lock(mutex_);
    if (verbosity_ == Verbosity::kVerbose) Print("note", line);
  }
  void Warn(std::string_view line) override {
    const std::lock_guard lock(mutex_);
    if (verbosity_ != Verbosity::kQuiet) Print("warning", line);
  }

 protected:
  virtual double Interval() const = 0;  // seconds between two Shows
  virtual void Show(bool starts) = 0;   // the current task
  virtual void ShowEnd() = 0;           // the task that ends
  virtual void Print(std::string_view kind, std::string_view line) = 0;

  double Seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  double SecondsLeft() const {
    return done_ > 0 ? Seconds() * static_cast<double>(total_ - done_) / static_cast<double>(done_)
                     : 0;
  }
  void Finish() {
    if (!task_.empty() && verbosity_ != Verbosity::kQuiet) ShowEnd();
    task_.clear();
  }

  std::string task_, unit_;
  std::int64_t total_ = 0, done_ = 0;

 private:
  std::mutex mutex_;
  Verbosity verbosity_;
  Clock::time_point start_, shown_;
};

class Bar final : public ShownProgress {
 public:
  using ShownProgress::ShownProgress;
  ~Bar() override { Finish(); }

 protected:
  double Interval() const override { return 0.1; }
  void Show(bool) override {
    constexpr int kCells = 24;
    const double share =
        total_ > 0 ? std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_)) : 0;
    const int full = static_cast<int>(share * kCells);
    std::string line = fmt::format(
        "{:<28} [{}{}] {}/{} {}", task_, std::string(static_cast<std::size_t>(full), '#'),
        std::string(static_cast<std::size_t>(kCells - full), '.'), done_, total_, unit_);
    if (done_ > 0) {
      line +=
          fmt::format("  {:.3g}/s  {} left", static_cast<double>(done_) / std::max(1e-9, Seconds()),
                      Duration(SecondsLeft()));
    }
    Draw(line);
  }
  void ShowEnd() override {
    Draw(fmt::format("{:<28} {} {} in {}", task_, done_, unit_, Duration(Seconds())));
    std::fputc('\n', stderr);
  }
  void Print(std::string_view kind, std::string_view line) override {
    Draw("");
    const bool color = kind == "warning" && std::getenv("NO_COLOR") == nullptr;
    fmt::print(stderr, "\r{}{}: {}{}\n", color ? "\033[33m" : "", kind, line,
               color ? "\033[0m" : "");
  }

 private:
  void Draw(const std::string& line) {
    winsize size{};
    const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    const std::size_t width = known ? static_cast<std::size_t>(size.ws_col) - 1U : 100U;
    fmt::print(stderr, "\r{}\033[K", line.substr(0, width));
    std::fflush(stderr);
  }
};

class Plain final : public ShownProgress {
 public:
  using ShownProgress::ShownProgress;
  ~Plain() override { Finish(); }

 protected:
  double Interval() const override { return 5; }
  void Show(bool starts) override {
    if (starts) {
      fmt::print(stderr, "{}: {} {}\n", task_, total_, unit_);
    } else {
      fmt::print(stderr, "{}: {}/{} {}, {} left\n", task_, done_, total_, unit_,
                 Duration(SecondsLeft()));
    }
  }
  void ShowEnd() override { fmt::print(stderr, "{}: done in {:.1f} s\n", task_, Seconds()); }
  void Print(std::string_view kind, std::string_view line) override {
    fmt::print(stderr, "{}: {}\n", kind, line);
  }
};

class JsonLines final : public ShownProgress {
 public:
  using ShownProgress::ShownProgress;
  ~JsonLines() override { Finish(); }

 protected:
  double Interval() const override { return 0.5; }
  void Show(bool) override { Put(false); }
  void ShowEnd() override { Put(true); }
  void Print(std::string_view kind, std::string_view line) override {
    fmt::print(stderr, "{}\n", nlohmann::json{{std::string(kind), std::string(line)}}.dump());
  }

 private:
  void Put(bool finished) {
    const nlohmann::ordered_json json = {{"task", task_},        {"done", done_},
                                         {"total", total_},      {"unit", unit_},
                                         {"seconds", Seconds()}, {"finished", finished}};
    fmt::print(stderr, "{}\n", json.dump());
  }
};

}  // namespace

std::unique_ptr<Progress> MakeProgress(ProgressStyle style, Verbosity verbosity) {
  if (style == ProgressStyle::kAuto) {
    style = isatty(STDERR_FILENO) != 0 ? ProgressStyle::kBar : ProgressStyle::kPlain;
  }
  if (style == ProgressStyle::kBar) return std::make_unique<Bar>(verbosity);
  if (style == ProgressStyle::kJson) return std::make_unique<JsonLines>(verbosity);
  return std::make_unique<Plain>(verbosity);
}

}  // namespace lamella
