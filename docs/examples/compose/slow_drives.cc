// Adds a delay of 3 ms and a low-pass filter of 40 Hz to the drives of the shipped walking robot.

#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/sample_delay.h>

#include "walk.h"

#include <numbers>

int main() {
  using Torque = tenon::Vec<12>;
  constexpr double kLag = 1 / (2 * std::numbers::pi * 40);  // s

  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", TrotParams());
  auto& delay = builder.Add<tenon::SampleDelay<Torque>>("delay", {.samples = 3, .unit = "N m"});
  auto& lag = builder.Add<tenon::LowPassFilter<Torque>>("lag", {.time_constant = kLag, .unit = "N m"});
  builder.Insert(loop.locomotion.torque, delay.u, delay.y);
  builder.Insert(delay.y, lag.u, lag.y);

  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  return WalkFor(3, simulator, loop);
}
