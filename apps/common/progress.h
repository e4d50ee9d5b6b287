#pragma once

#include <tenon/systems/simulation/simulator.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace tenon::apps {

/// On stderr, control characters escaped; what cannot be told there is lost, and nothing else with it.
void Say(const std::string& text) noexcept;
/// On a terminal, control characters and all: for lines that are written over.
void Draw(const std::string& text) noexcept;

/// How far something is, on stderr: a line that is written over with a bar if stderr is a terminal, else a
/// line every 5 s.
class ProgressLine {
 public:
  ProgressLine();
  /// Whether it is time to show something again.
  bool due() const;
  /// `share` of the whole, for the bar; none if that is not known.
  void Show(std::optional<double> share, const std::string& text);
  /// The same for the last time; nothing where no line came before, as of what is short.
  void End(std::optional<double> share, const std::string& text);
  double elapsed() const;  ///< since it was made [s]
  bool terminal() const { return terminal_; }

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool shown_any_ = false;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point shown_ = begin_;
};

/// Shows how far a run is: its name, simulated time, real-time factor, time left. It is a sink: add it to one
/// of the run's logs.
class ProgressSink final : public LogSink {
 public:
  /// `duration` [s]; `name` of one of several runs: "run 3 of 64".
  explicit ProgressSink(double duration, const std::string& name = {})
      : prefix_(name.empty() ? "" : name + ": "), duration_(duration) {}
  void Begin(const std::vector<std::string>&, const std::vector<std::string>&) override {}
  void Row(std::span<const double> row) override;
  void Flush() override;

 private:
  double share() const { return time_ / duration_; }
  std::string Text() const;

  std::string prefix_;
  double duration_;
  double time_ = 0;
  ProgressLine line_;
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

/// Advances a run by `advance`. A RunError, or that memory is out, is caught and told in the outcome, so that
/// the caller can still write what there is. A monitor that ends it has broken a limit; the reason
/// "interrupted" counts as SIGINT.
RunOutcome Observe(Simulator& simulator, const std::function<RunStatus()>& advance);
/// Lets SIGINT and SIGTERM end what the simulator advances, see SignalGuard, and memory that is all but out.
void StopOnSignal(Simulator& simulator);

/// Advances to `duration` [s], or until SIGINT or SIGTERM comes, see SignalGuard, or `wall_limit` [s] on the
/// clock are over, which ends the run as a monitor does. Errors as with Observe.
RunOutcome Advance(Simulator& simulator, double duration, std::optional<double> wall_limit = {});
/// Why a run ended that took longer than its limit.
std::string TookTooLong(double wall_limit);

}  // namespace tenon::apps
