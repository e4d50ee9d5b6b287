// Members that hold or compute values, one block for each; the results are compared with closed forms.

#include <tenon/systems/block.h>
#include <tenon/tests/testing/test_rig.h>

#include "near.h"

#include <algorithm>
#include <cmath>
#include <vector>

using namespace tenon;

// A cup of coffee cools: T' = (ambient - T) / 300 s.
class Cup final : public LeafSystem<void> {
 public:
  InputPort<double> ambient{this, {"ambient", "degC"}};
  ContinuousState<double> T{this, {"T", "degC"}, 90};
  TimeDerivative<double> dT{T, Uses(T, ambient),
                            [](double T, double ambient) { return (ambient - T) / 300; }};
  OutputPort<double> temperature{this, {"temperature"}, T};
};

bool CheckContinuousState() {
  TestRig<Cup> rig;
  rig.Fix(rig->ambient, 20).RunTo(300);
  return Near("ContinuousState", rig[rig->temperature], 20 + 70 * std::exp(-1));
}

// An exponential average at 10 Hz: mean[k + 1] = 0.9 mean[k] + 0.1 u[k].
class Average final : public LeafSystem<void> {
 public:
  InputPort<double> u{this, {"u", "N"}};
  DiscreteState<double> mean{this, {"mean", "N"}};
  Update<double> next{mean, Sampled{Hz(10)}, Uses(mean, u),
                      [](double mean, double u) { return 0.9 * mean + 0.1 * u; }};
  OutputPort<double> y{this, {"y"}, mean};
};

bool CheckDiscreteState() {
  TestRig<Average> rig;
  rig.Fix(rig->u, 5).RunTo(1);  // 11 ticks: 0, 0.1, …, 1 s
  return Near("DiscreteState", rig[rig->y], 5 * (1 - std::pow(0.9, 11)));
}

struct SpringParams {
  double stiffness = 4;  // N/m
  void Validate() const { Demand(stiffness > 0, "stiffness must be positive"); }
};
// A spring whose stiffness can be changed during a run.
class Spring final : public LeafSystem<SpringParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<double> x{this, {"x", "m"}};
  Parameter<double> stiffness{this, {"stiffness", "N/m"}, params.stiffness, "force per length"};
  OutputPort<double> force{
      this, {"force", "N"}, Uses(stiffness, x), [](double k, double x) { return -k * x; }};
};

bool CheckParameter() {
  TestRig<Spring> rig;
  rig.Fix(rig->x, 2).RunTo(1);
  rig.context().Set(rig->stiffness, 7);
  return Near("Parameter", rig[rig->force], -7 * 2);
}

// A pendulum of 1 m. Its derivative and its energy use the place of the bob.
class Pendulum final : public LeafSystem<void> {
 public:
  ContinuousState<Vec<2>> x{this, {"x", "rad, rad/s", "angle, rate"}, Vec<2>(1, 0)};
  Shared<Vec<2>> bob{this, "bob", Uses(x),
                     [](const Vec<2>& x) { return Vec<2>(std::sin(x[0]), -std::cos(x[0])); }};
  TimeDerivative<Vec<2>> dx{x, Uses(x, bob),
                            [](const Vec<2>& x, const Vec<2>& bob) { return Vec<2>(x[1], -9.81 * bob[0]); }};
  OutputPort<double> energy{this, {"energy", "J/kg"}, Uses(x, bob), [](const Vec<2>& x, const Vec<2>& bob) {
                              return 0.5 * x[1] * x[1] + 9.81 * bob[1];
                            }};
};

bool CheckShared() {
  TestRig<Pendulum> rig;
  rig.RunTo(5);
  return Near("Shared", rig[rig->energy], -9.81 * std::cos(1));
}

struct LargestParams {
  std::size_t count = 2;
};
// The largest of any number of forces.
class Largest final : public LeafSystem<LargestParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPorts<double> u{this, {"u", "N"}, params.count};
  OutputPort<double> y{this, {"y", "N"}, Uses(u), [](const Inputs<double>& u) {
                         double largest = u[0];
                         for (std::size_t i = 1; i < u.size(); ++i) largest = std::max(largest, u[i]);
                         return largest;
                       }};
};

bool CheckInputPorts() {
  TestRig<Largest> rig({.count = 3});
  rig.Fix(rig->u[0], 1).Fix(rig->u[1], 7).Fix(rig->u[2], 5);
  return Near("InputPorts", rig[rig->y], 7);
}

// Kepler's equation E - 0.5 sin E = M by one Newton step per tick, which begins at the last result.
class Kepler final : public LeafSystem<void> {
 public:
  InputPort<double> M{this, {"M", "rad"}};
  Scratch<double> last{this, "last"};
  OutputPort<double> E{this, {"E", "rad"}, Sampled{Hz(100)}, Uses(M, last), [](double M, double& last) {
                         return last -= (last - 0.5 * std::sin(last) - M) / (1 - 0.5 * std::cos(last));
                       }};
};

bool CheckScratch() {
  TestRig<Kepler> rig;
  rig.Fix(rig->M, 2 - 0.5 * std::sin(2)).RunTo(0.1);
  return Near("Scratch", rig[rig->E], 2);
}

// The median of five readings, sorted in memory that is allocated once per context.
class Median final : public LeafSystem<void> {
 public:
  InputPort<Vec<5>> u{this, {"u", "m"}};
  Workspace<std::vector<double>> sorted{this, "sorted", std::vector<double>(5)};
  OutputPort<double> y{this, {"y", "m"}, Uses(u, sorted), [](const Vec<5>& u, std::vector<double>& sorted) {
                         sorted.assign(u.begin(), u.end());
                         std::nth_element(sorted.begin(), sorted.begin() + 2, sorted.end());
                         return sorted[2];
                       }};
};

bool CheckWorkspace() {
  TestRig<Median> rig;
  rig.Fix(rig->u, Vec<5>(3, 9, 1, 4, 8));
  return Near("Workspace", rig[rig->y], 4);
}

// White noise of deviation 0.1 m at 100 Hz.
class Noise final : public LeafSystem<void> {
 public:
  Random random{this, "random"};
  OutputPort<double> y{this, {"y", "m"}, Sampled{Hz(100)}, Uses(random), [](RandomStream& random) {
                         return 0.1 * random.Normal();
                       }};
};

bool CheckRandom() {
  TestRig<Noise> rig;
  rig.Tick();
  return Near("Random", rig[rig->y], 0.1 * RandomStream(0, "block.random").Normal());
}

int main() {
  const bool good[] = {CheckContinuousState(), CheckDiscreteState(), CheckParameter(), CheckShared(),
                       CheckInputPorts(),      CheckScratch(),       CheckWorkspace(), CheckRandom()};
  return std::ranges::find(good, false) == std::end(good) ? 0 : 1;
}
