// Connects a cart, a digital PD controller and a reference to a diagram and simulates it.

#include <tenon/systems/report/report.h>
#include <tenon/systems/simulation.h>

#include "cart.h"

#include <cstdio>

int main() {
  tenon::DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart", {.mass = 2});
  auto& pd = builder.Add<Pd>("pd");
  auto& ref = builder.AddFunction({"ref", "m"}, tenon::Uses(builder.time),
                                  [](double t) { return t < 1 ? 0.0 : 0.2; });
  builder.Connect(cart.state, pd.x);
  builder.Connect(ref, pd.ref);
  builder.Connect(pd.u, cart.force);
  const auto diagram = builder.Build();

  tenon::Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
  const auto log = simulator.AddLog(tenon::Hz(2), {&cart.state, &pd.u});
  tenon::Report report({.title = "A cart under a digital PD controller"});
  report.Log(simulator, {&cart.state, &ref, &pd.u}, {&cart.geometry});
  simulator.RunTo(10);
  report.Write("cart.html");

  for (std::size_t i = 0; i < log->rows(); ++i) {
    std::printf("t = %4.1f s   x = %6.4f m   u = %7.4f N\n", log->row(i)[0], log->row(i)[1], log->row(i)[3]);
  }
}
