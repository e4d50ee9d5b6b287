#pragma once

#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/context/context.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tenon {

/// Takes the rows of a log as the run goes. Time is the first column.
///
/// A log holds one run. When the run goes on after Context::Restore has set it back, each sink first drops
/// the rows after the restored time, and the row at that time if its tick has yet to happen. Earlier rows
/// stay, so time never goes back in MemoryLog, CsvLog and reports. A restored time that lies ahead leaves a
/// gap. For sinks that cannot drop rows, use Simulator::HoldLogs.
class LogSink {
 public:
  virtual ~LogSink() = default;
  /// Called once, before the first row. Names are "block.port.element", units may be empty.
  virtual void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) = 0;
  virtual void Row(std::span<const double> row) = 0;
  /// Called when the run pauses or ends, also after an error: make everything readable.
  virtual void Flush() {}
  /// Forgets the rows at `time` [s] and after it or, if `after`, only those after it. A sink that does not
  /// override it keeps them, and sees the time go back.
  virtual void DropFrom(double time, bool after) { (void)time, (void)after; }
};

/// Keeps a log in memory.
class MemoryLog final : public LogSink {
 public:
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  void DropFrom(double time, bool after) override;

  /// Makes room, so that the next `rows` rows do not allocate.
  void Reserve(std::size_t rows);
  std::size_t rows() const { return names_.empty() ? 0 : data_.size() / names_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  std::span<const double> row(std::size_t i) const { return {&data_[i * names_.size()], names_.size()}; }
  /// All values of one column; throws Error with the nearest name if there is none of that name.
  std::vector<double> column(const std::string& name) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::string> units_;
  std::vector<double> data_;
  std::size_t reserved_ = 0;  ///< rows asked for before their length was known
};

/// Writes a log as CSV with a header of "name [unit]". Whole rows reach the file, at least once a second on
/// the clock: a killed run leaves what it had, and its last row is torn only where the kill comes within a
/// write. Opens in PlotJuggler as it is. If the run is set back, the file is cut.
class CsvLog final : public LogSink {
 public:
  /// Throws OutputError if the file cannot be opened.
  explicit CsvLog(std::filesystem::path file) : file_(std::move(file)) {}
  ~CsvLog() override;
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  /// Throws OutputError if the disk is full or gone. The file ends with a whole row then; those since the
  /// last flush are lost.
  void Row(std::span<const double> row) override;
  void Flush() override;
  /// Throws OutputError if the file cannot be cut, a pipe say.
  void DropFrom(double time, bool after) override;

 private:
  std::size_t FindRow(double time, bool after) const;

  using Clock = std::chrono::steady_clock;
  GrowingFile file_;
  std::vector<char> buffer_;  ///< rows that are not in the file yet
  std::size_t used_ = 0;      ///< of it [bytes]
  std::size_t longest_row_ = 0;
  std::size_t first_row_ = 0;  ///< where it begins in the file [bytes]
  Clock::time_point flushed_ = Clock::now();
};

/// Logs the values of any ports and states at a rate into sinks; the blocks know nothing of it. A row holds
/// what the signals are at the tick after all due sampled outputs have run and before updates take effect.
class SignalLog {
 public:
  /// Throws ParameterError for a signal without numbers, and for two columns of the same name: a signal that
  /// is given twice, or a state and the output that shows it under its name.
  SignalLog(Context& context, std::vector<const Source*> signals,
            std::vector<std::shared_ptr<LogSink>> sinks);
  ~SignalLog();
  /// Computes what is stale and hands a row to the sinks. Throws RunError if a signal has another size than
  /// in the first row; at that, ParameterError if a size known at run time brings a name that is there.
  void Sample();
  void Flush();

  /// From now on rows reach the sinks this much later [s] of the run's time, and Flush waits for Release.
  /// Throws ParameterError unless it is positive.
  void Hold(double seconds);
  /// Forgets the rows at `time` [s] and after it or, if `after`, only those after it: see LogSink.
  void DropFrom(double time, bool after);
  /// Hands over all rows that are held, and holds none any more.
  void Release();

 private:
  struct Columns {
    std::vector<std::string> names, units;
    std::vector<std::size_t> sizes;  ///< of each signal
  };
  /// With the values as they are at present.
  Columns ListColumns() const;
  void Begin();
  void HandOver(double until);
  void HandOver(std::span<const double> row);
  Context& context_;
  std::vector<const Source*> signals_;
  std::vector<std::shared_ptr<LogSink>> sinks_;
  std::vector<internal::Op> ops_;
  std::vector<double> row_;
  std::vector<std::size_t> sizes_;                            ///< of each signal
  double hold_ = 0;                                           ///< [s]
  std::deque<double> held_;                                   ///< rows
  double handed_ = -std::numeric_limits<double>::infinity();  ///< time of the sinks' last row [s]
};

}  // namespace tenon
