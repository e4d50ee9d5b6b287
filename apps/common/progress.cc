#include <tenon/apps/common/progress.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>
#include <sys/time.h>
#include <unistd.h>

#include <cctype>
#include <csignal>
#include <cstdio>

namespace tenon::apps {

void Say(const std::string& text) noexcept {
  try {
    Draw(internal::Printable(text));
  } catch (const std::bad_alloc&) {
    for (const char c : text)
      std::fputc(std::iscntrl(static_cast<unsigned char>(c)) != 0 && c != '\n' ? '?' : c, stderr);
  }
}

void Draw(const std::string& text) noexcept {
  std::fputs(text.c_str(), stderr);
}

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

bool ProgressLine::due() const {
  const std::chrono::duration<double> since = Clock::now() - shown_;
  return since.count() >= (terminal_ ? 0.1 : 5.0);
}

void ProgressLine::Show(std::optional<double> share, const std::string& text) {
  shown_ = Clock::now();
  shown_any_ = true;
  if (terminal_) {
    constexpr int kWidth = 30;
    const auto filled = static_cast<std::size_t>(kWidth * std::clamp(share.value_or(0), 0.0, 1.0));
    const std::string bar = share ? fmt::format("[{:<{}}] ", std::string(filled, '#'), kWidth) : "";
    Draw(fmt::format("\r{}{}   ", bar, internal::Printable(text)));
  } else {
    Say(text + "\n");
  }
  std::fflush(stderr);
}

void ProgressLine::End(std::optional<double> share, const std::string& text) {
  if (!terminal_ && !shown_any_) return;
  Show(share, text);
  if (terminal_) Say("\n");
}

void ProgressSink::Row(std::span<const double> row) {
  time_ = row[0];
  if (line_.due()) line_.Show(share(), Text());
}

void ProgressSink::Flush() {
  if (std::exchange(ended_, time_) == time_) return;
  line_.End(share(), Text());
}

std::string ProgressSink::Text() const {
  const double wall = line_.elapsed();
  const double rate = wall > 0 ? time_ / wall : 0;
  const double left = rate > 0 ? (duration_ - time_) / rate : 0;
  return prefix_ +
         fmt::format(
             fmt::runtime(line_.terminal()
                              ? "{:.1f}/{:.1f} s  {:.1f}x real time  {:.0f} s left"
                              : "{:.1f} of {:.1f} s simulated, {:.1f} times real time, {:.0f} s left"),
             time_, duration_, rate, left);
}

namespace {

std::atomic<int> caught_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may only set lock-free atomics");

constexpr const char* kInterrupted = "interrupted";
constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
std::mutex guard_mutex;
int guards = 0;  ///< number of SignalGuards
std::array<struct sigaction, kSignals.size()> actions_before{};

constexpr unsigned kPatience = 800'000;  ///< time that a calculation has to end after a signal [us]
std::atomic<int> running = 0;            ///< number of runs that Observe advances

/// Ends the process with the exit code of a caught signal, because a calculation does not return.
void GiveUp(int) {
  constexpr char kText[] =
      "a calculation does not end: the run is stopped inside of it, without its results\n";
  static_cast<void>(::write(STDERR_FILENO, kText, sizeof(kText) - 1));
  ::_exit(128 + caught_signal);
}

/// Sends SIGALRM after `time` [us]; 0 cancels it.
void Alarm(unsigned time) {
  const struct itimerval timer = {{}, {0, time}};
  ::setitimer(ITIMER_REAL, &timer, nullptr);
}

/// A run that a signal ends, even inside a calculation.
class Run {
 public:
  Run() { ++running; }
  ~Run() {
    if (--running == 0 && caught_signal != 0) Alarm(0);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
};

}  // namespace

SignalGuard::SignalGuard() {
  const std::lock_guard lock(guard_mutex);
  if (guards++ > 0) return;
  caught_signal = 0;
  struct sigaction note = {};
  note.sa_handler = [](int signal) {
    caught_signal = signal;
    if (running > 0) {
      std::signal(SIGALRM, GiveUp);
      Alarm(kPatience);
    }
    // Any second signal ends the process.
    for (const int each : kSignals) std::signal(each, SIG_DFL);
  };
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &note, &actions_before[i]);
  const auto hangup = std::ranges::find(kSignals, SIGHUP) - kSignals.begin();
  struct sigaction& before = actions_before[static_cast<std::size_t>(hangup)];
  if (before.sa_handler == SIG_IGN) sigaction(SIGHUP, &before, nullptr);
}

SignalGuard::~SignalGuard() {
  const std::lock_guard lock(guard_mutex);
  if (--guards > 0) return;
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &actions_before[i], nullptr);
}

int SignalGuard::caught() {
  return caught_signal;
}

void StopOnSignal(Simulator& simulator) {
  simulator.AddMonitor(
      [](Context&) { return SignalGuard::caught() == 0 ? Verdict() : Verdict(kInterrupted); });
}

RunOutcome Observe(Simulator& simulator, const std::function<RunStatus()>& advance) {
  RunOutcome outcome;
  const auto fail = [&](std::string failure, ExitCode code) {
    outcome.failure = std::move(failure);
    outcome.status.time = simulator.context().time();
    outcome.exit_code = code;
  };
  const SignalGuard guard;
  const auto begin = std::chrono::steady_clock::now();
  try {
    {
      const Run run;
      outcome.status = advance();
    }
    if (outcome.status.ended) outcome.exit_code = kLimitBroken;
    if (outcome.status.reason == kInterrupted) outcome.exit_code = 128 + SIGINT;  // from a browser
  } catch (const OutputError& error) {
    fail(error.what(), kOutputFailed);
  } catch (const RunError& error) {
    fail(error.what(), kNumericalFailure);
  } catch (const std::bad_alloc&) {
    fail(fmt::format("{} in the run at t = {} s", kOutOfMemory, simulator.context().time()),
         kNumericalFailure);
  }
  // A signal in the last tick counts, too, because it is meant to stop all of several runs.
  if (const int caught = SignalGuard::caught(); caught != 0 && outcome.exit_code != kOutputFailed) {
    outcome.exit_code = 128 + caught;
    outcome.status = {outcome.status.time, true, kInterrupted};
  }
  outcome.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

std::string TookTooLong(double wall_limit) {
  return fmt::format("took longer than {} s of wall-clock time", wall_limit);
}

RunOutcome Advance(Simulator& simulator, double duration, std::optional<double> wall_limit) {
  StopOnSignal(simulator);
  const auto too_long = std::make_shared<bool>(false);  // shared, because the monitor outlives this function
  if (wall_limit) {
    const auto begin = std::chrono::steady_clock::now();
    simulator.AddMonitor([=, limit = *wall_limit](Context&) {
      const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
      *too_long = *too_long || wall.count() > limit;
      return *too_long ? Verdict(TookTooLong(limit)) : Verdict();
    });
  }
  RunOutcome outcome = Observe(simulator, [&] { return simulator.AdvanceTo(duration); });
  if (*too_long && outcome.exit_code == kLimitBroken) outcome.exit_code = kNumericalFailure;
  return outcome;
}

LiveSession::LiveSession(const LiveSessionOptions& options) : options_(options) {
  if (options.replay) {
    recording_ = LiveRecording::Read(*options.replay);
    return;
  }
  server_ = std::make_unique<LiveServer>(
      LiveOptions{.address = options.address, .port = options.port, .returns_for_reset = true});
  Say(fmt::format("live: {}\n", server_->url()));
}
LiveSession::~LiveSession() = default;

RunOutcome LiveSession::Advance(Simulator& simulator, const LiveView& view, double duration,
                                const std::filesystem::path& out) {
  if (recording_) {
    const std::optional<double> until = options_.duration ? options_.duration
                                        : recording_->end ? std::nullopt
                                                          : std::optional<double>(duration);
    StopOnSignal(simulator);
    try {
      return Observe(simulator, [&] { return Replay(simulator, *recording_, until); });
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("--replay {}: {}", options_.replay->string(), error.what()));
    }
  }
  server_->options().recording = out.empty() ? out : out / "live.jsonl";
  server_->options().stop = [] { return SignalGuard::caught() != 0; };
  RunOutcome outcome = Observe(simulator, [&] { return server_->Run(simulator, view, options_.duration); });
  server_->options().stop = nullptr;
  return outcome;
}

}  // namespace tenon::apps
