#include <tenon/systems/simulation.h>

#include "foreign_filter.h"

#include <cstdio>

int main() {
  tenon::DiagramBuilder builder;
  auto& filter = builder.Add<ForeignFilter>("filter");
  builder.Connect(builder.AddFunction("step", tenon::Uses(builder.time), [](double) { return 1.0; }),
                  filter.u);
  tenon::Simulator simulator(builder.Build());

  simulator.RunTo(0.1);
  const auto saved = simulator.context().Save();
  simulator.RunTo(0.3);
  const double first = simulator.context().Eval(filter.y);

  simulator.context().Restore(saved);
  simulator.RunTo(0.3);
  const double again = simulator.context().Eval(filter.y);
  std::printf("y = %.6f, after going back %.6f: %s\n", first, again,
              first == again ? "the same" : "different");
  return first == again ? 0 : 1;
}
