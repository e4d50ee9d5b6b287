// Computing times of a walk. DogBot trots for two seconds, after two seconds of starting, with control and
// optimization at 1 kHz; `plan` has a crawl of its own.
//
//   wbc/tick     the whole-body controller: model, task, optimization, torques
//   wbc/model    the model of the whole-body controller
//   loop/all     the whole diagram with a log at 1 kHz
//   plan         the first plan of a crawl by TrajectoryPlanner (cold), and the next one (warm)
//
// Counters: median_ns, p99_ns and mean_ns of a tick; for the loop real_time_factor. RunProfile shows the time
// of each block.

#include <tenon/controllers/legged/planning/trajectory_planner.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>

#include "least_times.h"
#include <benchmark/benchmark.h>

#include <numeric>

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

void Wbc(benchmark::State& state) {
  DiagramBuilder builder;
  const auto& wbc = builder.Add<WholeBodyController>("block", Loop().locomotion.whole_body.params);
  const auto diagram = builder.BuildWithOpenInputs();
  LeastTimes times(kMeasured);
  for (auto _ : state) {
    Simulator simulator(*diagram);
    Context& context = simulator.context();
    for (int n = 0; n < kTicks; ++n) {
      const test::TrotTick& recorded = Recording()[static_cast<std::size_t>(n)];
      context.Set(wbc.state, recorded.state);
      context.Set(wbc.schedule, recorded.schedule);
      context.Set(wbc.body, recorded.body);
      context.Set(wbc.feet, recorded.feet);
      context.Set(wbc.wrench, {});
      context.Set(wbc.leg_forces, {});
      context.Set(wbc.ground, recorded.ground);
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

/// The run repeats bit by bit. The least time of each hundredth of a second over the iterations counts, so
/// that other load of the machine does not count.
void All(benchmark::State& state) {
  constexpr int kChunk = 10;
  std::vector<double> best((kTicks - kFirst) / kChunk, 1e300);
  const QuadrupedWalk& loop = Loop();
  for (auto _ : state) {
    Simulator simulator(*Trot().diagram, test::TrotLoop::Options());
    const auto log = simulator.AddLog(
        Hz(1000), {&loop.world.state, &loop.world.ground_forces, &loop.world.plant.joint_torque,
                   &loop.locomotion.schedule, &loop.locomotion.body, &loop.locomotion.feet,
                   &loop.locomotion.torque, &loop.locomotion.whole_body.diagnostics, &loop.errors.errors});
    log->Reserve(kTicks + 1);
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

void Plan(benchmark::State& state) {
  DiagramBuilder builder;
  const auto& planner = builder.Add<TrajectoryPlanner>("planner", {.robot = test::DogBot()});
  const auto diagram = builder.BuildWithOpenInputs();
  BodyReference body;
  body.com_W[2] = planner.stance.com_height;
  ContactSchedule schedule;
  schedule.gait = Gait::kCrawl;
  schedule.timing = {.num_steps = 4, .step = {1, 3, 0, 2}, .stance = 0.05, .swing = 0.3};
  const double step_time = schedule.timing.step_duration();
  LeastTimes cold(1), warm(1);
  for (auto _ : state) {
    Simulator simulator(*diagram);
    Context& context = simulator.context();
    context.Set(planner.body, body);
    context.Set(planner.state, test::Standing(test::DogBot()));
    context.Set(planner.ground, {});
    for (const int step : {0, 1}) {
      if (step > 0) static_cast<void>(simulator.AdvanceToBefore(step_time));
      schedule.footsteps = step + 1;
      schedule.step = step;
      context.Set(planner.schedule, schedule);
      context.Set(planner.path, {.position_W = {0.15 * step_time * step, 0}, .velocity = {0.15, 0}});
      (step == 0 ? cold : warm).Measure(0, [&] { simulator.RunTo(step_time * step); });
    }
  }
  cold.Report(state, "cold_");
  warm.Report(state, "warm_");
}

void Register(const char* name, auto function) {
  benchmark::RegisterBenchmark(name, function)->Iterations(10)->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
  Register("wbc/tick", Wbc);
  Register("wbc/model", Model);
  Register("loop/all", All);
  Register("plan", Plan);
  return true;
}();

}  // namespace
}  // namespace tenon
