#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tenon/systems/geometry.h>
#include <tenon/systems/simulation/signal_log.h>

namespace tenon::internal {

/// Columns of a log, kept in single precision; time in double.
class ColumnLog final : public LogSink {
 public:
  /// Keeps the columns that `wanted` says yes to. `begin` runs before the first row.
  ColumnLog(std::function<bool(const std::string&)> wanted, std::function<void()> begin)
      : wanted_(std::move(wanted)), begin_(std::move(begin)) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;

  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  const std::vector<double>& time() const { return time_; }
  std::size_t rows() const { return time_.size(); }
  std::size_t columns() const { return names_.size(); }
  float at(std::size_t row, std::size_t column) const { return data_[row * columns() + column]; }

 private:
  std::function<bool(const std::string&)> wanted_;
  std::function<void()> begin_;
  std::vector<std::size_t> kept_;
  std::vector<std::string> names_, units_;
  std::vector<double> time_;
  std::vector<float> data_;
};

/// The columns that a name means: the one of that name, or all elements of the signal of that name.
std::vector<std::size_t> FindColumns(const std::vector<std::string>& names, const std::string& name);

/// At most about `limit` rows of the log that show the same curves: of each of equally long runs of rows the
/// first, and of each of the columns the smallest and the largest; and the last of all. Ascending.
std::vector<std::size_t> DecimatePeaks(const ColumnLog& log, const std::vector<std::size_t>& columns,
                                       std::size_t limit);

/// Numbers as base64 of their little-endian bytes.
std::string Base64(const std::vector<double>& values);
std::string Base64(const std::vector<float>& values);

}  // namespace tenon::internal
