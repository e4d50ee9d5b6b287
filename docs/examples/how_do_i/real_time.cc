// Paces a run to the clock, here at twice its speed, and prints how many ticks were late.

#include "pendulum.h"

#include <chrono>
#include <cstdio>

/// A block with effects outside, such as sending the angle to a screen. Here it counts its calls.
class Screen final : public tenon::LeafSystem<void> {
 public:
  explicit Screen(int* sent) : sent_(sent) {}
  tenon::InputPort<tenon::Vec<2>> state{this, {"state", "rad, rad/s"}};
  tenon::Publish send{this, "send", tenon::Sampled{tenon::Hz(50)}, tenon::Uses(state),
                      [this](const tenon::Vec<2>&) { ++*sent_; }};

 private:
  int* sent_;
};

int main() {
  int sent = 0;
  tenon::DiagramBuilder builder;
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  builder.Connect(pendulum.state, builder.Add<Screen>("screen", &sent).state);
  tenon::Simulator simulator(builder.Build(), {.real_time_rate = 2, .late_tolerance = 0.01});

  const auto begin = std::chrono::steady_clock::now();
  simulator.RunTo(0.5);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  std::printf("0.5 s took %.3f s on the clock; %d sent, %ld of %ld ticks late, at worst by %.1f ms\n",
              wall.count(), sent, simulator.real_time().missed, simulator.real_time().ticks,
              1000 * simulator.real_time().worst_lateness);
  return wall.count() >= 0.25 && sent == 26 ? 0 : 1;
}
