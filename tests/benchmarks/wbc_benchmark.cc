// What a millisecond of a walk costs: DogBot trots for two seconds, after two in which it gets going, with
// control and optimisation at 1 kHz.
//
//   wbc/tick     the whole-body controller: model, task, optimisation, torques
//   wbc/model    of these the model
//   loop/BLOCK   each block alone, at every tick with what it reads in the walk; the plant integrated over
//                the millisecond with the walk's torques, which takes it along the same motion
//   loop/all     all of it, wired, with a log at 1 kHz; loop/all_unlogged without the log
//
// Counters: median_ns and p99_ns of a tick; of the loop real_time_factor, simulated over processor time, the
// best of the iterations.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <vector>

#include "tenon/tests/diagrams/trot_recording.h"

namespace tenon {
namespace {

constexpr int kFirst = 2000, kTicks = 4000;

const test::TrotLoop& Loop() {
  static const test::TrotLoop loop;
  return loop;
}

const std::vector<test::TrotTick>& Recording() {
  static const std::vector<test::TrotTick> ticks = test::RecordTrot(Loop(), 1e-3 * kTicks);
  return ticks;
}

class Times {
 public:
  Times() { ns_.reserve(1 << 16); }
  template <class F>
  void Measure(F&& f) {
    const auto begin = std::chrono::steady_clock::now();
    f();
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - begin;
    if (ns_.size() < ns_.capacity()) ns_.push_back(elapsed.count());
  }
  void Report(benchmark::State& state) {
    std::sort(ns_.begin(), ns_.end());
    state.counters["median_ns"] = ns_[ns_.size() / 2];
    state.counters["p99_ns"] = ns_[ns_.size() * 99 / 100];
  }

 private:
  std::vector<double> ns_;
};

/// Ticks a block with its inputs of each tick, as `give(context, block, tick)` sets them.
template <class Block, class Give>
void Replay(benchmark::State& state, const Block& original, const Give& give) {
  DiagramBuilder builder;
  const Block& block = builder.Add<Block>("block", original.params);
  const auto diagram = builder.BuildWithOpenInputs();
  Times times;
  for (auto _ : state) {
    Simulator simulator(*diagram);
    for (int n = 0; n < kTicks; ++n) {
      give(simulator.context(), block, Recording()[static_cast<std::size_t>(n)]);
      const auto tick = [&] { simulator.AdvanceTo(n / 1000.0); };
      if (n < kFirst) {
        tick();
      } else {
        times.Measure(tick);
      }
    }
  }
  times.Report(state);
}

void Scheduler(benchmark::State& state) {
  Replay(state, *Loop().scheduler, [](Context& context, const FootScheduler& b, const test::TrotTick& tick) {
    context.Set(b.command, tick.command);
    context.Set(b.foot_forces, tick.foot_forces);
  });
}

void Com(benchmark::State& state) {
  Replay(state, *Loop().com_planner, [](Context& context, const ComPlanner& b, const test::TrotTick& tick) {
    context.Set(b.command, tick.command);
    context.Set(b.schedule, tick.schedule);
    context.Set(b.state, tick.state);
  });
}

void Swing(benchmark::State& state) {
  Replay(state, *Loop().swing_planner,
         [](Context& context, const SwingPlanner& b, const test::TrotTick& tick) {
           context.Set(b.schedule, tick.schedule);
           context.Set(b.path, tick.path);
           context.Set(b.body, tick.body);
           context.Set(b.state, tick.state);
           context.Set(b.wrench, tick.wrench);
         });
}

void Wbc(benchmark::State& state) {
  Replay(state, *Loop().wbc, [](Context& context, const WholeBodyController& b, const test::TrotTick& tick) {
    context.Set(b.state, tick.state);
    context.Set(b.schedule, tick.schedule);
    context.Set(b.body, tick.body);
    context.Set(b.feet, tick.feet);
    context.Set(b.wrench, tick.wrench);
    context.Set(b.leg_forces, tick.leg_forces);
  });
}

void Model(benchmark::State& state) {
  const QuadrupedModel model(Loop().wbc->params.robot);
  QuadrupedDynamics dynamics;
  Times times;
  for (auto _ : state) {
    for (int n = kFirst; n < kTicks; ++n) {
      times.Measure([&] { model.Calc(Recording()[static_cast<std::size_t>(n)].state, &dynamics); });
      benchmark::DoNotOptimize(dynamics);
    }
  }
  times.Report(state);
}

void Plant(benchmark::State& state) {
  DiagramBuilder builder;
  auto& plant = builder.Add<QuadrupedPlant>("plant", Loop().plant->params);
  const auto& torque =
      builder.AddFunction({"torque", "N m"}, Sampled{Hz(1000)}, Uses(builder.time), [](double t) -> Vec<12> {
        return Recording()[static_cast<std::size_t>(std::lround(1000 * t))].torque;
      });
  builder.Connect(torque, plant.torque);
  const auto diagram = builder.Build();
  Times times;
  long evaluations = 0, measured = 0;
  for (auto _ : state) {
    Simulator simulator(*diagram, test::TrotLoop::Options());
    simulator.AdvanceTo(kFirst / 1000.0);
    const long before = simulator.statistics().evaluations;
    for (int n = kFirst + 1; n < kTicks; ++n) {
      times.Measure([&] { simulator.AdvanceTo(n / 1000.0); });
    }
    evaluations += simulator.statistics().evaluations - before;
    measured += kTicks - 1 - kFirst;
    const LeggedState& end = simulator.context().Eval(plant.state);
    if (end.p_WB != Recording().back().state.p_WB) state.SkipWithError("the replay left the walk's motion");
  }
  times.Report(state);
  state.counters["evaluations"] = static_cast<double>(evaluations) / static_cast<double>(measured);
}

void All(benchmark::State& state, bool logged) {
  const test::TrotLoop& loop = Loop();
  double best = 0;
  for (auto _ : state) {
    Simulator simulator(*loop.diagram, test::TrotLoop::Options());
    std::shared_ptr<MemoryLog> log;
    if (logged) {
      log =
          simulator.AddLog(Hz(1000), {&loop.plant->state, &loop.plant->foot_forces, &loop.plant->joint_torque,
                                      &loop.scheduler->schedule, &loop.com_planner->reference,
                                      &loop.swing_planner->feet, &loop.wbc->torque, &loop.wbc->diagnostics});
      log->Reserve(kTicks + 1);
    }
    simulator.AdvanceTo(kFirst / 1000.0);
    const std::clock_t begin = std::clock();
    simulator.AdvanceTo(kTicks / 1000.0);
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    best = std::max(best, (kTicks - kFirst) / 1000.0 / seconds);
  }
  state.counters["real_time_factor"] = best;
}

void Register(const char* name, auto function) {
  benchmark::RegisterBenchmark(name, function)->Iterations(3)->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
  Register("wbc/tick", Wbc);
  Register("wbc/model", Model);
  Register("loop/plant", Plant);
  Register("loop/scheduler", Scheduler);
  Register("loop/com_planner", Com);
  Register("loop/swing_planner", Swing);
  Register("loop/wbc", Wbc);
  Register("loop/all_unlogged", [](benchmark::State& state) { All(state, false); });
  Register("loop/all", [](benchmark::State& state) { All(state, true); });
  return true;
}();

}  // namespace
}  // namespace tenon
