#pragma once

#include <memory>
#include <string>
#include <vector>

namespace tenon {

/// Gives the thread that constructs it the conditions of real time, as far as the system permits, until it is
/// destroyed:
///
///     const RealTimeThread real_time;
///     Simulator simulator(diagram, {.real_time_rate = 1});
///     simulator.RunTo(60);
///
/// - SCHED_FIFO, a priority over all programs without one. Threads that the program has already started, such
///   as those of Cyclone DDS, get the priority below it; later ones have none.
/// - A processor that no other thread of the program uses. Other programs use it, too, unless Linux was
///   started with `isolcpus`.
/// - Memory that stays in RAM, which includes all that is allocated later.
///
/// A program has one such thread at a time.
class RealTimeThread {
 public:
  /// `processor` counts from the last one that the program may use: two programs on one machine give 0 and 1.
  explicit RealTimeThread(int processor = 0);
  ~RealTimeThread();
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;

  /// Returns what the system does not permit, each with the remedy.
  const std::vector<std::string>& refused() const { return refused_; }

 private:
  struct Before;
  std::unique_ptr<Before> before_;
  std::vector<std::string> refused_;
};

}  // namespace tenon
