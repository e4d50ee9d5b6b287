#include <tenon/controllers/legged/whole_body/whole_body_controller.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::whole_body_controller_test {

WholeBodyParams Params() {
  return {.robot = test::DogBot()};
}

/// All inputs of the controller, for a robot that stands still at its reference.
struct Inputs {
  explicit Inputs(const QuadrupedDescription& robot)
      : model(robot), arm(0, 0, -robot.foot_radius), state(test::Standing(robot)) {
    Follow();
  }
  /// References at the present state, at rest.
  void Follow() {
    model.Calc(state, &dynamics);
    body = {};
    body.com_W = dynamics.com_W;
    body.q_WB = state.q_WB;
    feet = {};
    for (int leg = 0; leg < kNumLegs; ++leg) feet[leg].p_W = dynamics.feet[leg].p_W;
    StandOnContacts();
  }
  void Swing(std::initializer_list<int> legs) {
    for (const int leg : legs) schedule.legs[leg].state = ContactState::kSwing;
    model.Calc(state, &dynamics);
    StandOnContacts();
  }
  void Give(TestRig<WholeBodyController>& rig) const {
    WholeBodyController& block = rig.system();
    rig.Fix(block.state, state).Fix(block.schedule, schedule).Fix(block.body, body).Fix(block.feet, feet);
    rig.Fix(block.wrench, wrench).Fix(block.leg_forces, leg_forces);
  }

  Vec<3> FootAcceleration(int leg, const Vec<18>& acceleration) const {
    return dynamics.FootJacobian(leg) * acceleration + dynamics.feet[leg].bias;
  }

  QuadrupedModel model;
  Vec<3> arm;                  ///< from a foot's centre to the ground
  QuadrupedDynamics dynamics;  ///< with the stance feet's points in contact
  LeggedState state;
  ContactSchedule schedule;
  BodyReference body;
  FeetReference feet;
  WrenchEstimate wrench;
  LegForceEstimate leg_forces;

 private:
  void StandOnContacts() {
    for (int leg = 0; leg < kNumLegs; ++leg)
      if (schedule.legs[leg].stance()) dynamics.feet[leg] = dynamics.Contact(leg, arm);
  }
};

/// The controller after its first tick with these inputs.
struct Ticked : TestRig<WholeBodyController> {
  explicit Ticked(const Inputs& inputs, const WholeBodyParams& params = Params()) : TestRig(params) {
    inputs.Give(*this);
    Tick();
  }
};

/// nu' of a robot whose stance feet the ground holds, under torques and a generalised force.
Vec<18> StandingDynamics(const QuadrupedDynamics& dynamics, const ContactSchedule& schedule,
                         const Vec<12>& torque, const Vec<18>& force) {
  const int size = 18 + 3 * schedule.num_stance();
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right(size);
  kkt.topLeftCorner(18, 18) = dynamics.M;
  right.head(18) = force - dynamics.bias();
  right.segment(6, 12) += torque;
  int row = 18;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (!schedule.legs[leg].stance()) continue;
    kkt.block(row, 0, 3, 18) = dynamics.FootJacobian(leg);
    kkt.block(0, row, 18, 3) = dynamics.FootJacobian(leg).transpose();
    right.segment(row, 3) = -dynamics.feet[leg].bias;
    row += 3;
  }
  return test::Solve(kkt, right).topRows(18);
}

TEST(WholeBodyController, StandsStillAndCarriesALoadOnTheTrunk) {
  for (const Vec<3>& load : {Vec<3>(0, 0, 0), Vec<3>(0, 0, -100)}) {
    Inputs inputs(Params().robot);
    inputs.wrench.force_W = load;
    inputs.wrench.torque_W = Vec<3>(0.03, -0.04, 0) * load.norm();
    Ticked rig(inputs);
    Vec<3> sum = Vec<3>::Zero();
    for (int leg = 0; leg < kNumLegs; ++leg) sum += rig[rig->plan].solution.force[leg];
    EXPECT_THAT(sum, IsNear(Vec<3>(0, 0, inputs.model.mass() * 9.81 - load[2]), 1e-2));
    Vec<18> force = Vec<18>::Zero();
    Vec<6> wrench;
    wrench << load, inputs.wrench.torque_W;
    force.head<6>() = AboutBase(inputs.dynamics, wrench);
    const Vec<18> a = StandingDynamics(inputs.dynamics, inputs.schedule, rig[rig->torque], force);
    EXPECT_THAT(a, IsNear(Vec<18>(Vec<18>::Zero()), 1e-2));
    EXPECT_EQ(rig[rig->diagnostics].failures, 0);
  }
}

// Each gain alone, by the acceleration of the model with its stance feet fixed.
TEST(WholeBodyController, ErrorsAreCorrectedAsTheGainsSay) {
  WholeBodyParams params = Params();
  Inputs inputs(params.robot);
  const double m = inputs.model.mass();
  const auto realised = [&](const BodyReference& body) {
    Inputs given = inputs;
    given.body = body;
    Ticked rig(given, params);
    return StandingDynamics(inputs.dynamics, inputs.schedule, rig[rig->torque], Vec<18>::Zero());
  };
  const auto com = [&](const Vec<18>& a) {
    return Vec<3>(inputs.dynamics.M.topRows<3>() * a / m + inputs.dynamics.com_bias_W);
  };
  BodyReference body = inputs.body;
  body.com_W += Vec<3>(0.01, -0.005, 0.004);
  EXPECT_THAT(com(realised(body)), IsNear(Vec<3>(Vec<3>(25, -12.5, 10) / m), 5e-3));
  body = inputs.body;
  body.com_velocity_W += Vec<3>(0.05, 0.02, -0.03);
  EXPECT_THAT(com(realised(body)), IsNear(Vec<3>(Vec<3>(20, 8, -12) / m), 5e-3));
  body = inputs.body;
  body.com_acceleration_W = Vec<3>(0.5, -1, 1.5);
  EXPECT_THAT(com(realised(body)), IsNear(body.com_acceleration_W, 5e-3));

  const auto spin = [&](const Vec<18>& a) {  // L' = I_com alpha wanted
    return Vec<3>(test::Solve(inputs.dynamics.centroidal_inertia_W, inputs.dynamics.angular_map * a));
  };
  body = inputs.body;
  body.q_WB = QuaternionProduct(QuaternionFromRotationVector({0.01, -0.02, 0.005}), inputs.body.q_WB);
  EXPECT_THAT(spin(realised(body)), IsNear(Vec<3>(2.5, -5, 1.25), 2e-2));
  body = inputs.body;
  body.w_W = Vec<3>(0.02, 0.03, -0.01);
  body.alpha_W = Vec<3>(1, 0, 2);
  EXPECT_THAT(spin(realised(body)), IsNear(Vec<3>(2, 1.5, 1.5), 2e-2));
}

// The task of the optimisation.
WholeBodyTask TaskFor(const Inputs& inputs, const BodyReference& body, const WholeBodyGains& gains) {
  TestRig<WholeBodyController> rig(Params());
  return rig->MakeTask(inputs.dynamics, inputs.state, inputs.schedule, body, inputs.feet, inputs.wrench,
                       inputs.leg_forces, {}, gains);
}

// Inside the layer the feedback is linear, outside it is the largest one plus lambda e'.
TEST(WholeBodyController, SlidingModeReplacesTheFeedback) {
  Inputs inputs(Params().robot);
  inputs.Swing({1});
  const double m = inputs.model.mass();
  const SlidingMode law{.slope = 8, .reach = 20, .layer = 0.02};
  const WholeBodyGains sliding{.sliding = SlidingGains{law, law, law}};
  const WholeBodyGains linear{.com_stiffness = 160 * m,
                              .com_damping = 28 * m,
                              .trunk_stiffness = 160,
                              .trunk_damping = 28,
                              .swing_stiffness = 160,
                              .swing_damping = 28};
  BodyReference body = inputs.body;
  body.com_W += Vec<3>(0.01, -0.005, 0.004);
  body.com_velocity_W += Vec<3>(0.02, 0.01, -0.03);
  body.w_W = Vec<3>(0.02, 0.03, -0.01);
  inputs.feet[1].p_W = inputs.dynamics.feet[1].p_W + Vec<3>(0, 0.01, -0.01);
  const WholeBodyTask inside = TaskFor(inputs, body, sliding), expected = TaskFor(inputs, body, linear);
  EXPECT_THAT(inside.wrench, IsNear(expected.wrench, 1e-9));
  EXPECT_THAT(inside.foot_acceleration[1], IsNear(expected.foot_acceleration[1], 1e-9));
  body = inputs.body;
  body.com_W += Vec<3>(0.05, 0, 0);
  EXPECT_NEAR(TaskFor(inputs, body, sliding).wrench[0], m * 20 * 8 * 0.02, 1e-9);
}

TEST(WholeBodyController, ErrorsOfTheCoMAndOfTheHeadingSaturate) {
  const Inputs inputs(Params().robot);
  const double weight = inputs.model.mass() * 9.81;
  BodyReference body = inputs.body;
  body.com_W += Vec<3>(0.03, -0.04, 0);
  EXPECT_THAT(TaskFor(inputs, body, {.com_limit = 0.05}).wrench.head<3>(),
              IsNear(Vec<3>(75, -100, weight), 1e-9));
  EXPECT_THAT(TaskFor(inputs, body, {.com_limit = 0.01}).wrench.head<3>(),
              IsNear(Vec<3>(15, -20, weight), 1e-9));
  body = inputs.body;
  body.q_WB = QuaternionFromRotationVector({0, 0, 1});
  const Vec<3> full = inputs.dynamics.centroidal_inertia_W * Vec<3>(0, 0, 250);
  EXPECT_THAT(TaskFor(inputs, body, {.turn_limit = 2}).wrench.tail<3>(), IsNear(full, 1e-9));
  EXPECT_THAT(TaskFor(inputs, body, {.turn_limit = 0.2}).wrench.tail<3>(), IsNear(Vec<3>(0.2 * full), 1e-9));
  body.w_W = Vec<3>(0.4, 0.1, -2);
  EXPECT_NEAR(TaskFor(inputs, body, {.trunk_stiffness = 250, .trunk_damping = 50}).turn, 1 - 2 * 0.2, 1e-12);
}

// A robot turned by 2 rad and tilted by 0.1 rad rotates back about the axis of the tilt.
TEST(WholeBodyController, ATurnedRobotCorrectsItsTilt) {
  Inputs inputs(Params().robot);
  const Eigen::AngleAxisd turn(2, Vec<3>::UnitZ()), tilt(0.1, Vec<3>(0.6, 0.8, 0));
  inputs.state.q_WB = QuaternionFromRotation((tilt * turn).toRotationMatrix());
  inputs.Follow();
  const WholeBodyTask task = TaskFor(inputs, BodyReference{.com_W = inputs.body.com_W}, {.turn_limit = 1e-9});
  const Vec<3> alpha = test::Solve(inputs.dynamics.centroidal_inertia_W, task.wrench.tail<3>());
  EXPECT_THAT(alpha, IsNear(Vec<3>(-0.1 * 250 * Vec<3>(0.6, 0.8, 0)), 1e-6));
  EXPECT_NEAR(task.tilt, 0.1, 1e-12);
}

// With mu = 0.15, a pull of 100 N and the CoM 4 cm off, the required ground force is limited to 2 mu m g
// against the pull and to m g upwards.
TEST(WholeBodyController, LimitsTheRequiredForceByFriction) {
  Inputs inputs(Params().robot);
  const double weight = inputs.model.mass() * 9.81;
  inputs.wrench.force_W = Vec<3>(100, 10, 0);
  BodyReference body = inputs.body;
  body.com_W[0] -= 0.04;
  WholeBodyGains gains;
  gains.qp.friction = 0.15;
  const WholeBodyTask task = TaskFor(inputs, body, gains);
  EXPECT_THAT(task.wrench.head<3>() - task.disturbance.head<3>(),
              IsNear(Vec<3>(-0.3 * weight, -10, weight), 1e-9));
}

// A push on a robot on two feet turns it about their line by alpha = n . ((p - x) x F) / (n . I n), which is
// integrated here over the 0.1 s until its swing feet land. It would be tilted by alpha T^2 / 2 at T = 0.15
// s.
TEST(WholeBodyController, TheCoMYieldsBeforeTheTrunkTips) {
  Inputs inputs(Params().robot);
  inputs.Swing({kFrontRight, kRearLeft});
  inputs.wrench.force_W = Vec<3>(10, -100, 0);
  const auto& feet = inputs.dynamics.feet;
  const Vec<3> line = (feet[kRearRight].p_W - feet[kFrontLeft].p_W).normalized();
  const Vec<3> arm = feet[kFrontLeft].p_W - inputs.dynamics.com_W;
  const double inertia = line.dot(inputs.dynamics.centroidal_inertia_W * line);
  const auto by_ground = [&](double limit) {
    return Vec<3>(TaskFor(inputs, inputs.body, {.tip_limit = limit}).wrench.head<3>() -
                  inputs.wrench.force_W);
  };
  const auto acceleration = [&](const Vec<3>& force) { return line.dot(arm.cross(force)) / inertia; };
  const auto tilt_at_the_end = [&](double limit) {
    double tilt = 0, rate = 0;
    for (int n = 0;; ++n) {
      for (const Leg leg : {kFrontRight, kRearLeft})
        inputs.schedule.legs[leg].time_to_touchdown = (100 - n) * 1e-3;
      inputs.state.q_WB = QuaternionFromRotationVector(tilt * line);
      inputs.state.w_W = rate * line;
      const double alpha = acceleration(by_ground(limit));
      if (n == 100) return std::abs(tilt + rate * 0.05 + alpha * 0.05 * 0.05 / 2);
      tilt += rate * 1e-3 + alpha * 1e-6 / 2;
      rate += alpha * 1e-3;
    }
  };
  const double free = std::abs(acceleration(Vec<3>(-10, 100, inputs.model.mass() * 9.81))) * 0.15 * 0.15 / 2;
  EXPECT_GT(free, 0.4) << "the limits below have nothing to do";
  for (const Leg leg : {kFrontRight, kRearLeft}) inputs.schedule.legs[leg].time_to_touchdown = 0.1;
  EXPECT_EQ(by_ground(free + 1e-6), by_ground(std::numeric_limits<double>::infinity()));
  const Vec<3> change = by_ground(0.2) - by_ground(10);
  EXPECT_THAT(Vec<2>(change[2], change.dot(line)), IsNear(Vec<2>(0, 0), 1e-12)) << "not across the line";
  EXPECT_NEAR(std::abs(acceleration(by_ground(0.2))) * 0.15 * 0.15 / 2, 0.2, 1e-12);
  inputs.schedule.legs[kRearLeft].state = ContactState::kStance;
  EXPECT_EQ(by_ground(0.01), by_ground(10)) << "three feet exert any moment";
  inputs.schedule.legs[kRearLeft].state = ContactState::kSwing;
  EXPECT_NEAR(tilt_at_the_end(0.2), 0.2, 1e-3);
}

TEST(WholeBodyController, SwingFeetFollowTheirReferences) {
  Inputs inputs(Params().robot);
  inputs.Swing({kFrontRight, kRearLeft});
  inputs.state.qd.segment<3>(3) << 0.3, -1, 0.5;  // of the front right leg
  inputs.Follow();
  FootReference& reference = inputs.feet[kFrontRight];
  reference.p_W += Vec<3>(0.002, 0.001, 0.004);
  reference.v_W = inputs.dynamics.feet[kFrontRight].v_W + Vec<3>(0.1, 0, -0.05);
  reference.a_W = Vec<3>(1, 2, 3);
  Ticked rig(inputs);
  const Vec<18> a = StandingDynamics(inputs.dynamics, inputs.schedule, rig[rig->torque], Vec<18>::Zero());
  EXPECT_THAT(inputs.FootAcceleration(kFrontRight, a),
              IsNear(Vec<3>(1 + 14 + 9.8, 2 + 4.9, 3 - 7 + 19.6), 1e-3));
  EXPECT_THAT(inputs.FootAcceleration(kRearLeft, a), IsNear(Vec<3>(Vec<3>::Zero()), 1e-3));
}

// A swing foot that an edge holds back is pulled with limited acceleration.
TEST(WholeBodyController, AStuckSwingFootIsPulledWithinALimit) {
  Inputs inputs(Params().robot);
  inputs.Swing({kFrontRight, kRearLeft});
  inputs.Follow();
  FootReference& reference = inputs.feet[kFrontRight];
  reference.p_W += Vec<3>(0.12, 0, 0.16);
  reference.a_W = Vec<3>(1, 2, 3);
  WholeBodyParams params = Params();
  params.gains.swing_limit = 20;
  Ticked rig(inputs, params);
  const Vec<3> a = inputs.FootAcceleration(kFrontRight, rig[rig->plan].solution.acceleration);
  EXPECT_THAT(a, IsNear(Vec<3>(1 + 12, 2, 3 + 16), 1e-3));
}

// The foot counts as standing but has no contact, so its joints move.
TEST(WholeBodyController, AStanceFootThatMovesIsStopped) {
  Inputs inputs(Params().robot);
  inputs.state.qd.segment<3>(3) << 0.3, -1, 0.5;
  inputs.Follow();
  Ticked rig(inputs);
  const QuadrupedDynamics::Foot& foot = inputs.dynamics.feet[kFrontRight];
  ASSERT_GT(foot.v_W.norm(), 0.1);
  const Vec<3> a = inputs.FootAcceleration(kFrontRight, rig[rig->plan].solution.acceleration);
  EXPECT_THAT(a, IsNear(Vec<3>(-50 * foot.v_W), 1e-9));
}

// Near the straight knee no ground force can bend the leg again, so the hip is pulled back earlier.
TEST(WholeBodyController, AStretchedStanceLegIsBent) {
  Inputs inputs(Params().robot);
  inputs.state.q.segment<3>(3) << 0, 0.15, -0.3;
  inputs.Follow();
  Ticked rig(inputs);
  const Vec<3> hip = inputs.state.p_WB + Params().robot.HipPosition(kFrontRight, inputs.state.q);
  const Vec<3> to_hip = hip - inputs.feet[kFrontRight].p_W;
  const double excess = to_hip.norm() - 0.97 * Params().robot.LegLength(kFrontRight);
  ASSERT_GT(excess, 5e-3);
  const Vec<3> a = inputs.FootAcceleration(kFrontRight, rig[rig->plan].solution.acceleration);
  EXPECT_THAT(a, IsNear(Vec<3>(2500 * excess * to_hip.normalized()), 1e-6));
}

// With a ramp of 20 ms the bound rises by a twentieth of the weight in each solve after touchdown, and falls
// with the time to lift-off. Neither a foot that stands from the start nor one that waits to lift off is
// limited.
TEST(WholeBodyController, LoadsRampAfterTouchdownAndBeforeLiftOff) {
  WholeBodyParams params = Params();
  params.gains.load_ramp = 0.02;
  Inputs inputs(params.robot);
  const double weight = inputs.model.mass() * inputs.model.gravity();
  inputs.schedule.timing = {.num_steps = 2, .stance = 0.15, .swing = 0.1};
  for (LegContact& leg : inputs.schedule.legs) leg.time_to_lift_off = 0.1;
  Ticked standing(inputs, params);
  EXPECT_GT(standing[standing->plan].solution.force[kFrontLeft][2], 0.15 * weight);

  Inputs swinging = inputs;
  swinging.Swing({kFrontLeft});
  Ticked rig(swinging, params);
  inputs.Give(rig);
  for (int solves = 1; solves <= 3; ++solves) {
    rig.Tick();
    EXPECT_NEAR(rig[rig->plan].solution.force[kFrontLeft][2], solves * weight / 20, 1e-6);
  }
  for (int k = 0; k < 20; ++k) rig.Tick();
  EXPECT_GT(rig[rig->plan].solution.force[kFrontLeft][2], 0.15 * weight);
  inputs.schedule.legs[kFrontLeft].time_to_lift_off = 0.002;
  inputs.Give(rig);
  rig.Tick();
  EXPECT_NEAR(rig[rig->plan].solution.force[kFrontLeft][2], weight / 10, 1e-6);
  inputs.schedule.legs[kFrontLeft].time_to_lift_off = -0.001;
  inputs.Give(rig);
  rig.Tick();
  EXPECT_GT(rig[rig->plan].solution.force[kFrontLeft][2], 0.15 * weight);
}

/// A robot that moves under a wrench, with a foot in the air.
Inputs Moving(const QuadrupedDescription& robot) {
  Inputs inputs(robot);
  inputs.Swing({kFrontRight});
  inputs.state.w_W = Vec<3>(0.4, -0.3, 0.5);
  inputs.state.qd.segment<3>(3) << 1, -4, 3;
  inputs.state.qd.segment<3>(6) << 0.1, 0.3, -0.2;
  inputs.Follow();
  inputs.wrench.force_W = Vec<3>(10, -20, -30);
  inputs.wrench.torque_W = Vec<3>(3, 2, -1);
  return inputs;
}

// Eq. (2.3): I_com and M_q are decoupled, and the rows of the legs do not contain the wrench on the trunk.
TEST(WholeBodyController, TheDecoupledFormIsThatOfTheThesis) {
  WholeBodyParams params = Params();
  params.gains.dynamics = BodyDynamics::kDecoupled;
  params.gains.compensation = LegCompensation::kThesis;
  const Inputs inputs = Moving(params.robot);
  Ticked rig(inputs, params);
  const WholeBodySolution& solution = rig[rig->plan].solution;
  DecoupledDynamics decoupled;
  inputs.model.CalcDecoupled(inputs.state, inputs.dynamics, &decoupled);
  ASSERT_GT(inputs.dynamics.angular_momentum_bias_W.norm(), 0.1);

  Vec<12> force;
  Vec<3> sum = Vec<3>::Zero(), torque = Vec<3>::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    force.segment<3>(3 * leg) = solution.force[leg];
    sum += solution.force[leg];
    torque += (inputs.dynamics.feet[leg].p_W - inputs.dynamics.com_W).cross(solution.force[leg]);
  }
  const double m = inputs.model.mass();
  const Vec<3> com = inputs.dynamics.M.topRows<3>() * solution.acceleration / m + inputs.dynamics.com_bias_W;
  EXPECT_THAT(com, IsNear(Vec<3>(sum / m - Vec<3>(0, 0, 9.81)), 1e-9));
  EXPECT_THAT(Vec<3>(inputs.dynamics.angular_map * solution.acceleration), IsNear(torque, 1e-9));
  const Vec<12> expected = decoupled.M_q * solution.acceleration.tail<12>() + decoupled.coriolis -
                           decoupled.J_q.transpose() * force;
  EXPECT_THAT(rig[rig->torque], IsNear(expected, 1e-9));
}

// m x'' and I alpha of one rigid body with the robot's inertia, without terms of velocity, whatever the
// joints do.
TEST(WholeBodyController, QuasiStaticForcesMoveOneRigidBody) {
  WholeBodyParams params = Params();
  params.gains.dynamics = BodyDynamics::kQuasiStatic;
  const Inputs inputs = Moving(params.robot);
  Ticked rig(inputs, params);
  const QuadrupedDynamics& dynamics = inputs.dynamics;
  const WholeBodySolution& solution = rig[rig->plan].solution;
  Vec<3> force = inputs.wrench.force_W - inputs.model.mass() * Vec<3>(0, 0, 9.81),
         moment = inputs.wrench.torque_W;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    force += solution.force[leg];
    moment += (dynamics.feet[leg].p_W - dynamics.com_W).cross(solution.force[leg]);
    const auto joints = Eigen::seqN(6 + 3 * leg, 3);
    const Vec<3> expected = dynamics.M(joints, joints) * solution.acceleration(joints) +
                            dynamics.gravity(joints) -
                            dynamics.feet[leg].J_leg.transpose() * solution.force[leg];
    EXPECT_THAT(Vec<3>(rig[rig->torque].segment<3>(3 * leg)), IsNear(expected, 1e-9));
  }
  const Vec<3> alpha = solution.acceleration.segment<3>(3);
  const Vec<3> com = solution.acceleration.head<3>() + alpha.cross(Vec<3>(dynamics.com_W - dynamics.base_W));
  EXPECT_THAT(Vec<3>(inputs.model.mass() * com), IsNear(force, 1e-9));
  EXPECT_THAT(Vec<3>(dynamics.centroidal_inertia_W * alpha), IsNear(moment, 1e-9));
}

// A push on a swing foot that the observers estimate is compensated exactly once, in both forms: compensated
// twice or not at all, the foot would accelerate by several m/s^2.
TEST(WholeBodyController, APushedSwingFootIsHeld) {
  const Vec<3> push(12, -8, 10);
  for (const LegCompensation form : {LegCompensation::kExact, LegCompensation::kThesis}) {
    WholeBodyParams params = Params();
    params.gains.compensation = form;
    Inputs inputs(params.robot);
    inputs.Swing({kFrontRight, kRearLeft});
    const Vec<18> force = inputs.dynamics.FootJacobian(kFrontRight).transpose() * push;
    for (const bool known : {true, false}) {
      if (known) {
        inputs.leg_forces.joint_torque = force.tail<12>();
        inputs.leg_forces.foot_force[kFrontRight] = push;
        if (form == LegCompensation::kExact) {  // the thesis's form knows the legs only
          inputs.wrench.force_W = push;
          inputs.wrench.torque_W =
              (inputs.dynamics.feet[kFrontRight].p_W - inputs.dynamics.com_W).cross(push);
        }
      } else {
        inputs.leg_forces = {};
        inputs.wrench = {};
      }
      Ticked rig(inputs, params);
      const Vec<18> a = StandingDynamics(inputs.dynamics, inputs.schedule, rig[rig->torque], force);
      const Vec<3> foot = inputs.dynamics.FootJacobian(kFrontRight) * a;
      if (known) {
        EXPECT_THAT(foot, IsNear(Vec<3>(Vec<3>::Zero()), 1e-3)) << static_cast<int>(form);
      } else {
        EXPECT_GT(foot.norm(), 3) << static_cast<int>(form);
      }
      if (known && form == LegCompensation::kExact) {  // and the body stays where it is
        EXPECT_THAT(a, IsNear(rig[rig->plan].solution.acceleration, 1e-6));
      }
    }
  }
}

// A torque that pushes a joint back into its range is that of an end stop. In the other direction, and within
// the range, it is a disturbance.
TEST(WholeBodyController, TorquesOfEndStopsAreNotCompensated) {
  WholeBodyParams params = Params();
  Inputs inputs(params.robot);
  const auto torque = [&](double estimate) {
    inputs.leg_forces.joint_torque[2] = estimate;
    Ticked rig(inputs, params);
    return Vec<12>(rig[rig->torque]);
  };
  EXPECT_GT((torque(-5) - torque(0)).norm(), 1);
  JointDescription& knee = params.robot.legs[kFrontLeft].joints[2];
  const double upper = knee.upper;
  knee.upper = inputs.state.q[2] - 0.01;
  EXPECT_EQ(torque(-5), torque(0));
  EXPECT_GT((torque(5) - torque(0)).norm(), 1);
  knee.upper = upper;
  knee.lower = inputs.state.q[2] + 0.01;
  EXPECT_EQ(torque(5), torque(0));
  EXPECT_GT((torque(-5) - torque(0)).norm(), 1);
}

TEST(WholeBodyController, AFailureIsCountedAndTheLastTorqueStays) {
  Inputs inputs(Params().robot);
  Ticked rig(inputs);
  const Vec<12> before = rig[rig->torque];
  Inputs impossible = inputs;
  impossible.leg_forces.joint_torque.setConstant(1e4);
  impossible.Give(rig);
  rig.Tick().Tick();
  EXPECT_EQ(rig[rig->torque], before);
  EXPECT_EQ(rig[rig->diagnostics].solves, 3);
  EXPECT_EQ(rig[rig->diagnostics].failures, 2);
  EXPECT_EQ(rig[rig->diagnostics].failures_in_a_row, 2);
  EXPECT_EQ(rig[rig->diagnostics].status, QpStatus::kInfeasible);
  EXPECT_GE(rig[rig->diagnostics].constraint, 0);
  inputs.Give(rig);
  rig.Tick();
  EXPECT_THAT(rig[rig->torque], IsNear(before, 1e-6));
  EXPECT_EQ(rig[rig->diagnostics].failures_in_a_row, 0);
}

TEST(WholeBodyController, EndsTheRunAfterTooManyFailuresInARow) {
  WholeBodyParams params = Params();
  params.max_failures_in_a_row = 1;
  Inputs impossible(params.robot);
  impossible.leg_forces.joint_torque.setConstant(1e4);
  Ticked rig(impossible, params);
  rig.Set(rig->max_failures_in_a_row, 3).Tick().Tick();
  EXPECT_FALSE(rig[rig->solves].has_value());
  rig.Tick();
  ASSERT_TRUE(rig[rig->solves].has_value());
  EXPECT_THAT(*rig[rig->solves], ::testing::HasSubstr("4 times"));
}

// Between the solves of a slower QP the torques follow the state, here by the Coriolis forces of a fast leg.
TEST(WholeBodyController, TorquesAreComputedAnewBetweenSolves) {
  WholeBodyParams params = Params();
  params.qp_rate = Hz(250);
  Inputs inputs(params.robot);
  inputs.Swing({kFrontRight});
  Ticked rig(inputs, params);
  const WholeBodySolution solution = rig[rig->plan].solution;
  inputs.state.q[5] -= 0.2;
  inputs.state.qd[5] = 4;
  inputs.Follow();
  inputs.Give(rig);
  rig.Tick();
  EXPECT_EQ(rig[rig->diagnostics].solves, 1);
  EXPECT_THAT(rig[rig->torque], IsNear(JointTorque(inputs.dynamics, solution, Vec<12>::Zero()), 1e-12));
  rig.Tick().Tick().Tick();
  EXPECT_EQ(rig[rig->diagnostics].solves, 2);
}

// 400 Hz does not divide 1 kHz: solves are at multiples of 2.5 ms, and each torque uses the latest solve.
TEST(WholeBodyController, SolvesAt400HzWithinTorquesAt1kHz) {
  WholeBodyParams params = Params();
  params.qp_rate = Hz(400);
  Inputs inputs(params.robot);
  Ticked rig(inputs, params);
  const std::array<double, 12> times{1, 2, 2.5, 3, 4, 5, 6, 7, 7.5, 8, 9, 10};
  const std::array<long, 12> solves{1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5};
  for (std::size_t i = 0; i < times.size(); ++i) {
    inputs.body.com_W[2] += 0.001;  // so that every solve has another solution
    const Vec<12> torque = rig[rig->torque];
    const WholeBodySolution before = rig[rig->plan].solution;
    inputs.Give(rig);
    rig.Tick();
    EXPECT_NEAR(rig.time(), 1e-3 * times[i], 1e-15);
    EXPECT_EQ(rig[rig->diagnostics].solves, solves[i]) << times[i];
    const bool solved = solves[i] > (i == 0 ? 1 : solves[i - 1]);
    const WholeBodySolution& after = rig[rig->plan].solution;
    EXPECT_EQ((after.acceleration - before.acceleration).norm() > 0, solved) << times[i];
    const bool computed = times[i] == std::floor(times[i]);
    const Vec<12> expected = computed ? JointTorque(inputs.dynamics, after, Vec<12>::Zero()) : torque;
    EXPECT_THAT(rig[rig->torque], IsNear(expected, 1e-12)) << times[i];
  }
}

}  // namespace tenon::whole_body_controller_test
