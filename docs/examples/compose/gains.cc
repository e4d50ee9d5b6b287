// Changes gains, which are values of a context, in the middle of a run, and runs 1000 variants of one diagram
// in two threads.

#include <tenon/systems/simulation.h>

#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

struct SpringParams {
  double stiffness = 100;  // N/m
  double damping = 1;      // N s/m
  double mass = 1;         // kg
  void Validate() const {
    tenon::Demand(stiffness >= 0 && damping >= 0, "stiffness and damping must not be negative");
  }
};
class Spring final : public tenon::LeafSystem<SpringParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::Parameter<double> stiffness{this, {"stiffness", "N/m"}, params.stiffness};
  tenon::Parameter<double> damping{this, {"damping", "N s/m"}, params.damping};
  tenon::ContinuousState<tenon::Vec<2>> x{this, {"x", "m, m/s", "position, speed"}, tenon::Vec<2>(1, 0)};
  tenon::OutputPort<tenon::Vec<2>> state{this, x};

 private:
  tenon::TimeDerivative<tenon::Vec<2>> dx_{x, tenon::Uses(x, stiffness, damping),
                                           [this](const tenon::Vec<2>& x, double k, double d) {
                                             return tenon::Vec<2>(x[1], -(k * x[0] + d * x[1]) / params.mass);
                                           }};
};

/// Returns the position after five seconds with this damping.
double End(const tenon::Diagram& diagram, const Spring& spring, double damping) {
  auto context = diagram.CreateContext();
  context->Set(spring.damping, damping);
  tenon::Simulator simulator(std::move(context));
  simulator.RunTo(5);
  return simulator.context().Eval(spring.state)[0];
}

/// Returns the position after five seconds of a diagram that is built with this damping.
double EndBuiltAnew(double damping) {
  tenon::DiagramBuilder builder;
  auto& spring = builder.Add<Spring>("spring", {.damping = damping});
  tenon::Simulator simulator(builder.Build());
  simulator.RunTo(5);
  return simulator.context().Eval(spring.state)[0];
}

int main() {
  tenon::DiagramBuilder builder;
  auto& spring = builder.Add<Spring>("spring", {.damping = 0.2});
  const auto diagram = builder.Build();

  tenon::Simulator simulator(diagram);
  simulator.RunTo(2);
  simulator.context().Set(spring.damping, 20);  // holds for the rest of the run
  simulator.RunTo(4);
  std::printf("damped from 2 s on: x = %.1e m\n", simulator.context().Eval(spring.state)[0]);
  try {
    simulator.context().Set(spring.damping, -1);
  } catch (const tenon::ParameterError& error) {
    std::printf("refused: %s\n", error.what());
  }

  constexpr std::size_t kRuns = 1000;
  std::vector<double> ends(kRuns);
  const auto run = [&](std::size_t begin) {
    for (std::size_t i = begin; i < kRuns; i += 2)
      ends[i] = End(*diagram, spring, 0.01 * static_cast<double>(i));
  };
  std::thread odd(run, 1);
  run(0);
  odd.join();
  std::size_t best = 0, same = 0;
  for (std::size_t i = 0; i < kRuns; ++i) {
    if (std::abs(ends[i]) < std::abs(ends[best])) best = i;
    if (ends[i] == EndBuiltAnew(0.01 * static_cast<double>(i))) ++same;
  }
  std::printf("of %zu dampings, %.2f N s/m leaves the smallest deviation: %.1e m\n", kRuns,
              0.01 * static_cast<double>(best), ends[best]);
  std::printf("%zu results are bit by bit those of new diagrams\n", same);
  return same == kRuns ? 0 : 1;
}
