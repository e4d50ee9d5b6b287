// The quadratic programs of the whole-body controller: DogBot trots on the spot for five seconds at 1 kHz,
// 5000 problems, each one started at the active constraints of the one before. The state sways about the
// stance by random sums of sines, and the wanted wrench and accelerations with it, so that friction and
// torque limits are met at times.
//
//     qp/12, qp/30          the solver alone, on the eliminated and on the full problem
//     qp_cold/12, /30       the same without a guess
//     whole_body_qp/12, /30 with making the problem from the dynamics

#include <benchmark/benchmark.h>
#include <tenon/controllers/whole_body_qp.h>
#include <tenon/plants/description/resources.h>
#include <tenon/systems/random_stream.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace tenon {
namespace {

constexpr int kProblems = 5000;

struct Instant {
  QuadrupedDynamics dynamics;
  WholeBodyTask task;
};

std::vector<Instant> MakeTrot() {
  const QuadrupedDescription robot = LoadQuadruped(FindResource("robots", "dogbot"));
  const QuadrupedModel model(robot);
  RandomStream random(1);
  // Amplitude, angular frequency [rad/s] and phase of every signal.
  constexpr int kSignals = 6 + 12 + 6 + 12;
  std::array<std::array<double, 3>, kSignals> sines;
  for (auto& sine : sines) sine = {random.Uniform(0.3, 1), random.Uniform(5, 30), random.Uniform(0, 6)};
  std::vector<Instant> trot(kProblems);
  for (int k = 0; k < kProblems; ++k) {
    const double t = 1e-3 * k;
    const auto value = [&](int i) { return sines[i][0] * std::sin(sines[i][1] * t + sines[i][2]); };
    const auto rate = [&](int i) {
      return sines[i][0] * sines[i][1] * std::cos(sines[i][1] * t + sines[i][2]);
    };
    LeggedState x;
    x.p_WB[2] = robot.StanceHeight();
    x.q_WB = QuaternionFromRotationVector(0.05 * Vec<3>(value(0), value(1), value(2)));
    x.q = robot.stance;
    for (int i = 0; i < 3; ++i) x.w_W[i] = 0.05 * rate(i), x.v_W[i] = 0.02 * rate(3 + i);
    for (int j = 0; j < 12; ++j) x.q[j] += 0.15 * value(6 + j), x.qd[j] = 0.15 * rate(6 + j);
    model.Calc(x, &trot[k].dynamics);
    WholeBodyTask& task = trot[k].task;
    const int phase = (k / 133) % 4;  // both pairs stand, one swings, both stand, the other swings
    if (phase == 1) task.stance = {true, false, false, true};
    if (phase == 3) task.stance = {false, true, true, false};
    for (int i = 0; i < 6; ++i) task.wrench[i] = (i < 2 ? 150 : i == 2 ? 60 : 15) * value(18 + i);
    task.wrench[2] += model.mass() * model.gravity();
    for (int leg = 0; leg < kNumLegs; ++leg)
      for (int i = 0; i < 3; ++i) task.foot_acceleration[leg][i] = 30 * value(24 + 3 * leg + i);
  }
  return trot;
}

const std::vector<Instant>& Trot() {
  static const std::vector<Instant> trot = MakeTrot();
  return trot;
}

Vec<12> Limits() {
  return Vec<12>::Constant(60);
}

class Times {
 public:
  Times() { us_.reserve(1 << 20); }
  template <class F>
  auto Measure(F&& f) {
    const auto begin = std::chrono::steady_clock::now();
    const auto result = f();
    const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - begin;
    if (us_.size() < us_.capacity()) us_.push_back(elapsed.count());
    iterations_ += result.iterations;
    failures_ += !result.ok();
    return result;
  }
  void Report(benchmark::State& state) {
    std::sort(us_.begin(), us_.end());
    const double count = static_cast<double>(us_.size());
    state.counters["median_us"] = us_[us_.size() / 2];
    state.counters["p99_us"] = us_[us_.size() * 99 / 100];
    state.counters["iterations"] = static_cast<double>(iterations_) / count;
    state.counters["failures"] = static_cast<double>(failures_) / count;
  }

 private:
  std::vector<double> us_;
  long iterations_ = 0, failures_ = 0;
};

// A problem that owns its numbers.
struct Stored {
  explicit Stored(const QuadraticProgram& qp)
      : H(qp.H), g(qp.g), A_eq(qp.A_eq), b_eq(qp.b_eq), A_in(qp.A_in), b_in(qp.b_in) {}
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  ConstraintMatrix A_eq;
  Eigen::VectorXd b_eq;
  ConstraintMatrix A_in;
  Eigen::VectorXd b_in;
};

void Solve(benchmark::State& state, bool eliminate, bool warm) {
  std::vector<Stored> problems;
  WholeBodyQp maker(Limits(), {.eliminate = eliminate});
  WholeBodySolution solution;
  for (const Instant& instant : Trot()) {
    maker.Solve(instant.dynamics, instant.task, &solution);
    problems.emplace_back(maker.problem());
  }
  DualActiveSet solver(30, 60);
  std::vector<int> guess;
  guess.reserve(30);
  Times times;
  std::size_t k = 0;
  for (auto _ : state) {
    const Stored& qp = problems[k++ % kProblems];
    const QpReport report = times.Measure([&] {
      return solver.Solve({qp.H, qp.g, qp.A_eq, qp.b_eq, qp.A_in, qp.b_in}, guess);
    });
    if (warm && report.ok()) guess.assign(solver.active().begin(), solver.active().end());
  }
  times.Report(state);
}

void MakeAndSolve(benchmark::State& state, bool eliminate) {
  WholeBodyQp qp(Limits(), {.eliminate = eliminate});
  WholeBodySolution solution;
  Times times;
  std::size_t k = 0;
  for (auto _ : state) {
    const Instant& instant = Trot()[k++ % kProblems];
    times.Measure([&] { return qp.Solve(instant.dynamics, instant.task, &solution); });
  }
  times.Report(state);
}

void Register(const char* name, auto... arguments) {
  benchmark::RegisterBenchmark(name, arguments...)->Iterations(4 * kProblems)->Unit(benchmark::kMicrosecond);
}

const bool kRegistered = [] {
  Register("qp/12", Solve, true, true);
  Register("qp/30", Solve, false, true);
  Register("qp_cold/12", Solve, true, false);
  Register("qp_cold/30", Solve, false, false);
  Register("whole_body_qp/12", MakeAndSolve, true);
  Register("whole_body_qp/30", MakeAndSolve, false);
  return true;
}();

}  // namespace
}  // namespace tenon
