// A planner that needs 25 ms for a plan: a cart follows a moving target by the cubic that meets it after
// 0.2 s. Slow makes the plan late; `age` says how old the plan is, by which the follower moves on along it.
#include <tenon/systems/io/slow.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/simulation.h>

#include <cmath>
#include <cstdio>

using tenon::Uses, tenon::Vec;

struct PlannerParams {
  double horizon = 0.2;  // s
};
class Planner : public tenon::LeafSystem<PlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  tenon::InputPort<Vec<2>> target{this, {"target", "m, m/s"}};
  // Acceleration and jerk at the time of the inputs.
  tenon::OutputPort<Vec<2>> plan{
      this,
      {"plan", "m/s^2, m/s^3"},
      tenon::Sampled{tenon::Hz(100)},
      Uses(x, target),
      [this](const Vec<2>& from, const Vec<2>& to) -> Vec<2> {
        const double T = params.horizon;
        const double p = to[0] + T * to[1] - from[0] - T * from[1], v = to[1] - from[1];
        return {6 * p / (T * T) - 2 * v / T, 6 * v / (T * T) - 12 * p / (T * T * T)};
      }};
};
using SlowPlanner = tenon::Slow<Planner, &Planner::plan>;

int main() {
  for (const double time : {0.0, 0.01, 0.025}) {
    tenon::DiagramBuilder builder;
    auto& planner = builder.Add<SlowPlanner>("planner", {.slow = {.time = time}});
    auto& cart = builder.Add<tenon::Integrator<Vec<2>>>("cart", {.initial = Vec<2>(1, 0)});
    auto& target = builder.AddFunction("target", Uses(builder.time),
                                       [](double t) { return Vec<2>(std::sin(t), std::cos(t)); });
    auto& rate = builder.AddFunction("rate", Uses(cart.y, planner.plan, planner.age),
                                     [](const Vec<2>& x, const Vec<2>& plan, double age) {
                                       return Vec<2>(x[1], plan[0] + age * plan[1]);
                                     });
    builder.Connect(cart.y, planner.x);
    builder.Connect(target, planner.target);
    builder.Connect(rate, cart.u);
    tenon::Simulator simulator(builder.Build());
    simulator.RunTo(5);
    std::printf("%3.0f ms: error %.4f m, age of the plan %.0f ms\n", 1e3 * time,
                std::abs(simulator.context().Eval(cart.y)[0] - std::sin(5)),
                1e3 * simulator.context().Eval(planner.age));
  }
}
