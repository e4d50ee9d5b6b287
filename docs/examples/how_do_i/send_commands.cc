// Sends commands from another thread during a run, then repeats the run from a recording.

#include <tenon/systems/io/external_input.h>

#include "pendulum.h"

#include <cstdio>
#include <thread>

using Input = tenon::ExternalInput<double>;

/// Returns the angle of the pendulum after one second with the torques that `send` puts in.
template <class Send>
std::pair<double, tenon::Recording<double>> Run(tenon::ExternalInputParams<double> params, Send send) {
  tenon::DiagramBuilder builder;
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  auto& torque = builder.Add<Input>("torque", std::move(params));
  builder.Connect(torque.y, pendulum.torque);
  tenon::Simulator simulator(builder.Build(), {.real_time_rate = 10});
  std::thread sender([&] { send(torque); });
  simulator.RunTo(1);
  sender.join();
  return {simulator.context().Eval(pendulum.state)[0], simulator.context().Eval(torque.taken).recording};
}

int main() {
  const auto [live, recording] =
      Run({.rate = tenon::Hz(100), .unit = "N m", .record = true}, [](Input& torque) {
        for (int i = 0; i < 100; ++i) torque.Put(-0.02 * i);  // from a window, a joystick or a planner
      });
  const auto [again, unused] =
      Run({.rate = tenon::Hz(100), .unit = "N m", .replay = recording}, [](Input&) {});
  std::printf("%zu values were taken over; the angle is %.6f rad, and %.6f rad again\n", recording.size(),
              live, again);
  return live == again ? 0 : 1;
}
