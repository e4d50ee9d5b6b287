#pragma once

#include <tenon/systems/framework/types/signal.h>
#include <tenon/systems/simulation/simulator.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// A Parameter or state that is set from outside, by its path, and the numbers that it gets.
struct LiveSet {
  std::string path;
  std::vector<double> values;
};

/// What sets a Parameter or a state to `value`.
template <class S>
LiveSet SetTo(const S& source, const typename S::Value& value) {
  const internal::TypeInfo& type = internal::TypeInfoOf<typename S::Value>();
  LiveSet set{source.path(), std::vector<double>(internal::CountScalars(type, &value))};
  internal::ToDoubles(type, &value, set.values.data());
  return set;
}

/// What was set between two ticks of a live run, and when.
struct LiveEntry {
  double time = 0;  ///< of the run; the tick there has yet to happen [s]
  std::vector<LiveSet> sets;
};

/// All that reached a live run from outside, as live.jsonl holds it: a line of JSON for the run, one for each
/// instant at which something was set, and one for the end.
///
///     {"tenon_live": 1, "seed": 1}
///     {"time": 1.25, "set": {"loop_drive.velocity": [0.3, 0, 0]}}
///     {"end": 12.5, "tick": false}
///
/// Replayed, they make the same run again, bit for bit.
struct LiveRecording {
  std::uint64_t seed = 0;  ///< of the run's random streams
  std::vector<LiveEntry> entries;
  std::optional<double> end;  ///< [s]; none of a run that was killed
  bool end_tick = false;      ///< whether the tick at the end belongs to the run

  /// Throws ParameterError that names the file, the line and what is wrong there.
  static LiveRecording Read(const std::filesystem::path& file);
};

/// Runs what was recorded, to its end or, if that comes first or there is none, to `duration` [s]. Nothing is
/// paced to the clock. Throws ParameterError that names the file's entry if this diagram has no such path or
/// does not take the value, and what Simulator::AdvanceTo throws.
RunStatus Replay(Simulator& simulator, const LiveRecording& recording, std::optional<double> duration = {});

}  // namespace tenon
