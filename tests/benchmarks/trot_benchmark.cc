// Work against precision: DogBot trots on the spot for a second by joint PD at 1 kHz, in Tenon and in MuJoCo.
//
//   x_real_time  simulated time over processor time, the best of three runs
//   error_mm     largest distance of the trunk, over all ticks, from the same engine's run at its limit:
//   order 5
//                and rtol = 1e-9 here, RK4 with steps of 1/32 ms there
//
// Each engine against its own limit, because their contacts differ: compliant feet with bristle friction
// here, MuJoCo's soft constraints with its default settings there. So this compares integration, not contact
// models.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <vector>

#include "tenon/controllers/joint_pd.h"
#include "tenon/plants/quadruped_plant.h"
#include "tenon/systems/diagram_builder.h"
#include "tenon/systems/simulator.h"
#include "tenon/tests/plants/quadruped_mujoco.h"
#include "tenon/tests/plants/quadruped_test_robot.h"

namespace tenon {
namespace {

constexpr double kStiffness = 300, kDamping = 8;  // [N m/rad], [N m s/rad]
constexpr int kTicks = 1000;                      // of 1 ms
using Path = std::vector<Vec<3>>;                 // of the trunk, at the ticks

/// The stance, the legs of one diagonal after the other folded by up to 0.2 rad at the hip in 0.15 s.
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
  double seconds;  // of the processor
};

class Stopwatch {
 public:
  double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t start_ = std::clock();
};

Trotting RunTenon(int order, double rtol) {
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
  const auto diagram = builder.Build();
  const double scale = rtol / 1e-3;  // QuadrupedPlant's tolerances
  Simulator simulator(*diagram, {.order = order,
                                 .rtol = rtol,
                                 .atol = 1e-5 * scale,
                                 .state_atol = {{"plant.motion.v_W", 1e-3 * scale},
                                                {"plant.motion.w_W", 1e-3 * scale},
                                                {"plant.motion.qd", 1e-3 * scale},
                                                {"plant.bristles", 1e-6 * scale}}});
  Trotting result;
  const Stopwatch watch;
  for (int i = 1; i <= kTicks; ++i) {
    simulator.AdvanceTo(i / 1000.0);
    result.path.push_back(simulator.context().Eval(plant.state).p_WB);
  }
  result.seconds = watch.seconds();
  return result;
}

Trotting RunMuJoCo(int integrator, int steps_per_ms) {
  const QuadrupedDescription robot = test::DogBot();
  const test::MuJoCoModel model = test::LoadMuJoCo(test::Mjcf(robot, true));
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
  return result;
}

template <class Run>
void Measure(benchmark::State& state, const Path& limit, const Run& run) {
  double error = 0, seconds = std::numeric_limits<double>::infinity();
  for (auto _ : state) {
    const Trotting trotting = run();
    seconds = std::min(seconds, trotting.seconds);
    for (std::size_t i = 0; i < limit.size(); ++i)
      error = std::max(error, (trotting.path[i] - limit[i]).norm());
  }
  state.counters["x_real_time"] = 1e-3 * kTicks / seconds;
  state.counters["error_mm"] = 1e3 * error;
}

void Tenon(benchmark::State& state) {
  static const Path limit = RunTenon(5, 1e-9).path;
  const double rtol = std::pow(10, -static_cast<double>(state.range(1)));
  Measure(state, limit, [&] { return RunTenon(static_cast<int>(state.range(0)), rtol); });
}
BENCHMARK(Tenon)
    ->Name("tenon")
    ->ArgNames({"order", "minus_log10_rtol"})
    ->ArgsProduct({{2, 3}, {2, 3, 4}})
    ->Iterations(3);

void MuJoCo(benchmark::State& state) {
  static const Path limit = RunMuJoCo(mjINT_RK4, 32).path;
  const int integrator = state.range(0) == 4 ? mjINT_RK4 : mjINT_EULER;
  Measure(state, limit, [&] { return RunMuJoCo(integrator, static_cast<int>(state.range(1))); });
}
BENCHMARK(MuJoCo)
    ->Name("mujoco")
    ->ArgNames({"order", "steps_per_ms"})
    ->ArgsProduct({{1, 4}, {1, 2, 4}})
    ->Iterations(3);

}  // namespace
}  // namespace tenon
