#pragma once

#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/context/context.h>

#include <chrono>
#include <deque>

namespace tenon {

/// Receives the rows of a log during the run. Time is the first column.
///
/// A sink belongs to one log, and a log holds one run. When the run continues after Context::Restore has set
/// it back, each sink first drops the rows after the restored time, and the row at that time if its tick has
/// not happened yet. Earlier rows stay, so time never decreases in MemoryLog, CsvLog and reports. A restored
/// time that lies ahead leaves a gap. For sinks that cannot drop rows, use Simulator::HoldLogs.
class LogSink {
 public:
  virtual ~LogSink() = default;
  /// Called once, before the first row. Names are "block.port.element"; units may be empty.
  virtual void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
    (void)names, (void)units;
  }
  virtual void Row(std::span<const double> row) = 0;
  /// Called when the run pauses or ends, also after an error; makes all rows readable.
  virtual void Flush() {}
  /// Drops the rows at `time` [s] and later or, if `after` is set, only later ones. A sink that does not
  /// override this keeps them and sees the time decrease.
  virtual void DropFrom(double time, bool after) { (void)time, (void)after; }

 private:
  friend class SignalLog;
  friend class BackgroundLog;
  /// Throws ParameterError for a null sink, and for one that another log has, because their rows would mix.
  static void Claim(const std::vector<std::shared_ptr<LogSink>>& sinks, const char* log);
  bool claimed_ = false;
};

/// Keeps a log in memory.
class MemoryLog final : public LogSink {
 public:
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  void DropFrom(double time, bool after) override;

  /// Reserves memory, so that the next `rows` rows do not allocate.
  void Reserve(std::size_t rows);
  std::size_t rows() const { return names_.empty() ? 0 : data_.size() / names_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  std::span<const double> row(std::size_t i) const { return {&data_[i * names_.size()], names_.size()}; }
  /// Returns all values of one column. Throws Error with the nearest name if no column has that name.
  std::vector<double> column(const std::string& name) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::string> units_;
  std::vector<double> data_;
  std::size_t reserved_ = 0;  ///< rows reserved before their length was known
};

/// Writes a log as CSV with a header of "name [unit]". Whole rows reach the file, at least once a second of
/// wall-clock time: a killed run leaves its rows up to then, and its last row is incomplete only if the kill
/// interrupts a write. PlotJuggler opens the file. If the run is set back, the file is truncated.
class CsvLog final : public LogSink {
 public:
  /// Throws OutputError if the file cannot be opened, also because another CsvLog is open on it.
  explicit CsvLog(std::filesystem::path file) : file_(std::move(file)) {}
  ~CsvLog() override;
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  /// Throws OutputError if the disk is full or gone. Then the file ends with a whole row, and the rows since
  /// the last flush are lost.
  void Row(std::span<const double> row) override;
  void Flush() override;
  /// Throws OutputError if the file cannot be truncated, because it is a pipe, say.
  void DropFrom(double time, bool after) override;

 private:
  std::size_t FindRow(double time, bool after) const;

  using Clock = std::chrono::steady_clock;
  GrowingFile file_;
  std::vector<char> buffer_;  ///< rows that are not in the file yet
  std::size_t used_ = 0;      ///< part of the buffer that holds rows [bytes]
  std::size_t longest_row_ = 0;
  std::size_t first_row_ = 0;  ///< offset of the first row in the file [bytes]
  Clock::time_point flushed_ = Clock::now();
};

/// Logs the values of any ports and states at a rate into sinks, without support from the blocks. A row holds
/// the values of the signals at the tick after all due sampled outputs have run and before updates take
/// effect.
class SignalLog {
 public:
  /// Throws ParameterError for a signal without numbers and for two columns of the same name: a signal that
  /// is given twice, or a state and the output that shows it under its name. Also throws it for a sink that
  /// is null or belongs to another log.
  SignalLog(Context& context, std::vector<const Source*> signals,
            std::vector<std::shared_ptr<LogSink>> sinks);
  ~SignalLog();
  /// Updates stale signals and passes a row to the sinks. Throws RunError if a signal has another size than
  /// in the first row, and ParameterError if in the first row a size known at run time gives two columns the
  /// same name.
  void Sample();
  void Flush();

  /// Delays rows by `seconds` of the run's time before they reach the sinks, and Flush until Release. Throws
  /// ParameterError unless it is positive and finite.
  void Hold(double seconds);
  /// Drops the rows at `time` [s] and later or, if `after` is set, only later ones: see LogSink.
  void DropFrom(double time, bool after);
  /// Passes all held rows to the sinks and ends the delay of Hold.
  void Release();

 private:
  struct Columns {
    std::vector<std::string> names, units;
  };
  /// Numbers of one kind that lie one after the other.
  struct Run {
    const void* data;
    std::size_t count;
    internal::ScalarKind kind;
  };
  /// The memory of a matrix, list or optional whose size can change.
  struct ResizableBlock {
    const internal::TypeInfo* type;
    void* value;
    void* data = nullptr;  ///< null if it is empty
    internal::Extents size = {};
    const Source* signal = nullptr;  ///< which it is part of
    bool operator==(const ResizableBlock&) const = default;
  };
  static ResizableBlock BlockOf(const internal::TypeInfo& type, void* value, const Source* signal);
  /// Lists the columns for the present values.
  Columns ListColumns() const;
  void Begin();
  /// Lists where the numbers of all signals lie at present.
  void ListNumbers();
  void ListNumbers(const internal::TypeInfo& type, std::byte* value, const Source* signal);
  /// Throws RunError if a signal has another size than in the first row.
  void CheckSizes() const;
  void HandOver(double until);
  void HandOver(std::span<const double> row);
  Context& context_;
  std::vector<const Source*> signals_;
  std::vector<std::shared_ptr<LogSink>> sinks_;
  std::vector<internal::Op> ops_;
  std::vector<double> row_;
  std::vector<Run> runs_;               ///< the numbers of a row behind the time, in the order of the columns
  std::vector<ResizableBlock> blocks_;  ///< while these stay the same, `runs_` is valid
  std::vector<ResizableBlock> first_;   ///< in the first row
  double hold_ = 0;                     ///< [s]
  std::deque<double> held_;             ///< rows
  double handed_ = -std::numeric_limits<double>::infinity();  ///< time of the sinks' last row [s]
};

}  // namespace tenon
