// Computing times of the plants.
//
// cable/straight, pulley, sag and sag_pulley: CalcCableStatics for one taut cable of the cable robot, at
// random poses of the platform.
//
// Work-precision diagram: DogBot trots on the spot for one second by joint PD at 1 kHz, in Tenon and in
// MuJoCo, with one row for each setting (trot/ENGINE/SETTING):
//
//   x_real_time         simulated time over processor time, the best of five runs
//   error_mm            largest distance of the trunk, over all ticks, from a reference run of the same
//   engine:
//                       order 5 and rtol = 1e-9 in Tenon, RK4 with steps of 1/32 ms in MuJoCo
//   evaluations_per_ms  evaluations of the accelerations
//
// Each engine has its own reference because the contact models differ: compliant feet with bristle friction
// in Tenon, soft constraints with default settings in MuJoCo. The comparison is one of integration, not of
// contact models. Tenon's absolute tolerances are those that QuadrupedPlant recommends, scaled with rtol,
// except that the tolerance of the bristles is never increased.

#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/plants/model/quadruped_mujoco.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <benchmark/benchmark.h>

#include <ctime>

namespace tenon {
namespace {

void Cable(benchmark::State& state, double mass_per_length, double pulley_radius) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.mass_per_length = mass_per_length;
  robot.winch.pulley_radius = pulley_radius;
  RandomStream random(42);
  std::vector<Vec<3>> spans;
  for (int i = 0; i < 1000; ++i)
    spans.emplace_back(random.Uniform(1, 5), random.Uniform(1, 5), random.Uniform(0.5, 3));
  std::size_t next = 0;
  for (auto _ : state) {
    const Vec<3>& span = spans[next++ % spans.size()];
    benchmark::DoNotOptimize(CalcCableStatics(robot, 0, span, 0.997 * span.norm(), 9.81));
  }
}
BENCHMARK_CAPTURE(Cable, straight, 0, 0)->Name("cable/straight");
BENCHMARK_CAPTURE(Cable, pulley, 0, 0.04)->Name("cable/pulley");
BENCHMARK_CAPTURE(Cable, sag, 0.05, 0)->Name("cable/sag");
BENCHMARK_CAPTURE(Cable, sag_pulley, 0.05, 0.04)->Name("cable/sag_pulley");

// --- Trot: work-precision diagram -----------------------------------------------------------------------

constexpr double kStiffness = 300, kDamping = 8;  // [N m/rad], [N m s/rad]
constexpr int kTicks = 1000;                      // ticks of 1 ms
using Path = std::vector<Vec<3>>;                 // positions of the trunk at the ticks

/// Joint angles of the trot: the stance, with the diagonal pairs of legs folded in turn by up to 0.2 rad at
/// the hip, 0.15 s each.
Vec<12> Trot(const Vec<12>& stance, double t) {
  Vec<12> q = stance;
  const double wave = std::sin(2 * std::numbers::pi * t / 0.3);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const bool diagonal = leg == kFrontLeft || leg == kRearRight;
    q.segment<2>(3 * leg + 1) += std::max(0.0, diagonal ? wave : -wave) * Vec<2>(0.2, -0.4);
  }
  return q;
}

struct Trotting {
  Path path;
  double seconds = 0;  // processor time
  double evaluations = 0;
};

class Stopwatch {
 public:
  double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t start_ = std::clock();
};

Trotting RunTenon(Method method, int order, double rtol) {
  const QuadrupedDescription robot = test::DogBot();
  DiagramBuilder builder;
  QuadrupedPlantParams params;
  params.robot = robot;
  params.initial = test::Standing(robot);
  auto& plant = builder.Add<QuadrupedPlant>("plant", params);
  auto& pd =
      builder.Add<JointPd>("pd", JointPdParams{.robot = robot, .stiffness = kStiffness, .damping = kDamping});
  auto& trot = builder.AddFunction("trot", Sampled{Hz(1000)}, Uses(builder.time),
                                   [=](double t) -> Vec<12> { return Trot(robot.stance, t); });
  auto& joints = builder.AddFunction("joints", Uses(plant.state), [](const LeggedState& x) {
    return JointMotion{x.q, x.qd};
  });
  builder.Connect(trot, pd.reference);
  builder.Connect(joints, pd.joints);
  builder.Connect(pd.torque, plant.torque);
  Simulator simulator(builder.Build(), {.method = method,
                                        .order = order,
                                        .rtol = rtol,
                                        .atol = rtol / 100,
                                        .state_atol = {{"plant.motion.v_W", rtol},
                                                       {"plant.motion.w_W", rtol},
                                                       {"plant.motion.qd", rtol},
                                                       {"plant.bristles", std::min(1e-6, rtol / 1000)}}});
  Trotting result;
  const Stopwatch watch;
  for (int i = 1; i <= kTicks; ++i) {
    simulator.RunTo(i / 1000.0);
    result.path.push_back(simulator.context().Eval(plant.state).p_WB);
  }
  result.seconds = watch.seconds();
  result.evaluations = static_cast<double>(simulator.statistics().evaluations);
  return result;
}

Trotting RunMuJoCo(int integrator, int steps_per_ms) {
  const QuadrupedDescription robot = test::DogBot();
  const test::MuJoCoModel model = test::LoadMuJoCo(test::Mjcf(robot, test::kLevelGround));
  model->opt.integrator = integrator;
  model->opt.timestep = 1e-3 / steps_per_ms;
  const test::MuJoCoData data(mj_makeData(model.get()));
  const LeggedState start = test::Standing(robot);
  Eigen::Map<Eigen::VectorXd>(data->qpos, 19) << start.p_WB, start.q_WB, start.q;
  const Vec<12> feedforward = StandingTorque(robot, 9.81);
  Trotting result;
  const Stopwatch watch;
  for (int i = 0; i < kTicks; ++i) {
    const Vec<12> q = Eigen::Map<const Eigen::VectorXd>(data->qpos + 7, 12);
    const Vec<12> qd = Eigen::Map<const Eigen::VectorXd>(data->qvel + 6, 12);
    const Vec<12> torque = kStiffness * (Trot(robot.stance, i / 1000.0) - q) - kDamping * qd + feedforward;
    Eigen::Map<Eigen::VectorXd>(data->qfrc_applied + 6, 12) = torque.cwiseMax(-60.0).cwiseMin(60.0);
    for (int k = 0; k < steps_per_ms; ++k) mj_step(model.get(), data.get());
    result.path.push_back(Eigen::Map<const Eigen::Vector3d>(data->qpos));
  }
  result.seconds = watch.seconds();
  result.evaluations = kTicks * steps_per_ms * (integrator == mjINT_RK4 ? 4.0 : 1.0);
  return result;
}

template <class Run>
void MeasureTrot(benchmark::State& state, const Path& limit, const Run& run) {
  double error = 0, seconds = std::numeric_limits<double>::infinity(), evaluations = 0;
  for (auto _ : state) {
    const Trotting trotting = run();
    seconds = std::min(seconds, trotting.seconds);
    evaluations = trotting.evaluations;
    for (std::size_t i = 0; i < limit.size(); ++i)
      error = std::max(error, (trotting.path[i] - limit[i]).norm());
  }
  state.counters["x_real_time"] = 1e-3 * kTicks / seconds;
  state.counters["error_mm"] = 1e3 * error;
  state.counters["evaluations_per_ms"] = evaluations / kTicks;
}

void TrotTenon(benchmark::State& state, Method method, int order, double rtol) {
  static const Path limit = RunTenon(Method::kErk, 5, 1e-9).path;
  MeasureTrot(state, limit, [&] { return RunTenon(method, order, rtol); });
}

void TrotMuJoCo(benchmark::State& state, int integrator, int steps_per_ms) {
  static const Path limit = RunMuJoCo(mjINT_RK4, 32).path;
  MeasureTrot(state, limit, [&] { return RunMuJoCo(integrator, steps_per_ms); });
}

const int trot_rows = [] {
  const auto row = [](const std::string& name, auto... run) {
    benchmark::RegisterBenchmark(("trot/" + name).c_str(), run...)->Iterations(5);
  };
  row("tenon/order 2 rtol 1e-1", TrotTenon, Method::kErkOpen, 2, 1e-1);
  row("tenon/order 2 rtol 1e-2", TrotTenon, Method::kErkOpen, 2, 1e-2);
  row("tenon/order 2 rtol 1e-3", TrotTenon, Method::kErkOpen, 2, 1e-3);
  row("tenon/order 3 rtol 1e-3", TrotTenon, Method::kErkOpen, 3, 1e-3);
  row("tenon/order 3 rtol 1e-4", TrotTenon, Method::kErkOpen, 3, 1e-4);
  row("tenon/stabilized 2 rtol 1e-1", TrotTenon, Method::kStabilized, 2, 1e-1);
  row("tenon/stabilized 2 rtol 1e-2", TrotTenon, Method::kStabilized, 2, 1e-2);
  row("tenon/stabilized 2 rtol 1e-3", TrotTenon, Method::kStabilized, 2, 1e-3);
  row("tenon/stabilized 3 rtol 1e-1", TrotTenon, Method::kStabilized, 3, 1e-1);
  row("tenon/stabilized 3 rtol 1e-2", TrotTenon, Method::kStabilized, 3, 1e-2);
  row("tenon/stabilized 3 rtol 1e-3", TrotTenon, Method::kStabilized, 3, 1e-3);
  row("mujoco/Euler 1 ms", TrotMuJoCo, mjINT_EULER, 1);
  row("mujoco/Euler 0.5 ms", TrotMuJoCo, mjINT_EULER, 2);
  row("mujoco/Euler 0.25 ms", TrotMuJoCo, mjINT_EULER, 4);
  row("mujoco/RK4 1 ms", TrotMuJoCo, mjINT_RK4, 1);
  row("mujoco/RK4 0.5 ms", TrotMuJoCo, mjINT_RK4, 2);
  row("mujoco/RK4 0.25 ms", TrotMuJoCo, mjINT_RK4, 4);
  return 0;
}();

}  // namespace
}  // namespace tenon
