#pragma once

#include <tenon/systems/report/report.h>

namespace tenon::internal {

/// Columns of a log in single precision, with time in double precision, in memory of bounded size. A short
/// run keeps all rows; a long run is thinned out as `Thinning` says, increasingly as the run proceeds.
class ColumnLog final : public LogSink {
 public:
  enum class Thinning {
    kPeaks,   ///< two rows hold the lowest and highest values of an interval in their temporal order
    kSample,  ///< every second, fourth, ... row, and the last
  };
  /// Numbers of signal rows and frames in a report, which at the default rates cover 80 s.
  static constexpr std::size_t kRows = 16384, kFrames = 4096;

  /// Keeps up to `max_rows`, a multiple of 4. `begin` runs before the first row.
  ColumnLog(Thinning thinning, std::size_t max_rows, std::function<void()> begin)
      : thinning_(thinning), max_rows_(max_rows), begin_(std::move(begin)) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  /// Drops whole intervals if two rows stand for an interval.
  void DropFrom(double time, bool after) override;

  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  std::size_t rows() const { return time_.size(); }
  std::size_t columns() const { return names_.size(); }
  double time(std::size_t row) const { return time_[row]; }
  float at(std::size_t row, std::size_t column) const { return data_[row * columns() + column]; }

 private:
  float& cell(std::size_t row, std::size_t column) { return data_[row * columns() + column]; }
  void Append(std::span<const double> row);
  void Widen(std::span<const double> row);
  void Truncate(std::size_t rows);
  void MergePeaks();
  void DropRows();

  Thinning thinning_;
  std::size_t max_rows_;
  std::function<void()> begin_;
  std::vector<std::string> names_, units_;
  std::size_t stride_ = 1;  ///< number of the run's rows for each stored row
  std::size_t pending_ =
      0;  ///< number of the run's rows since the last stored row or the begin of the last interval
  bool trailing_ = false;  ///< whether the last row is temporary
  std::vector<double> time_;
  std::vector<float> data_;
};

/// Returns the indices of the column of that name, or of all elements of the signal of that name; of a path,
/// `xy:NAME`, the first two elements.
std::vector<std::size_t> FindColumns(const std::vector<std::string>& names, const std::string& name);

/// Selects about `limit` rows that preserve the curves of the columns: of each interval of rows the first row
/// and the rows with the smallest and largest value of each column, and the last row of the log. Returns
/// ascending indices.
std::vector<std::size_t> DecimatePeaks(const ColumnLog& log, const std::vector<std::size_t>& columns,
                                       std::size_t limit);

std::string EncodeBase64(const void* data, std::size_t size);
std::string DecodeBase64(const std::string& text);

/// Encodes numbers as base64 of their little-endian bytes.
template <class T>
std::string Base64(const std::vector<T>& values) {
  return EncodeBase64(values.data(), values.size() * sizeof(T));
}
/// Decodes a text of Base64. Throws std::out_of_range for invalid texts.
template <class T>
std::vector<T> FromBase64(const std::string& text) {
  const std::string bytes = DecodeBase64(text);
  std::vector<T> values(bytes.size() / sizeof(T));
  // memcpy requires a valid pointer even for size 0, which an empty vector does not have.
  if (!values.empty()) {
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  }
  return values;
}

/// Whether a name in a plot stands for a path, `xy:NAME`.
bool IsPath(std::string_view name);

/// Returns a sink that appends to each row the columns `norm:NAME` and `rate:NAME` that the plots name, see
/// Plot, and passes it to `sink`; or `sink` itself, if they name none.
std::shared_ptr<LogSink> WithDerived(const std::vector<Plot>& plots, std::shared_ptr<LogSink> sink);

}  // namespace tenon::internal
