#include "tenon/systems/simulator.h"

#include <gtest/gtest.h>

#include "tenon/systems/diagram.h"

namespace tenon {
namespace {

struct CartParams {
  double mass = 2;
  void Validate() const { Demand(mass > 0, "mass must be positive"); }
};
class Cart final : public LeafSystem<CartParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<double> force{this, {"force", "N"}};
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  OutputPort<Vec<2>> state{this, x};
  TimeDerivative<Vec<2>> dx{x, Uses(x, force), &Cart::CalcDx};

 private:
  Vec<2> CalcDx(const Vec<2>& x, const double& force) const { return {x[1], force / params.mass}; }
};

struct PdParams {
  double kp = 10;
  double kd = 2;
  Rate rate = Hz(1000);
};
class Pd final : public LeafSystem<PdParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  InputPort<double> ref{this, {"ref", "m"}};
  OutputPort<double> u{this, {"u", "N"}, Sampled{params.rate}, Uses(x, ref), &Pd::CalcU};

 private:
  double CalcU(const Vec<2>& x, double ref) const { return params.kp * (ref - x[0]) - params.kd * x[1]; }
};

TEST(SimulatorTest, ClosesALoop) {
  DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart", CartParams{.mass = 2});
  auto& pd = builder.Add<Pd>("pd");
  auto& ref = builder.AddFunction("ref", Uses(builder.time), [](double t) { return t < 1 ? 0.0 : 0.2; });
  builder.Connect(cart.state, pd.x);
  builder.Connect(ref, pd.ref);
  builder.Connect(pd.u, cart.force);
  auto diagram = builder.Build();
  Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
  auto log = simulator.AddLog(Hz(100), {&cart.state, &pd.u});
  simulator.AdvanceTo(20);
  EXPECT_NEAR(simulator.context().Eval(cart.state)[0], 0.2, 1e-4);
  EXPECT_EQ(log->rows(), 2001);
  for (auto& n : log->names()) std::cout << n << "\n";
  std::cout << simulator.statistics().steps << " " << simulator.statistics().evaluations << "\n";
}

}  // namespace
}  // namespace tenon
