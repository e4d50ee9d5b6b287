// One real-time iteration of the SLQ on the cable robot: 15 kg on four cables, horizon 1 s, along a circle of
// 0.5 m radius in 10 s. The start is 2 cm off the path, so that no call starts at the solution.

#include <tenon/controllers/cdpr/cdpr_tracking_problem.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <benchmark/benchmark.h>

#include <chrono>

namespace tenon {
namespace {

using Problem = CdprTrackingProblem<4>;

Slq<Problem> MakeSlq(int steps, const SlqOptions& options) {
  static const CdprDescription robot = LoadCdpr(FindResource("robots", "cdpr_4"));
  static const EquilibriumPath path(robot, Path::Circle({0, 0, 2}, 0.5, 10, 0.5));
  const double h = 1.0 / steps;
  Problem problem(robot, steps);
  problem.Q << 20, 20, 20, 5000, 5000, 5000, 1000, 1000, 1000, 20, 20, 20;
  problem.R.setConstant(1e-3);
  problem.Q_f = (0.3 * problem.Q).asDiagonal();
  for (int k = 0; k <= steps; ++k) {
    const CdprReference at = path.At(5 + k * h);
    problem.targets[k].x << at.velocity, Eigen::Vector3d::Zero(), at.position, at.euler;
    problem.targets[k].u = at.tension;
    problem.targets[k].upper.setConstant(robot.cable.tension_max);
  }
  const Problem::Target start = problem.targets[0];
  Slq<Problem> slq(std::move(problem), std::vector<double>(steps, h), options);
  slq.SetPolicy(start.x, start.u);
  return slq;
}

void Iterate(benchmark::State& state, int steps, const SlqOptions& options) {
  Slq<Problem> slq = MakeSlq(steps, options);
  CentroidalState x0 = slq.problem().targets[0].x;
  std::vector<double> times;
  times.reserve(1 << 20);
  for (auto _ : state) {
    x0[6] = slq.problem().targets[0].x[6] + (times.size() % 2 == 0 ? 0.02 : -0.02);
    const auto begin = std::chrono::steady_clock::now();
    const SlqReport report = slq.Solve(x0);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (!report.ok()) state.SkipWithError("no descent");
    if (times.size() < times.capacity()) times.push_back(1e6 * elapsed.count());
  }
  std::sort(times.begin(), times.end());
  state.counters["min_us"] = times.front();
  state.counters["median_us"] = times[times.size() / 2];
  state.counters["p99_us"] = times[times.size() * 99 / 100];
}

void Register(const std::string& name, int steps, const SlqOptions& options) {
  benchmark::RegisterBenchmark(name.c_str(), Iterate, steps, options)->Unit(benchmark::kMicrosecond);
}

const bool kRegistered = [] {
  for (const int steps : {100, 50}) {
    Register("slq/" + std::to_string(steps), steps, {.method = StepMethod::kRungeKutta4});
    Register("slq_midpoint/" + std::to_string(steps), steps, {.method = StepMethod::kMidpoint});
  }
  return true;
}();

}  // namespace
}  // namespace tenon
