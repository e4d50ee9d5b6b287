// Simulates a thousand pendulums of random length in two threads, for one second each.

#include <tenon/systems/campaign/campaign.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/simulation.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

/// A pendulum released at 0.1 rad: l a'' = -g sin a.
class Pendulum final : public tenon::LeafSystem<void> {
 public:
  tenon::Parameter<double> length{this, {"length", "m"}, 1.0};
  tenon::ContinuousState<tenon::Vec<2>> x{this, {"x", "rad, rad/s", "angle, rate"}, tenon::Vec<2>(0.1, 0)};
  tenon::OutputPort<tenon::Vec<2>> state{this, x};
  tenon::TimeDerivative<tenon::Vec<2>> dx{x, tenon::Uses(x, length),
                                          [](const tenon::Vec<2>& x, double length) {
                                            return tenon::Vec<2>(x[1], -9.81 / length * std::sin(x[0]));
                                          }};
};

int main() {
  tenon::DiagramBuilder builder;
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  const auto diagram = builder.Build();

  const auto runs = tenon::RunCampaign(
      *diagram, 1000, 2,
      [&](std::size_t run, tenon::Context& context) {
        context.Set(pendulum.length, tenon::RandomStream(run, "length").Uniform(0.5, 2));
      },
      [&](tenon::Simulator& simulator) {
        simulator.RunTo(1);
        return simulator.context().Eval(pendulum.state)[0];
      });

  std::vector<double> angles;
  for (const auto& run : runs) {
    if (run.figures) {
      angles.push_back(*run.figures);
    } else {
      std::printf("seed %lu: %s\n", static_cast<unsigned long>(run.seed), run.failure.c_str());
    }
  }
  std::ranges::sort(angles);
  std::printf("%zu runs, angles from %.3f to %.3f rad, median %.3f rad\n", angles.size(), angles.front(),
              angles.back(), angles[angles.size() / 2]);
  return angles.size() == runs.size() ? 0 : 1;
}
