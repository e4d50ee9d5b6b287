// Computing times of one millisecond of a walk. DogBot trots for two seconds, after two seconds of starting,
// with control and optimization at 1 kHz.
//
//   wbc/tick     the whole-body controller: model, task, optimization, torques
//   wbc/model    the model of the whole-body controller
//   loop/BLOCK   one block alone, at each tick with its inputs of the walk; the plant is integrated over the
//                millisecond with the torques of the walk, along the same motion
//   loop/all     the whole diagram with a log at 1 kHz; loop/all_unlogged without the log
//
// Counters: median_ns, p99_ns and mean_ns of a tick; for the plant also evaluations of its derivatives per
// ms; for the loop also real_time_factor.

#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>

#include "least_times.h"
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

namespace tenon {
namespace {

constexpr int kFirst = 2000, kTicks = 4000;
constexpr std::size_t kMeasured = kTicks - kFirst;

const test::TrotLoop& Trot() {
  static const test::TrotLoop trot;
  return trot;
}

const QuadrupedWalk& Loop() {
  return *Trot().loop;
}

const std::vector<test::TrotTick>& Recording() {
  static const std::vector<test::TrotTick> ticks = test::RecordTrot(Trot(), 1e-3 * kTicks);
  return ticks;
}

/// Measures the ticks of a block, whose inputs are set by `give(context, block, tick)`.
template <class Block, class Give>
void Replay(benchmark::State& state, const Block& original, const Give& give) {
  DiagramBuilder builder;
  const Block& block = builder.Add<Block>("block", original.params);
  const auto diagram = builder.BuildWithOpenInputs();
  LeastTimes times(kMeasured);
  for (auto _ : state) {
    Simulator simulator(*diagram);
    for (int n = 0; n < kTicks; ++n) {
      give(simulator.context(), block, Recording()[static_cast<std::size_t>(n)]);
      const auto tick = [&] { simulator.RunTo(n / 1000.0); };
      if (n < kFirst) {
        tick();
      } else {
        times.Measure(static_cast<std::size_t>(n - kFirst), tick);
      }
    }
  }
  times.Report(state);
}

void Walk(benchmark::State& state) {
  Replay(state, Loop().walk, [](Context&, const WalkSchedule&, const test::TrotTick&) {});
}

void Scheduler(benchmark::State& state) {
  Replay(state, Loop().locomotion.scheduler,
         [](Context& context, const FootScheduler& b, const test::TrotTick& tick) {
           context.Set(b.command, tick.command);
           context.Set(b.foot_forces, tick.foot_forces);
         });
}

void Ground(benchmark::State& state) {
  Replay(state, Loop().locomotion.ground_estimator,
         [](Context& context, const GroundEstimator& b, const test::TrotTick& tick) {
           context.Set(b.state, tick.state);
           context.Set(b.schedule, tick.schedule);
         });
}

void Com(benchmark::State& state) {
  Replay(state, Loop().locomotion.com_planner,
         [](Context& context, const ComPlanner& b, const test::TrotTick& tick) {
           context.Set(b.command, tick.command);
           context.Set(b.schedule, tick.schedule);
           context.Set(b.ground, tick.ground);
         });
}

void Swing(benchmark::State& state) {
  Replay(state, Loop().locomotion.swing_planner,
         [](Context& context, const SwingPlanner& b, const test::TrotTick& tick) {
           context.Set(b.schedule, tick.schedule);
           context.Set(b.path, tick.path);
           context.Set(b.body, tick.body);
           context.Set(b.state, tick.state);
           context.Set(b.ground, tick.ground);
         });
}

void Trunk(benchmark::State& state) {
  Replay(state, *Loop().locomotion.trunk_planner,
         [](Context& context, const TrunkPlanner& b, const test::TrotTick& tick) {
           context.Set(b.schedule, tick.schedule);
           context.Set(b.body, tick.body);
           context.Set(b.state, tick.state);
         });
}

void Wbc(benchmark::State& state) {
  Replay(state, Loop().locomotion.whole_body,
         [](Context& context, const WholeBodyController& b, const test::TrotTick& tick) {
           context.Set(b.state, tick.state);
           context.Set(b.schedule, tick.schedule);
           context.Set(b.body, tick.body);
           context.Set(b.feet, tick.feet);
           context.Set(b.wrench, {});
           context.Set(b.leg_forces, {});
           context.Set(b.ground, tick.ground);
         });
}

void Encoders(benchmark::State& state) {
  Replay(state, Loop().world.encoders,
         [](Context& context, const JointEncoders& b, const test::TrotTick& tick) {
           context.Set(b.state, tick.state);
         });
}

void TorqueSensor(benchmark::State& state) {
  Replay(state, Loop().world.torque_sensor,
         [](Context& context, const JointTorqueSensor& b, const test::TrotTick& tick) {
           context.Set(b.torque, tick.torque);
         });
}

void Imu(benchmark::State& state) {
  Replay(state, Loop().world.imu, [](Context& context, const TrunkImu& b, const test::TrotTick& tick) {
    context.Set(b.body, tick.state);
    context.Set(b.acceleration, {});
  });
}

void FootSensor(benchmark::State& state) {
  Replay(state, Loop().world.foot_sensor,
         [](Context& context, const FootForceSensor& b, const test::TrotTick& tick) {
           context.Set(b.forces, tick.foot_forces);
         });
}

void Model(benchmark::State& state) {
  const QuadrupedModel model(Loop().locomotion.whole_body.params.robot);
  QuadrupedDynamics dynamics;
  LeastTimes times(kMeasured);
  for (auto _ : state) {
    for (int n = kFirst; n < kTicks; ++n) {
      times.Measure(static_cast<std::size_t>(n - kFirst),
                    [&] { model.Calc(Recording()[static_cast<std::size_t>(n)].state, &dynamics); });
      benchmark::DoNotOptimize(dynamics);
    }
  }
  times.Report(state);
}

void Plant(benchmark::State& state) {
  DiagramBuilder builder;
  auto& plant = builder.Add<QuadrupedPlant>("plant", Loop().world.plant.params);
  const auto& torque =
      builder.AddFunction({"torque", "N m"}, Sampled{Hz(1000)}, Uses(builder.time), [](double t) -> Vec<12> {
        return Recording()[static_cast<std::size_t>(std::lround(1000 * t))].torque;
      });
  builder.Connect(torque, plant.torque);
  const auto diagram = builder.BuildWithOpenInputs();
  LeastTimes times(kMeasured);
  long evaluations = 0, measured = 0;
  for (auto _ : state) {
    Simulator simulator(*diagram, test::TrotLoop::Options("plant"));
    simulator.context().Set(plant.external, Recording()[0].external);
    simulator.RunTo((kFirst - 1) / 1000.0);
    const long before = simulator.statistics().evaluations;
    for (int n = kFirst; n < kTicks; ++n) {
      times.Measure(static_cast<std::size_t>(n - kFirst), [&] { simulator.RunTo(n / 1000.0); });
    }
    evaluations += simulator.statistics().evaluations - before;
    measured += kTicks - kFirst;
    const LeggedState& end = simulator.context().Eval(plant.state);
    if (end.p_WB != Recording().back().state.p_WB) state.SkipWithError("the replay left the walk's motion");
  }
  times.Report(state);
  state.counters["evaluations"] = static_cast<double>(evaluations) / static_cast<double>(measured);
}

/// The run repeats bit by bit. The least time of each hundredth of a second over the iterations counts, so
/// that other load of the machine does not count.
void All(benchmark::State& state, bool logged) {
  constexpr int kChunk = 10;
  std::vector<double> best((kTicks - kFirst) / kChunk, 1e300);
  const QuadrupedWalk& loop = Loop();
  for (auto _ : state) {
    Simulator simulator(*Trot().diagram, test::TrotLoop::Options());
    if (logged) {
      const auto log = simulator.AddLog(
          Hz(1000), {&loop.world.state, &loop.world.ground_forces, &loop.world.plant.joint_torque,
                     &loop.locomotion.schedule, &loop.locomotion.body, &loop.locomotion.feet,
                     &loop.locomotion.torque, &loop.locomotion.whole_body.diagnostics, &loop.errors.errors});
      log->Reserve(kTicks + 1);
    }
    simulator.RunTo(kFirst / 1000.0);
    for (std::size_t i = 0; i < best.size(); ++i) {
      const auto begin = std::chrono::steady_clock::now();
      simulator.RunTo((kFirst + kChunk * (static_cast<int>(i) + 1)) / 1000.0);
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
      best[i] = std::min(best[i], elapsed.count());
    }
  }
  const double seconds = std::accumulate(best.begin(), best.end(), 0.0);
  state.counters["real_time_factor"] = (kTicks - kFirst) / 1000.0 / seconds;
}

void Register(const char* name, auto function) {
  benchmark::RegisterBenchmark(name, function)->Iterations(10)->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
  Register("wbc/tick", Wbc);
  Register("wbc/model", Model);
  Register("loop/plant", Plant);
  Register("loop/encoders", Encoders);
  Register("loop/torque_sensor", TorqueSensor);
  Register("loop/foot_sensor", FootSensor);
  Register("loop/imu", Imu);
  Register("loop/walk", Walk);
  Register("loop/scheduler", Scheduler);
  Register("loop/ground_estimator", Ground);
  Register("loop/com_planner", Com);
  Register("loop/swing_planner", Swing);
  Register("loop/trunk_planner", Trunk);
  Register("loop/wbc", Wbc);
  Register("loop/all_unlogged", [](benchmark::State& state) { All(state, false); });
  Register("loop/all", [](benchmark::State& state) { All(state, true); });
  return true;
}();

}  // namespace
}  // namespace tenon
