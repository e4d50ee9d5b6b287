#include <tenon/apps/common/progress.h>

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>

namespace tenon::apps {

ProgressSink::ProgressSink(double duration) : duration_(duration), terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressSink::Row(std::span<const double> row) {
  time_ = row[0];
  const std::chrono::duration<double> since = Clock::now() - shown_;
  if (since.count() >= (terminal_ ? 0.1 : 5.0)) Show();
}

void ProgressSink::Flush() {
  if (!terminal_ && !shown_any_) return;  // a short run needs no lines in a file
  Show();
  if (terminal_) fmt::print(stderr, "\n");
}

void ProgressSink::Show() {
  shown_ = Clock::now();
  shown_any_ = true;
  const double wall = std::chrono::duration<double>(shown_ - begin_).count();
  const double rate = wall > 0 ? time_ / wall : 0;
  const double left = rate > 0 ? (duration_ - time_) / rate : 0;
  if (terminal_) {
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(kWidth * time_ / duration_);
    fmt::print(stderr, "\r[{:<{}}] {:.1f}/{:.1f} s  {:.1f}x real time  {:.0f} s left ",
               std::string(filled, '#'), kWidth, time_, duration_, rate, left);
  } else {
    fmt::print(stderr, "{:.1f} of {:.1f} s simulated, {:.1f} times real time, {:.0f} s left\n", time_,
               duration_, rate, left);
  }
  std::fflush(stderr);
}

RunOutcome Advance(Simulator& simulator, double duration) {
  RunOutcome outcome;
  const auto begin = std::chrono::steady_clock::now();
  try {
    outcome.status = simulator.AdvanceTo(duration);
  } catch (const RunError& error) {
    outcome.failure = error.what();
    outcome.status.time = simulator.context().time();
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

}  // namespace tenon::apps
