#include <tenon/systems/report/internal/run_log.h>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace tenon::internal {

static_assert(std::endian::native == std::endian::little, "Base64 writes the bytes as they are");

void ColumnLog::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  if (begin_) begin_();
  for (std::size_t i = 1; i < names.size(); ++i) {
    if (wanted_ && !wanted_(names[i])) continue;
    kept_.push_back(i);
    names_.push_back(names[i]);
    units_.push_back(units[i]);
  }
}

void ColumnLog::Row(std::span<const double> row) {
  time_.push_back(row[0]);
  for (const std::size_t i : kept_) data_.push_back(static_cast<float>(row[i]));
}

std::vector<std::size_t> FindColumns(const std::vector<std::string>& names, const std::string& name) {
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
      std::size_t low = begin, high = begin;
      for (std::size_t row = begin + 1; row < end; ++row) {
        if (log.at(row, column) < log.at(low, column)) low = row;
        if (log.at(row, column) > log.at(high, column)) high = row;
      }
      rows.insert(rows.end(), {low, high});
    }
  }
  if (log.rows() > 0) rows.push_back(log.rows() - 1);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

namespace {

std::string Encode(const void* data, std::size_t size) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t count = std::min<std::size_t>(3, size - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? bytes[i + k] : 0);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string Base64(const std::vector<double>& values) {
  return Encode(values.data(), values.size() * sizeof(double));
}
std::string Base64(const std::vector<float>& values) {
  return Encode(values.data(), values.size() * sizeof(float));
}

}  // namespace tenon::internal
