// A person, a leash, the supervisor and the admittance filter with a kinematic robot, which follows its
// commands exactly but takes new ones only at its footsteps. The force is filtered with 20 rad/s, like by an
// observer.

#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/controllers/guide_dog/supervisor.h>
#include <tenon/plants/surroundings/leash.h>
#include <tenon/plants/surroundings/person.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/simulation/simulator.h>

#include <gmock/gmock.h>

#include <numbers>

namespace tenon::leash_walk_test {

constexpr double kForward = 0.12;  // [m/s]

/// A trunk that moves with the velocities of its last command.
class KinematicRobot final : public LeafSystem<void> {
 public:
  InputPort<WalkCommand> command{this, {"command"}};
  ContinuousState<Vec<3>> pose{this, {"pose", "m, m, rad", "x, y, yaw"}};
  OutputPort<Vec<3>> pose_port{this, pose};
  DiscreteState<WalkCommand> taken{this, {"taken"}};
  Update<WalkCommand> take{taken, Sampled{Seconds(0.265)}, Uses(command),
                           [](const WalkCommand& command) -> WalkCommand { return command; }};
  TimeDerivative<Vec<3>> dpose{pose, Uses(pose, taken), &KinematicRobot::Velocity};
  OutputPort<LeggedState> state{this, {"state"}, Uses(pose, taken), &KinematicRobot::CalcState};

 private:
  Vec<3> Velocity(const Vec<3>& pose, const WalkCommand& taken) const {
    const double c = std::cos(pose[2]), s = std::sin(pose[2]);
    return {c * taken.forward - s * taken.left, s * taken.forward + c * taken.left, taken.yaw_rate};
  }
  LeggedState CalcState(const Vec<3>& pose, const WalkCommand& taken) const {
    const Vec<3> velocity = Velocity(pose, taken);
    LeggedState x{.p_WB = {pose[0], pose[1], 0.43},
                  .q_WB = QuaternionFromRotationVector({0, 0, pose[2]}),
                  .v_W = {velocity[0], velocity[1], 0}};
    x.w_W[2] = velocity[2];
    return x;
  }
};

struct Walk {
  std::vector<PersonPhase> phases = {};
  std::function<WalkCommand(double)> command = [](double) -> WalkCommand {
    return {.gait = Gait::kTrot, .forward = kForward};
  };
  PersonParams person = {};
  LeashParams leash = {};
  Vec<2> obstacle{1e3, 0};  ///< seen from 1 m away, within 0.5 m of the path [m]
};

/// Runs a walk and logs it at 100 Hz.
class WalkRun {
 public:
  WalkRun(const Walk& walk, double duration) {
    DiagramBuilder builder;
    auto& robot = builder.Add<KinematicRobot>("robot");
    PersonParams walker = walk.person;
    walker.start = {-1.7, 0};
    walker.phases = walk.phases;
    auto& person = builder.Add<Person>("person", walker);
    auto& leash = builder.Add<Leash>("leash", walk.leash);
    auto& observer =
        builder.Add<LowPassFilter<Vec<3>>>("observer", LowPassFilterParams<Vec<3>>{.time_constant = 0.05});
    auto& supervisor = builder.Add<Supervisor>("supervisor");
    auto& filter = builder.Add<AdmittanceFilter>("filter");
    auto& command = builder.AddFunction({"command"}, Uses(builder.time), walk.command);
    auto& force = builder.AddFunction({"force"}, Uses(leash.force),
                                      [](const ExternalForce& on) -> Vec<3> { return on.force_W; });
    auto& wrench =
        builder.AddFunction({"wrench"}, Uses(observer.y), [](const Vec<3>& force_W) -> WrenchEstimate {
          return {force_W, Vec<3>::Zero()};
        });
    auto& obstacle = builder.AddFunction(
        {"obstacle"}, Uses(robot.pose_port), [at = walk.obstacle](const Vec<3>& pose) -> bool {
          const Vec<2> to = at - pose.head<2>();
          const double c = std::cos(pose[2]), s = std::sin(pose[2]);
          const double ahead = c * to[0] + s * to[1], aside = c * to[1] - s * to[0];
          return ahead > 0 && ahead < 1 && std::abs(aside) < 0.5;
        });
    builder.Connect(robot.state, leash.robot);
    builder.Connect(person.person, leash.person);
    builder.Connect(leash.leash, person.leash);
    builder.Connect(force, observer.u);
    builder.Connect(command, supervisor.command);
    builder.Connect(wrench, supervisor.wrench);
    builder.Connect(robot.state, supervisor.state);
    builder.Connect(obstacle, supervisor.obstacle);
    builder.Connect(supervisor.walk, filter.command);
    builder.Connect(wrench, filter.wrench);
    builder.Connect(robot.state, filter.state);
    builder.Connect(filter.walk, robot.command);
    diagram_ = builder.Build();
    Simulator simulator(*diagram_, {.order = 3, .rtol = 1e-5, .atol = 1e-7});
    log_ = simulator.AddLog(Hz(100), {&leash.leash, &person.person, &person.intent, &robot.pose_port,
                                      &robot.state, &supervisor.status, &filter.motion});
    simulator.RunTo(duration);
  }
  /// The values of a signal from `from` to `to` [s].
  std::vector<double> operator()(const std::string& column, double from, double to) const {
    const std::vector<double> all = log_->column(column);
    return {all.begin() + std::lround(100 * from), all.begin() + std::lround(100 * to) + 1};
  }
  double operator()(const std::string& column, double at) const { return (*this)(column, at, at).front(); }
  /// The first time after `from` at which the mode is `mode`, or infinity [s].
  double When(GuideMode mode, double from) const {
    const std::vector<double> modes = log_->column("supervisor.status.mode");
    for (auto i = static_cast<std::size_t>(std::lround(100 * from)); i < modes.size(); ++i)
      if (modes[i] == static_cast<double>(mode)) return 0.01 * static_cast<double>(i);
    return INFINITY;
  }

 private:
  std::shared_ptr<const Diagram> diagram_;
  std::shared_ptr<MemoryLog> log_;
};

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}
double Max(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}
double Min(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

PersonPhase Follow(double duration, double speed) {
  return {.activity = Activity::kFollow, .duration = duration, .speed = speed};
}
PersonPhase Stand(double duration) {
  return {.activity = Activity::kWalk, .duration = duration};
}

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// Expects about the desired tension and a constant length of the leash between two times.
void ExpectSteady(const WalkRun& run, double from, double to) {
  const auto tension = run("leash.leash.tension", from, to), length = run("leash.leash.length", from, to);
  EXPECT_NEAR(Mean(tension), 30, 3);
  EXPECT_GT(Min(tension), 20);
  EXPECT_LT(Max(tension), 40);
  EXPECT_GT(Min(length), 0.97 * Mean(length));
  EXPECT_LT(Max(length), 1.03 * Mean(length));
}

TEST(LeashWalkTest, AdaptsToThePersonAndStopsWithThePerson) {
  const WalkRun run({.phases = {Follow(15, 0.07), Follow(25, 0.10), Follow(22, 0.05)}}, 82);
  ExpectSteady(run, 5, 62);
  EXPECT_NEAR(Mean(run("robot.state.v_W.x", 8, 14)), 0.07, 0.001);
  EXPECT_NEAR(Mean(run("robot.state.v_W.x", 20, 39)), 0.10, 0.001);
  EXPECT_NEAR(Mean(run("robot.state.v_W.x", 45, 61)), 0.05, 0.001);

  // The robot moves on until the standing person pulls with more than 50 N.
  const double stop = run.When(GuideMode::kStop, 0);
  const auto before = run("leash.leash.tension", 0, stop - 1);
  EXPECT_GT(stop, 62);
  EXPECT_LT(stop, 67);
  EXPECT_LT(Max(before), 50);
  EXPECT_GT(run("leash.leash.tension", stop), 50);
  EXPECT_LT(Max(run("leash.leash.tension", 0, 82)), 60);
  EXPECT_EQ(Max(run("robot.state.v_W.x", stop + 0.3, 82)), 0);
  EXPECT_EQ(run.When(GuideMode::kTurn, 0), INFINITY)
      << "the pull that stops the robot does not start it again";
}

TEST(LeashWalkTest, FollowsAPersonOfChangingSpeed) {
  PersonPhase sine = Follow(101, 0.08);
  sine.speed_amplitude = 0.04;
  sine.angular_frequency = 0.2;
  const WalkRun run({.phases = {sine}}, 100);
  ExpectSteady(run, 5, 100);
  for (double t = 5; t < 100; t += 0.1)
    EXPECT_NEAR(run("robot.state.v_W.x", t), run("person.intent.speed", t), 0.008) << t;
}

// Other masses and stiffnesses of the person, and another leash.
TEST(LeashWalkTest, HoldsTheTensionOfOtherPeople) {
  for (const double mass : {45.0, 100.0}) {
    for (const double stiffness : {300.0, 1500.0}) {
      for (const double leash : {100.0, 300.0}) {
        Walk walk{.phases = {Follow(15, 0.07), Follow(25, 0.10), Follow(20, 0.05)}};
        walk.person.mass = mass;
        walk.person.stiffness = stiffness;
        walk.person.damping = 2 * std::sqrt(mass * stiffness);
        walk.leash.stiffness = leash;
        SCOPED_TRACE(::testing::Message() << mass << " kg, " << stiffness << " and " << leash << " N/m");
        ExpectSteady(WalkRun(walk, 60), 8, 60);
      }
    }
  }
}

TEST(LeashWalkTest, LeadsThePersonAlongACurve) {
  const WalkRun run(
      {.phases = {Follow(100, 0.09)},
       .command = [](double t) -> WalkCommand {
         return {
             .gait = Gait::kTrot, .forward = kForward, .left = 0, .yaw_rate = t > 10 && t < 50 ? 0.05 : 0};
       }},
      100);
  ExpectSteady(run, 5, 100);
  EXPECT_NEAR(run("robot.pose.yaw", 100.0), 2, 0.05);
  double last = 0;
  for (double t = 5; t < 100; t += 0.5) {
    const Vec<2> v(run("person.person.v_W.x", t), run("person.person.v_W.y", t));
    EXPECT_NEAR(v.norm(), 0.09, 0.003) << t;
    const double heading = std::atan2(v[1], v[0]);
    EXPECT_LT(std::abs(heading - last), 0.05) << "the person turns smoothly";
    last = heading;
  }
  EXPECT_NEAR(last, 2, Radians(10));
}

/// The robot stops before an obstacle. The person steps to the left and pulls there at 31 s.
Walk AtTheObstacle() {
  return {.phases = {Follow(23, 0.09),
                     {.activity = Activity::kWalk, .duration = 5, .speed = 0.44, .direction = Radians(47)},
                     Stand(3),
                     {.activity = Activity::kPull, .duration = 6, .direction = Radians(90), .force = 75},
                     Follow(100, 0.09)},
          .obstacle = {2.8, 0}};
}

TEST(LeashWalkTest, StopsAtAnObstacleAndGoesWhereThePersonPulls) {
  const WalkRun run(AtTheObstacle(), 90);
  const double stop = run.When(GuideMode::kStop, 0), turn = run.When(GuideMode::kTurn, 0);
  EXPECT_LT(stop, 22);
  EXPECT_LT(Max(run("robot.pose.x", stop, 31)), 1.8 + 0.265 * 0.1);
  EXPECT_LT(Mean(run("leash.leash.tension", stop + 2, 23)), 3) << "the person feels the stop";
  EXPECT_GT(turn, 31);
  EXPECT_LT(turn, 35);
  const double move = run.When(GuideMode::kMove, turn);
  EXPECT_LT(move, turn + 10);
  const Vec<2> pull(-run("leash.leash.direction_W.x", turn), -run("leash.leash.direction_W.y", turn));
  const double yaw = run("robot.pose.yaw", 90.0);
  EXPECT_NEAR(yaw, std::atan2(pull[1], pull[0]), Radians(2)) << "the direction of the force";
  EXPECT_NEAR(yaw, Radians(90), Radians(5)) << "the direction that the person means";
  EXPECT_EQ(run.When(GuideMode::kStop, turn), INFINITY);
  // The robot passes the person and leads again.
  ExpectSteady(run, 65, 90);
  EXPECT_GT(run("robot.pose.y", 90.0), run("person.person.p_W.y", 90.0) + 1.5);
}

TEST(LeashWalkTest, WaitsAtTheObstacleWithoutAPull) {
  Walk walk = AtTheObstacle();
  walk.phases.resize(3);
  const WalkRun run(walk, 90);
  const double stop = run.When(GuideMode::kStop, 0);
  EXPECT_LT(stop, 22);
  EXPECT_EQ(run.When(GuideMode::kTurn, 0), INFINITY);
  EXPECT_EQ(run.When(GuideMode::kMove, stop), INFINITY);
  EXPECT_LT(run("robot.pose.x", 90.0), 1.83);
}

}  // namespace tenon::leash_walk_test
