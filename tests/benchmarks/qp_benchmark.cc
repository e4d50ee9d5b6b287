// The quadratic programmes of the whole-body controller in a walk: DogBot trots for two seconds in closed
// loop with the plant (see trot_recording.h), 2000 problems at 1 kHz, in sequence.
//
//     qp/eliminated             in 12 variables, each one started at the active constraints of the one before
//     qp/full                   the same in 30 variables
//     whole_body_qp/eliminated  with making the problem from the dynamics
//     whole_body_qp/full
//     qp/alglib_ipm             in 30 variables, ALGLIB's dense interior point method
//     qp/alglib_aul             and its augmented Lagrangian, which Morlando 2023 used; both to 1e-6, since
//                               smaller tolerances take longer and bring them hardly closer
//
// Counters: median_ns and p99_ns over the problems, each with the least time of all iterations, since what
// the machine does besides is not the solver's; iterations a problem; failures, and the largest difference
// from the full problem's solution by the dual active set method, relative to its norm.

#include <benchmark/benchmark.h>
#include <libalglib/optimization.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>

namespace tenon {
namespace {

constexpr std::size_t kFirst = 2000, kTicks = 4000;

struct Sequence {
  std::vector<test::TrotTask> tasks;
  WholeBodyQpParams params;
  Vec<12> limit;
};

const Sequence& Trot() {
  static const Sequence sequence = [] {
    const test::TrotLoop trot;
    const WholeBodyController& controller = trot.loop->locomotion.whole_body;
    Sequence made;
    made.params = controller.params.gains.qp;
    made.limit = WholeBodyController::TorqueLimit(controller.params.robot);
    const std::vector<test::TrotTick> ticks = test::RecordTrot(trot, 1e-3 * kTicks);
    for (std::size_t n = kFirst; n < kTicks; ++n) made.tasks.push_back(test::MakeTask(controller, ticks[n]));
    return made;
  }();
  return sequence;
}

WholeBodyQpParams Params(bool eliminate) {
  WholeBodyQpParams params = Trot().params;
  params.eliminate = eliminate;
  return params;
}

// A problem that owns its numbers, and its solution.
struct Stored {
  explicit Stored(const QuadraticProgram& qp)
      : H(qp.H), g(qp.g), A_eq(qp.A_eq), b_eq(qp.b_eq), A_in(qp.A_in), b_in(qp.b_in) {}
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  ConstraintMatrix A_eq;
  Eigen::VectorXd b_eq;
  ConstraintMatrix A_in;
  Eigen::VectorXd b_in;
  Eigen::VectorXd x;
};

std::vector<Stored> MakeProblems(bool eliminate) {
  std::vector<Stored> problems;
  const WholeBodyQpParams params = Params(eliminate);
  WholeBodyQp maker(Trot().limit);
  WholeBodySolution solution;
  for (const auto& [dynamics, task] : Trot().tasks) {
    maker.Solve(dynamics, task, params, &solution);
    problems.emplace_back(maker.problem());
    problems.back().x = maker.solver().x();
  }
  return problems;
}

/// The least time that each problem of the sequence takes.
class Times {
 public:
  Times() : ns_(Trot().tasks.size(), std::numeric_limits<double>::infinity()) {}
  template <class F>
  auto Measure(std::size_t problem, F&& f) {
    const auto begin = std::chrono::steady_clock::now();
    const auto result = f();
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - begin;
    ns_[problem] = std::min(ns_[problem], elapsed.count());
    return result;
  }
  void Report(benchmark::State& state) {
    std::sort(ns_.begin(), ns_.end());
    state.counters["median_ns"] = ns_[ns_.size() / 2];
    state.counters["p99_ns"] = ns_[ns_.size() * 99 / 100];
  }

 private:
  std::vector<double> ns_;
};

void Solve(benchmark::State& state, bool eliminate) {
  const std::vector<Stored> problems = MakeProblems(eliminate);
  DualActiveSet solver(30, 60);
  std::vector<int> guess;
  guess.reserve(30);
  Times times;
  long iterations = 0, failures = 0;
  for (auto _ : state) {
    guess.clear();
    for (std::size_t k = 0; k < problems.size(); ++k) {
      const Stored& qp = problems[k];
      const QpReport report = times.Measure(k, [&] {
        return solver.Solve({qp.H, qp.g, qp.A_eq, qp.b_eq, qp.A_in, qp.b_in}, guess);
      });
      iterations += report.iterations;
      failures += !report.ok();
      if (report.ok()) guess.assign(solver.active().begin(), solver.active().end());
    }
  }
  times.Report(state);
  const double solves = static_cast<double>(state.iterations()) * static_cast<double>(problems.size());
  state.counters["iterations"] = static_cast<double>(iterations) / solves;
  state.counters["failures"] = static_cast<double>(failures);
}

void MakeAndSolve(benchmark::State& state, bool eliminate) {
  const WholeBodyQpParams params = Params(eliminate);
  WholeBodyQp qp(Trot().limit);
  WholeBodySolution solution;
  Times times;
  for (auto _ : state) {
    for (std::size_t k = 0; k < Trot().tasks.size(); ++k) {
      const auto& [dynamics, task] = Trot().tasks[k];
      times.Measure(k, [&] { return qp.Solve(dynamics, task, params, &solution); });
    }
  }
  times.Report(state);
}

void SolveByAlglib(benchmark::State& state, bool interior_point) {
  const std::vector<Stored> problems = MakeProblems(false);
  Times times;
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
        if (interior_point) {
          alglib::minqpsetalgodenseipm(solver, 1e-6);
        } else {
          alglib::minqpsetalgodenseaul(solver, 1e-6, 1e4, 5);
        }
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
  Register("qp/eliminated", 10, Solve, true);
  Register("qp/full", 10, Solve, false);
  Register("whole_body_qp/eliminated", 10, MakeAndSolve, true);
  Register("whole_body_qp/full", 10, MakeAndSolve, false);
  Register("qp/alglib_ipm", 2, SolveByAlglib, true);
  Register("qp/alglib_aul", 2, SolveByAlglib, false);
  return true;
}();

}  // namespace
}  // namespace tenon
