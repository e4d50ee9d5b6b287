#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/simulation/signal_log.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>
#include <fmt/format.h>

#include <fstream>
#include <iterator>

namespace tenon {

void LogSink::Claim(const std::vector<std::shared_ptr<LogSink>>& sinks, const char* log) {
  for (const auto& sink : sinks) {
    if (sink == nullptr) throw ParameterError(fmt::format("{}: a sink is null: give a LogSink", log));
    if (!std::exchange(sink->claimed_, true)) continue;
    throw ParameterError(fmt::format(
        "{}: a sink belongs to another log already, and their rows would mix: give each log a sink of "
        "its own",
        log));
  }
}

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
  if (names_.empty()) {
    throw Error(fmt::format(
        "the log has no column '{}', because it has not run yet: advance the simulator first", name));
  }
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
    // The run flushes at its end and reports the error there.
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
    // Nine digits exceed the resolution of any sensor and take half the space of seventeen. Time is exact.
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

/// Finds the offset of the first row to drop [bytes] by bisection, because rows are in the order of time.
std::size_t CsvLog::FindRow(double time, bool after) const {
  std::ifstream file(file_.path(), std::ios::binary);
  std::string row;
  const double rounding = 1e-14 * std::abs(time);  // of the digits in the file
  // The first row to drop begins between these offsets.
  std::size_t kept = first_row_, dropped = file_.size();
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
          "cannot set '{}' back to t = {} s: it cannot be read or another program changed it; log into a "
          "file that nothing else writes, or call HoldLogs",
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
  for (const Source*& signal : signals_) {
    context_.CheckReadable(*signal);
    signal = &signal->Current();
    using enum internal::TypeInfo::Kind;
    if (const auto kind = signal->type_->kind; kind != kText && kind != kOpaque) continue;
    throw ParameterError(
        fmt::format("'{}' is of type {}, which holds no numbers for a log: log another signal, give a struct "
                    "a Fields(), or read it by a Publish",
                    signal->path(), signal->type_name()));
  }
  static_cast<void>(ListColumns());
  LogSink::Claim(sinks_, "AddLog");
}

SignalLog::~SignalLog() = default;

SignalLog::Columns SignalLog::ListColumns() const {
  Columns columns{{"time"}, {"s"}};
  std::map<std::string, std::size_t> signal_of;
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const Source& signal = *signals_[i];
    const std::vector<Element> elements =
        internal::ListElements(*signal.type_, context_.Address(signal), signal.spec());
    for (const Element& element : elements) {
      const std::string name = element.PathIn(signal.path());
      const std::string cell = name + element.unit;
      if (std::ranges::any_of(cell, [](unsigned char c) { return c < 0x20 || c == 0x7F || c == ','; }))
        throw ParameterError(
            fmt::format("'{}' in '{}' cannot be the name and unit of a column: remove commas and control "
                        "characters",
                        internal::Excerpt(name), internal::Excerpt(element.unit)));
      if (const auto [first, is_new] = signal_of.emplace(name, i); !is_new) {
        throw ParameterError(
            fmt::format("a log cannot have two columns '{}': of '{}' (signal {}) and of '{}' (signal {}); "
                        "log each signal once, log either a state or the output that shows it, or rename "
                        "elements",
                        name, signals_[first->second]->path(), first->second + 1, signal.path(), i + 1));
      }
      columns.names.push_back(name);
      columns.units.push_back(element.unit);
    }
  }
  return columns;
}

/// The header waits for the first row, because sizes known at run time show in the values only.
void SignalLog::Begin() {
  for (const Source* signal : signals_) static_cast<void>(context_.EvalAddress(*signal));
  const Columns columns = ListColumns();
  for (const auto& sink : sinks_) sink->Begin(columns.names, columns.units);
  row_.resize(columns.names.size());
  ListNumbers();
  first_ = blocks_;
}

void SignalLog::ListNumbers() {
  blocks_.clear();
  runs_.clear();
  for (const Source* signal : signals_)
    ListNumbers(*signal->type_, const_cast<std::byte*>(context_.Address(*signal)), signal);
}

void SignalLog::ListNumbers(const internal::TypeInfo& type, std::byte* value, const Source* signal) {
  using enum internal::TypeInfo::Kind;
  const auto add = [&](const void* data, std::size_t count, internal::ScalarKind kind) {
    if (count > 0) runs_.push_back({data, count, kind});
  };
  if (type.fixed) {
    for (const internal::ScalarRun& run : type.runs) add(value + run.offset, run.count, run.kind);
  } else if (type.kind == kStruct) {
    for (const Field& field : type.fields) ListNumbers(field.type(), value + field.offset, signal);
  } else if (type.kind == kArray) {
    for (std::size_t i = 0; i < type.count; ++i)
      ListNumbers(type.item(), value + i * type.item().size, signal);
  } else if (type.kind == kMatrix || type.kind == kList || type.kind == kOptional) {
    const ResizableBlock& block = blocks_.emplace_back(BlockOf(type, value, signal));
    auto* const data = static_cast<std::byte*>(block.data);
    const internal::Extents size = block.size;
    if (type.kind == kMatrix) return add(data, size.rows * size.cols, type.scalar);
    for (std::size_t i = 0; i < size.rows; ++i) ListNumbers(type.item(), data + i * type.item().size, signal);
  }
}

SignalLog::ResizableBlock SignalLog::BlockOf(const internal::TypeInfo& type, void* value,
                                             const Source* signal) {
  const internal::Extents size = internal::ExtentsOf(type, value);
  return {&type, value, size.rows > 0 ? type.data(value) : nullptr, size, signal};
}

void SignalLog::CheckSizes() const {
  const auto equal = [](const ResizableBlock& now, const ResizableBlock& first) {
    return now.signal == first.signal && now.size == first.size;
  };
  const auto [now, first] = std::ranges::mismatch(blocks_, first_, equal);
  if (first == first_.end()) return;  // an added block follows one with other rows
  throw RunError(
      fmt::format("'{}' has another size at t = {} s than in the first row of its log: log only signals of "
                  "constant size",
                  first->signal->path(), context_.time()));
}

void SignalLog::Sample() {
  if (row_.empty()) Begin();
  context_.RunStale(ops_);
  // Outer blocks precede those inside them, so the search stops before it follows an outdated address.
  const auto has_changed = [](const ResizableBlock& block) {
    return BlockOf(*block.type, block.value, block.signal) != block;
  };
  if (std::ranges::any_of(blocks_, has_changed)) {
    ListNumbers();
    CheckSizes();
  }
  double* out = row_.data();
  *out++ = context_.time();
  for (const Run& run : runs_) {
    internal::WithKind(run.kind, const_cast<void*>(run.data),
                       [&](const auto* first) { out = std::copy_n(first, run.count, out); });
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
        "logs cannot be held for {} s: give a positive time; ReleaseLogs ends the delay", seconds));
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
  hold_ = 0;  // even if a sink throws, so that Flush reaches it
  HandOver(std::numeric_limits<double>::infinity());
}

void SignalLog::Flush() {
  if (hold_ > 0) return;
  for (const auto& sink : sinks_) sink->Flush();
}

}  // namespace tenon
