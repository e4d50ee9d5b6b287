#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::disturbance_observer_test {

using test::DogBot;

DisturbanceObserverParams Params(ObserverKind kind) {
  DisturbanceObserverParams params;
  params.kind = kind;
  params.legs.robot = params.com.robot = params.ndo.robot = DogBot();
  return params;
}

/// A push on a body.
PulseForceParams Push(const ExternalForce& where, const Vec<3>& force) {
  PulseForceParams push{.push = where, .start = 0.3, .duration = 10};
  push.push.force_W = force;
  return push;
}

/// A robot without joint friction that stands by joint PD, and an observer.
struct Cell {
  Cell(ObserverKind kind, const PulseForceParams& pulse) : Cell(Params(kind), pulse) {}
  Cell(const DisturbanceObserverParams& params, const PulseForceParams& pulse) {
    QuadrupedStandParams stand = MakeQuadrupedStand(DogBot());
    stand.pd = {.robot = DogBot(), .stiffness = 500, .damping = 10};
    stand.world.plant.robot.drive.friction = stand.world.plant.robot.drive.damping = 0;
    stand.world.imu.angular_velocity_noise.setZero();
    stand.world.imu.specific_force_noise.setZero();
    stand.world.pulses = {pulse};
    DiagramBuilder builder;
    loop = &builder.Add<QuadrupedStand>("loop", stand);
    observer = &builder.Add<DisturbanceObserver>("observer", params);
    builder.Connect(loop->world.state, observer->state);
    builder.Connect(loop->pd.torque, observer->torque);
    builder.Connect(loop->world.foot_forces, observer->foot_forces);
    builder.Connect(loop->world.inertial, observer->imu);
    simulator = std::make_unique<Simulator>(builder.Build(), RecommendedOptions(*loop));
  }
  const LegForceEstimate& legs() { return simulator->context().Eval(observer->leg_forces); }
  const WrenchEstimate& wrench() { return simulator->context().Eval(observer->wrench); }
  const LeggedState& state() { return simulator->context().Eval(loop->world.state); }

  QuadrupedStand* loop;
  DisturbanceObserver* observer;
  std::unique_ptr<Simulator> simulator;
};

// A force on the trunk is in the estimated wrench, and not in the forces of the legs.
TEST(DisturbanceObserverTest, ForceOnTheTrunk) {
  const Vec<3> force(15, -10, -40);
  const ExternalForce where{.p_B = {0.1, 0.05, 0}};
  Cell cell(ObserverKind::kHybrid, Push(where, force));
  cell.simulator->RunTo(0.29);
  EXPECT_LT(cell.wrench().force_W.norm(), 0.5);
  EXPECT_LT(cell.wrench().torque_W.norm(), 0.1);
  cell.simulator->RunTo(1);
  EXPECT_THAT(cell.wrench().force_W, IsNear(force, 0.01 * force.norm()));
  QuadrupedDynamics dynamics;
  QuadrupedModel(DogBot()).Calc(cell.state(), &dynamics);
  const Vec<3> arm = cell.state().p_WB + cell.state().R_WB() * where.p_B - dynamics.com_W;
  EXPECT_THAT(cell.wrench().torque_W, IsNear(arm.cross(force), 0.02 * force.norm()));
  for (int leg = 0; leg < kNumLegs; ++leg)
    EXPECT_LT(cell.legs().foot_force[leg].norm(), 0.01 * force.norm()) << leg;
}

// A force on the shank of a standing leg is in the wrench and in the torques of this leg.
TEST(DisturbanceObserverTest, ForceOnAStandingLeg) {
  const Vec<3> force(12, 16, -5);
  const ExternalForce where = PointOnLeg(DogBot(), 1, 0.3);
  Cell cell(ObserverKind::kHybrid, Push(where, force));
  cell.simulator->RunTo(1);
  QuadrupedDynamics dynamics;
  QuadrupedModel(DogBot()).Calc(cell.state(), &dynamics);
  EXPECT_THAT(cell.wrench().force_W, IsNear(force, 0.01 * force.norm()));
  EXPECT_LT(cell.legs().joint_torque.head<3>().norm(), 0.02);
  EXPECT_LT(cell.legs().joint_torque.tail<6>().norm(), 0.02);
  EXPECT_GT(cell.legs().joint_torque.segment<3>(3).norm(), 1);
  // The push acts on the shank, at 0.3 of the leg length above the foot.
  const Vec<3> foot = dynamics.feet[1].p_W;
  const Vec<3> knee = dynamics.origin_W[5];
  const Vec<3> p_W = foot + 0.6 * (knee - foot);
  EXPECT_THAT(cell.legs().joint_torque.segment<3>(3),
              IsNear(dynamics.LegJacobian(1, p_W).transpose() * force, 0.05));
}

// The estimate of the nonlinear observer at `time` after a force at a foot begins, for a robot at rest. F is
// the joint torque reduced by the motion of the trunk; the error decays by F_hat' = x M_q^-1 (F - F_hat).
Vec<12> TorqueOfTheNonlinearObserver(const LeggedState& state, int leg, const Vec<3>& force, double x,
                                     double time) {
  QuadrupedDynamics dynamics;
  QuadrupedModel(DogBot()).Calc(state, &dynamics);
  const Vec<3> foot = dynamics.feet[static_cast<std::size_t>(leg)].p_W;
  Vec<6> wrench;
  wrench << force, (foot - dynamics.base_W).cross(force);
  using Eigen::MatrixXd;
  const MatrixXd M = dynamics.M,
                 give_way = test::Solve(M.topLeftCorner(6, 6), M.topRightCorner(6, 12)).transpose();
  Vec<12> F = -give_way * wrench;
  F.segment<3>(3 * leg) += dynamics.LegJacobian(leg, foot).transpose() * force;
  const MatrixXd M_q = M.bottomRightCorner(12, 12) - give_way * M.topRightCorner(6, 12);
  const test::SymmetricModes modes(M_q);
  const Vec<12> reached = 1 - (-x * time * modes.eigenvalues.array().inverse()).exp();
  return modes.eigenvectors * reached.asDiagonal() * modes.eigenvectors.transpose() * F;
}

TEST(DisturbanceObserverTest, EveryKindEstimatesItsPart) {
  const Vec<3> force(12, 16, -5);
  for (const auto& [kind, name] : EnumNames(ObserverKind{})) {
    Cell cell(kind, Push(PointOnLeg(DogBot(), 1, 0), force));
    cell.simulator->RunTo(1);
    const bool hybrid = kind == ObserverKind::kHybrid || kind == ObserverKind::kNdoHybrid;
    const bool legs = hybrid || kind == ObserverKind::kLegs || kind == ObserverKind::kNdoM ||
                      kind == ObserverKind::kNdoInverse;
    const bool com = hybrid || kind == ObserverKind::kCom || kind == ObserverKind::kFocchi;
    EXPECT_EQ(cell.observer->com != nullptr, com) << name;
    EXPECT_EQ(cell.observer->legs != nullptr || cell.observer->ndo != nullptr, legs) << name;
    EXPECT_THAT(cell.wrench().force_W, IsNear(com ? force : Vec<3>(Vec<3>::Zero()), com ? 0.3 : 0)) << name;
    if (kind == ObserverKind::kNdoInverse) {  // its estimate has not settled
      EXPECT_THAT(cell.legs().joint_torque,
                  IsNear(TorqueOfTheNonlinearObserver(cell.state(), 1, force, 0.1, 0.7), 0.05));
      continue;
    }
    EXPECT_THAT(cell.legs().foot_force.front_right,
                IsNear(legs ? force : Vec<3>(Vec<3>::Zero()), legs ? 0.3 : 0))
        << name;
  }
}

// The observer of Focchi et al. has first-order gains of its own: a step is known to 1 - exp(-K t) after t.
TEST(DisturbanceObserverTest, GainsOfFocchi) {
  const Vec<3> force(12, 16, -5);
  for (const double bandwidth : {25., 5.}) {
    DisturbanceObserverParams params = Params(ObserverKind::kFocchi);
    params.focchi.force_bandwidth = bandwidth;
    Cell cell(params, Push(ExternalForce{}, force));
    cell.simulator->RunTo(0.4);
    EXPECT_THAT(cell.wrench().force_W, IsNear((1 - std::exp(-bandwidth * 0.1)) * force, 0.5)) << bandwidth;
  }
}

/// A robot that stands by its whole-body controller, which compensates the estimated disturbance.
WalkingErrors StandUnderPush(ObserverKind kind, const PulseForceParams& pulse) {
  QuadrupedWalkParams params = MakeQuadrupedWalk(DogBot());
  params.walk.segments = {{.duration = 5}};
  params.world.imu.angular_velocity_noise.setZero();
  params.world.imu.specific_force_noise.setZero();
  params.world.pulses = {pulse};
  params.observer = Params(kind);
  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), RecommendedOptions(loop));
  simulator.RunTo(1.3);
  return simulator.context().Eval(loop.errors.errors);
}

// The controller compensates both the joint torque and the wrench of a force on a standing leg. If either
// were missing or counted twice, the ground forces would differ from the plan and the robot would be
// displaced.
TEST(DisturbanceObserverTest, ForceOnAStandingLegIsCompensatedOnce) {
  for (const double height : {0.0, 0.5}) {
    const PulseForceParams push = Push(PointOnLeg(DogBot(), 1, height), {20, 15, -10});
    const WalkingErrors with = StandUnderPush(ObserverKind::kHybrid, push);
    EXPECT_LT(with.com.norm(), 1.5e-3) << height;
    EXPECT_LT(with.ground_force.maxCoeff(), 1.5)
        << height;  // the controller assumes contact at the centres of the feet
    const WalkingErrors legs = StandUnderPush(ObserverKind::kLegs, push);
    const WalkingErrors com = StandUnderPush(ObserverKind::kCom, push);
    const WalkingErrors none = StandUnderPush(ObserverKind::kNone, push);
    EXPECT_GT(legs.com.norm(), 5e-3) << height;
    EXPECT_GT(com.ground_force.maxCoeff(), 5) << height;
    EXPECT_GT(none.ground_force.maxCoeff(), 5) << height;
  }
}

}  // namespace tenon::disturbance_observer_test
