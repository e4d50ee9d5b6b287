#include <tenon/systems/report/internal/run_log.h>

#include <bit>

namespace tenon {
namespace {

constexpr std::string_view kNorm = "norm:", kRate = "rate:", kPath = "xy:";

}  // namespace

std::string_view LoggedName(std::string_view name) {
  for (const std::string_view prefix : {kNorm, kRate, kPath})
    if (name.starts_with(prefix)) return name.substr(prefix.size());
  return name;
}

namespace internal {

static_assert(std::endian::native == std::endian::little, "Base64 writes bytes in memory order");

void ColumnLog::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  if (begin_) begin_();
  names_.assign(names.begin() + 1, names.end());  // without the time
  units_.assign(units.begin() + 1, units.end());
  time_.reserve(max_rows_ + 1);
  data_.reserve((max_rows_ + 1) * columns());
}

void ColumnLog::Row(std::span<const double> row) {
  std::size_t interval = stride_;
  if (thinning_ == Thinning::kSample) {
    if (trailing_) Truncate(rows() - 1);
    Append(row);
    trailing_ = pending_ != 0;
  } else if (stride_ == 1) {
    Append(row);
  } else {
    interval *= 2;
    if (pending_ == 0) {
      Append(row);
      Append(row);
    } else {
      Widen(row);
    }
  }
  pending_ = (pending_ + 1) % interval;
  if (pending_ != 0 || rows() < max_rows_ + (trailing_ ? 1 : 0)) return;
  Truncate(max_rows_);
  if (thinning_ == Thinning::kPeaks) {
    MergePeaks();
  } else {
    DropRows();
    Append(row);
    trailing_ = true;
  }
  stride_ *= 2;
}

void ColumnLog::DropFrom(double time, bool after) {
  std::size_t kept = rows();
  while (kept > 0 && (time_[kept - 1] > time || (!after && time_[kept - 1] == time))) --kept;
  if (kept == rows()) return;
  if (thinning_ == Thinning::kPeaks && stride_ > 1) kept -= kept % 2;
  Truncate(kept);
  pending_ = 0;
  trailing_ = false;
}

void ColumnLog::Append(std::span<const double> row) {
  time_.push_back(row[0]);
  for (const double value : row.subspan(1)) data_.push_back(static_cast<float>(value));
}

void ColumnLog::Truncate(std::size_t rows) {
  time_.resize(rows);
  data_.resize(rows * columns());
}

namespace {

/// Returns the rows from `begin` to before `end` with the lowest and the highest value of a column. NaN
/// is neither if there are other values.
std::pair<std::size_t, std::size_t> Extremes(const ColumnLog& log, std::size_t column, std::size_t begin,
                                             std::size_t end) {
  std::size_t low = begin, high = begin;
  for (std::size_t row = begin + 1; row < end; ++row) {
    const float value = log.at(row, column), lowest = log.at(low, column), highest = log.at(high, column);
    if (value < lowest || std::isnan(lowest)) low = row;
    if (value > highest || std::isnan(highest)) high = row;
  }
  return {low, high};
}

}  // namespace

/// Adds a row to the last interval, whose lowest and highest values are the last two rows in either order.
void ColumnLog::Widen(std::span<const double> row) {
  const std::size_t last = rows() - 1;
  time_[last] = row[0];
  for (std::size_t column = 0; column < columns(); ++column) {
    const auto value = static_cast<float>(row[1 + column]);
    float &first = cell(last - 1, column), &second = cell(last, column);
    const float low = std::fmin(first, second), high = std::fmax(first, second);
    if (std::isnan(value) || (value >= low && value <= high)) continue;
    if (std::isnan(high)) {
      first = second = value;
      continue;
    }
    first = value > high ? low : high;  // the opposite extremum came before
    second = value;
  }
}

/// Replaces every four rows by the lowest and the highest value of each column, in their temporal order.
void ColumnLog::MergePeaks() {
  for (std::size_t to = 0; 2 * to < rows(); to += 2) {
    const std::size_t from = 2 * to;
    for (std::size_t column = 0; column < columns(); ++column) {
      const auto [low, high] = Extremes(*this, column, from, from + 4);
      const float first = at(std::min(low, high), column), second = at(std::max(low, high), column);
      cell(to, column) = first;
      cell(to + 1, column) = second;
    }
    time_[to] = time_[from];
    time_[to + 1] = time_[from + 3];
  }
  Truncate(rows() / 2);
}

void ColumnLog::DropRows() {
  for (std::size_t to = 0; 2 * to < rows(); ++to) {
    time_[to] = time_[2 * to];
    for (std::size_t column = 0; column < columns(); ++column) cell(to, column) = at(2 * to, column);
  }
  Truncate(rows() / 2);
}

std::vector<std::size_t> FindColumns(const std::vector<std::string>& names, const std::string& name) {
  if (name.starts_with("xy:")) {
    std::vector<std::size_t> path = FindColumns(names, name.substr(3));
    path.resize(std::min<std::size_t>(path.size(), 2));
    return path;
  }
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name || names[i].starts_with(name + ".")) found.push_back(i);
  }
  return found;
}

std::vector<std::size_t> DecimatePeaks(const ColumnLog& log, const std::vector<std::size_t>& columns,
                                       std::size_t limit) {
  const std::size_t per_interval = 2 * columns.size() + 1;
  const std::size_t intervals = std::max<std::size_t>(1, limit / per_interval);
  const std::size_t length = log.rows() <= limit ? 1 : (log.rows() + intervals - 1) / intervals;
  std::vector<std::size_t> rows;
  for (std::size_t begin = 0; begin < log.rows(); begin += length) {
    const std::size_t end = std::min(begin + length, log.rows());
    rows.push_back(begin);
    if (length == 1) continue;
    for (const std::size_t column : columns) {
      const auto [low, high] = Extremes(log, column, begin, end);
      rows.insert(rows.end(), {low, high});
    }
  }
  if (log.rows() > 0) rows.push_back(log.rows() - 1);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

namespace {
constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
}

std::string EncodeBase64(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  std::string text((size + 2) / 3 * 4, '=');
  char* out = text.data();
  const auto digits = [&](std::uint32_t bits, int count) {
    for (int k = 0; k < count; ++k) *out++ = kDigits[bits >> (18 - 6 * k) & 63];
  };
  std::size_t i = 0;
  for (; i + 3 <= size; i += 3) {
    digits(static_cast<std::uint32_t>(bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2]), 4);
  }
  if (size - i == 1) digits(static_cast<std::uint32_t>(bytes[i] << 16), 2);
  if (size - i == 2) digits(static_cast<std::uint32_t>(bytes[i] << 16 | bytes[i + 1] << 8), 3);
  return text;
}

std::string DecodeBase64(const std::string& text) {
  std::array<int, 256> digit;
  digit.fill(-1);
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    digit[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    const int value = digit[static_cast<unsigned char>(c)];
    if (value < 0) throw std::out_of_range("invalid base64");
    bits = bits << 6 | static_cast<unsigned>(value);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255);
  }
  return bytes;
}

bool IsPath(std::string_view name) {
  return name.starts_with(kPath);
}

namespace {

std::string RateUnit(const std::string& unit) {
  if (unit.ends_with("/s")) return unit + "^2";
  if (unit.ends_with("/s^2")) return unit.substr(0, unit.size() - 1) + "3";
  return unit.empty() ? "1/s" : unit + "/s";
}

class DerivedLog final : public LogSink {
 public:
  DerivedLog(std::vector<std::string> derived, std::shared_ptr<LogSink> sink)
      : derived_(std::move(derived)), sink_(std::move(sink)) {}

  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override {
    std::vector<std::string> all = names, all_units = units;
    columns_.clear();
    const auto add = [&](std::string name, std::string unit, std::vector<std::size_t> from, bool rate) {
      if (std::ranges::count(all, name) > 0) return;
      columns_.push_back({std::move(from), rate});
      all.push_back(std::move(name));
      all_units.push_back(std::move(unit));
    };
    for (const std::string& name : derived_) {
      const std::vector<std::size_t> from = FindColumns(names, std::string(LoggedName(name)));
      if (name.starts_with(kNorm) && !from.empty()) add(name, units[from.front()], from, false);
      if (!name.starts_with(kRate)) continue;
      for (const std::size_t column : from)
        add(std::string(kRate) + names[column], RateUnit(units[column]), {column}, true);
    }
    last_.clear();
    row_.reserve(all.size());
    last_.reserve(names.size());
    sink_->Begin(all, all_units);
  }

  void Row(std::span<const double> row) override {
    row_.assign(row.begin(), row.end());
    for (const Column& column : columns_) {
      double value = 0;
      if (column.rate) {
        const std::size_t i = column.from.front();
        value = last_.empty() ? std::numeric_limits<double>::quiet_NaN()
                              : (row[i] - last_[i]) / (row[0] - last_[0]);
      } else {
        for (const std::size_t i : column.from) value = std::hypot(value, row[i]);
      }
      row_.push_back(value);
    }
    last_.assign(row.begin(), row.end());
    sink_->Row(row_);
  }

  void Flush() override { sink_->Flush(); }
  void DropFrom(double time, bool after) override {
    last_.clear();
    sink_->DropFrom(time, after);
  }

 private:
  struct Column {
    std::vector<std::size_t> from;
    bool rate;
  };
  std::vector<std::string> derived_;
  std::shared_ptr<LogSink> sink_;
  std::vector<Column> columns_;
  std::vector<double> row_, last_;
};

}  // namespace

std::shared_ptr<LogSink> WithDerived(const std::vector<Plot>& plots, std::shared_ptr<LogSink> sink) {
  std::vector<std::string> derived;
  for (const Plot& plot : plots)
    for (const auto* names : {&plot.signals, &plot.references})
      for (const std::string& name : *names)
        if ((name.starts_with(kNorm) || name.starts_with(kRate)) && std::ranges::count(derived, name) == 0)
          derived.push_back(name);
  if (derived.empty()) return sink;
  return std::make_shared<DerivedLog>(std::move(derived), std::move(sink));
}

}  // namespace internal
}  // namespace tenon
