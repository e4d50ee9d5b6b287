#pragma once

#include <tenon/systems/live/internal/live_channel.h>
#include <tenon/systems/live/live_server.h>
#include <tenon/systems/report/internal/report_json.h>

#include <fstream>
#include <set>

namespace tenon::internal {

using Json = nlohmann::ordered_json;

/// Returns the data of the page for report.js: a report without samples, and the token of the run.
std::string PageData(const LiveView& view, const std::string& token);

/// Returns the description of the run, which a page needs before the samples.
Json Hello(const LiveView& view, const Geometry& shapes, Context& context,
           const std::vector<const ParameterSource*>& parameters, double history);

/// Returns the Parameters that consist of a fixed number of numbers.
std::vector<const ParameterSource*> Tunable(const Diagram& diagram);

/// Returns the value of a Parameter as a number or a list of numbers.
Json ParameterValue(const ParameterSource& parameter, Context& context);

/// Returns median and 99 % quantile of times in us, and how many are below each of several limits.
Json TimesJson(const TimeQuantiles& times);

/// Collects the rows of a log between two messages.
class LiveRows final : public LogSink {
 public:
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  /// While this is set, rows are skipped because they were already sent.
  bool muted = false;
  void Clear() { data_.clear(); }
  bool empty() const { return data_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }

  /// Removes the rows and returns them as "time":[…],"KEY":[[…],…] with a list for each column. With
  /// `constants`, a constant column is a single number.
  std::string Take(const char* key, bool constants);

 private:
  std::vector<std::string> names_, units_;
  std::vector<double> data_;
};

/// Sets the values of an entry in order. Throws as Context::SetDoubles does, and Error for an unknown path.
void ApplyEntry(Context& context, const LiveEntry& entry);

/// Reads a seed. Throws ParameterError unless it is an integer from 0 to 2^64 - 1.
inline std::uint64_t ReadSeed(const nlohmann::ordered_json& json) {
  if (!json.is_number_unsigned())
    throw ParameterError("a seed must be an integer from 0 to 18446744073709551615");
  return json.get<std::uint64_t>();
}

/// Writes a recording during the run; the file is complete after every entry.
class LiveFile {
 public:
  /// Writes nothing if the name is empty. Throws OutputError.
  LiveFile(std::filesystem::path file, std::uint64_t seed);
  void Add(LiveEntry entry);
  /// Removes the entries at `time` [s] and later.
  void DropFrom(double time);
  void End(double time, bool tick);
  const std::vector<LiveEntry>& entries() const { return recording_.entries; }

 private:
  void Rewrite();
  void Line(const std::string& text);
  std::filesystem::path file_;
  std::ofstream out_;
  LiveRecording recording_;
};

/// One run of a LiveServer in one thread. Commands of browsers are executed between two frames, say every
/// hundredth of a second of the run.
class LiveRun {
 public:
  LiveRun(Simulator& simulator, const LiveView& view, const LiveOptions& options, LiveChannel& channel);
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;
  RunStatus Run(std::optional<double> duration);
  /// Executes a command and returns the answer, which also reports errors of the command.
  LiveReply Execute(const std::string& client, const std::string& json);
  LiveStatus status() const;
  std::optional<std::uint64_t> reset_seed() const { return reset_seed_; }

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { kRunning, kPaused, kEnded };
  /// A state to which the run can be set back.
  struct Snapshot {
    double time;
    std::vector<std::byte> bytes;
    std::size_t entries;  // number of recorded entries
  };

  Context& context() { return simulator_.context(); }
  double time() const { return simulator_.context().time(); }
  void Begin();
  void ServeRequests();
  void Advance(double until, bool to_tick = false);
  double NextFrame() const;
  Clock::time_point Due() const;
  void RestartClock();
  void TakeSnapshot();
  void Publish(bool now);
  void PublishStatus();
  void MeasureRate();
  RunStatus Serve(std::optional<double> duration);
  RunStatus Finish(RunStatus status, bool tick);

  Json Do(const std::string& client, const Json& command);
  void Steer(const Json& command, const std::string& name);
  void DemandDriver(const std::string& client);
  void Apply(LiveSets sets);
  void SetParameter(const Json& command);
  void Tick();
  void Back(double to);
  void Reset(std::uint64_t seed);
  std::string SaveScenario();
  void SayChangedParameters();
  void SayEvent(const std::string& label);
  bool HasDriver() const;
  void LetGoIfAbandoned();
  void LetGo();
  bool IsHeld(const LiveSets& release) const;

  Simulator& simulator_;
  const LiveView& view_;
  const LiveOptions& options_;
  LiveChannel& channel_;
  LiveFile file_;
  std::vector<const ParameterSource*> parameters_;
  std::vector<Json> shown_;  // values shown in the pages
  std::set<std::string> tuned_;
  std::shared_ptr<LiveRows> signals_ = std::make_shared<LiveRows>(), frames_ = std::make_shared<LiveRows>();
  std::deque<Snapshot> snapshots_;
  std::vector<std::byte> start_;  // snapshot of the begin of the run

  State state_ = State::kRunning;
  RunStatus ended_;
  std::exception_ptr failure_;
  double wanted_rate_;  // 0: as fast as possible
  Clock::time_point clock_start_;
  double clock_start_time_ = 0;
  std::deque<std::pair<Clock::time_point, double>> pace_;  // wall-clock times and times of the run
  double rate_ = 0;
  TimeQuantiles late_, compute_;  // begin of a frame after its due time, and its computation
  Clock::time_point published_, status_published_;
  std::string driver_;
  Clock::time_point driver_seen_;
  bool driver_listens_ = false, drives_ = false, pulls_ = false, stop_ = false;
  Json pull_;  // pull shown in the pages
  std::optional<std::uint64_t> reset_seed_;
  std::string message_;
};

}  // namespace tenon::internal
