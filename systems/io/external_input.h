#pragma once

#include <tenon/systems/framework/block/external_port.h>
#include <tenon/systems/io/recording.h>

#include <mutex>

namespace tenon {

template <class T = double>
struct ExternalInputParams {
  T initial = internal::Zeroed<T>();  ///< y until the first Put [unit]
  Rate rate = Hz(1000);               ///< rate at which y takes over values
  std::string unit = "";
  bool record = false;       ///< records the values and the times at which y took them over
  Recording<T> replay = {};  ///< if not empty, y follows this recording and ignores Put
};

/// An input for values from other threads: from a window, a joystick, or a slow planner.
///
///     auto& speed = builder.Add<ExternalInput<double>>("speed", {.rate = Hz(100), .record = true});
///     …
///     speed.Put(0.3);                                  // from any thread, at any time
///     context.Eval(speed.taken).recording;             // the values and their times
///     builder.Add<ExternalInput<double>>("speed", {.rate = Hz(100), .replay = recording});
///
/// At each tick, y takes over the value of the last Put and holds it until the next tick. A run with the
/// recording as `replay` repeats the recorded run bit for bit.
///
/// The recording is part of the context and of its snapshots. Put affects all contexts of the diagram. A tick
/// does not allocate unless it records.
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

  /// Sets the value that the next tick takes over. Any thread may call it.
  void Put(const T& value) {
    const std::lock_guard lock(mutex_);
    latest_ = value;
    ++number_;
  }

 private:
  T TakeOver(double t, TakenOver<T>& taken_now) const {
    if (!params.replay.empty()) {
      taken_now.Replay(params.replay, t);
      return taken_now.value;
    }
    const std::lock_guard lock(mutex_);
    if (number_ != taken_now.number) {
      taken_now.Take(t, latest_, params.record);
      taken_now.number = number_;
    }
    return taken_now.value;
  }

  mutable std::mutex mutex_;
  T latest_ = params.initial;
  std::uint64_t number_ = 0;
};

}  // namespace tenon
