// A compiled diagram may join equal calculations into one call and omit copies. Its values, messages and
// counts are those of calculations that run one by one; only its description shows the difference.

#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/concatenate.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::batched_ops_test {

/// The calculations of one evaluation of the derivatives, as Describe() lists them.
std::string AtEachStage(const Diagram& diagram) {
  const std::string text = diagram.Describe(), begin = "at each stage: ";
  const std::size_t at = text.find(begin);
  return at == std::string::npos ? ""
                                 : text.substr(at + begin.size(), text.find('\n', at) - at - begin.size());
}

Eigen::VectorXd Derivatives(Context& context, const Eigen::VectorXd& x) {
  Eigen::VectorXd xdot(x.size());
  context.CalcTimeDerivatives(0, x.data(), xdot.data());
  return xdot;
}

// ---- Copies ----

/// x'' = -4 x. The input of `speed` is computed, the input of `position` is a state.
struct Spring {
  Spring() {
    builder.Connect(speed.y, position.u);
    builder.Connect(position.y, gain.u);
    builder.Connect(gain.y, speed.u);
  }
  DiagramBuilder builder;
  Integrator<>& speed = builder.Add<Integrator<>>("speed", {.initial = 1});
  Integrator<>& position = builder.Add<Integrator<>>("position");
  Gain<>& gain = builder.Add<Gain<>>("gain", {.gain = -4});
};

TEST(BatchedOpsTest, WhatIsIntegratedAsItIsComputesIntoTheDerivative) {
  Spring spring;
  const auto diagram = spring.builder.Build();
  EXPECT_EQ(AtEachStage(*diagram), "gain.y, position.d/dt y");
  const auto context = diagram->CreateContext();
  EXPECT_EQ(Derivatives(*context, Eigen::Vector2d(2, 3)), Eigen::Vector2d(-12, 2));
  context->SetContinuousState(Eigen::Vector2d(2, 3));
  EXPECT_EQ(context->EvalTimeDerivatives(), Eigen::Vector2d(-12, 2));
  context->SetContinuousState(Eigen::Vector2d(5, 7));
  EXPECT_EQ(context->Eval(spring.speed.dx), -28);
  EXPECT_EQ(context->Eval(spring.position.dx), 5);
  EXPECT_EQ(std::as_const(*context).Eval(spring.gain.y), -28);
}

TEST(BatchedOpsTest, OneValueIntegratedTwiceIsCopiedOnce) {
  DiagramBuilder builder;
  auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return 3 + t; });
  auto& first = builder.Add<Integrator<>>("first");
  auto& second = builder.Add<Integrator<>>("second");
  builder.Connect(clock, first.u);
  builder.Connect(clock, second.u);
  const auto diagram = builder.Build();
  EXPECT_EQ(AtEachStage(*diagram), "clock.output, second.d/dt y");
  EXPECT_EQ(Derivatives(*diagram->CreateContext(), Eigen::Vector2d(1, 2)), Eigen::Vector2d(3, 3));
}

TEST(BatchedOpsTest, HeldValuesAreIntegratedToo) {
  DiagramBuilder builder;
  auto& constant = builder.Add<ConstantSource<double>>("constant", {.value = 5});
  auto& of_constant = builder.Add<Integrator<>>("of_constant");
  auto& sample =
      builder.AddFunction("sample", Sampled{Hz(10)}, Uses(builder.time), [](double t) { return 1 + t; });
  auto& of_sample = builder.Add<Integrator<>>("of_sample");
  auto& open = builder.Add<Integrator<>>("open");
  builder.Connect(constant.y, of_constant.u);
  builder.Connect(sample, of_sample.u);
  const auto diagram = builder.BuildWithOpenInputs();
  const auto context = diagram->CreateContext();
  context->Set(open.u, 7.0);
  EXPECT_TRUE(Throws<RunError>([&] { context->EvalTimeDerivatives(); }, "'sample.output'", "t = 0 s"));
  context->Set(sample, 6.0);
  EXPECT_EQ(context->EvalTimeDerivatives(), Eigen::Vector3d(5, 6, 7));

  Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
  simulator.context().Set(open.u, 7.0);
  simulator.RunTo(1);
  EXPECT_NEAR(simulator.context().Eval(of_constant.y), 5, 1e-12);
  EXPECT_NEAR(simulator.context().Eval(of_sample.y), 1.45, 1e-12);  // 0.1 (1 + 1.1 + ... + 1.9)
  EXPECT_NEAR(simulator.context().Eval(open.y), 7, 1e-12);
}

TEST(BatchedOpsTest, ARunGoesOnFromItsSnapshotBitForBit) {
  Spring spring;
  const auto diagram = spring.builder.Build();
  Simulator whole(*diagram), half(*diagram);
  whole.RunTo(0.5);
  half.RunTo(0.5);
  Simulator rest(diagram->CreateContext());
  rest.context().Restore(half.context().Save());
  Simulator cloned(half.context().Clone());
  for (Simulator* each : {&whole, &rest, &cloned}) each->RunTo(1);
  EXPECT_EQ(rest.context().Save(), whole.context().Save());
  EXPECT_EQ(cloned.context().Save(), whole.context().Save());
  EXPECT_EQ(rest.context().Eval(spring.gain.y), whole.context().Eval(spring.gain.y));
}

// ---- Runs of equal calculations ----

/// A ring of integrators: a map and a gain lead from each state to the next integrator.
struct Maps {
  Maps(int count, const std::function<double(int, double)>& f) {
    for (int i = 0; i < count; ++i) {
      const std::string number = std::to_string(i);
      states.push_back(&builder.Add<Integrator<>>("state" + number));
      maps.push_back(&builder.Add<Map>("map" + number, [f, i](double u) { return f(i, u); }));
      gains.push_back(&builder.Add<Gain<>>("gain" + number, {.gain = 2}));
      builder.Connect(states.back()->y, maps.back()->u);
      builder.Connect(maps.back()->y, gains.back()->u);
    }
    for (std::size_t i = 0; i < states.size(); ++i)
      builder.Connect(gains[i]->y, states[(i + 1) % states.size()]->u);
  }
  DiagramBuilder builder;
  std::vector<Integrator<>*> states;
  std::vector<Map*> maps;
  std::vector<Gain<>*> gains;
};

TEST(BatchedOpsTest, EqualCalculationsFollowOneAnother) {
  Maps maps(3, [](int i, double u) { return i + u; });
  const auto diagram = maps.builder.Build();
  EXPECT_EQ(AtEachStage(*diagram), "map0.y, map1.y, map2.y, gain0.y, gain1.y, gain2.y");
  EXPECT_EQ(Derivatives(*diagram->CreateContext(), Eigen::Vector3d(5, 7, 9)), Eigen::Vector3d(22, 10, 16));
}

/// An integrator and a chain of maps from its output back to its input.
struct ChainOfMaps {
  explicit ChainOfMaps(const std::function<double(int, double)>& f) {
    const OutputPort<double>* last = &state.y;
    for (int i = 0; i < 6; ++i) {
      maps.push_back(&builder.Add<Map>("map" + std::to_string(i), [f, i](double u) { return f(i, u); }));
      builder.Connect(*last, maps.back()->u);
      last = &maps.back()->y;
    }
    builder.Connect(*last, state.u);
  }
  DiagramBuilder builder;
  Integrator<>& state = builder.Add<Integrator<>>("state", {.initial = 1});
  std::vector<Map*> maps;
};

TEST(BatchedOpsTest, EachValueOfAChainCanBeRead) {
  int calls = 0;
  ChainOfMaps chain([&](int i, double u) {
    ++calls;
    return 10 * u + i;
  });
  const auto context = chain.builder.Build()->CreateContext();
  EXPECT_EQ(Derivatives(*context, Vec<1>(3))[0], 3012345);
  context->SetContinuousState(Vec<1>(2));
  EXPECT_EQ(context->EvalTimeDerivatives()[0], 2012345);
  EXPECT_EQ(calls, 12);
  const double expected[] = {20, 201, 2012, 20123, 201234, 2012345};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(std::as_const(*context).Eval(chain.maps[i]->y), expected[i]);
  EXPECT_EQ(calls, 12);
}

TEST(BatchedOpsTest, TheOneOfAChainThatFailsIsNamed) {
  ChainOfMaps chain([](int i, double u) {
    if (i == 4) throw std::runtime_error("it breaks");
    return u;
  });
  EXPECT_TRUE(
      Throws<RunError>([&] { Derivatives(*chain.builder.Build()->CreateContext(), Vec<1>(3)); }, "'map4.y'"));
}

TEST(BatchedOpsTest, AChainBesideOthersOfItsKind) {
  DiagramBuilder builder;
  auto& state = builder.Add<Integrator<>>("state");
  auto& aside = builder.Add<Integrator<>>("aside");
  const OutputPort<double>* last = &state.y;
  for (int i = 0; i < 5; ++i) {
    auto& gain = builder.Add<Gain<>>("gain" + std::to_string(i), GainParams{.gain = 2.0 + i});
    builder.Connect(*last, gain.u);
    last = &gain.y;
  }
  auto& other = builder.Add<Gain<>>("other", {.gain = -1});
  builder.Connect(state.y, other.u);
  builder.Connect(*last, state.u);
  builder.Connect(other.y, aside.u);
  const auto diagram = builder.Build();
  EXPECT_EQ(AtEachStage(*diagram), "gain0.y, other.y, gain1.y, gain2.y, gain3.y, gain4.y");
  EXPECT_EQ(Derivatives(*diagram->CreateContext(), Eigen::Vector2d(3, 0)), Eigen::Vector2d(2160, -3));
}

TEST(BatchedOpsTest, ListsOfDifferentLengths) {
  DiagramBuilder builder;
  auto& states = builder.Add<Integrator<Vec<3>>>("states", {.initial = {1, 2, 3}});
  auto& parts = builder.Add<Demux<3>>("parts");
  auto& two = builder.Add<Adder<>>("two", {.weights = {2, 3}});
  auto& three = builder.Add<Adder<>>("three", {.weights = {1, 10, 100}});
  auto& one = builder.Add<Adder<>>("one", {.weights = {-1}});
  auto& join = builder.Add<Mux<3>>("join");
  builder.Connect(states.y, parts.u);
  for (std::size_t i = 0; i < 3; ++i) builder.Connect(parts.y[i], three.u[i]);
  builder.Connect(parts.y[0], two.u[1]);
  builder.Connect(parts.y[2], two.u[0]);
  builder.Connect(parts.y[1], one.u[0]);
  builder.Connect(two.y, join.u[0]);
  builder.Connect(three.y, join.u[1]);
  builder.Connect(one.y, join.u[2]);
  builder.Connect(join.y, states.u);
  const auto diagram = builder.Build();
  EXPECT_EQ(AtEachStage(*diagram), "parts.y_0, parts.y_1, parts.y_2, one.y, two.y, three.y, join.y");
  EXPECT_EQ(Derivatives(*diagram->CreateContext(), Eigen::Vector3d(4, 5, 6)), Eigen::Vector3d(24, 654, -5));
}

TEST(BatchedOpsTest, TheOneThatFailsIsNamed) {
  int fails = -1;
  Maps maps(3, [&](int i, double u) {
    if (i == fails) throw std::runtime_error("it is tired");
    return u;
  });
  const auto diagram = maps.builder.Build();
  for (fails = 0; fails < 3; ++fails) {
    const std::string path = "'map" + std::to_string(fails) + ".y' failed at t = 0 s: it is tired";
    const auto context = diagram->CreateContext();
    EXPECT_TRUE(Throws<RunError>([&] { Derivatives(*context, Eigen::Vector3d::Zero()); }, path));
    EXPECT_TRUE(Throws<RunError>([&] { context->EvalTimeDerivatives(); }, path));
    EXPECT_TRUE(
        Throws<RunError>([&] { context->Eval(maps.maps[static_cast<std::size_t>(fails)]->y); }, path));
    for (const bool profile : {false, true})
      EXPECT_TRUE(Throws<RunError>([&] { Simulator(diagram, {.profile = profile}).RunTo(1); }, path));
  }
}

TEST(BatchedOpsTest, TheOneThatIsNotFiniteIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Maps maps(3, [=](int i, double u) { return i == 1 ? nan : u; });
  EXPECT_TRUE(Throws<RunError>([&] { Simulator(maps.builder.Build()).RunTo(1); }, "'map1.y'"));
}

TEST(BatchedOpsTest, WhatIsFreshIsNotComputedAgain) {
  std::vector<int> calls(3, 0);
  Maps maps(3, [&](int i, double u) {
    ++calls[static_cast<std::size_t>(i)];
    return u;
  });
  const auto context = maps.builder.Build()->CreateContext();
  context->Eval(maps.maps[1]->y);
  context->EvalTimeDerivatives();
  EXPECT_EQ(calls, (std::vector<int>{1, 1, 1}));
  context->EvalTimeDerivatives();
  EXPECT_EQ(calls, (std::vector<int>{1, 1, 1}));
  context->Eval(maps.maps[2]->y);
  context->Set(maps.states[0]->x, 1.0);
  context->EvalTimeDerivatives();
  EXPECT_EQ(calls, (std::vector<int>{2, 2, 2}));
}

TEST(BatchedOpsTest, EachCountsForItselfInAProfile) {
  Maps maps(3, [](int, double u) { return -u; });
  Simulator simulator(maps.builder.Build(), {.profile = true});
  simulator.RunTo(1);
  const auto calculations = simulator.Profile().calculations;
  EXPECT_EQ(calculations.size(), 6);
  for (const auto& each : calculations) {
    EXPECT_GE(each.calls, simulator.statistics().evaluations) << each.path;
    EXPECT_EQ(each.calls, calculations[0].calls) << each.path;
  }
}

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
    EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(3); }), 0);
    EXPECT_GT(simulator.context().Eval(everything.crossings), 8);
    EXPECT_EQ(simulator.context().Eval(everything.steps), simulator.statistics().steps);
    EXPECT_EQ(log->rows(), 301);
  }
}

}  // namespace tenon::batched_ops_test
