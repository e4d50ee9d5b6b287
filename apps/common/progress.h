#pragma once

#include <chrono>
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

/// Advances to `duration` [s], or until SIGINT or SIGTERM comes, which ends the run as a monitor does; a
/// second one ends the process. A RunError, or that memory is out, is caught and told in the outcome, so that
/// the caller can still write what there is.
RunOutcome Advance(Simulator& simulator, double duration);

}  // namespace tenon::apps
