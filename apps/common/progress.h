#pragma once

#include <chrono>
#include <optional>
#include <string>

#include <tenon/systems/simulation/simulator.h>

namespace tenon::apps {

/// Shows how far a run is on stderr: simulated time, real-time factor, time left. A bar if stderr is a
/// terminal, else a line every 5 s. It is a sink: add it to one of the run's logs.
class ProgressSink final : public LogSink {
 public:
  explicit ProgressSink(double duration);  ///< [s]
  void Begin(const std::vector<std::string>&, const std::vector<std::string>&) override {}
  void Row(std::span<const double> row) override;
  void Flush() override;

 private:
  using Clock = std::chrono::steady_clock;
  void Show();

  double duration_;
  bool terminal_;
  double time_ = 0;
  bool shown_any_ = false;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point shown_ = begin_;
};

/// How a run went, for summary.json.
struct RunOutcome {
  RunStatus status;
  std::string failure;  ///< what() of a RunError; empty if there was none
  int exit_code = 0;    ///< an ExitCode, or 128 and the number of the signal that stopped it
  double wall_s = 0;    ///< of the advance alone
};

/// While one lives, the first SIGINT or SIGTERM is noted, and ends what Advance runs, in all threads; the
/// next one ends the process. Of several at a time the first counts.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;
  /// The number of the signal that came; 0 for none.
  static int caught();
};

/// Advances to `duration` [s], or until SIGINT or SIGTERM comes, see SignalGuard, or `wall_limit` [s] on the
/// clock are over, which ends the run as a monitor does. A RunError, or that memory is out, is caught and
/// told in the outcome, so that the caller can still write what there is.
RunOutcome Advance(Simulator& simulator, double duration, std::optional<double> wall_limit = {});

}  // namespace tenon::apps
