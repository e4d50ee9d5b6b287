#pragma once

#include <tenon/systems/live/live_server.h>

namespace tenon::apps {

/// Prints on stderr with control characters escaped. Errors are ignored.
void Say(const std::string& text) noexcept;
/// Prints on stderr without escaping, for lines that are overwritten.
void Draw(const std::string& text) noexcept;

/// Shows progress on stderr: a line with a bar that is overwritten if stderr is a terminal, else a line every
/// 5 s.
class ProgressLine {
 public:
  ProgressLine();
  /// Returns whether the line should be updated.
  bool due() const;
  /// Shows a text, and a bar if the completed `share` is known.
  void Show(std::optional<double> share, const std::string& text);
  /// Shows the final line. Without a terminal, prints it only after other lines.
  void End(std::optional<double> share, const std::string& text);
  /// Time since construction [s].
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  bool terminal() const { return terminal_; }

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool shown_any_ = false;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point shown_ = begin_;
};

/// A log sink that shows the progress of a run: its name, simulated time, real-time factor and time left.
class ProgressSink final : public LogSink {
 public:
  /// `duration` of the run [s]; `name` of one of several runs, such as "run 3 of 64".
  explicit ProgressSink(double duration, const std::string& name = {})
      : prefix_(name.empty() ? "" : name + ": "), duration_(duration) {}
  void Row(std::span<const double> row) override;
  void Flush() override;

 private:
  double share() const { return time_ / duration_; }
  std::string Text() const;

  std::string prefix_;
  double duration_;
  double time_ = 0, ended_ = -1;
  ProgressLine line_;
};

/// The outcome of a run, for summary.json.
struct RunOutcome {
  RunStatus status;
  std::string failure;  ///< message of a RunError; empty without error
  int exit_code = 0;    ///< an ExitCode, or 128 plus the number of the signal that stopped the run
  double wall_s = 0;    ///< wall-clock time of the simulation alone
};

/// During its lifetime, the first SIGINT, SIGTERM or SIGHUP ends the runs of Advance in all threads, and the
/// second one ends the process. If a calculation of a run does not return within a second after the first
/// one, the process ends with the signal's exit code; the rows logged so far are in their files. An ignored
/// SIGHUP stays ignored. Guards may be nested.
class SignalGuard {
 public:
  SignalGuard();
  ~SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;
  /// Returns the number of the received signal, 0 for none.
  static int caught();
};

/// Advances a run by `advance`. A RunError or a lack of memory is caught and returned in the outcome, so that
/// the caller can still write its files. If a monitor ends the run, the exit code is kLimitBroken, or that of
/// SIGINT for the reason "interrupted".
RunOutcome Observe(Simulator& simulator, const std::function<RunStatus()>& advance);
/// Adds a monitor that ends the run at SIGINT, SIGTERM (see SignalGuard) or when memory runs out.
void StopOnSignal(Simulator& simulator);

/// Advances to `duration` [s], or until SIGINT, SIGTERM (see SignalGuard) or `wall_limit` [s] of wall-clock
/// time ends the run. Handles errors as Observe does.
RunOutcome Advance(Simulator& simulator, double duration, std::optional<double> wall_limit = {});
/// The begin of the end reason of a run for which the memory did not suffice.
inline constexpr const char* kOutOfMemory = "out of memory";

/// Returns the end reason of a run that exceeded its limit of wall-clock time [s].
std::string TookTooLong(double wall_limit);

/// Options of an app's run with --live or --replay.
struct LiveSessionOptions {
  int port = 8080;                                   ///< TCP port of the server
  std::string address = "127.0.0.1";                 ///< address at which the server listens
  std::optional<std::filesystem::path> replay = {};  ///< recording to repeat; then no server is started
  std::optional<double> duration = {};  ///< [s]; default: a live run continues until it is stopped
};

/// The server of a live run, or the recording of one. It outlives the run: a reset starts
/// another run with another seed at the same address.
class LiveSession {
 public:
  /// Prints the address on stderr. Throws as LiveServer and LiveRecording::Read do.
  explicit LiveSession(const LiveSessionOptions& options);
  ~LiveSession();

  /// Runs the simulation as apps::Advance does. A live run writes live.jsonl into `out`. A recording without
  /// an end is repeated for `duration` [s].
  RunOutcome Advance(Simulator& simulator, const LiveView& view, double duration,
                     const std::filesystem::path& out);
  /// The seed of the next run, if this one ended by a reset.
  std::optional<std::uint64_t> reset_seed() const { return server_ ? server_->reset_seed() : std::nullopt; }
  /// The seed of the recording, if there is one.
  std::optional<std::uint64_t> replay_seed() const {
    return recording_ ? std::optional(recording_->seed) : std::nullopt;
  }

 private:
  LiveSessionOptions options_;
  std::optional<LiveRecording> recording_;
  std::unique_ptr<LiveServer> server_;
};

}  // namespace tenon::apps
