#pragma once

#include <tenon/apps/common/summary.h>
#include <tenon/systems/io/recording.h>

namespace tenon::apps {

/// A robot or client on the wire, or the directory of a run with one, which is repeated without it.
struct Wire {
  std::string where = {};             ///< "INTERFACE[,DOMAIN]"; empty: none
  std::filesystem::path replay = {};  ///< empty: no replay
  bool changed = false;               ///< the replay has another scenario than the run
  bool any() const { return !where.empty() || !replay.empty(); }
};

/// The values that a run received over a wire: rows of a time, the elements of the received signal, the age
/// of the plan if it is calculated in a thread (see Slow), and the checksum of the message that was sent at
/// this tick.
struct WireRows {
  std::size_t columns = 0;
  bool ages = false;
  std::vector<double> numbers = {};

  std::size_t rows() const { return numbers.size() / columns; }
  const double* row(std::size_t i) const { return &numbers[i * columns]; }
  double end() const { return row(rows() - 1)[0]; }  ///< [s]
};

/// Reads wire.bin of a directory: a line of names, then rows of doubles. A last row that is not whole, as
/// after a kill, is dropped. Throws ParameterError for a file that cannot be read or whose columns without
/// ages are not `columns`.
WireRows ReadWire(const std::filesystem::path& directory, std::size_t columns);

/// Writes the wire.bin of a run, or compares a replay with that of its run.
class WireRecorder {
 public:
  /// `out` is the directory of the run, which is created; if empty, nothing is written.
  WireRecorder(Wire wire, std::filesystem::path out);

  /// The values that were received, for the block that repeats them; empty unless this is a replay.
  template <class T>
  Recording<T> Received(const T& initial) {
    Recording<T> recording;
    if (wire_.replay.empty()) return recording;
    recorded_ = ReadWire(wire_.replay, 2 + internal::CountScalars(internal::TypeInfoOf<T>(), &initial));
    recording.resize(recorded_.rows(), {0, initial});
    for (std::size_t i = 0; i < recorded_.rows(); ++i) {
      recording[i].time = recorded_.row(i)[0];
      internal::FromDoubles(internal::TypeInfoOf<T>(), &recording[i].value, recorded_.row(i) + 1);
    }
    return recording;
  }
  const WireRows& recorded() const { return recorded_; }
  /// The durations of the calculations by their starts, which are ticks of the wire; empty without ages.
  Recording<double> Durations(Rate rate) const;

  /// Logs the signals of a row at the rate of the wire.
  void AddTo(Simulator& simulator, Rate rate, const std::vector<const Source*>& signals);
  /// Adds the numbers of equal and of other checksums of a replay, and when the first one differed.
  void AddTo(Summary& summary) const;

 private:
  class Check;
  Wire wire_;
  std::filesystem::path out_;
  WireRows recorded_;
  std::shared_ptr<Check> check_;
};

}  // namespace tenon::apps
