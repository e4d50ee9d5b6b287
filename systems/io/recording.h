#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

#include <cstdint>
#include <vector>

namespace tenon {

/// What came from outside, and at which tick the diagram took it over.
template <class T>
struct Recorded {
  double time = 0;  ///< [s]
  T value = internal::Zeroed<T>();
  static FieldList Fields() { return {{"time", &Recorded::time, "s"}, {"value", &Recorded::value}}; }
};
template <class T>
using Recording = std::vector<Recorded<T>>;

/// What a block that takes values from outside keeps of them in the context, so that a context that was saved
/// or cloned goes on with the same.
template <class T>
struct TakenOver {
  T value = internal::Zeroed<T>();
  std::uint64_t number = 0;  ///< of the last one, as the block counts them
  Recording<T> recording;    ///< those of the run so far, if asked for
  static FieldList Fields() {
    return {
        {"value", &TakenOver::value}, {"number", &TakenOver::number}, {"recording", &TakenOver::recording}};
  }

  void Take(double time, const T& taken, bool record) {
    value = taken;
    ++number;
    if (record) recording.push_back({time, taken});
  }
  /// Goes on in a recording to `time` [s].
  void Replay(const Recording<T>& replay, double time) {
    for (; number < replay.size() && replay[number].time <= time; ++number) value = replay[number].value;
  }
};

}  // namespace tenon
