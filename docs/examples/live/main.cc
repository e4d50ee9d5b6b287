// Shows a run in the browser: a cart that follows its goal, and a slider for the goal.
//
//     live_example        until Ctrl-C, at http://127.0.0.1:8080/ or the next free port
//     live_example 2      for 2 s

#include <tenon/systems/live/live_server.h>
#include <tenon/systems/simulation.h>

#include "../cart/cart.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>

// Values that are tuned in the browser are Parameters.
class Goal final : public tenon::LeafSystem<void> {
 public:
  tenon::Parameter<double> position{this, {"position", "m"}, 0.2, "goal of the cart"};
  tenon::OutputPort<double> goal{this, {"goal", "m"}, tenon::Uses(position), [](double x) { return x; }};
};

volatile std::sig_atomic_t interrupted = 0;

int main(int argc, char** argv) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  tenon::DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart", {.mass = 2});
  auto& pd = builder.Add<Pd>("pd");
  auto& goal = builder.Add<Goal>("goal");
  builder.Connect(cart.state, pd.x);
  builder.Connect(goal.goal, pd.ref);
  builder.Connect(pd.u, cart.force);
  tenon::Simulator simulator(builder.Build(), {.order = 3, .rtol = 1e-6});

  tenon::LiveServer live({.recording = "live.jsonl", .stop = [] { return interrupted != 0; }});
  std::printf("%s\n", live.url().c_str());
  std::fflush(stdout);
  live.Run(simulator,
           {.signals = {&cart.state, &goal.goal, &pd.u}, .shapes = {&cart.geometry}, .title = "cart"},
           argc > 1 ? std::optional(std::atof(argv[1])) : std::nullopt);
}
