// The figures of the apps follow blocks that replaced the shipped ones. Figures of ports that only the
// shipped block has are null.

#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/guide_dog/guide_dog_figures.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/diagrams/evaluation/tracking_error.h>

#include <gmock/gmock.h>

namespace tenon::apps::figures_test {

constexpr double kDuration = 0.05;  // [s]

/// A supervisor that passes the command on.
struct OwnSupervisor final : LeafSystem<void> {
  InputPort<WalkCommand> command{this, {"command"}};
  OutputPort<WalkCommand> walk{this, {"walk"}, Uses(command), [](const WalkCommand& walk) { return walk; }};
};

/// A whole-body controller with a spring and a damper at each joint.
struct OwnWholeBody final : LeafSystem<Vec<12>> {
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  OutputPort<Vec<12>> torque{
      this, {"torque", "N m", kJointElements}, Sampled{Hz(1000)}, Uses(state), &OwnWholeBody::CalcTorque};
  OutputPort<WholeBodyPlan> plan{this, {"plan"}, Uses(), [] { return WholeBodyPlan(); }};

 private:
  Vec<12> CalcTorque(const LeggedState& x) const { return 300 * (params - x.q) - 5 * x.qd; }
};

/// An observer that estimates no disturbance.
struct OwnObserver final : LeafSystem<void> {
  OutputPort<WrenchEstimate> wrench{this, {"wrench"}, Uses(), [] { return WrenchEstimate(); }};
  OutputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}, Uses(), [] { return LegForceEstimate(); }};
};

/// An estimator whose input is the true state.
struct OwnEstimator final : LeafSystem<void> {
  InputPort<LeggedState> truth{this, {"truth"}};
  OutputPort<LeggedState> state{this, {"state"}, Uses(truth), [](const LeggedState& x) { return x; }};
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}, Uses(), [] { return ImuMeasurement(); }};
};

/// A block without the ports of the one that it replaces.
class Nothing final : public LeafSystem<void> {};

/// A monitor that sees a fall at 20 ms, or another fault.
struct OwnMonitor final : LeafSystem<std::string> {
  using LeafSystem::LeafSystem;
  Monitor fault{this, params, Sampled{Hz(1000)}, Uses(time),
                [](double time) { return time > 0.02 ? Verdict("it is over") : Verdict(); }};
};

/// An MPC with constant tensions.
struct OwnMpc final : LeafSystem<CableVector> {
  using LeafSystem::LeafSystem;
  InputPort<PlatformEstimate> estimate{this, {"estimate"}};
  OutputPort<CableVector> command{this, {"command", "N"}, params, Uses(), [](CableVector*) {}};
};

/// A PD controller without gains.
struct OwnPd final : LeafSystem<void> {
  InputPort<CdprReference> reference{this, {"reference"}};
  OutputPort<CableVector> command{
      this,
      {"command", "N"},
      CableVector(CableVector::Zero(4)),
      Uses(reference),
      [](const CdprReference& reference, CableVector* command) { *command = reference.tension; }};
};

template <class Scenario>
Scenario Read(const std::string& name, const std::string& app) {
  return LoadScenario(name, {}, app).template Read<Scenario>();
}

/// The figures of a run by their keys; null is "".
std::string Figure(const Summary& summary, const std::string& key) {
  const auto flat = summary.Flat();
  const auto found = std::ranges::find(flat, key, &std::pair<std::string, std::string>::first);
  return found == flat.end() ? "missing" : found->second;
}
void ExpectNull(const Summary& summary, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) EXPECT_EQ(Figure(summary, key), "") << key;
}
void ExpectNumbers(const Summary& summary, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    EXPECT_NE(Figure(summary, key), "") << key;
    EXPECT_NE(Figure(summary, key), "missing") << key;
  }
}

/// Runs a diagram as an app does, with its figures and its report.
Summary RunWith(Simulator& simulator, const std::vector<const Source*>& signals,
                const std::vector<const OutputPort<Geometry>*>& shapes, const auto&... figures) {
  Report report({.title = "replaced blocks", .signal_rate = Hz(100)});
  report.Log(simulator, signals, shapes);
  Summary summary("case", 1, Advance(simulator, kDuration));
  (figures->AddTo(summary), ...);
  return summary;
}

struct WalkTest : ::testing::Test {
  explicit WalkTest(const std::string& scenario = "A1")
      : scenario_(Read<QuadrupedScenario>(scenario, "tenon-quadruped")),
        loop_(builder_.Add<QuadrupedWalk>("loop", MakeWalkParams(scenario_))) {}
  Summary Walk() {
    Simulator simulator(builder_.Build(), MakeSimulatorOptions(scenario_, loop_.world.plant));
    const auto walk = std::make_shared<WalkFigures>(loop_, 0, true, PathVerdict(0.1, 1));
    const auto limits = std::make_shared<LimitFigures>(loop_.world.plant);
    simulator.AddLog(Hz(1000), WalkFigures::Judged(loop_), {walk});
    simulator.AddLog(Hz(1000), LimitFigures::Signals(loop_.world.plant), {limits});
    return RunWith(simulator, WalkFigures::Signals(loop_), WalkFigures::Shapes(loop_), walk, limits);
  }

  QuadrupedScenario scenario_;
  DiagramBuilder builder_;
  QuadrupedWalk& loop_;
};
struct EstimatedWalkTest : WalkTest {
  EstimatedWalkTest() : WalkTest("estimated") {}
};

TEST_F(WalkTest, WithAnotherWholeBodyControllerAndObserver) {
  builder_.Replace<OwnWholeBody>(loop_.locomotion.whole_body, loop_.world.plant.params.robot.stance);
  builder_.Replace<OwnObserver>(loop_.observer);
  const Summary summary = Walk();
  ExpectNull(summary, {"qp_time_median_us", "qp_time_p99_us", "qp_failures"});
  ExpectNumbers(summary, {"com_error_max_m", "force_estimate_error_rms_N", "distance_m",
                          "path_deviation_max_m", "torque_max_N_m", "foot_depth_max_m"});
  EXPECT_EQ(Figure(summary, "force_estimate_mean_N.x"), "0");
  EXPECT_EQ(Figure(summary, "fell"), "false");
}

TEST_F(WalkTest, WithoutItsEvaluation) {
  builder_.Replace<Nothing>(loop_.errors);
  builder_.Replace<Nothing>(loop_.view);
  const Summary summary = Walk();
  ExpectNull(summary, {"com_error_max_m", "foot_error_max_m.front_left", "grf_error_mean_N",
                       "path_deviation_max_m", "followed"});
  ExpectNumbers(summary, {"distance_m", "qp_time_median_us", "force_estimate_error_rms_N"});
}

TEST_F(WalkTest, AFallIsWhatTheMonitorOfFallsSees) {
  builder_.Replace<OwnMonitor>(loop_.world.monitor, "fall");
  const Summary fallen = Walk();
  EXPECT_FALSE(fallen.finished());
  EXPECT_EQ(Figure(fallen, "fell"), "true");
}

TEST_F(WalkTest, AnotherFaultIsNoFall) {
  builder_.Add<OwnMonitor>("mine", "fall");
  const Summary ended = Walk();
  EXPECT_FALSE(ended.finished());
  EXPECT_EQ(Figure(ended, "fell"), "false");
}

TEST_F(EstimatedWalkTest, WithAnotherEstimator) {
  auto& own = builder_.Replace<OwnEstimator>(*loop_.estimator);
  builder_.Connect(loop_.world.state, own.truth);
  const Summary summary = Walk();
  EXPECT_EQ(Figure(summary, "tilt_estimate_error_max_rad"), "missing");
  EXPECT_EQ(Figure(summary, "path_error_max_m"), Figure(summary, "com_error_max_m"));
}

TEST_F(EstimatedWalkTest, HasFiguresOfItsEstimate) {
  ExpectNumbers(Walk(), {"tilt_estimate_error_max_rad", "path_error_max_m", "drift_m"});
}

TEST(GuideDogTest, WithAnotherSupervisor) {
  const auto scenario = Read<GuideDogScenario>("C1", "tenon-guide-dog");
  DiagramBuilder builder;
  auto& loop = builder.Add<GuideDog>("loop", MakeGuideDogParams(scenario));
  builder.Replace<OwnSupervisor>(loop.supervisor);
  Simulator simulator(builder.Build(), MakeSimulatorOptions(scenario, loop.world.plant));
  const auto leash = std::make_shared<GuideDogFigures>(loop);
  const auto walk = std::make_shared<WalkFigures>(loop, 0, true, PathVerdict());
  simulator.AddLog(Hz(1000), GuideDogFigures::Judged(loop), {leash, walk});
  const Summary summary =
      RunWith(simulator, GuideDogFigures::Signals(loop), GuideDogFigures::Shapes(loop), leash, walk);
  ExpectNull(summary, {"tension_mean_N", "stop_delay_s", "heading_error_deg"});
  ExpectNumbers(summary, {"tension_max_N", "com_error_max_m", "qp_time_median_us"});
}

// A script of C3 in place of the robot: the person pulls to the left from 35 to 38 s, the robot turns at 35 s
// by `turned`, stands or walks, and ends `left` beside that direction.
Summary Turn(double turned, bool walks, double left = 0) {
  const auto scenario = Read<GuideDogScenario>("C3", "tenon-guide-dog");
  DiagramBuilder builder;
  auto& loop = builder.Add<GuideDog>("loop", MakeGuideDogParams(scenario));
  Simulator simulator(builder.Build(), MakeSimulatorOptions(scenario, loop.world.plant));
  const auto log = std::make_shared<MemoryLog>();
  simulator.AddLog(Hz(1000), GuideDogFigures::Judged(loop), {log});
  simulator.RunTo(0);
  std::vector<double> row(log->row(0).begin(), log->row(0).end());
  const auto set = [&](const std::string& signal, double value) {
    const auto found = std::ranges::find_if(
        log->names(), [&](const std::string& name) { return name.starts_with("loop." + signal); });
    row.at(static_cast<std::size_t>(found - log->names().begin())) = value;
  };
  GuideDogFigures figures(loop, scenario.task);
  figures.Begin(log->names(), {});
  const auto step = [&](double time, GuideMode mode, double yaw) {
    row[0] = time;
    set("leash.leash.tension", 30);
    set("leash.leash.direction_W.x", 0);
    set("leash.leash.direction_W.y", -1);
    set("supervisor.status.mode", static_cast<double>(mode));
    set("world.plant.state.q_WB.w", std::cos(yaw / 2));
    set("world.plant.state.q_WB.z", std::sin(yaw / 2));
    figures.Row(row);
  };
  for (int k = 33000; k <= 60000; ++k) {
    const double time = 1e-3 * k;
    const GuideMode after = walks ? GuideMode::kMove : GuideMode::kStop;
    step(time,
         time < 35   ? GuideMode::kStop
         : time < 36 ? GuideMode::kTurn
                     : after,
         time < 36   ? 0
         : time < 58 ? turned
                     : turned + left);
  }
  Summary summary("case", 1, {.status = {.time = 60}});
  figures.AddTo(summary);
  return summary;
}

TEST(GuideDogTest, ACaseWithoutItsTurnIsNotFinished) {
  const double pull = std::numbers::pi / 2;
  EXPECT_EQ(Figure(Turn(pull, true), "finished"), "true");
  for (const auto& [summary, why] : {std::pair{Turn(0.1, true), "along the pull"},
                                     {Turn(pull, false), "along the pull"},
                                     {Turn(pull, true, 0.1), "left the direction"}}) {
    EXPECT_EQ(Figure(summary, "finished"), "false");
    EXPECT_THAT(Figure(summary, "end_reason"), ::testing::HasSubstr(why));
  }
}

/// Runs D1 with the controller of the scenario replaced.
Summary FlyD1(CdprController controller, const auto& replace) {
  auto scenario = Read<CdprScenario>("D1", "tenon-cdpr");
  scenario.controller = controller;
  DiagramBuilder builder;
  auto& loop = builder.Add<CdprLoop>("loop", MakeLoopParams(scenario));
  replace(builder, loop);
  Simulator simulator(builder.Build(), MakeSimulatorOptions(scenario));
  const auto figures = std::make_shared<CdprFigures>(loop, 1, 2, PathVerdict(0.1, 1));
  simulator.AddLog(Hz(1000), CdprFigures::Signals(loop), {figures});
  const auto limits = std::make_shared<CdprLimits>(loop, 0.003);
  simulator.AddLog(Hz(1000), CdprLimits::Signals(loop), {limits});
  std::shared_ptr<MpcFigures> solves;
  if (const CdprMpc* mpc = loop.control.mpc) {
    solves = std::make_shared<MpcFigures>(*mpc);
    simulator.AddLog(Hz(100), MpcFigures::Signals(*mpc), {solves});
  }
  Summary summary = RunWith(simulator, CdprFigures::Signals(loop), {&loop.world.plant.geometry}, limits);
  EXPECT_TRUE(summary.finished());
  figures->AddTo(summary);
  if (solves) solves->AddTo(summary);
  return summary;
}

TEST(CdprTest, WithAnotherMpc) {
  const Summary summary = FlyD1(CdprController::kMpcEquilibrium, [](DiagramBuilder& builder, CdprLoop& loop) {
    builder.Replace<OwnMpc>(*loop.control.mpc, loop.reference.params.path->At(0).tension);
  });
  ExpectNull(summary, {"mpc_time_median_us", "mpc_fallbacks"});
  ExpectNumbers(summary, {"tension_max_N", "command_max_N", "tracking_error_rms_m", "cable_distance_min_m"});
}

TEST(CdprTest, WithAnotherPd) {
  const Summary summary = FlyD1(CdprController::kPd, [](DiagramBuilder& builder, CdprLoop& loop) {
    builder.Replace<OwnPd>(*loop.control.pd);
  });
  ExpectNumbers(summary, {"tension_max_N", "command_max_N", "tracking_error_rms_m", "turn_max_rad"});
}

TEST(CdprTest, WithItsMpc) {
  const Summary summary = FlyD1(CdprController::kMpcEquilibrium, [](DiagramBuilder&, CdprLoop&) {});
  ExpectNumbers(summary, {"mpc_time_median_us", "mpc_fallbacks", "tracking_error_rms_m"});
}

}  // namespace tenon::apps::figures_test
