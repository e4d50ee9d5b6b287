#pragma once

#include <tenon/systems/framework/diagram/internal/program.h>

namespace tenon::internal {

/// The ticks of a run, as integers of 1 / L seconds. Entries are a program's sample groups, followed by the
/// logs.
class Schedule {
 public:
  /// Throws BuildError if the periods have no common tick above a picosecond.
  explicit Schedule(const std::vector<SampleGroup>& groups);

  /// Moves to the first ticks after `time`, or at or after it if `inclusive`. Throws RunError if a double
  /// cannot distinguish ticks at `time`.
  void MoveTo(double time, bool inclusive);
  /// Time of the next tick [s]; infinity if there is none.
  double next_time() const { return next_time_; }
  /// Time of the next tick that restarts the integrator [s]; infinity if there is none.
  double next_feeding_time() const { return next_feeding_time_; }
  /// The exact time of the next tick, or of the next one that restarts the integrator, minus its double [s].
  double next_rest() const { return Rest(next_tick_); }
  double next_feeding_rest() const { return Rest(next_feeding_tick_); }
  /// Times of the ticks before and after the next one [s]; infinite if there is none.
  double previous_time() const;
  double following_time() const;
  /// The shortest period of all entries, and of those whose ticks restart the integrator [s]; 0 if there is
  /// none.
  double shortest_period() const { return shortest_period_; }
  double shortest_feeding_period() const { return shortest_feeding_period_; }
  /// Returns the entries that are due at the next tick, and moves past it. The result is valid until the next
  /// call.
  const Groups& Take();

 private:
  void FindNext();
  double Time(std::int64_t tick) const;
  double Rest(std::int64_t tick) const;
  void CheckResolution(double time) const;

  struct Entry {
    std::int64_t period;
    std::int64_t offset;
    std::int64_t next;
    bool feeds;
  };
  std::vector<Entry> entries_;
  Groups due_;
  std::int64_t per_second_ = 1;
  std::int64_t next_tick_ = 0;
  std::int64_t next_feeding_tick_ = 0;
  double next_time_ = 0;
  double next_feeding_time_ = 0;
  double shortest_period_ = 0;
  double shortest_feeding_period_ = 0;
  std::string finest_;  ///< the example of the entry with the shortest period
};

}  // namespace tenon::internal
