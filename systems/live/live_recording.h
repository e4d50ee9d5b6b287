#pragma once

#include <tenon/systems/simulation/simulator.h>

namespace tenon {

/// The path of a Parameter or state that is set from outside, and its numbers.
struct LiveSet {
  std::string path;
  std::vector<double> values;
};

/// Returns the LiveSet of a Parameter or state with the given value.
template <class S>
LiveSet SetTo(const S& source, const typename S::Value& value) {
  return {source.path(), internal::DoublesOf(internal::TypeInfoOf<typename S::Value>(), &value)};
}

/// The values that were set between two ticks of a live run.
struct LiveEntry {
  double time = 0;  ///< time of the run, before its tick [s]
  std::vector<LiveSet> sets;
};

/// All inputs of a live run. The file live.jsonl has a line of JSON for the run, for each time at which
/// values were set, and for the end:
///
///     {"tenon_live": 1, "seed": 1, "tenon": "0.3.0"}
///     {"time": 1.25, "set": {"loop_drive.velocity": [0.3, 0, 0]}}
///     {"end": 12.5, "tick": false}
///
/// A replay repeats the run bit for bit.
struct LiveRecording {
  std::uint64_t seed = 0;  ///< seed of the run's random streams
  std::vector<LiveEntry> entries;
  std::optional<double> end;  ///< end of the run [s]; empty if the run was killed
  bool end_tick = false;      ///< whether the tick at the end belongs to the run

  /// Reads a file. Throws ParameterError with the file, the line and the error.
  static LiveRecording Read(const std::filesystem::path& file);
};

/// Repeats a recorded run until its end or `duration` [s], whichever is earlier, as fast as possible. Throws
/// ParameterError that names the entry if the diagram has no such path or refuses the value, and as
/// Simulator::AdvanceTo does.
RunStatus Replay(Simulator& simulator, const LiveRecording& recording, std::optional<double> duration = {});

}  // namespace tenon
