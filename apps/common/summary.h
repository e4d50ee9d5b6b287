#pragma once

#include <tenon/apps/common/progress.h>

namespace tenon::apps {

/// An event that makes the point of a case. A run that lasts until it is due is not finished without it.
struct Condition {
  const char* key;                    ///< figure: the time at which it happened [s]
  const char* missed;                 ///< end reason of a run without it
  std::optional<double> due = {};     ///< [s]; empty: the event need not happen
  std::optional<double> met_at = {};  ///< [s]

  void Meet(double time) {
    if (!met_at) met_at = time;
  }
};

/// The figures of a run as in summary.json, in SI units, which the keys name. The constructor sets the
/// figures that all apps have.
class Summary {
 public:
  Summary(const std::string& case_name, std::uint64_t seed, const RunOutcome& outcome);
  /// Reads the file that Write left of a run with the given exit code. Throws RunError if it is no summary.
  static Summary Load(const std::filesystem::path& file, int exit_code);
  Summary(Summary&&) noexcept;
  ~Summary();
  /// Sets a figure, null if `value` is empty.
  void Set(const std::string& key, std::optional<double> value);
  void Set(const std::string& key, std::optional<double> value, const Limits& limits) {
    Set(key, value);
    Limit(key, limits);
  }
  void Set(const std::string& key, const std::string& value);
  /// Sets a figure with several named values, for example one for each leg.
  void Set(const std::string& key, const std::vector<std::pair<std::string, std::optional<double>>>& values);

  /// Sets `fell`: whether `fall`, or the Monitor that replaced it, ended the run. Without this call, `fell`
  /// is false.
  void SetFell(const Monitor& fall);
  /// Sets `followed`: whether the robot followed its path, null without a path.
  void SetFollowed(std::optional<bool> followed);
  /// Adds a remark on a part of the scenario that has no effect, under `notes` in summary.json and the
  /// report.
  void Note(const std::string& text) { notes_.push_back(text); }

  /// Sets the limits of a figure and all figures nested in it. They are shown beside the figure and written
  /// under `limits` in summary.json.
  /// Later limits of the same figure replace earlier ones.
  void Limit(const std::string& key, const Limits& limits) { limits_.emplace(limits_.begin(), key, limits); }
  /// Records an event that must not happen, such as a physically impossible one, at `time` [s]: the run is
  /// not finished and has the exit code kLimitBroken. The earliest such event becomes the end reason, unless
  /// something else ended the run.
  void Break(double time, const std::string& reason);
  /// Sets the figure of a condition. If it was due and is not met, the run is not finished, as after a Break.
  void Require(const Condition& condition);
  /// Demands a number within the limits of the figure with this dotted key. If a run that lasts until `due`
  /// [s] lacks it, it is not finished, as after a Break. Throws KeyError if there is no such figure.
  void Require(const std::string& key, const Limits& limits, double due);
  /// Overrides the end reason and the exit code.
  void EndedBy(const std::string& reason, int exit_code);

  void Write(const std::filesystem::path& file) const;  ///< throws OutputError
  void Print() const;                                   ///< on stdout, see FigureLines
  void AddTo(Report& report) const;                     ///< adds the figures and the verdict
  /// Figures by key as text that reads back as the same value, "" for null. Nested figures have dotted keys.
  std::vector<std::pair<std::string, std::string>> Flat() const;
  bool finished() const;
  int exit_code() const { return exit_code_; }
  void set_exit_code(int code) { exit_code_ = code; }

  using Named = std::vector<std::pair<std::string, Summary>>;
  /// Writes the figures of several runs by the names of the runs. Throws OutputError.
  static void WriteComparison(const Named& runs, const std::filesystem::path& file);
  static void PrintComparison(const Named& runs);  ///< on stdout, see FigureColumns

 private:
  struct Json;
  Summary(std::unique_ptr<Json> json, int exit_code);
  std::unique_ptr<Json> json_;
  const Source* ended_by_ = nullptr;  ///< the Monitor that ended the run
  std::vector<std::pair<std::string, Limits>> limits_;
  std::vector<std::string> notes_;
  std::vector<std::pair<double, std::string>> breaches_;  ///< times [s] and reasons, ascending
  bool judged_ = false;  ///< the run reached its end and failed only because of a breach
  int exit_code_;
};

}  // namespace tenon::apps
