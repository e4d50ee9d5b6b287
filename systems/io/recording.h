#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// A value from outside the diagram and the time of the tick that took it over.
template <class T>
struct Recorded {
  double time = 0;  ///< [s]
  T value = internal::Zeroed<T>();
  static FieldList Fields() { return {{"time", &Recorded::time, "s"}, {"value", &Recorded::value}}; }
};
template <class T>
using Recording = std::vector<Recorded<T>>;

/// The state of a block that takes over values from outside. It is part of the context, so that saved and
/// cloned contexts continue with the same values.
template <class T>
struct TakenOver {
  T value = internal::Zeroed<T>();
  std::uint64_t number = 0;  ///< number of the last value, counted by the block
  Recording<T> recording;    ///< values of the run so far, if recorded
  static FieldList Fields() {
    return {
        {"value", &TakenOver::value}, {"number", &TakenOver::number}, {"recording", &TakenOver::recording}};
  }

  void Take(double time, const T& taken, bool record) {
    value = taken;
    ++number;
    if (record) recording.push_back({time, taken});
  }
  /// Takes over the values of a recording up to `time` [s].
  void Replay(const Recording<T>& replay, double time) {
    for (; number < replay.size() && replay[number].time <= time; ++number) value = replay[number].value;
  }
};

}  // namespace tenon
