#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/simulation/signal_log.h>
#include <tenon/systems/text/nearest_name.h>

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace tenon {

void MemoryLog::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  names_ = names;
  units_ = units;
  if (reserved_ > 0) Reserve(reserved_);
}

void MemoryLog::Reserve(std::size_t rows) {
  reserved_ = rows;
  data_.reserve(data_.size() + rows * names_.size());
}

void MemoryLog::Row(std::span<const double> row) {
  data_.insert(data_.end(), row.begin(), row.end());
}

void MemoryLog::DropFrom(double time, bool after) {
  std::size_t kept = rows();
  while (kept > 0 && (row(kept - 1)[0] > time || (!after && row(kept - 1)[0] == time))) --kept;
  data_.resize(kept * names_.size());
}

std::vector<double> MemoryLog::column(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) {
    throw Error(fmt::format("the log has no column '{}'; did you mean '{}'?", name,
                            internal::NearestName(name, names_)));
  }
  std::vector<double> values;
  values.reserve(rows());
  for (auto i = static_cast<std::size_t>(found - names_.begin()); i < data_.size(); i += names_.size()) {
    values.push_back(data_[i]);
  }
  return values;
}

CsvLog::~CsvLog() {
  try {
    Flush();
  } catch (const OutputError&) {
    // errors were reported by the run, which flushes at its end
  }
}

void CsvLog::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  std::string header;
  for (std::size_t i = 0; i < names.size(); ++i) {
    header += (i == 0 ? "" : ",") + names[i] + (units[i].empty() ? "" : " [" + units[i] + "]");
  }
  header += '\n';
  file_.Append(header);
  first_row_ = header.size();
  longest_row_ = names.size() * 32;
  buffer_.resize(std::max<std::size_t>(1 << 16, longest_row_));
}

void CsvLog::Row(std::span<const double> row) {
  if (buffer_.size() - used_ < longest_row_) Flush();
  char* end = buffer_.data() + used_;
  for (const double& value : row) {
    // Nine digits exceed the precision of any sensor, in half the file of 17. Time has 15 digits.
    end = std::to_chars(end, end + 30, value, std::chars_format::general, &value == row.data() ? 15 : 9).ptr;
    *end++ = ',';
  }
  end[-1] = '\n';
  used_ = static_cast<std::size_t>(end - buffer_.data());
  if (Clock::now() - flushed_ > std::chrono::milliseconds(500)) Flush();
}

void CsvLog::Flush() {
  flushed_ = Clock::now();
  file_.Append({buffer_.data(), std::exchange(used_, 0)});
}

void CsvLog::DropFrom(double time, bool after) {
  Flush();
  file_.Truncate(FindRow(time, after));
}

/// Finds the beginning of the first row to be dropped by bisection; rows are in order of time.
std::size_t CsvLog::FindRow(double time, bool after) const {
  std::ifstream file(file_.path(), std::ios::binary);
  std::string row;
  const double rounding = 1e-14 * std::abs(time);         // of times in the file
  std::size_t kept = first_row_, dropped = file_.size();  // the row to be found begins in [kept, dropped]
  while (kept < dropped) {
    std::size_t begin = kept + (dropped - kept) / 2;
    file.seekg(static_cast<std::streamoff>(begin));
    if (std::getline(file, row)) begin += row.size() + 1;  // skip the rest of a row
    if (begin >= dropped) begin = kept;
    file.clear();
    file.seekg(static_cast<std::streamoff>(begin));
    double of_row = 0;
    if (!std::getline(file, row) ||
        std::from_chars(row.data(), row.data() + row.size(), of_row).ec != std::errc()) {
      throw OutputError(fmt::format(
          "cannot set '{}' back to t = {} s: it was changed or cannot be read; log to another file, "
          "or call HoldLogs",
          file_.path().string(), time));
    }
    if (of_row < time - rounding || (after && of_row <= time + rounding)) {
      kept = begin + row.size() + 1;
    } else {
      dropped = begin;
    }
  }
  return dropped;
}

SignalLog::SignalLog(Context& context, std::vector<const Source*> signals,
                     std::vector<std::shared_ptr<LogSink>> sinks)
    : context_(context),
      signals_(std::move(signals)),
      sinks_(std::move(sinks)),
      ops_(context.diagram().program().Evaluation(signals_)) {
  for (const Source* signal : signals_) {
    context_.CheckReadable(*signal);
    using enum internal::TypeInfo::Kind;
    if (const auto kind = signal->type_->kind; kind != kText && kind != kOpaque) continue;
    throw ParameterError(
        fmt::format("'{}' is of type {}, which has no numbers to log: log another signal, give the struct a "
                    "Fields(), or read it by a Publish",
                    signal->path(), signal->type_name()));
  }
  static_cast<void>(ListColumns());
}

SignalLog::~SignalLog() = default;

SignalLog::Columns SignalLog::ListColumns() const {
  Columns columns{{"time"}, {"s"}, {}};
  std::map<std::string, std::size_t> signal_of;
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const Source& signal = *signals_[i];
    const std::vector<Element> elements =
        internal::ListElements(*signal.type_, context_.Address(signal), signal.spec());
    columns.sizes.push_back(elements.size());
    for (const Element& element : elements) {
      const std::string name = signal.path() + (element.name.empty() ? "" : "." + element.name);
      if (const auto [first, is_new] = signal_of.emplace(name, i); !is_new) {
        throw ParameterError(fmt::format(
            "a log cannot have two columns '{}', from '{}' (signal {}) and '{}' (signal {}): log each signal "
            "once, a state or the output that shows it, or give the elements other names",
            name, signals_[first->second]->path(), first->second + 1, signal.path(), i + 1));
      }
      columns.names.push_back(name);
      columns.units.push_back(element.unit);
    }
  }
  return columns;
}

/// Writes the header, which waits for the first row because it may depend on sizes known only at run time.
void SignalLog::Begin() {
  for (const Source* signal : signals_) static_cast<void>(context_.EvalAddress(*signal));
  Columns columns = ListColumns();
  sizes_ = std::move(columns.sizes);
  for (const auto& sink : sinks_) sink->Begin(columns.names, columns.units);
  row_.resize(columns.names.size());
}

void SignalLog::Sample() {
  if (row_.empty()) Begin();
  context_.RunStale(ops_);
  double* out = row_.data();
  *out++ = context_.time();
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const void* value = context_.Address(*signals_[i]);
    if (const std::size_t size = internal::CountScalars(*signals_[i]->type_, value); size != sizes_[i]) {
      throw RunError(fmt::format(
          "'{}' had {} elements in the first row of its log and has {} at t = {} s: log only signals "
          "of constant size",
          signals_[i]->path(), sizes_[i], size, context_.time()));
    }
    out = internal::ToDoubles(*signals_[i]->type_, value, out);
  }
  if (hold_ > 0) {
    held_.insert(held_.end(), row_.begin(), row_.end());
    HandOver(row_[0] - hold_);
    return;
  }
  HandOver(row_);
}

void SignalLog::HandOver(std::span<const double> row) {
  handed_ = row[0];
  for (const auto& sink : sinks_) sink->Row(row);
}

void SignalLog::Hold(double seconds) {
  if (!(seconds > 0) || !std::isfinite(seconds))
    throw ParameterError(fmt::format(
        "logs cannot be held for {} s: give a positive time, or call ReleaseLogs to end holding", seconds));
  hold_ = seconds;
}

void SignalLog::HandOver(double until) {
  const auto size = static_cast<std::ptrdiff_t>(row_.size());
  std::vector<double> row(row_.size());
  while (!held_.empty() && held_.front() <= until) {
    std::copy(held_.begin(), held_.begin() + size, row.begin());
    held_.erase(held_.begin(), held_.begin() + size);
    HandOver(row);
  }
}

void SignalLog::DropFrom(double time, bool after) {
  const auto stays = [&](double row_time) { return row_time < time || (after && row_time == time); };
  const auto size = static_cast<std::ptrdiff_t>(row_.size());
  while (!held_.empty() && !stays(*(held_.end() - size))) held_.erase(held_.end() - size, held_.end());
  if (stays(handed_)) return;
  for (const auto& sink : sinks_) sink->DropFrom(time, after);
  handed_ = time;
}

void SignalLog::Release() {
  hold_ = 0;  // even if a sink throws: its rows will be flushed
  HandOver(std::numeric_limits<double>::infinity());
}

void SignalLog::Flush() {
  if (hold_ > 0) return;
  for (const auto& sink : sinks_) sink->Flush();
}

}  // namespace tenon
