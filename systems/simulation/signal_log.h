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

/// Receives the rows of a log during the run. Time is the first column.
///
/// A log contains one run. When the run continues after Context::Restore has set it back, each sink first
/// drops the rows after the restored time, and the row at that time if its tick is still to come. Earlier
/// rows stay, so time never decreases in MemoryLog, CsvLog and reports. Restoring a later time leaves a gap.
/// For sinks that cannot drop rows, use Simulator::HoldLogs.
class LogSink {
 public:
  virtual ~LogSink() = default;
  /// Called once, before the first row. Names are "block.port.element"; units may be empty.
  virtual void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) = 0;
  virtual void Row(std::span<const double> row) = 0;
  /// Called when the run pauses or ends, also after an error: makes all rows readable.
  virtual void Flush() {}
  /// Drops the rows at and after `time` [s] or, if `after`, only those after it. The default keeps them, so
  /// that the sink sees time decrease.
  virtual void DropFrom(double time, bool after) { (void)time, (void)after; }
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
  /// Returns all values of a column. Throws Error with the nearest name if there is no such column.
  std::vector<double> column(const std::string& name) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::string> units_;
  std::vector<double> data_;
  std::size_t reserved_ = 0;  ///< rows reserved before the row length was known
};

/// Writes a log as CSV with a header of "name [unit]". Whole rows are written at least once a second of
/// wall-clock time, so a killed run leaves its rows; the last one is incomplete only if the process is killed
/// during a write. PlotJuggler opens the file directly. If the run is set back, the file is truncated.
class CsvLog final : public LogSink {
 public:
  /// Throws OutputError if the file cannot be opened.
  explicit CsvLog(std::filesystem::path file) : file_(std::move(file)) {}
  ~CsvLog() override;
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  /// Throws OutputError if the disk is full or missing. The file then ends with a whole row; rows since the
  /// last flush are lost.
  void Row(std::span<const double> row) override;
  void Flush() override;
  /// Throws OutputError if the file cannot be truncated (a pipe, say).
  void DropFrom(double time, bool after) override;

 private:
  std::size_t FindRow(double time, bool after) const;

  using Clock = std::chrono::steady_clock;
  GrowingFile file_;
  std::vector<char> buffer_;  ///< rows that are not yet in the file
  std::size_t used_ = 0;      ///< used part of the buffer [bytes]
  std::size_t longest_row_ = 0;
  std::size_t first_row_ = 0;  ///< offset of the first row in the file [bytes]
  Clock::time_point flushed_ = Clock::now();
};

/// Logs the values of any ports and states at a rate; no block needs to be changed. A row holds the
/// values at the tick after all due sampled outputs have run and before updates take effect.
class SignalLog {
 public:
  /// Throws ParameterError for a signal without numbers, and for two columns with the same name: a signal
  /// that is given twice, or a state and the output with its name.
  SignalLog(Context& context, std::vector<const Source*> signals,
            std::vector<std::shared_ptr<LogSink>> sinks);
  ~SignalLog();
  /// Evaluates the signals and passes a row to the sinks. Throws RunError if the size of a signal differs
  /// from the first row; in the first row, ParameterError if a size known only at run time gives two columns
  /// the same name.
  void Sample();
  void Flush();

  /// Delays the rows by `seconds` of simulated time on their way to the sinks; Flush then keeps held rows
  /// until Release. Throws ParameterError if `seconds` is not positive.
  void Hold(double seconds);
  /// Drops the rows at and after `time` [s] or, if `after`, only those after it; see LogSink.
  void DropFrom(double time, bool after);
  /// Passes on all held rows and ends holding.
  void Release();

 private:
  struct Columns {
    std::vector<std::string> names, units;
    std::vector<std::size_t> sizes;  ///< of each signal
  };
  /// Lists the columns for the present values.
  Columns ListColumns() const;
  void Begin();
  void HandOver(double until);
  void HandOver(std::span<const double> row);
  Context& context_;
  std::vector<const Source*> signals_;
  std::vector<std::shared_ptr<LogSink>> sinks_;
  std::vector<internal::Op> ops_;
  std::vector<double> row_;
  std::vector<std::size_t> sizes_;                            ///< of each signal in the first row
  double hold_ = 0;                                           ///< [s]
  std::deque<double> held_;                                   ///< rows
  double handed_ = -std::numeric_limits<double>::infinity();  ///< time of the sinks' last row [s]
};

}  // namespace tenon
