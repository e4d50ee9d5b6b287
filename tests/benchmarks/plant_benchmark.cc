// What the quadruped costs (DogBot), with medians and 99th percentiles over blocks of 20 calls as counters.
//
//   accelerations/simbody   one evaluation of all derivatives of QuadrupedPlant: contact, kinematics,
//   dynamics model/eigen             QuadrupedModel::Calc: everything that controllers need of one state
//   model/decoupled         the decoupled form on top of it
//   model/simbody           the same quantities as model/eigen from Simbody's operators

#include <benchmark/benchmark.h>
#include <tenon/plants/simbody.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <vector>

#include "tenon/plants/description/quadruped_model.h"
#include "tenon/plants/quadruped_plant.h"
#include "tenon/systems/simulator.h"
#include "tenon/tests/plants/quadruped_simbody.h"
#include "tenon/tests/plants/quadruped_test_robot.h"

namespace tenon {
namespace {

/// Runs `call` with another one of a thousand states each time, and counts.
template <class Call>
void Measure(benchmark::State& state, const Call& call) {
  using Clock = std::chrono::steady_clock;
  constexpr int kBlock = 20;
  RandomStream random(41);
  std::vector<LeggedState> states;
  const LeggedState stance = test::Standing(test::DogBot());
  for (int i = 0; i < 1000; ++i) {
    LeggedState x = stance;
    x.q += test::RandomVector<12>(random, 0.1);
    x.qd = test::RandomVector<12>(random, 1);
    states.push_back(x);
  }
  std::vector<double> ns;
  std::size_t next = 0;
  for (auto _ : state) {
    const auto start = Clock::now();
    for (int i = 0; i < kBlock; ++i) call(states[next++ % states.size()]);
    ns.push_back(std::chrono::duration<double, std::nano>(Clock::now() - start).count() / kBlock);
  }
  std::sort(ns.begin(), ns.end());
  state.counters["median_ns"] = ns[ns.size() / 2];
  state.counters["p99_ns"] = ns[ns.size() * 99 / 100];
}

void Accelerations(benchmark::State& state) {
  QuadrupedPlantParams params;
  params.robot = test::DogBot();
  params.initial = test::Standing(params.robot);
  DiagramBuilder builder;
  auto& plant = builder.Add<QuadrupedPlant>("plant", params);
  const auto diagram = builder.BuildWithOpenInputs();
  Simulator simulator(*diagram, {});
  Context& context = simulator.context();
  context.Set(plant.torque, Vec<12>::Constant(1));
  Measure(state, [&](const LeggedState& x) {
    context.Set(plant.motion, x);
    benchmark::DoNotOptimize(context.EvalTimeDerivatives());
  });
}
BENCHMARK(Accelerations)->Name("accelerations/simbody");

void Model(benchmark::State& state) {
  const QuadrupedModel model(test::DogBot());
  QuadrupedDynamics dynamics;
  Measure(state, [&](const LeggedState& x) {
    model.Calc(x, &dynamics);
    benchmark::DoNotOptimize(dynamics);
  });
}
BENCHMARK(Model)->Name("model/eigen");

void Decoupled(benchmark::State& state) {
  const QuadrupedModel model(test::DogBot());
  QuadrupedDynamics dynamics;
  DecoupledDynamics decoupled;
  model.Calc(test::Standing(test::DogBot()), &dynamics);
  Measure(state, [&](const LeggedState& x) {
    model.CalcDecoupled(x, dynamics, &decoupled);
    benchmark::DoNotOptimize(decoupled);
  });
}
BENCHMARK(Decoupled)->Name("model/decoupled");

void Simbody(benchmark::State& state) {
  test::QuadrupedSimbody simbody(test::DogBot());
  Measure(state, [&](const LeggedState& x) {
    simbody.Calc(x, 9.81);
    benchmark::DoNotOptimize(simbody);
  });
}
BENCHMARK(Simbody)->Name("model/simbody");

}  // namespace
}  // namespace tenon
