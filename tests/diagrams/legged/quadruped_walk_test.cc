// Closed loops of plant, observers and controllers.

#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <gtest/gtest.h>

namespace tenon::quadruped_walk_test {

WalkSegment Segment(Gait gait, double forward, double duration) {
  return {.gait = gait, .forward = forward, .duration = duration};
}

/// Figures of a walk, from all ticks of the controller.
struct Findings {
  bool fell = false;
  double com = 0, foot = 0;        // largest errors [m]
  double cone = 0;                 // largest ratio of planned tangential to normal force
  double torque = 0;               // largest ratio to the limit
  double slip = 0;                 // largest in one stance [m]
  double ground_force = 0;         // mean error of the ground forces [N]
  long failures = 0;               // of the quadratic programme
  Vec<3> wrench = Vec<3>::Zero();  // last estimate of the force [N]
  Vec<3> end = Vec<3>::Zero();     // last position of the trunk [m]
};

Findings Walk(const QuadrupedWalkParams& params, double duration) {
  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), RecommendedOptions(loop));
  Context& context = simulator.context();
  const Vec<12> limit = WholeBodyController::TorqueLimit(params.world.plant.robot);
  Findings found;
  std::array<Vec<3>, kNumLegs> slip;
  std::array<double, kNumLegs> stood{};  // time since touchdown [s]
  double samples = 0;
  const int ticks = static_cast<int>(std::lround(1000 * duration));
  for (int k = 1; k <= ticks && !found.fell; ++k) {
    found.fell = simulator.AdvanceTo(k / 1000.0).ended;
    const WalkingErrors& errors = context.Eval(loop.errors.errors);
    const WholeBodyPlan& plan = context.Eval(loop.locomotion.plan);
    const ContactSchedule& schedule = context.Eval(loop.locomotion.schedule);
    found.com = std::max(found.com, errors.com.norm());
    found.foot = std::max(found.foot, errors.foot.maxCoeff());
    found.failures = plan.diagnostics.failures;
    found.torque = std::max(
        found.torque, context.Eval(loop.world.plant.joint_torque).cwiseAbs().cwiseQuotient(limit).maxCoeff());
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const auto i = static_cast<std::size_t>(leg);
      const Vec<3>& f = plan.solution.force[leg];
      if (f[2] > 1) found.cone = std::max({found.cone, std::abs(f[0]) / f[2], std::abs(f[1]) / f[2]});
      stood[i] = schedule.legs[i].stance() ? stood[i] + 1e-3 : 0;
      if (stood[i] < 0.012) slip[i].setZero();
      slip[i] += 1e-3 * context.Eval(loop.world.plant.foot_slips)[i];
      found.slip = std::max(found.slip, slip[i].norm());
      if (stood[i] >= 0.012 && schedule.legs[i].time_to_lift_off > 0.012) {
        found.ground_force += errors.ground_force[leg];
        ++samples;
      }
    }
  }
  found.ground_force /= std::max(samples, 1.0);
  found.wrench = context.Eval(loop.observer.wrench).force_W;
  found.end = context.Eval(loop.world.state).p_WB;
  return found;
}

class GaitTest : public ::testing::TestWithParam<Gait> {};
INSTANTIATE_TEST_SUITE_P(QuadrupedWalk, GaitTest,
                         ::testing::Values(Gait::kCrawl, Gait::kTrot, Gait::kPace, Gait::kGallop),
                         [](const auto& info) { return std::string(EnumName(info.param)); });

TEST_P(GaitTest, FollowsItsReferenceWithinFrictionAndTorques) {
  for (const QuadrupedDescription& robot : {test::DogBot(), test::A1()}) {
    QuadrupedWalkParams params = MakeQuadrupedWalk(robot);
    params.walk.segments = {Segment(Gait::kStand, 0, 0.3), Segment(GetParam(), 0.12, 2.7)};
    const Findings found = Walk(params, 3);
    EXPECT_FALSE(found.fell) << robot.name;
    EXPECT_LT(found.com, 5e-3) << robot.name;
    EXPECT_LT(found.foot, 5e-3) << robot.name;
    EXPECT_LT(found.slip, 2e-3) << robot.name;
    EXPECT_LE(found.cone, params.locomotion.whole_body.gains.qp.friction + 1e-6) << robot.name;
    EXPECT_LE(found.torque, 1) << robot.name;
    EXPECT_EQ(found.failures, 0) << robot.name;
    // The ramp to full speed and the wait for the first footstep cost up to a quarter of a second each.
    EXPECT_NEAR(found.end[0], 0.12 * 2.45, 0.03) << robot.name;
    if (GetParam() == Gait::kTrot) {
      EXPECT_LT(found.ground_force, robot.name == "dogbot" ? 2 : 3) << robot.name;
    }
  }
}

TEST(QuadrupedWalkTest, SquatsAndTrotsInPlace) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  WalkSegment squat = Segment(Gait::kStand, 0, 4);
  squat.squat_amplitude = 0.08;
  params.walk.segments = {squat, Segment(Gait::kTrot, 0, 1)};
  const Findings found = Walk(params, 5);
  EXPECT_FALSE(found.fell);
  EXPECT_LT(found.com, 5e-3);
  EXPECT_LT(found.slip, 2e-3);
}

/// The first foot that is late when a trot steps off an edge of 3 cm.
struct LateFoot {
  bool found = false, landed = false;
  double pressed = 0;  // largest force on it until then [N]
};

LateFoot StepDown(double touchdown_force) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.walk.segments = {Segment(Gait::kTrot, 0.12, 3)};
  params.locomotion.scheduler.touchdown_force = touchdown_force;
  QuadrupedPlantParams& plant = params.world.plant;
  plant.terrain.boxes = {{.centre = Vec<2>(-0.6, 0), .size = Vec<2>(2, 2), .height = 0.03, .friction = 1}};
  plant.initial.p_WB[2] += 0.03;
  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), RecommendedOptions(loop));
  LateFoot late;
  int leg = -1;
  for (int k = 1; k <= 3000; ++k) {
    if (simulator.AdvanceTo(k / 1000.0).ended) break;
    const auto& legs = simulator.context().Eval(loop.locomotion.schedule).legs;
    for (int i = 0; i < kNumLegs && leg < 0; ++i) {
      if (legs[static_cast<std::size_t>(i)].state == ContactState::kLate) leg = i;
    }
    if (leg < 0) continue;
    late.found = true;
    late.pressed = std::max(late.pressed, simulator.context().Eval(loop.world.plant.foot_forces)[leg].norm());
    const ContactState state = legs[static_cast<std::size_t>(leg)].state;
    late.landed = state == ContactState::kStance;
    if (state != ContactState::kLate) break;
  }
  return late;
}

// The foot touches down by its own downward motion, with more than the threshold of the touchdown force.
TEST(QuadrupedWalkTest, ALateFootReachesTheTouchdownForce) {
  const double shipped = MakeQuadrupedWalk(test::DogBot()).locomotion.scheduler.touchdown_force;
  const LateFoot foot = StepDown(shipped);
  ASSERT_TRUE(foot.found);
  EXPECT_TRUE(foot.landed);
  EXPECT_GT(foot.pressed, 3 * shipped);
  EXPECT_TRUE(StepDown(5 * shipped).landed) << "with five times the threshold";
}

TEST(QuadrupedWalkTest, ChangesGaitsAndTurnsWhileItWalks) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.walk.segments = {Segment(Gait::kTrot, 0.12, 1), Segment(Gait::kPace, 0.12, 1),
                          Segment(Gait::kCrawl, 0.12, 1.5), Segment(Gait::kTrot, 0.12, 1)};
  for (WalkSegment& segment : params.walk.segments) segment.yaw_rate = 0.3;
  const Findings found = Walk(params, 5);
  EXPECT_FALSE(found.fell);
  EXPECT_LT(found.com, 0.01);
  EXPECT_EQ(found.failures, 0);
}

// The observer compensates a steady pull on the trunk. Without it the CoM is displaced by f / K_p.
TEST(QuadrupedWalkTest, CompensatesWhatItEstimates) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.walk.segments = {Segment(Gait::kTrot, 0.12, 3)};
  params.world.pulses = {{.push = {.force_W = {-20, 0, 0}}, .duration = 10}};
  const Findings with = Walk(params, 2.5);
  EXPECT_NEAR(with.wrench[0], -20, 1);
  params.observer.kind = ObserverKind::kNone;
  const Findings without = Walk(params, 2.5);
  EXPECT_EQ(without.wrench[0], 0);
  EXPECT_GT(without.com, 0.7 * 20 / params.locomotion.whole_body.gains.com_stiffness);
  EXPECT_LT(with.com, 0.5 * without.com);
}

// Walks that use the state estimator, compared with the true state of the plant.

/// DogBot trots from a stand, with noise on all sensors that its controller uses.
QuadrupedWalkParams Trot() {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.world.encoders.angle.absolute = 1e-4;
  params.world.encoders.speed.absolute = 0.02;
  params.world.foot_sensor.error.relative = 0.1;
  params.walk.segments = {{.duration = 0.3}, {.gait = Gait::kTrot, .forward = 0.12, .duration = 10}};
  params.estimator.emplace();
  params.estimator->robot = params.world.plant.robot;
  params.estimator->initial = params.world.plant.initial;
  return params;
}

struct Errors {
  bool ended = false;
  double velocity_rms = 0, velocity_max = 0, tilt_max = 0;
  double weighted = 0;  ///< mean square of the velocity error over its estimated deviation
  Vec<3> drift = Vec<3>::Zero();
  int min_feet = kNumLegs;
  LeggedEstimatorDiagnostics diagnostics;
};

Errors WalkEstimated(const QuadrupedWalkParams& params, double duration) {
  DiagramBuilder builder;
  auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), RecommendedOptions(loop));
  Errors errors;
  const int ticks = static_cast<int>(std::lround(1000 * duration));
  for (int k = 1; k <= ticks && !errors.ended; ++k) {
    errors.ended = simulator.AdvanceTo(1e-3 * k).ended;
    const LeggedState& truth = simulator.context().Eval(loop.world.state);
    const LeggedState& estimate = simulator.context().Eval(loop.estimator->state);
    errors.diagnostics = simulator.context().Eval(loop.estimator->diagnostics);
    const Vec<3> off = estimate.v_W - truth.v_W;
    errors.velocity_rms += off.squaredNorm() / ticks;
    errors.velocity_max = std::max(errors.velocity_max, off.norm());
    errors.weighted += off.cwiseQuotient(errors.diagnostics.velocity_deviation).squaredNorm() / 3 / ticks;
    errors.tilt_max = std::max(errors.tilt_max, (estimate.R_WB().row(2) - truth.R_WB().row(2)).norm());
    errors.drift = estimate.p_WB - truth.p_WB;
    errors.min_feet = std::min(errors.min_feet, errors.diagnostics.feet);
  }
  errors.velocity_rms = std::sqrt(errors.velocity_rms);
  return errors;
}

TEST(QuadrupedWalkEstimatedTest, TrotsByImuEncodersAndContacts) {
  const Errors errors = WalkEstimated(Trot(), 3);
  EXPECT_FALSE(errors.ended);
  EXPECT_LT(errors.velocity_rms, 0.003);
  EXPECT_LT(errors.velocity_max, 0.01);
  EXPECT_LT(errors.tilt_max, 2e-3);
  EXPECT_LT(errors.drift.norm(), 0.005);
  EXPECT_GT(errors.velocity_rms, 1e-4);  // the estimate is not the true state
  EXPECT_LT(errors.weighted, 1);         // the estimated deviation is not too small
  EXPECT_EQ(errors.min_feet, 2);
  EXPECT_EQ(errors.diagnostics.moved_feet, 0);
}

// Feet of 28 mm radius roll forward by some millimetres in each stance. A filter of point feet drifts.
TEST(QuadrupedWalkEstimatedTest, PointFeetWouldDrift) {
  const QuadrupedWalkParams params = Trot();
  QuadrupedWalkParams points = params;
  points.estimator->robot.foot_radius = 0;
  EXPECT_GT(std::abs(WalkEstimated(points, 3).drift[0]), 4 * std::abs(WalkEstimated(params, 3).drift[0]));
}

TEST(QuadrupedWalkEstimatedTest, WalksWithBiasedSensors) {
  QuadrupedWalkParams params = Trot();
  params.world.imu.specific_force_bias = {0.03, -0.02, 0.04};
  params.world.imu.angular_velocity_bias = {0.003, -0.002, 0.002};
  const Errors errors = WalkEstimated(params, 3);
  EXPECT_FALSE(errors.ended);
  EXPECT_LT(errors.velocity_rms, 0.006);
  EXPECT_LT((errors.diagnostics.angular_velocity_bias_B - params.world.imu.angular_velocity_bias).norm(),
            1e-3);
  EXPECT_NEAR(errors.diagnostics.specific_force_bias_B[2], 0.04, 0.005);
}

}  // namespace tenon::quadruped_walk_test
