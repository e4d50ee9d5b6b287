#include <tenon/apps/common/progress.h>

#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <new>
#include <utility>

#include <tenon/apps/common/command_line.h>
#include <tenon/systems/io/output_file.h>

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
  if (terminal_) Say("\n");
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
    Say(fmt::format("\r[{:<{}}] {:.1f}/{:.1f} s  {:.1f}x real time  {:.0f} s left ", std::string(filled, '#'),
                    kWidth, time_, duration_, rate, left));
  } else {
    Say(fmt::format("{:.1f} of {:.1f} s simulated, {:.1f} times real time, {:.0f} s left\n", time_, duration_,
                    rate, left));
  }
  std::fflush(stderr);
}

namespace {

volatile std::sig_atomic_t caught_signal = 0;

/// While it lives, the first SIGINT or SIGTERM is noted; the next one ends the process.
class SignalGuard {
 public:
  SignalGuard() {
    caught_signal = 0;
    struct sigaction note = {};
    note.sa_handler = [](int signal) {
      caught_signal = signal;
      // The other of the two as well: whoever insists is obeyed.
      std::signal(SIGINT, SIG_DFL);
      std::signal(SIGTERM, SIG_DFL);
    };
    for (std::size_t i = 0; i < before_.size(); ++i) sigaction(kSignals[i], &note, &before_[i]);
  }
  ~SignalGuard() {
    for (std::size_t i = 0; i < before_.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  }
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace

RunOutcome Advance(Simulator& simulator, double duration) {
  RunOutcome outcome;
  const auto fail = [&](std::string failure, ExitCode code) {
    outcome.failure = std::move(failure);
    outcome.status.time = simulator.context().time();
    outcome.exit_code = code;
  };
  const SignalGuard guard;
  simulator.AddMonitor([](Context&) { return caught_signal == 0 ? Verdict() : Verdict("interrupted"); });
  const auto begin = std::chrono::steady_clock::now();
  try {
    outcome.status = simulator.AdvanceTo(duration);
    if (outcome.status.ended) outcome.exit_code = kLimitBroken;
  } catch (const OutputError& error) {
    fail(error.what(), kOutputFailed);
  } catch (const RunError& error) {
    fail(error.what(), kNumericalFailure);
  } catch (const std::bad_alloc&) {
    fail(fmt::format("out of memory in the run at t = {} s", simulator.context().time()), kNumericalFailure);
  }
  // Also if it came with the last tick: who stops one run of several means all.
  if (caught_signal != 0 && outcome.exit_code != kOutputFailed) {
    outcome.exit_code = 128 + caught_signal;
    outcome.status = {outcome.status.time, true, "interrupted"};
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

}  // namespace tenon::apps
