#pragma once

#include <tenon/tests/testing/block_test.h>

namespace tenon {

/// A mass m on a frictionless rail: m a = force, state (position, velocity).
struct CartParams {
  double mass = 2;  // kg
  void Validate() const { Demand(mass > 0, "mass must be positive"); }
};
struct Cart final : LeafSystem<CartParams> {
  using LeafSystem::LeafSystem;
  InputPort<double> force{this, {"force", "N"}};
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  OutputPort<Vec<2>> state{this, x};
  TimeDerivative<Vec<2>> dx{
      x, Uses(x, force), [this](const Vec<2>& x, double force) { return Vec<2>(x[1], force / params.mass); }};
};

/// u = kp (ref - position) - kd velocity, sampled.
struct PdParams {
  double kp = 10;
  double kd = 2;
  Rate rate = Hz(1000);
};
struct Pd final : LeafSystem<PdParams> {
  using LeafSystem::LeafSystem;
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  InputPort<double> ref{this, {"ref", "m"}, 0.0};
  OutputPort<double> u{
      this, {"u", "N"}, Sampled{params.rate}, Uses(x, ref), [this](const Vec<2>& x, double ref) {
        return params.kp * (ref - x[0]) - params.kd * x[1];
      }};
};

/// A cart under a sampled PD controller.
struct PdLoop {
  explicit PdLoop(const PdParams& params = {}, const CartParams& cart_params = {})
      : cart(builder.Add<Cart>("cart", cart_params)), pd(builder.Add<Pd>("pd", params)) {
    builder.Connect(cart.state, pd.x);
    builder.Connect(pd.u, cart.force);
  }
  DiagramBuilder builder;
  Cart& cart;
  Pd& pd;
};

/// The harmonic oscillator q'' = -w² q + u from (1, 0): q = cos w t.
struct Oscillator final : LeafSystem<double> {
  explicit Oscillator(double frequency = 1) : LeafSystem(frequency) {}
  InputPort<double> u{this, "u", 0.0};
  ContinuousState<Vec<2>> x{this, {"x", "", "q, v"}, Vec<2>(1, 0)};
  OutputPort<Vec<2>> state{this, x};
  TimeDerivative<Vec<2>> dx{
      x, Uses(x, u), [this](const Vec<2>& x, double u) { return Vec<2>(x[1], -params * params * x[0] + u); }};
};

/// Prothero and Robinson: x' = -1e5 (x - cos t) - sin t from 1: x = cos t.
struct Stiff final : LeafSystem<void> {
  ContinuousState<double> x{this, "x", 1.0};
  OutputPort<double> state{this, x};
  TimeDerivative<double> dx{x, Uses(x, time),
                            [](double x, double t) { return -1e5 * (x - std::cos(t)) - std::sin(t); }};
};

/// The name of a method, for the names of tests.
inline const char* NameOf(Method method) {
  constexpr const char* kNames[] = {"Erk", "Dirk", "Bdf", "Adams", "Stabilized", "ErkOpen"};
  return kNames[static_cast<int>(method)];
}

/// Every adaptive method of the integrator.
inline constexpr Method kAllMethods[] = {Method::kErk, Method::kStabilized, Method::kDirk, Method::kBdf,
                                         Method::kAdams};

/// Connects a sampled force of 0: at each of its ticks the integrator starts again.
inline void AddRestarts(DiagramBuilder& builder, const std::string& name, Rate rate,
                        InputPort<double>& force) {
  builder.Connect(builder.AddFunction(name, Sampled{rate}, Uses(), [] { return 0.0; }), force);
}

/// y = f(u), not sampled.
struct Map final : LeafSystem<std::function<double(double)>> {
  explicit Map(std::function<double(double)> f) : LeafSystem(std::move(f)) {}
  InputPort<double> u{this, "u"};
  OutputPort<double> y{this, "y", Uses(u), &Map::Calc};

 private:
  double Calc(double u) const { return params(u); }
};

/// y = f(u), sampled.
struct SampledMapParams {
  std::function<double(double)> f;
  Sampled sampled{Hz(100)};
};
struct SampledMap final : LeafSystem<SampledMapParams> {
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, "u"};
  OutputPort<double> y{this, "y", params.sampled, Uses(u), [this](double u) { return params.f(u); }};
};

/// Counts its ticks: n += 1; shows the count before the update.
struct Counter final : LeafSystem<Sampled> {
  explicit Counter(Sampled sampled) : LeafSystem(sampled) {}
  DiscreteState<int> n{this, "n"};
  OutputPort<int> count{this, n};
  Update<int> next{n, params, Uses(n), [](int n) { return n + 1; }};
};

}  // namespace tenon
