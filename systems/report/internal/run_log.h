#pragma once

#include <tenon/systems/geometry.h>
#include <tenon/systems/simulation/signal_log.h>

#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tenon::internal {

/// Columns of a log, kept in single precision, time in double, in memory that does not grow with the run. All
/// rows of a short one; of a long one what `Thinning` says, ever coarser as the run goes on.
class ColumnLog final : public LogSink {
 public:
  enum class Thinning {
    kPeaks,   ///< every two rows stand for an interval: in each column its lowest and highest, as they came
    kSample,  ///< every second, fourth, ... row as it was, and the last
  };
  /// What a report keeps of signals and of frames: at the usual rates all of some 80 s.
  static constexpr std::size_t kRows = 16384, kFrames = 4096;

  /// Keeps up to `max_rows`, a multiple of 4. `begin` runs before the first row.
  ColumnLog(Thinning thinning, std::size_t max_rows, std::function<void()> begin)
      : thinning_(thinning), max_rows_(max_rows), begin_(std::move(begin)) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  /// Of rows that stand for an interval, the whole interval.
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
  std::size_t stride_ = 1;   ///< rows of the run that one row here stands for
  std::size_t pending_ = 0;  ///< rows of the run since the last one kept, or since the last interval began
  bool trailing_ = false;    ///< whether the last row is not one to keep
  std::vector<double> time_;
  std::vector<float> data_;
};

/// The columns that a name means: the one of that name, or all elements of the signal of that name.
std::vector<std::size_t> FindColumns(const std::vector<std::string>& names, const std::string& name);

/// At most about `limit` rows of the log that show the same curves: of each of equally long runs of rows the
/// first, and of each of the columns the smallest and the largest; and the last of all. Ascending.
std::vector<std::size_t> DecimatePeaks(const ColumnLog& log, const std::vector<std::size_t>& columns,
                                       std::size_t limit);

std::string EncodeBase64(const void* data, std::size_t size);
std::string DecodeBase64(const std::string& text);

/// Numbers as base64 of their little-endian bytes.
template <class T>
std::string Base64(const std::vector<T>& values) {
  return EncodeBase64(values.data(), values.size() * sizeof(T));
}
/// What Base64 made; throws std::out_of_range if that it is not.
template <class T>
std::vector<T> FromBase64(const std::string& text) {
  const std::string bytes = DecodeBase64(text);
  std::vector<T> values(bytes.size() / sizeof(T));
  // memcpy wants a place even for nothing, which an empty vector does not have.
  if (!values.empty()) {
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  }
  return values;
}

}  // namespace tenon::internal
