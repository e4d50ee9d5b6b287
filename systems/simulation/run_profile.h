#pragma once

#include <string>
#include <vector>

namespace tenon {

/// Where a run spent its time, for a simulator with `.profile = true`. All times are wall-clock seconds; the
/// parts add up to `total`.
struct RunProfile {
  struct Entry {
    std::string path;  ///< path of the calculation, such as "loop.pd.u" or "loop.cart.d/dt x"
    long calls = 0;
    double seconds = 0;
  };
  std::vector<Entry> calculations;  ///< longest first
  double integrator = 0;            ///< SUNDIALS and the simulator's integration, without the calculations
  double logs = 0;
  double ticks = 0;    ///< schedule, updates, checks
  double waiting = 0;  ///< waiting for the clock, with a real_time_rate
  double total = 0;    ///< in AdvanceTo

  /// Times added up by block; `path` is the block's. Blocks of nested diagrams are listed separately.
  std::vector<Entry> Blocks() const;
  /// A table for a terminal: the parts, and the slowest blocks and calculations.
  std::string Text() const;
};

}  // namespace tenon
