#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

namespace tenon::internal {

/// A stopwatch that always runs for exactly one part: a calculation, or an activity of the simulator.
class Profiler {
 public:
  enum Part : std::size_t { kTicks, kIntegrator, kLogs, kWaiting, kCalculations };  ///< then by calculation
  using Clock = std::chrono::steady_clock;

  explicit Profiler(std::size_t num_calculations) : parts_(kCalculations + num_calculations) {}

  void Start() {
    since_ = Clock::now();
    current_ = kTicks;
  }
  /// Starts counting time for `part`; returns the previous part.
  std::size_t Enter(std::size_t part) {
    const Clock::time_point now = Clock::now();
    parts_[current_].time += now - since_;
    ++parts_[part].calls;
    since_ = now;
    const std::size_t before = current_;
    current_ = part;
    return before;
  }
  std::size_t current() const { return current_; }
  double seconds(std::size_t part) const { return std::chrono::duration<double>(parts_[part].time).count(); }
  long calls(std::size_t part) const { return parts_[part].calls; }

 private:
  struct Counter {
    Clock::duration time{};
    long calls = 0;
  };
  std::vector<Counter> parts_;
  std::size_t current_ = kTicks;
  Clock::time_point since_;
};

/// Counts time for a part during its lifetime; does nothing if `profiler` is null.
class Profiled {
 public:
  Profiled(Profiler* profiler, std::size_t part)
      : profiler_(profiler), before_(profiler != nullptr ? profiler->Enter(part) : 0) {}
  Profiled(const Profiled&) = delete;
  Profiled& operator=(const Profiled&) = delete;
  ~Profiled() {
    if (profiler_ != nullptr) profiler_->Enter(before_);
  }

 private:
  Profiler* profiler_;
  std::size_t before_;
};

}  // namespace tenon::internal
