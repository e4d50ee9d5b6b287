// Continues one run in two ways, and goes back to a saved instant.

#include "pendulum.h"

#include <cstdio>

int main() {
  tenon::DiagramBuilder builder;
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  tenon::Simulator simulator(builder.BuildWithOpenInputs());
  auto& context = simulator.context();
  context.Set(pendulum.torque, 0.0);
  simulator.RunTo(1);

  const auto moment = context.Save();  // bytes in memory; see SaveFile for a file
  tenon::Simulator other(context.Clone());
  other.context().Set(pendulum.torque, -2.0);
  other.RunTo(2);
  simulator.RunTo(2);
  const double first = context.Eval(pendulum.state)[0], second = other.context().Eval(pendulum.state)[0];

  context.Restore(moment);  // back to t = 1 s
  simulator.RunTo(2);
  const double again = context.Eval(pendulum.state)[0];
  std::printf("%.6f rad without torque, %.6f rad with it; from the snapshot %.6f rad\n", first, second,
              again);
  return first == again && first != second ? 0 : 1;
}
