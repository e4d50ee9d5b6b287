#pragma once

#include <tenon/systems/framework/block/external_port.h>
#include <tenon/systems/io/recording.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <utility>

namespace tenon {

template <class T = double>
struct ExternalInputParams {
  T initial = internal::Zeroed<T>();  ///< y until something is put in [unit]
  Rate rate = Hz(1000);               ///< of taking over
  std::string unit = "";
  bool record = false;       ///< keeps what was taken over, with its ticks
  Recording<T> replay = {};  ///< if not empty: what is taken over, whatever is put in
};

/// The door for values from other threads: from a window, a joystick, a planner that takes its time.
///
///     auto& speed = builder.Add<ExternalInput<double>>("speed", {.rate = Hz(100), .record = true});
///     …
///     speed.Put(0.3);                                  // in any thread, at any time
///     context.Eval(speed.taken).recording;             // what was taken over, and when
///     builder.Add<ExternalInput<double>>("speed", {.rate = Hz(100), .replay = recording});
///
/// At each of its ticks the last value that was put in is taken over, and held until the next. A run with the
/// recording as `replay` is the recorded one, bit for bit.
///
///     | port | kind            | size | unit |
///     | y    | output, sampled | T    | unit |
///
/// The recording lies in the context: a context that goes back to a snapshot has that of the snapshot. Put is
/// for all contexts of the diagram. Taking over allocates nothing, unless it records.
template <class T = double>
class ExternalInput final : public LeafSystem<ExternalInputParams<T>> {
  using Base = LeafSystem<ExternalInputParams<T>>;

 public:
  using Base::Base;
  using Base::params;

  Scratch<TakenOver<T>> taken{this, "taken", {params.initial, 0, {}}};
  ExternalPort<T> y{this,
                    {"y", params.unit},
                    params.initial,
                    Sampled{params.rate},
                    Uses(this->time, taken),
                    &ExternalInput::TakeOver};

  /// From any thread: what the next tick takes over.
  void Put(const T& value) {
    const std::lock_guard lock(mutex_);
    latest_ = value;
    ++number_;
  }

 private:
  T TakeOver(double time, TakenOver<T>& taken) const {
    if (!params.replay.empty()) {
      taken.Replay(params.replay, time);
      return taken.value;
    }
    const std::lock_guard lock(mutex_);
    if (number_ != taken.number) {
      taken.Take(time, latest_, params.record);
      taken.number = number_;
    }
    return taken.value;
  }

  mutable std::mutex mutex_;
  T latest_ = params.initial;
  std::uint64_t number_ = 0;
};

}  // namespace tenon
