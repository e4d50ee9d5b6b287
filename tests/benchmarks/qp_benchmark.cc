// Quadratic programs of the whole-body controller, recorded from walks at 1 kHz and solved in sequence:
//
//     qp          DogBot trots on level ground (see trot_recording.h): few inequalities are active
//     qp_k3, k8   the problems of qp with 3 or 8 torque limits moved past the solution by 0.2 N m
//     qp_slip     on blocks with a friction of 0.25 (A6-slippery)
//     qp_push     a push of 160 N at a knee for 0.2 s, with an assumed friction of 0.4 (A3-160)
//     qp_lean     a constant lateral push of 60 N, with an assumed friction of 0.4 (lateral_push)
//
// Benchmarks of each set:
//
//     SET/eliminated            12 variables, warm start from the active set of the previous problem
//     SET/full                  30 variables (FullWholeBodyQp), warm start likewise
//
// Benchmark of the set qp only:
//
//     qp/alglib_ipm             30 variables, dense interior-point method of ALGLIB, which Morlando 2023
//     uses, with
//                               a tolerance of 1e-6: smaller ones take longer at hardly better precision
//
// Counters: median_ns and p99_ns over the problems, each with its least time over all iterations, so that
// other load of the machine does not count; cold_median_ns and cold_p99_ns without a warm start; active, the
// mean number of active inequalities; iterations per problem; failures. For the dual active set method also
// kkt, the largest residual of the Karush-Kuhn-Tucker conditions relative to its terms, and difference, the
// largest relative difference from the solution of the other form. A benchmark fails if one of the two
// exceeds 1e-8 or a solve fails. The difference of ALGLIB is relative to the solution of the full problem by
// the dual active set method.

#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/tests/controllers/legged/whole_body/full_whole_body_qp.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>

#include "least_times.h"
#include <benchmark/benchmark.h>
#include <libalglib/optimization.h>

namespace tenon {
namespace {

constexpr double kAgreement = 1e-8;

struct Sequence {
  std::vector<test::TrotTask> tasks;
  WholeBodyQpParams params;
  Vec<12> limit;
};

Sequence Empty(const WholeBodyController& controller) {
  return {{}, controller.params.gains.qp, WholeBodyController::TorqueLimit(controller.params.robot)};
}

Sequence Trot() {
  constexpr int kFirst = 2000, kTicks = 2000;
  const test::TrotLoop trot;
  const WholeBodyController& controller = trot.loop->locomotion.whole_body;
  Sequence made = Empty(controller);
  const std::vector<test::TrotTick> ticks = test::RecordTrot(trot, 1e-3 * (kFirst + kTicks));
  for (std::size_t n = kFirst; n < ticks.size(); ++n)
    made.tasks.push_back(test::MakeTask(controller, ticks[n]));
  return made;
}

// The inputs of the controller from tick `first` to `last` of a scenario.
Sequence Record(const std::string& name, const std::vector<std::string>& settings, int first, int last) {
  const auto scenario = apps::LoadScenario(name, settings, "tenon-quadruped").Read<apps::QuadrupedScenario>();
  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", apps::MakeWalkParams(scenario));
  Simulator simulator(builder.Build(), apps::MakeSimulatorOptions(scenario, loop.world.plant));
  Context& context = simulator.context();
  const LeggedLocomotion& locomotion = loop.locomotion;
  const WholeBodyController& controller = locomotion.whole_body;
  const WholeBodyGains& gains = controller.params.gains;
  Sequence made = Empty(controller);
  for (int n = first; n < last; ++n) {
    const RunStatus status = simulator.AdvanceTo(n / 1000.0);
    if (status.ended) throw RunError("the walk ended: " + status.reason);
    const LeggedState& state = context.Eval(loop.world.state);
    const ContactSchedule& schedule = context.Eval(locomotion.scheduler.schedule);
    const GroundPlane& ground = context.Eval(locomotion.ground_estimator.ground);
    test::TrotTask& task = made.tasks.emplace_back();
    QuadrupedDynamics of_model;
    QuadrupedModel(controller.params.robot).Calc(state, &of_model);
    controller.CalcDynamics(of_model, schedule, ground, gains, &task.dynamics);
    task.task =
        controller.MakeTask(task.dynamics, state, schedule, context.Eval(locomotion.com_planner.reference),
                            context.Eval(locomotion.swing_planner.feet), context.Eval(loop.observer.wrench),
                            context.Eval(loop.observer.leg_forces), ground, gains);
  }
  return made;
}

const Sequence& Walk(const std::string& name) {
  static const std::map<std::string, std::function<Sequence()>> walks{
      {"qp", Trot},
      {"qp_slip", [] { return Record("A6-slippery", {}, 11500, 13000); }},
      {"qp_push", [] { return Record("A3-160", {"walk.friction=0.4"}, 3500, 4500); }},
      {"qp_lean", [] { return Record("lateral_push", {"walk.friction=0.4"}, 500, 2500); }}};
  static std::map<std::string, Sequence> recorded;
  const auto found = recorded.find(name);
  return found != recorded.end() ? found->second : recorded.emplace(name, walks.at(name)()).first->second;
}

struct Stored : test::OwnedQp {
  using OwnedQp::OwnedQp;
  Eigen::VectorXd x;  // solution of the problem
};

// Moves `count` torque limits past the problem's solution by 0.2 N m. They are lower or upper limits of
// joints on all legs, and the same in all problems.
void MoveRows(int count, Stored* qp) {
  constexpr std::array<std::array<int, 2>, 8> kRows{
      {{0, 1}, {3, 2}, {1, 3}, {2, 5}, {0, 5}, {1, 1}, {3, 4}, {2, 0}}};  // legs, limits
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
    const int row = kRows[k][0] * WholeBodyQp::kRowsPerLeg + 4 + kRows[k][1];
    qp->b_in[row] = qp->A_in.row(row).dot(qp->x) + 0.2;
  }
}

struct Set {
  std::string walk;
  int moved = 0;
};

// The problems of a set in one form, with their solutions without a warm start.
std::vector<Stored> MakeProblems(const Set& set, bool eliminate) {
  std::vector<Stored> problems;
  const Sequence& walk = Walk(set.walk);
  WholeBodyQp maker(walk.limit);
  DualActiveSet solver = test::FullWholeBodySolver();
  for (const auto& [dynamics, task] : walk.tasks) {
    WholeBodySolution solution;
    maker.Solve(dynamics, task, walk.params, &solution);
    // At touchdown some torques are at their limits already, and the moved limits would contradict them.
    if (set.moved > 0 && solution.num_active > 0) continue;
    Stored& qp = problems.emplace_back(
        eliminate ? maker.problem() : test::FullWholeBodyQp(dynamics, task, walk.params, walk.limit).view());
    solver.Solve(qp.view());
    qp.x = solver.x();
    if (set.moved == 0) continue;
    MoveRows(set.moved, &qp);
    solver.Solve(qp.view());
    qp.x = solver.x();
  }
  return problems;
}

void Solve(benchmark::State& state, const Set& set, bool eliminate) {
  const std::vector<Stored> problems = MakeProblems(set, eliminate), others = MakeProblems(set, !eliminate);
  DualActiveSet solver = test::FullWholeBodySolver();
  std::vector<int> guess;
  guess.reserve(30);
  LeastTimes warm(problems.size()), cold(problems.size());
  long iterations = 0, failures = 0;
  for (auto _ : state) {
    guess.clear();
    for (std::size_t k = 0; k < problems.size(); ++k) {
      const Stored& qp = problems[k];
      const QpReport report = warm.Measure(k, [&] { return solver.Solve(qp.view(), guess); });
      iterations += report.iterations;
      failures += !report.ok();
      if (report.ok()) guess.assign(solver.active().begin(), solver.active().end());
    }
    for (std::size_t k = 0; k < problems.size(); ++k)
      failures += !cold.Measure(k, [&] { return solver.Solve(problems[k].view()); }).ok();
  }
  double kkt = 0, difference = 0;
  std::size_t active = 0;
  guess.clear();
  for (std::size_t k = 0; k < problems.size(); ++k) {
    const Stored& qp = problems[k];
    if (!solver.Solve(qp.view(), guess).ok()) continue;
    guess.assign(solver.active().begin(), solver.active().end());
    active += guess.size();
    kkt = std::max(kkt, test::KktResidual(qp.view(), solver.x(), solver.multipliers()).largest);
    const Vec<12> y = solver.x().tail<12>(), expected = others[k].x.tail<12>();
    difference = std::max(difference, (y - expected).norm() / expected.norm());
  }
  warm.Report(state);
  cold.Report(state, "cold_");
  const double solves = static_cast<double>(state.iterations()) * static_cast<double>(problems.size());
  state.counters["iterations"] = static_cast<double>(iterations) / solves;
  state.counters["active"] = static_cast<double>(active) / static_cast<double>(problems.size());
  state.counters["failures"] = static_cast<double>(failures);
  state.counters["kkt"] = kkt;
  state.counters["difference"] = difference;
  if (failures > 0 || !(kkt <= kAgreement) || !(difference <= kAgreement))
    state.SkipWithError("a solve failed, or is not the minimum");
}

void SolveByAlglib(benchmark::State& state) {
  const std::vector<Stored> problems = MakeProblems({"qp"}, false);
  LeastTimes times(problems.size());
  long iterations = 0, failures = 0;
  double difference = 0;
  for (auto _ : state) {
    for (std::size_t k = 0; k < problems.size(); ++k) {
      const Stored& qp = problems[k];
      const auto n = qp.g.size(), equalities = qp.b_eq.size(), rows = equalities + qp.b_in.size();
      alglib::real_2d_array H, A;
      alglib::real_1d_array g, lower, upper, scale, x;
      const ConstraintMatrix by_rows = qp.H;
      H.setcontent(n, n, by_rows.data());
      g.setcontent(n, qp.g.data());
      ConstraintMatrix all(rows, n);
      all << qp.A_eq, qp.A_in;
      A.setcontent(rows, n, all.data());
      Eigen::VectorXd bound(rows);
      bound << qp.b_eq, qp.b_in;
      lower.setcontent(rows, bound.data());
      bound.tail(qp.b_in.size()).setConstant(std::numeric_limits<double>::infinity());
      upper.setcontent(rows, bound.data());
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
      scale.setcontent(n, ones.data());
      const alglib::minqpreport report = times.Measure(k, [&] {
        alglib::minqpstate solver;
        alglib::minqpcreate(n, solver);
        alglib::minqpsetquadraticterm(solver, H);
        alglib::minqpsetlinearterm(solver, g);
        alglib::minqpsetlc2dense(solver, A, lower, upper);
        alglib::minqpsetscale(solver, scale);
        alglib::minqpsetalgodenseipm(solver, 1e-6);
        alglib::minqpoptimize(solver);
        alglib::minqpreport result;
        alglib::minqpresults(solver, x, result);
        return result;
      });
      iterations += report.outeriterationscount;
      if (report.terminationtype <= 0) {
        ++failures;
        continue;
      }
      const Eigen::Map<const Eigen::VectorXd> found(x.getcontent(), n);
      difference = std::max(difference, (found - qp.x).norm() / qp.x.norm());
    }
  }
  times.Report(state);
  const double solves = static_cast<double>(state.iterations()) * static_cast<double>(problems.size());
  state.counters["iterations"] = static_cast<double>(iterations) / solves;
  state.counters["failures"] = static_cast<double>(failures);
  state.counters["difference"] = difference;
}

void Register(const char* name, int iterations, auto... arguments) {
  benchmark::RegisterBenchmark(name, arguments...)->Iterations(iterations)->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
  for (const auto& [name, set] : {std::pair{"qp", Set{"qp"}},
                                  {"qp_k3", {"qp", 3}},
                                  {"qp_k8", {"qp", 8}},
                                  {"qp_slip", {"qp_slip"}},
                                  {"qp_push", {"qp_push"}},
                                  {"qp_lean", {"qp_lean"}}}) {
    Register((name + std::string("/eliminated")).c_str(), 10, Solve, set, true);
    Register((name + std::string("/full")).c_str(), 10, Solve, set, false);
  }
  Register("qp/alglib_ipm", 2, SolveByAlglib);
  return true;
}();

}  // namespace
}  // namespace tenon
