#include <tenon/apps/quadruped/log_estimator.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/io/external_input.h>
#include <tenon/systems/yaml/resources.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon::apps {
namespace {

/// The last sample at each tick, before the first one that.
template <class T>
const OutputPort<T>& Play(DiagramBuilder& builder, const std::string& name, const Recording<T>& samples,
                          Rate rate, const std::string& unit = "") {
  return builder
      .Add<ExternalInput<T>>(
          name, {.initial = samples.front().value, .rate = rate, .unit = unit, .replay = samples})
      .y;
}

struct StandingFeetParams {
  ContactThresholds thresholds = {};
  double weight = 0;  ///< [N]
  Rate rate = Hz(1000);
};

/// Contact states of the feet from their vertical forces.
class StandingFeet final : public LeafSystem<StandingFeetParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<FootForces> forces{this, {"forces"}};
  Scratch<std::array<bool, kNumLegs>> stands{this, "stands", {true, true, true, true}};
  OutputPort<ContactSchedule> schedule{
      this, {"schedule"}, Sampled{params.rate}, Uses(forces, stands), &StandingFeet::CalcSchedule};

 private:
  ContactSchedule CalcSchedule(const FootForces& forces_W, std::array<bool, kNumLegs>& stands_now) const {
    ContactSchedule out;
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      const double ratio = forces_W[static_cast<int>(leg)].z() / params.weight;
      bool& stands_here = stands_now[leg];
      stands_here = ratio > (stands_here ? params.thresholds.leave : params.thresholds.touch);
      out.legs[leg].state = stands_here ? ContactState::kStance : ContactState::kSwing;
    }
    return out;
  }
};

struct RobotViewParams {
  QuadrupedDescription robot;
};

/// Shapes of the robot with the forces on its feet and the estimated force on its trunk.
class RobotView final : public LeafSystem<RobotViewParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<FootForces> feet{this, {"feet"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  OutputPort<Geometry> geometry{
      this,
      {"geometry"},
      MakeQuadrupedGeometry(params.robot, {}, {}),
      Uses(state, feet, wrench),
      [this](const LeggedState& x, const FootForces& forces, const WrenchEstimate& estimate, Geometry* out) {
        ExternalForces external;
        external[0].p_B = params.robot.trunk.com;
        external[0].force_W = estimate.force_W;
        MoveQuadrupedGeometry(params.robot, {}, x, forces, external, out);
      }};
};

/// The pose at the start: that of the log's odometry, or of a robot that stands at the origin.
LeggedState StartOf(const SensorLog& log, const QuadrupedDescription& robot) {
  LeggedState start;
  if (!log.odometry.empty()) {
    TakenOver<LeggedState> at_zero{log.odometry.front().value, 0, {}};
    at_zero.Replay(log.odometry, 0);
    start = at_zero.value;
    start.q = log.joints.front().value.q;
    return start;
  }
  constexpr double kLevelled = 0.1;  // time in which the specific force is averaged [s]
  Vec<3> up_B = Vec<3>::Zero();
  for (const auto& [time, measured] : log.imu)
    if (time <= kLevelled) up_B += measured.specific_force_B;
  const Eigen::Quaterniond level = Eigen::Quaterniond::FromTwoVectors(up_B, Eigen::Vector3d::UnitZ());
  start.q_WB = {level.w(), level.x(), level.y(), level.z()};
  start.q = log.joints.front().value.q;
  for (int leg = 0; leg < kNumLegs; ++leg)
    start.p_WB.z() =
        std::max(start.p_WB.z(), robot.foot_radius - (level * robot.FootPosition(leg, start.q)).z());
  return start;
}

/// Compares two states of a log when the first one has a new sample.
class StateComparison final : public LogSink {
 public:
  StateComparison(const OutputPort<LeggedState>& reference, const OutputPort<LeggedState>& state)
      : reference_(reference), state_(state) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override {
    truth_.Begin(names, &reference_);
    estimated_.Begin(names, &state_);
  }
  void Row(std::span<const double> row) override {
    const LeggedState truth = truth_.In(row);
    if (std::exchange(last_, truth.p_WB) != truth.p_WB) errors_.Add(estimated_.In(row), truth);
  }
  const StateErrors& errors() const { return errors_; }

 private:
  const OutputPort<LeggedState>&reference_, &state_;
  Logged<LeggedState> estimated_, truth_;
  StateErrors errors_;
  Vec<3> last_ = Vec<3>::Constant(std::numeric_limits<double>::quiet_NaN());
};

}  // namespace

static const OutputPort<FootForces>& AddFootForces(DiagramBuilder& builder, const LoadedLog& loaded,
                                                   const OutputPort<LeggedState>& last_state,
                                                   const OutputPort<Vec<12>>& torque,
                                                   const OutputPort<GroundPlane>& ground) {
  const auto& [scenario, walk, log] = loaded;
  if (walk.world.foot_sensor.mounted == FootSensing::kNone) {
    FootForcesOfLegsParams params{.robot = walk.estimator->robot, .rate = log.rate};
    params.initial = walk.estimator->initial;
    auto& of_legs = builder.Add<FootForcesOfLegs>("foot_forces", params);
    builder.Connect(last_state, of_legs.state);
    builder.Connect(torque, of_legs.torque);
    builder.Connect(ground, of_legs.ground);
    return of_legs.forces;
  }
  std::array<const OutputPort<Vec<3>>*, kNumLegs> feet;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    feet[leg] = &Play(builder, std::string("force_") + kLegNames[leg], log.feet[leg], log.rate, "N");
  return builder.AddFunction(
      "foot_forces", Uses(last_state, *feet[0], *feet[1], *feet[2], *feet[3]),
      [](const LeggedState& x, const Vec<3>& fl, const Vec<3>& fr, const Vec<3>& rl, const Vec<3>& rr) {
        const Eigen::Matrix3d R_WB = x.R_WB();
        return FootForces{R_WB * fl, R_WB * fr, R_WB * rl, R_WB * rr};
      });
}

LogEstimator AddLogEstimator(DiagramBuilder& builder, const LoadedLog& loaded) {
  const auto& [scenario, walk, log] = loaded;
  const QuadrupedDescription& robot = walk.estimator->robot;
  auto& estimator = builder.Add<LeggedStateEstimator>("estimator", *walk.estimator);
  auto& observer = builder.Add<DisturbanceObserver>("observer", walk.observer);
  auto& ground = builder.Add<GroundEstimator>("ground", walk.locomotion.ground);
  auto& last_state = builder.Add<UnitDelay<LeggedState>>(
      "last_state", {.initial = walk.estimator->initial, .rate = log.rate});
  auto& last_ground = builder.Add<UnitDelay<GroundPlane>>("last_ground", {.rate = log.rate});
  auto& standing = builder.Add<StandingFeet>(
      "standing", {.weight = robot.mass() * walk.estimator->gravity, .rate = log.rate});
  auto& view = builder.Add<RobotView>("view", RobotViewParams{robot});
  const OutputPort<Vec<12>>& torque = Play(builder, "torque", log.torque, log.rate, "N m");
  const OutputPort<FootForces>& forces = AddFootForces(builder, loaded, last_state.y, torque, last_ground.y);
  builder.Connect(Play(builder, "imu", log.imu, log.rate), estimator.imu);
  builder.Connect(Play(builder, "joints", log.joints, log.rate), estimator.joints);
  builder.Connect(standing.schedule, estimator.schedule);
  builder.Connect(last_ground.y, estimator.ground);
  builder.Connect(forces, standing.forces);
  builder.Connect(estimator.state, ground.state);
  builder.Connect(standing.schedule, ground.schedule);
  builder.Connect(estimator.state, last_state.u);
  builder.Connect(ground.ground, last_ground.u);
  builder.Connect(estimator.state, observer.state);
  builder.Connect(torque, observer.torque);
  builder.Connect(forces, observer.foot_forces);
  builder.Connect(estimator.inertial, observer.imu);
  builder.Connect(last_ground.y, observer.ground);
  builder.Connect(estimator.state, view.state);
  builder.Connect(forces, view.feet);
  builder.Connect(observer.wrench, view.wrench);
  return {estimator, observer, torque, forces, standing.schedule, view.geometry};
}

LoadedLog LoadLog(const std::filesystem::path& file, const QuadrupedScenario& scenario) {
  if (!scenario.walk)
    throw ParameterError(fmt::format(
        "'{}' stands: choose a scenario with a walk, which has estimator and observers, such as flat",
        scenario.case_name));
  LoadedLog loaded{scenario, {}, {}};
  loaded.scenario.walk->state = StateSource::kEstimated;
  loaded.scenario.report = {};  // its plots are of a simulated robot
  loaded.scenario.log = {};
  loaded.walk = Blame("", [&] { return MakeWalkParams(loaded.scenario); });
  QuadrupedWalkParams& walk = loaded.walk;
  loaded.log = ReadSensorLog(file, walk.estimator->robot, LoadRobotLinks(scenario.robot),
                             walk.world.foot_sensor.mounted != FootSensing::kNone);
  walk.estimator->initial = StartOf(loaded.log, walk.estimator->robot);
  walk.estimator->rate = walk.observer.legs.rate = walk.observer.com.rate = walk.observer.ndo.rate =
      walk.locomotion.ground.rate = loaded.log.rate;
  return loaded;
}

RunResult RunEstimate(const std::filesystem::path& file, const QuadrupedScenario& scenario,
                      const RunOptions& options, bool identify) {
  QuadrupedScenario used = scenario;
  if (identify) used.observer = ObserverKind::kCom;
  const LoadedLog loaded = LoadLog(file, used);
  const SensorLog& log = loaded.log;
  for (const std::string& told : log.told) Say(fmt::format("warning: {}\n", told));
  DiagramBuilder builder;
  const LogEstimator blocks = AddLogEstimator(builder, loaded);
  std::vector<const Source*> signals{
      &blocks.estimator.estimate, &blocks.observer.wrench, &blocks.observer.leg_forces,
      &blocks.foot_forces,        &blocks.torque,          &blocks.schedule};
  std::array<const OutputPort<LeggedState>*, 2> poses{};
  if (!log.odometry.empty()) signals.push_back(poses[0] = &Play(builder, "odom", log.odometry, log.rate));
  if (!log.truth.empty()) signals.push_back(poses[1] = &Play(builder, "ground_truth", log.truth, log.rate));
  const OutputPort<Vec<12>>* commands = nullptr;
  if (identify && !log.commands.empty()) commands = &Play(builder, "command", log.commands, log.rate, "N m");
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  std::optional<Identification> identification;
  if (identify) identification.emplace(loaded, blocks, commands, simulator);
  const OutputPort<LeggedState>* const reference = poses[1] != nullptr ? poses[1] : poses[0];
  std::vector<Plot> plots;
  std::shared_ptr<StateComparison> estimated, recorded;
  const auto compare = [&](const OutputPort<LeggedState>& state) {
    const auto sink = std::make_shared<StateComparison>(*reference, state);
    simulator.AddLog(log.rate, {reference, &state}, {sink});
    return sink;
  };
  if (reference != nullptr) estimated = compare(blocks.estimator.state);
  if (poses[0] != nullptr && poses[1] != nullptr) recorded = compare(*poses[0]);
  for (const char* name : {"p_WB", "q_WB", "v_W"}) {
    Plot plot{.title = name, .signals = {fmt::format("estimator.estimate.state.{}", name)}};
    if (reference != nullptr) plot.references = {fmt::format("{}.{}", reference->path(), name)};
    plots.push_back(plot);
  }
  plots.push_back({.title = "disturbance", .signals = {"observer.wrench.force_W"}});
  plots.push_back({.title = "vertical force on the feet", .signals = {}});
  for (const char* leg : kLegNames)
    plots.back().signals.push_back(fmt::format("{}.{}.z", blocks.foot_forces.path(), leg));
  const auto judge = [&](Summary& summary) {
    summary.Set("robot", ResourceName(loaded.scenario.robot));
    summary.Set("observer", EnumName(loaded.walk.observer.kind));
    summary.Set("start_stamp_s", log.start);
    summary.Set("rate_hz", log.rate.hz());
    summary.Set("gaps", static_cast<double>(log.gaps));
    summary.Set("longest_gap_s", log.longest_gap);
    if (reference != nullptr) summary.Set("reference", poses[1] != nullptr ? "ground_truth" : "odom");
    if (estimated) estimated->errors().AddTo(summary);
    if (recorded) recorded->errors().AddTo(summary, "recorded_");
    if (identification) identification->AddTo(summary, options.out, scenario);
    for (const std::string& told : log.told) summary.Note(told);
  };
  const double duration = std::min(log.end, loaded.scenario.duration_s.value_or(log.end));
  return RunScenario(options, loaded.scenario, Describe(loaded.scenario, duration), duration, simulator,
                     signals, {&blocks.geometry}, {}, judge, {}, plots);
}

}  // namespace tenon::apps
