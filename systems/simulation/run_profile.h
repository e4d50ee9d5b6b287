#pragma once

#include <string>
#include <vector>

namespace tenon {

/// Where the time of a run went, of a simulator with `.profile = true`. All times are wall-clock seconds; the
/// parts sum up to `total`.
struct RunProfile {
  struct Entry {
    std::string path;  ///< of the calculation: "loop.pd.u", "loop.cart.d/dt x"
    long calls = 0;
    double seconds = 0;
  };
  std::vector<Entry> calculations;  ///< the longest first
  double integrator = 0;            ///< SUNDIALS and what surrounds it, without the calculations
  double logs = 0;
  double ticks = 0;    ///< schedule, updates, checks
  double waiting = 0;  ///< for the clock, with a real_time_rate
  double total = 0;    ///< inside of AdvanceTo

  /// The same by block, nested diagrams left apart: `path` is that of the block.
  std::vector<Entry> Blocks() const;
  /// A table for a terminal: the parts, the blocks and the calculations that take most.
  std::string Text() const;
};

}  // namespace tenon
