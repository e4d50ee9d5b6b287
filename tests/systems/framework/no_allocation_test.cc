#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::no_allocation_test {

/// Continuous and discrete states, two rates, noise, scratch, a witness, monitors and updates after each
/// step.
struct Everything final : LeafSystem<void> {
  InputPort<Vec<2>> x{this, "x"};
  Random random{this, "random"};
  Scratch<Eigen::VectorXd> warm{this, "warm", Eigen::VectorXd::Zero(4)};
  Shared<double> energy{this, "energy", Uses(x), [](const Vec<2>& x) { return x.squaredNorm(); }};
  OutputPort<double> u{this, "u", Sampled{Hz(200)}, Uses(x, energy, random, warm),
                       [](const Vec<2>& x, double e, RandomStream& r, Eigen::VectorXd& w) {
                         w.array() += x[0];
                         return 1e-6 * (r.Normal() + w.sum() + e) - 0.1 * x[1];
                       }};
  OutputPort<Eigen::VectorXd> list{this,
                                   "list",
                                   Eigen::VectorXd::Zero(3),
                                   Sampled{Hz(50)},
                                   Uses(x),
                                   [](const Vec<2>& x, Eigen::VectorXd* out) { out->setConstant(x[0]); }};
  DiscreteState<Eigen::VectorXd> last{this, "last", Eigen::VectorXd::Zero(3)};
  Update<Eigen::VectorXd> keep{last, Sampled{Hz(50)}, Uses(last),
                               [](const Eigen::VectorXd& last, Eigen::VectorXd* out) { *out = last; }};
  DiscreteState<int> crossings{this, "crossings"};
  Witness zero{this, "zero", Crossing::kBoth, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Update<int> count{crossings, zero, Uses(crossings), [](int n) { return n + 1; }};
  DiscreteState<int> steps{this, "steps"};
  Update<int> step{steps, EachStep{}, Uses(steps), [](int n) { return n + 1; }};
  Monitor sampled_monitor{this, "sampled_monitor", Sampled{Hz(10)}, Uses(x), &Everything::Check};
  Monitor step_monitor{this, "step_monitor", EachStep{}, Uses(x), &Everything::Check};

 private:
  Verdict Check(const Vec<2>& x) const { return x.norm() > 100 ? Verdict("far away") : Verdict(); }
};

/// Explicit methods only: with the implicit ones, SUNDIALS allocates for each Jacobian.
TEST(NoAllocationTest, RunningAllocatesNothing) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  DiagramBuilder builder;
  auto& plant = builder.Add<Oscillator>("plant", 10.0);
  auto& everything = builder.Add<Everything>("everything");
  builder.Connect(plant.state, everything.x);
  builder.Connect(everything.u, plant.u);
  const auto diagram = builder.Build();
  for (const int order : {2, 3, 4, 5}) {
    Simulator simulator(*diagram, {.order = order, .rtol = 1e-4});
    const auto log = simulator.AddLog(Hz(100), {&plant.state, &everything.u, &everything.list});
    log->Reserve(1000);
    simulator.RunTo(0.5);
    {
      AllocationGuard guard;
      simulator.RunTo(3);
      EXPECT_EQ(guard.count(), 0);
    }
    EXPECT_GT(simulator.context().Eval(everything.crossings), 8);
    EXPECT_EQ(simulator.context().Eval(everything.steps), simulator.statistics().steps);
    EXPECT_EQ(log->rows(), 301);
  }
}

}  // namespace tenon::no_allocation_test
