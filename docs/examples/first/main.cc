#include <tenon/systems/simulation.h>

#include <cstdio>

struct CartParams {
  double mass = 2;  // kg
  void Validate() const { tenon::Demand(mass > 0, "mass must be positive"); }
};

// A cart on a rail: x = (position, velocity), dx/dt = (velocity, force / mass).
class Cart final : public tenon::LeafSystem<CartParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<double> force{this, {"force", "N"}};
  tenon::ContinuousState<tenon::Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  tenon::OutputPort<tenon::Vec<2>> state{this, x};
  tenon::TimeDerivative<tenon::Vec<2>> dx{x, tenon::Uses(x, force), &Cart::CalcDx};

 private:
  tenon::Vec<2> CalcDx(const tenon::Vec<2>& x, double force) const { return {x[1], force / params.mass}; }
};

struct PdParams {
  double kp = 10;  // N/m
  double kd = 6;   // N s/m
  tenon::Rate rate = tenon::Hz(1000);
};

// u = kp (ref - position) - kd velocity, computed at its rate and held between.
class Pd final : public tenon::LeafSystem<PdParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  tenon::InputPort<double> ref{this, {"ref", "m"}};
  tenon::OutputPort<double> u{this, {"u", "N"}, tenon::Sampled{params.rate}, tenon::Uses(x, ref), &Pd::CalcU};

 private:
  double CalcU(const tenon::Vec<2>& x, double ref) const {
    return params.kp * (ref - x[0]) - params.kd * x[1];
  }
};

int main() {
  tenon::DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart", {.mass = 2});
  auto& pd = builder.Add<Pd>("pd");
  auto& ref = builder.AddFunction({"ref", "m"}, tenon::Uses(builder.time),
                                  [](double t) { return t < 1 ? 0.0 : 0.2; });
  builder.Connect(cart.state, pd.x);  // does not compile if the types differ
  builder.Connect(ref, pd.ref);
  builder.Connect(pd.u, cart.force);
  const auto diagram = builder.Build();  // names unconnected inputs and every hop of an algebraic loop

  tenon::Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
  const auto log = simulator.AddLog(tenon::Hz(2), {&cart.state, &pd.u});
  simulator.RunTo(10);
  for (std::size_t i = 0; i < log->rows(); ++i) {
    std::printf("t = %4.1f s   x = %6.4f m   u = %7.4f N\n", log->row(i)[0], log->row(i)[1], log->row(i)[3]);
  }
}
