#pragma once

#include <cstdint>
#include <vector>

#include <tenon/systems/framework/internal/program.h>

namespace tenon::internal {

/// The ticks of a run, in integers of 1 / L seconds. Entries are a program's sample groups, then logs.
class Schedule {
 public:
  /// Throws BuildError if the periods have no common tick above a picosecond.
  explicit Schedule(std::vector<SampleGroup> entries);

  /// Makes the next ticks those after `time` (`inclusive`: at or after).
  void MoveTo(double time, bool inclusive);
  /// Time of the next tick [s]; infinity if there is none.
  double next_time() const { return next_time_; }
  /// Bits of the entries that are due at the next tick, which is thereby passed.
  std::uint64_t Take();
  std::int64_t next_tick() const { return next_tick_; }
  /// The tick from which on everything repeats; huge if the periods have no short common multiple.
  std::int64_t cycle_end() const;

 private:
  void FindNext();

  struct Entry {
    std::int64_t period;
    std::int64_t offset;
    std::int64_t next;
  };
  std::vector<Entry> entries_;
  std::int64_t per_second_ = 1;
  std::int64_t next_tick_ = 0;
  double next_time_ = 0;
};

}  // namespace tenon::internal
