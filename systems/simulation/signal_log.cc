#include <tenon/systems/simulation/signal_log.h>

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <tenon/systems/framework/diagram.h>
#include <tenon/systems/framework/internal/nearest_name.h>
#include <tenon/systems/framework/internal/program.h>

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
    // A run flushes at its end, and says so there.
  }
}

void CsvLog::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  std::string header;
  for (std::size_t i = 0; i < names.size(); ++i) {
    header += (i == 0 ? "" : ",") + names[i] + (units[i].empty() ? "" : " [" + units[i] + "]");
  }
  header += '\n';
  file_.Append(header);
  longest_row_ = names.size() * 32;
  buffer_.resize(std::max<std::size_t>(1 << 16, longest_row_));
}

void CsvLog::Row(std::span<const double> row) {
  if (buffer_.size() - used_ < longest_row_) Flush();
  char* end = buffer_.data() + used_;
  for (const double& value : row) {
    // Nine digits: more than any sensor has, half the file of the full seventeen. Time is exact.
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
        fmt::format("'{}' is of type {}, of which a log has no numbers: log another signal, give a struct a "
                    "Fields(), or read it by a Publish",
                    signal->path(), signal->type_name()));
  }
}

SignalLog::~SignalLog() = default;

/// Sizes known at run time only show in the values, not in the ports: so the header waits for the first row.
void SignalLog::Begin() {
  std::vector<std::string> names{"time"}, units{"s"};
  for (const Source* signal : signals_) {
    const std::vector<Element> elements =
        internal::ListElements(*signal->type_, context_.EvalAddress(*signal), signal->spec());
    sizes_.push_back(elements.size());
    for (const Element& element : elements) {
      names.push_back(signal->path() + (element.name.empty() ? "" : "." + element.name));
      units.push_back(element.unit);
    }
  }
  row_.resize(names.size());
  for (const auto& sink : sinks_) sink->Begin(names, units);
}

void SignalLog::Sample() {
  if (row_.empty()) Begin();
  context_.RunStale(ops_);
  double* out = row_.data();
  *out++ = context_.time();
  for (std::size_t i = 0; i < signals_.size(); ++i) {
    const void* value = context_.Address(*signals_[i]);
    if (const std::size_t size = internal::CountScalars(*signals_[i]->type_, value); size != sizes_[i]) {
      throw RunError(
          fmt::format("'{}' had {} elements in the first row of its log and has {} at t = {} s: log signals "
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
  for (const auto& sink : sinks_) sink->Row(row_);
}

void SignalLog::Hold(double seconds) {
  if (!(seconds > 0) || !std::isfinite(seconds))
    throw ParameterError(fmt::format(
        "logs cannot be held for {} s: give a positive time, and ReleaseLogs to hold them no more", seconds));
  hold_ = seconds;
}

void SignalLog::HandOver(double until) {
  const auto size = static_cast<std::ptrdiff_t>(row_.size());
  std::vector<double> row(row_.size());
  while (!held_.empty() && held_.front() <= until) {
    std::copy(held_.begin(), held_.begin() + size, row.begin());
    held_.erase(held_.begin(), held_.begin() + size);
    for (const auto& sink : sinks_) sink->Row(row);
  }
}

void SignalLog::DropFrom(double time, bool after) {
  const auto size = static_cast<std::ptrdiff_t>(row_.size());
  while (!held_.empty()) {
    const double last = *(held_.end() - size);
    if (last < time || (after && last == time)) return;
    held_.erase(held_.end() - size, held_.end());
  }
}

void SignalLog::Release() {
  hold_ = 0;  // whatever a sink throws: what it has gathered is flushed
  HandOver(std::numeric_limits<double>::infinity());
}

void SignalLog::Flush() {
  if (hold_ > 0) return;
  for (const auto& sink : sinks_) sink->Flush();
}

}  // namespace tenon
