#include <tenon/controllers/legged/planning/swing_planner.h>
#include <tenon/tests/controllers/legged/planning/test_map.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <iterator>

namespace tenon::swing_planner_test {

using enum ContactState;

constexpr GaitTiming kTrot{.num_steps = 2, .step = {0, 1, 1, 0}, .stance = 0.15, .swing = 0.115};
constexpr int kSwingTicks = 115;

SwingPlannerParams Params() {
  return {.robot = test::DogBot()};
}

/// A trotting robot whose front-left and rear-right legs the test moves from state to state.
class Trot {
 public:
  explicit Trot(const SwingPlannerParams& params = Params()) : rig_(params), robot_(params.robot) {
    state = test::Standing(params.robot);
    path.position_W = stance().center_B;
    schedule.gait = Gait::kTrot;
    schedule.timing = kTrot;
  }
  void Set(ContactState contact, double phase = 0) {
    for (const Leg leg : {kFrontLeft, kRearRight}) {
      schedule.legs[leg].state = contact;
      schedule.legs[leg].phase = phase;
      schedule.legs[leg].time_to_touchdown = contact == kSwing ? (1 - phase) * kTrot.swing : 0;
    }
  }
  const FootReference& Tick() {
    auto& block = rig_.system();
    rig_.Fix(block.schedule, schedule).Fix(block.path, path).Fix(block.body, body);
    rig_.Fix(block.state, state).Fix(block.ground, ground).Fix(block.wrench, wrench);
    rig_.Fix(block.planned, planned)
        .Fix(block.map, map)
        .Fix(block.known_wrench, known_wrench)
        .Fix(block.foot_forces, forces)
        .Tick();
    return rig_[block.feet][kFrontLeft];
  }
  /// The swing from stance along the path, tick by tick; the last entry is the first tick of a late foot. At
  /// the tick `pushed_at` the CoM gets faster by 1 m/s to the left.
  std::vector<FootReference> Swing(int pushed_at = -1) {
    Set(kStance);
    Tick();
    std::vector<FootReference> swing;
    for (int n = 0; n < kSwingTicks; ++n) {
      if (n == pushed_at) state.v_W[1] += 1;
      Set(kSwing, static_cast<double>(n) / kSwingTicks);
      swing.push_back(Tick());
      path = path.At(1e-3);
    }
    Set(kLate, 1);
    swing.push_back(Tick());
    return swing;
  }
  Eigen::Vector3d Foot(Leg leg) const {
    return state.p_WB + state.R_WB() * robot_.FootPosition(leg, state.q);
  }
  Eigen::Vector3d Foothold(Leg leg) { return rig_[rig_->footholds][leg]; }
  FootReference Reference(Leg leg) { return rig_[rig_->feet][leg]; }
  const NominalStance& stance() { return rig_->stance; }
  TestRig<SwingPlanner>& rig() { return rig_; }

  ContactSchedule schedule;
  PlanarPath path;
  BodyReference body;
  LeggedState state;
  GroundPlane ground;
  WrenchEstimate wrench, known_wrench;
  FootForces forces;
  ElevationMap map;
  FootholdPlan planned;

 private:
  TestRig<SwingPlanner> rig_;
  QuadrupedDescription robot_;
};

/// The largest height above the beginning.
double Top(const std::vector<FootReference>& motion, const Vec<3>& begin) {
  double top = 0;
  for (const FootReference& foot : motion) top = std::max(top, foot.p_W[2] - begin[2]);
  return top;
}

/// `snap`: its derivatives over those of a step of 5 cm, whose jerk at lift-off is 11000 m/s^3; a jump of its
/// acceleration would be 90 m/s^2.
void ExpectConsistent(const std::vector<FootReference>& motion, double snap = 1) {
  const double dt = 1e-3;
  for (std::size_t n = 1; n < motion.size(); ++n) {
    const FootReference &a = motion[n - 1], &b = motion[n];
    // Errors of the trapezoid: dt^3 / 12 times jerk, and times snap.
    EXPECT_THAT(b.p_W - a.p_W, IsNear(dt / 2 * (a.v_W + b.v_W), 1e-6 * snap)) << n;
    EXPECT_THAT(b.v_W - a.v_W, IsNear(dt / 2 * (a.a_W + b.a_W), 3e-4 * snap)) << n;
    EXPECT_LT((b.a_W - a.a_W).norm(), 12 * snap) << n;
  }
}

TEST(QuinticTest, MeetsItsEndsAndIsItsOwnDerivative) {
  const MotionPoint begin{1, -2, 30}, end{-0.5, 0.7, -11};
  const double T = 0.3, h = 1e-5;
  for (const auto& [t, point] : {std::pair{0.0, begin}, std::pair{T, end}}) {
    EXPECT_NEAR(Quintic(begin, end, T, t).position, point.position, 1e-13);
    EXPECT_NEAR(Quintic(begin, end, T, t).velocity, point.velocity, 1e-12);
    EXPECT_NEAR(Quintic(begin, end, T, t).acceleration, point.acceleration, 1e-10);
  }
  for (double t = 0.01; t < T; t += 0.02) {
    const MotionPoint x = Quintic(begin, end, T, t);
    const MotionPoint before = Quintic(begin, end, T, t - h), after = Quintic(begin, end, T, t + h);
    EXPECT_NEAR(x.velocity, (after.position - before.position) / (2 * h), 1e-6);
    EXPECT_NEAR(x.acceleration, (after.velocity - before.velocity) / (2 * h), 1e-4);
  }
}

TEST(SwingPlannerTest, StanceFeetRestWhereTheyStand) {
  Trot trot;
  trot.Tick();
  for (const Leg leg : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) {
    EXPECT_THAT(trot.Reference(leg).p_W, IsNear(trot.Foot(leg), 1e-15));
    EXPECT_EQ(trot.Reference(leg).v_W.norm(), 0);
    EXPECT_EQ(trot.Foothold(leg), trot.Reference(leg).p_W);
  }
  const Eigen::Vector3d before = trot.Foot(kFrontLeft);
  trot.state.p_WB[0] += 0.02;  // they do not slide along with the state
  trot.Tick();
  EXPECT_EQ(trot.Reference(kFrontLeft).p_W, before);
}

TEST(SwingPlannerTest, SwingLiftsAndLowersWithoutJumps) {
  Trot trot;
  trot.path.velocity << 0.12, 0.03;
  const Eigen::Vector3d begin = trot.Foot(kFrontLeft);
  const auto swing = trot.Swing();
  ExpectConsistent(swing);
  EXPECT_THAT(swing.front().p_W, IsNear(begin, 1e-12));
  EXPECT_THAT(swing.front().v_W, IsNear(Eigen::Vector3d(0, 0, 0), 1e-12));
  EXPECT_THAT(swing.front().a_W, IsNear(Eigen::Vector3d(0, 0, 0), 1e-9));
  EXPECT_THAT(swing.back().p_W, IsNear(trot.Foothold(kFrontLeft), 1e-12));
  EXPECT_THAT(swing.back().v_W, IsNear(Eigen::Vector3d(0, 0, -0.5), 1e-12));
  for (std::size_t n = 1; n < swing.size(); ++n) {
    if (n == kSwingTicks / 2 + 1) continue;  // the top lies between two ticks
    EXPECT_EQ(swing[n].p_W[2] > swing[n - 1].p_W[2], n <= kSwingTicks / 2) << n;  // up, then down
  }
  EXPECT_NEAR(Top(swing, begin), 0.05, 2e-5);
}

TEST(SwingPlannerTest, FootIsAtItsNominalPlaceInTheMiddleOfItsStance) {
  Trot trot;
  trot.path.velocity << 0.12, -0.04;
  trot.path.yaw_rate = 0.5;
  trot.path.yaw = 0.2;
  const PlanarPath middle = trot.path.At(0.115 + 0.415 / 2);
  trot.Swing();
  for (const Leg leg : {kFrontLeft, kRearRight}) {
    const Eigen::Vector2d from_path =
        middle.Heading().transpose() * (trot.Foothold(leg).head<2>() - middle.position_W);
    EXPECT_THAT(from_path, IsNear(trot.stance().foot[leg], 1e-12));
    EXPECT_NEAR(trot.Foothold(leg)[2], trot.Foot(kFrontRight)[2], 1e-12);
  }
}

TEST(SwingPlannerTest, FootInTheAirGoesToANewFoothold) {
  Trot pushed, still;
  still.Swing();
  ExpectConsistent(pushed.Swing(40));  // into the first tick of the late foot, which is at its foothold
  EXPECT_THAT(pushed.Foothold(kFrontLeft) - still.Foothold(kFrontLeft), IsNear(Vec<3>(0, 0.03, 0), 1e-12));
}

TEST(SwingPlannerTest, FootholdStaysFromTheRetargetPhaseOn) {
  Trot still, before, after, never({.robot = test::DogBot(), .step = {.retarget_phase = 0}});
  still.Swing();
  before.Swing(80);  // 0.696 of the swing
  after.Swing(81);   // 0.704
  never.Swing(1);
  const Vec<3> foothold = still.Foothold(kFrontLeft);
  EXPECT_THAT(before.Foothold(kFrontLeft), IsNear(Vec<3>(foothold + Vec<3>(0, 0.03, 0)), 1e-12));
  EXPECT_THAT(after.Foothold(kFrontLeft), IsNear(foothold, 1e-12));
  EXPECT_THAT(never.Foothold(kFrontLeft), IsNear(foothold, 1e-12));
}

// Without a stance phase, a landing and the next lift-off can fall into one tick.
TEST(SwingPlannerTest, ASwingAfterASwingBeginsAnew) {
  for (const double retarget_phase : {0.0, 0.7}) {
    Trot trot({.robot = test::DogBot(), .step = {.retarget_phase = retarget_phase}});
    trot.path.velocity << 0.12, 0;
    for (const double phase : {0.0, 0.5, 0.6}) {
      trot.Set(kSwing, phase);
      trot.Tick();
    }
    trot.state.p_WB[0] += 0.02;
    trot.Set(kSwing, 0);
    EXPECT_THAT(trot.Tick().p_W, IsNear(trot.Foot(kFrontLeft), 1e-12)) << retarget_phase;
  }
}

// If the trunk moves away from a foothold, the foot follows before the knee is straight.
TEST(SwingPlannerTest, KneesStayBent) {
  const QuadrupedDescription robot = test::DogBot();
  const auto& leg = robot.legs[kFrontLeft];
  const double longest = 0.95 * (leg.joints[2].p_PJ.norm() + leg.foot_J.norm());
  Trot aside, up;
  for (Trot* trot : {&aside, &up}) trot->Swing();
  aside.state.p_WB[1] -= 0.6;
  up.state.p_WB[2] += 0.5;
  for (Trot* trot : {&aside, &up}) {
    const Vec<3> foothold = trot->Foothold(kFrontLeft);
    const Vec<3> to_foot = trot->Tick().p_W - trot->state.p_WB - robot.HipPosition(kFrontLeft, trot->state.q);
    EXPECT_NEAR(to_foot.norm(), longest, 1e-12);
    if (trot == &aside) {
      EXPECT_LT(trot->Reference(kFrontLeft).p_W[2], foothold[2] + 1e-9) << "still searching for the ground";
    } else {
      EXPECT_NEAR(to_foot.head<2>().norm(), 0, 1e-7) << "below the hip";
      EXPECT_EQ(trot->Reference(kFrontLeft).v_W.norm(), 0);
    }
  }
}

// The nominal foothold is on the first cell of a kerb of 0.1 m.
TEST(SwingPlannerTest, AFootClimbsOntoTheMap) {
  Trot flat, trot;
  flat.path.velocity << 0.3, 0;
  trot.path = flat.path;
  flat.Swing();
  const double cell = 0.03, nominal = flat.Foothold(kFrontLeft)[0];
  const double edge = cell * (std::round(nominal / cell) - 0.5);
  trot.map = test::MapOf([&](double x, double) { return x > edge ? 0.1 : 0; }, cell);
  const Vec<3> begin = trot.Foot(kFrontLeft);
  const auto swing = trot.Swing();
  ExpectConsistent(swing, 8);  // the foot sets out between two ticks
  const double radius = test::DogBot().foot_radius, on_kerb = 0.1 + radius;
  EXPECT_THAT(trot.Foothold(kFrontLeft),
              IsNear(Vec<3>(nominal + 2 * cell, flat.Foothold(kFrontLeft)[1], on_kerb), 1e-9));
  EXPECT_THAT(swing.back().p_W, IsNear(trot.Foothold(kFrontLeft), 1e-12));
  EXPECT_NEAR(Top(swing, begin), 0.05 + on_kerb - begin[2], 2e-4);
  for (const FootReference& foot : swing)
    EXPECT_TRUE(foot.p_W[0] < edge - radius || foot.p_W[2] > on_kerb - 1e-9) << foot.p_W.transpose();
}

// At lift-off, the plan of CentroidalMpc may be one in which the foot still stands, before a kerb of 0.1 m.
TEST(SwingPlannerTest, AFootClimbsOntoTheMapWhereALaterPlanPutsIt) {
  for (const int renewed_at : {0, 1, 5, 20}) {
    Trot trot;
    const Vec<3> begin = trot.Foot(kFrontLeft);
    const double edge = begin[0] + 0.06;
    trot.map = test::MapOf([&](double x, double) { return x > edge ? 0.1 : 0; });
    trot.planned.planned = true;
    for (int i = 0; i < kNumLegs; ++i)
      trot.planned.position_W[static_cast<std::size_t>(i)] = trot.Foot(static_cast<Leg>(i)).head<2>();
    const double radius = test::DogBot().foot_radius;
    trot.Set(kStance);
    trot.Tick();
    for (int n = 0; n < kSwingTicks; ++n) {
      if (n == renewed_at) trot.planned.position_W[kFrontLeft][0] += 0.3;
      if (n == 30) trot.planned.position_W[kFrontLeft][0] = edge - 0.02;  // keeps its level
      trot.Set(kSwing, static_cast<double>(n) / kSwingTicks);
      const Vec<3> foot = trot.Tick().p_W;
      EXPECT_TRUE(foot[0] < edge - radius || foot[2] > 0.1 + radius - 1e-9) << renewed_at << ", " << n;
    }
    EXPECT_NEAR(trot.Foothold(kFrontLeft)[2], 0.1 + radius, 1e-9);
  }
}

TEST(SwingPlannerTest, AFootholdOnTheMapIsFreeOfTheOtherFeet) {
  Trot trot;
  trot.map = test::MapOf([](double, double) { return 0.0; });
  trot.planned.planned = true;
  trot.planned.position_W.fill(trot.Foot(kFrontRight).head<2>());
  trot.Swing();
  const Vec<3> between = trot.Foothold(kFrontLeft) - trot.Foothold(kFrontRight);
  EXPECT_GE(between.head<2>().norm(), StepProperties().footing.clear);
  EXPECT_LT(between.head<2>().norm(), 2 * StepProperties().footing.clear);
}

TEST(SwingPlannerTest, AFootDescendsStraight) {
  Trot flat, trot;
  flat.path.velocity << 0.3, 0;
  trot.path = flat.path;
  flat.Swing();
  const double depth = 0.1, edge = flat.Foothold(kFrontLeft)[0] - 0.06;
  trot.map = test::MapOf([&](double x, double) { return x > edge ? -depth : 0; }, 0.01);
  const auto swing = trot.Swing();
  ExpectConsistent(swing, 7);  // the horizontal motion ends between two ticks
  const Vec<3> foothold = trot.Foothold(kFrontLeft);
  EXPECT_NEAR(foothold[2], test::DogBot().foot_radius - depth, 1e-9);
  EXPECT_THAT(swing.back().p_W, IsNear(foothold, 1e-12));
  const std::size_t straight = swing.size() * 71 / 100;
  for (std::size_t n = straight; n < swing.size(); ++n)
    EXPECT_THAT(swing[n].p_W.head<2>(), IsNear(foothold.head<2>(), 1e-12)) << n;
  EXPECT_GT(swing[straight].p_W[2], foothold[2] + depth / 2);
}

TEST(SwingPlannerTest, FootholdFollowsTheVelocityError) {
  Trot still, pushed;
  still.path.velocity << 0.1, 0;
  pushed.path = still.path;
  still.body.com_velocity_W << 0.1, 0, 0;
  pushed.body = still.body;
  still.state.v_W << 0.1, 0, 0;
  pushed.state.v_W << 0.16, -0.08, 0.2;
  still.Swing();
  pushed.Swing();
  EXPECT_THAT(pushed.Foothold(kFrontLeft) - still.Foothold(kFrontLeft),
              IsNear(0.03 * Eigen::Vector3d(0.06, -0.08, 0), 1e-12));
}

// Beyond a speed of 0.1 m/s, an inverted pendulum on the foothold's displacement d that moves with v
// comes to rest: x(t) = d (1 - cosh(w t)) + v / w sinh(w t) tends to d, with w = sqrt(g / h).
TEST(SwingPlannerTest, FootholdsCatchAPushedRobot) {
  const auto foothold = [](double velocity, const Vec<3>& ropes) {
    Trot trot({.robot = test::DogBot(), .capture_speed = 0.1});
    trot.state.v_W[1] = velocity;
    trot.known_wrench.force_W = ropes;
    trot.Swing();
    return trot.Foothold(kFrontLeft)[1];
  };
  const double v = 0.3, w = std::sqrt(9.81 / NominalStance(Params().robot).com_height), t = 5 / w;
  const double d = foothold(0.1 + v, {0, 0, 0}) - foothold(0.1, {0, 0, 0});
  EXPECT_NEAR(d * (1 - std::cosh(w * t)) + v / w * std::sinh(w * t), d, 0.01 * d);
  EXPECT_NEAR(foothold(-0.1 - v, {0, 0, 0}) - foothold(-0.1, {0, 0, 0}), -d, 1e-12);
  const Vec<3> ropes(0, 0, 50);  // a robot on ropes is no pendulum on its feet
  EXPECT_NEAR(foothold(0.1 + v, ropes) - foothold(0.1, ropes), 0.03 * v, 1e-12);
}

TEST(SwingPlannerTest, FootholdStaysInReach) {
  Trot trot;
  trot.path.velocity << 3, 0;
  const Eigen::Vector2d at_touchdown = trot.path.At(0.115).position_W + trot.stance().foot[kFrontLeft];
  trot.Swing();
  EXPECT_THAT(trot.Foothold(kFrontLeft).head<2>() - at_touchdown,
              IsNear(Eigen::Vector2d(trot.stance().reach[kFrontLeft], 0), 1e-12));
}

TEST(SwingPlannerTest, LateFootGoesOnDownwardsToItsBound) {
  SwingPlannerParams params = Params();
  params.step.search_depth = 0.1;  // less than the leg reaches
  Trot trot(params);
  std::vector<FootReference> motion = trot.Swing();
  const double foothold = trot.Foothold(kFrontLeft)[2];
  for (int n = 1; n < 2000; ++n) {
    if (n == 250) trot.Set(kSearching);
    motion.push_back(trot.Tick());
  }
  ExpectConsistent(motion);
  EXPECT_LT(motion[kSwingTicks + 250].p_W[2], foothold - 0.07);
  EXPECT_GE(motion.back().p_W[2], foothold - 0.1);
  EXPECT_NEAR(motion.back().p_W[2], foothold - 0.1, 0.003);
}

TEST(SwingPlannerTest, StanceFootThatSearchesGoesDownFromWhereItIs) {
  Trot trot;
  trot.Tick();
  trot.state.p_WB[2] += 0.01;
  trot.Set(kSearching);
  EXPECT_THAT(trot.Tick().p_W, IsNear(trot.Foot(kFrontLeft), 1e-12));
  trot.Tick();
  EXPECT_NEAR(trot.Reference(kFrontLeft).p_W[2], trot.Foot(kFrontLeft)[2] - 0.5e-3, 2e-6);
  trot.Set(kStance);
  EXPECT_THAT(trot.Tick().p_W, IsNear(trot.Foot(kFrontLeft), 1e-12));
}

// If the feet stayed where they are in W, the legs of a falling robot would fold until it lands.
TEST(SwingPlannerTest, FeetOfARobotInTheAirMoveWithIt) {
  Trot robot;
  robot.Tick();
  for (LegContact& leg : robot.schedule.legs) leg.state = kSearching;
  robot.state.v_W = {0.2, 0, -1};
  const double depth = robot.Tick().p_W[2] - robot.Foot(kFrontLeft)[2];
  for (int n = 0; n < 20; ++n) {
    robot.state.p_WB += 1e-3 * robot.state.v_W;
    const FootReference& foot = robot.Tick();
    EXPECT_THAT(foot.p_W.head<2>(), IsNear(robot.Foot(kFrontLeft).head<2>(), 1e-12)) << n;
    EXPECT_LT(foot.v_W[2], -1) << "searches for the ground";
    EXPECT_NEAR(foot.v_W[0], 0.2, 1e-12);
  }
  EXPECT_GT(robot.Reference(kFrontLeft).p_W[2] - robot.Foot(kFrontLeft)[2], depth - 0.02);
  robot.schedule.legs[kRearLeft].state = kStance;  // landed: the others search where they are
  const Vec<3> before = robot.Tick().p_W;
  EXPECT_THAT(robot.Tick().p_W.head<2>(), IsNear(before.head<2>(), 1e-12));
  EXPECT_EQ(robot.Tick().v_W[0], 0);
}

TEST(SwingPlannerTest, SecondSearchBeginsAnew) {
  Trot trot;
  trot.Swing();
  for (int n = 0; n < 100; ++n) trot.Tick();
  trot.Swing();
  EXPECT_THAT(trot.Reference(kFrontLeft).p_W, IsNear(trot.Foothold(kFrontLeft), 1e-12));
}

/// The displacement of the foothold by a wrench that has acted for `ticks`.
Vec<3> ShiftUnder(const WrenchEstimate& wrench, const SwingPlannerParams& params, int ticks) {
  Trot pushed(params), reference(params);
  pushed.wrench = wrench;
  for (Trot* trot : {&pushed, &reference}) {
    trot->Set(kStance);
    for (int n = 1; n < ticks; ++n) trot->Tick();
    trot->Set(kSwing);
    trot->Tick();
  }
  return pushed.Foothold(kFrontLeft) - reference.Foothold(kFrontLeft);
}

TEST(SwingPlannerTest, ShiftBalancesTheWrench) {
  SwingPlannerParams params = Params();
  params.step.free_shift = 0;
  const WrenchEstimate wrench{.force_W = {15, 20, -30}, .torque_W = {2, 3, 0}};
  const Vec<3> shift = ShiftUnder(wrench, params, 5000);
  // The ground holds the weight and the disturbance, at the shifted place below the CoM: no moment is left.
  const Eigen::Vector3d at(shift[0], shift[1], -Trot(params).stance().com_height);
  const Eigen::Vector3d weight(0, 0, params.robot.mass() * 9.81);
  const Eigen::Vector3d moment = at.cross(Eigen::Vector3d(weight - wrench.force_W)) + wrench.torque_W;
  EXPECT_GT(shift.norm(), 0.04);
  EXPECT_THAT(moment.head<2>(), IsNear(Eigen::Vector2d(0, 0), 1e-6));
}

// The whole stance is displaced at once and by any length: the ground's reaction at its centre on the slope
// leaves no moment about the CoM.
TEST(SwingPlannerTest, TheStanceBalancesAKnownWrench) {
  Trot roped, reference;
  const double weight = Params().robot.mass() * 9.81;
  roped.known_wrench = {{0.5 * weight, 0.05 * weight, 0.4 * weight}, {2, -3, 0}};
  for (Trot* trot : {&roped, &reference}) {
    trot->ground.slope = {0.8, 0.1};
    trot->Set(kStance);
    trot->Tick();
    trot->Set(kSwing);
    trot->Tick();
  }
  for (const Leg leg : {kFrontLeft, kRearRight}) {
    Vec<3> arm = roped.Foothold(leg) - reference.Foothold(leg);
    EXPECT_NEAR(arm[2], roped.ground.slope.dot(arm.head<2>()), 1e-9);
    EXPECT_GT(arm.norm(), 0.15);
    arm[2] -= roped.stance().com_height;
    const Vec<3> reaction = Vec<3>(0, 0, weight) - roped.known_wrench.force_W;
    const Vec<3> moment = arm.cross(reaction) + roped.known_wrench.torque_W;
    EXPECT_THAT(moment.head<2>(), IsNear(Eigen::Vector2d(0, 0), 1e-6));
  }
}

// A required shift s is reduced to s - d^2 / s, and to zero below the dead band d.
TEST(SwingPlannerTest, SmallWrenchesShiftNothing) {
  SwingPlannerParams params = Params();
  params.step.free_shift = 0.08;
  const Vec<3> direction(0.6, -0.8, 0);
  const double weight = params.robot.mass() * 9.81, height = Trot(params).stance().com_height;
  for (const double part : {0.5, 1.0, 1.1}) {
    const double expected = part > 1 ? 0.08 * (part - 1 / part) : 0;
    EXPECT_THAT(ShiftUnder({.force_W = part * 0.08 / height * weight * direction}, params, 2000),
                IsNear(Vec<3>(expected * direction), 1e-6))
        << part;
  }
}

TEST(SwingPlannerTest, ShiftIsSlowAndLimited) {
  SwingPlannerParams params = Params();
  params.step.shift_bandwidth = 4;
  EXPECT_THAT(ShiftUnder({.force_W = {200, 0, 0}}, params, 250),  // 1 / 4 s
              IsNear(Vec<3>(0.1 * (1 - std::exp(-1)), 0, 0), 1e-9));
}

TEST(SwingPlannerTest, AShiftThatIsSwitchedOffFades) {
  Trot pushed, reference;
  pushed.wrench.force_W << 100, 0, 0;
  for (const bool on : {true, false}) {
    StepProperties step = Params().step;
    step.wrench_shift = on;
    pushed.rig().Set(pushed.rig()->step, step);
    for (Trot* trot : {&pushed, &reference}) {
      trot->Set(kStance);
      for (int n = 0; n < 5000; ++n) trot->Tick();
      trot->Set(kSwing);
      trot->Tick();
    }
    const double shift = (pushed.Foothold(kFrontLeft) - reference.Foothold(kFrontLeft)).norm();
    EXPECT_EQ(shift > 0.02, on) << shift;
    EXPECT_EQ(shift < 1e-6, !on) << shift;
  }
}

// The robot is pushed aside by 10 cm, with a dead band of 3 cm, and turned by 0.5 rad, with a dead band of
// 0.1 rad: the footholds stay below the robot and move along the path.
TEST(SwingPlannerTest, FeetStayBelowARobotThatIsPushedOffItsPath) {
  const auto foothold = [](const Vec<3>& off, double turn) {
    SwingPlannerParams params = Params();
    params.step.velocity_feedback = 0;
    Trot trot(params);
    const QuadrupedDynamics dynamics = test::DynamicsOf(QuadrupedModel(params.robot), trot.state);
    trot.body.com_W = dynamics.com_W;
    const Eigen::AngleAxisd turned(turn, Vec<3>::UnitZ());  // about the CoM
    trot.state.q_WB = QuaternionFromRotation(turned.toRotationMatrix());
    trot.state.p_WB = dynamics.com_W + turned * (trot.state.p_WB - dynamics.com_W) + off;
    trot.path.velocity << 0.12, 0;
    trot.Set(kStance);
    trot.Tick();
    trot.Set(kSwing, 0);
    trot.Tick();
    return Eigen::Vector2d(trot.Foothold(kFrontLeft).head<2>());
  };
  const Eigen::Vector2d here = foothold({0, 0, 0}, 0);
  EXPECT_THAT(foothold({0.02, -0.02, 0}, 0.09), IsNear(here, 1e-12));
  EXPECT_THAT(foothold({0, -0.1, 0}, 0), IsNear(here + Eigen::Vector2d(0, -0.07), 1e-12));
  const NominalStance stance(Params().robot);
  const Eigen::Vector2d ahead = here - stance.center_B - stance.foot[kFrontLeft];  // along the path
  EXPECT_THAT(foothold({0, 0, 0}, 0.5),
              IsNear(stance.center_B + ahead + Eigen::Rotation2Dd(0.4) * stance.foot[kFrontLeft], 1e-12));
}

// A step along a slope is the step on level ground, measured from the ground.
TEST(SwingPlannerTest, StepsAlongASlope) {
  Trot level, uphill;
  for (Trot* trot : {&level, &uphill}) trot->path.velocity << 0.12, 0.03;
  uphill.ground.slope << 0.3, -0.2;
  uphill.state = StandingOn(Params().robot, uphill.ground);
  const double begin = uphill.Foot(kFrontLeft)[2];
  const auto flat = level.Swing(), climb = uphill.Swing();
  ExpectConsistent(climb);
  const double clearance = Params().robot.foot_radius / uphill.ground.Normal()[2];
  const auto over_ground = [&](const Vec<3>& p) { return p[2] - uphill.ground.HeightAt(p.head<2>()); };
  EXPECT_NEAR(begin, climb.front().p_W[2], 1e-12);
  for (std::size_t n = 0; n < flat.size(); ++n)
    EXPECT_NEAR(over_ground(climb[n].p_W) - clearance, flat[n].p_W[2] - Params().robot.foot_radius, 1e-8)
        << n;
  EXPECT_NEAR(over_ground(uphill.Foothold(kFrontLeft)), clearance, 1e-12);
}

// The feet of this robot stay in place, while the path moves their footholds 0.2 m ahead. The force acts on
// one of them as the side of a block does.
class AgainstABlock : public Trot {
 public:
  explicit AgainstABlock(const Vec<3>& force, const SwingPlannerParams& params = Params()) : Trot(params) {
    path.velocity << 0.6, 0;
    forces[kFrontLeft] = force;
  }
  Vec<3> Step(Leg leg) { return Foothold(leg) - Foot(leg); }
};

TEST(SwingPlannerTest, AFootThatMeetsABlockGoesBackAndLands) {
  SwingPlannerParams params = Params();
  params.step.retarget_phase = 0.4;
  AgainstABlock trot({-50, 0, 0}, params);
  const auto swing = trot.Swing();
  const Vec<3> begin = trot.Foot(kFrontLeft);
  EXPECT_THAT(trot.Step(kFrontLeft), IsNear(Vec<3>(-0.02, 0, 0), 1e-12));
  EXPECT_GT(trot.Step(kRearRight)[0], 0.1) << "nothing is in its way";
  const auto turned = std::is_sorted_until(
      swing.begin(), swing.end(),
      [](const FootReference& a, const FootReference& b) { return a.p_W[0] < b.p_W[0]; });
  EXPECT_THAT(turned->p_W.head<2>(), IsNear(begin.head<2>(), 1e-12)) << "it goes on from where it is";
  EXPECT_GT(std::prev(turned)->p_W[0] - begin[0], 0.027) << "a tick of 2 mm before the lag of 0.03 m";
  ExpectConsistent({turned, swing.end()});
}

TEST(SwingPlannerTest, OnlyAForceAgainstTheStepIsABlock) {
  const double threshold = 0.05 * Params().robot.mass() * 9.81;
  AgainstABlock held({-1.1 * threshold, 0, 0}), touched({-0.9 * threshold, 0, 0}), ground({0, 0, 200}),
      aside({0, 200, 0}), along({200, 0, 0});
  for (AgainstABlock* trot : {&held, &touched, &ground, &aside, &along}) trot->Swing();
  EXPECT_LT(held.Step(kFrontLeft)[0], 0);
  for (AgainstABlock* trot : {&touched, &ground, &aside, &along})
    EXPECT_GT(trot->Step(kFrontLeft)[0], 0.1) << trot->forces[kFrontLeft].transpose();
}

TEST(SwingPlannerTest, AFootThatGoesBackFindsTheGroundOfASlope) {
  AgainstABlock trot({-50, 0, 0});
  trot.ground.slope << 0.2, 0;
  trot.state = StandingOn(Params().robot, trot.ground);
  trot.Swing();
  EXPECT_NEAR(trot.Step(kFrontLeft)[0], -0.02, 1e-12);
  EXPECT_NEAR(trot.Step(kFrontLeft)[2], -0.02 * 0.2, 1e-12);
}

TEST(SwingPlannerTest, TheStepAfterThatIsHighAndGoesUpFirst) {
  SwingPlannerParams params = Params();
  params.step.reflex.rise_phase = 35.0 / kSwingTicks;
  AgainstABlock trot({-50, 0, 0}, params);
  trot.Swing();
  const auto swing = trot.Swing();  // in which there is no reflex
  const Vec<3> begin = trot.Foot(kFrontLeft);
  ExpectConsistent(swing, 4);
  EXPECT_THAT(swing.back().p_W, IsNear(trot.Foothold(kFrontLeft), 1e-12));
  for (std::size_t n = 0; n <= 35; ++n)
    EXPECT_THAT(swing[n].p_W.head<2>(), IsNear(begin.head<2>(), 1e-12)) << n;
  EXPECT_GT(swing[35].p_W[2], begin[2] + 0.05) << "above a block of 4 cm";
  EXPECT_NEAR(Top(swing, begin), 0.1, 1e-4);
  EXPECT_GT(trot.Step(kFrontLeft)[0], 0.1);
  trot.forces = FootForces();
  EXPECT_NEAR(Top(trot.Swing(), begin), 0.05, 1e-4) << "the next step has the usual height";
}

TEST(SwingPlannerTest, AHighStepIsNotLowerThanTheOthers) {
  SwingPlannerParams params = Params();
  params.step.height = 0.12;
  AgainstABlock trot({-50, 0, 0}, params);
  trot.Swing();
  EXPECT_NEAR(Top(trot.Swing(), trot.Foot(kFrontLeft)), 0.12, 1e-4);
}

TEST(SwingPlannerTest, TheReflexIsAnOption) {
  SwingPlannerParams params = Params();
  params.step.reflex.enabled = false;
  AgainstABlock with({-50, 0, 0}), without({-50, 0, 0}, params), alone({0, 0, 0}, params);
  for (AgainstABlock* trot : {&with, &without, &alone}) trot->Swing();
  EXPECT_EQ(without.Step(kFrontLeft), alone.Step(kFrontLeft));
  EXPECT_NE(with.Step(kFrontLeft), alone.Step(kFrontLeft));
}

TEST(SwingPlannerTest, DoesNotAllocate) {
  AgainstABlock trot({-50, 0, 0});
  trot.Set(kStance);
  trot.Tick();
  AllocationGuard guard;
  double step = 0;
  for (const ContactState state : {kSwing, kSwing, kLate, kSearching, kStance}) {
    trot.Set(state, 0.5);
    trot.Tick();
    if (state == kLate) step = trot.Step(kFrontLeft)[0];
  }
  EXPECT_EQ(guard.count(), 0);
  EXPECT_LT(step, 0) << "the reflex was part of it";
}

TEST(SwingPlannerTest, RefusesNonsense) {
  SwingPlannerParams params = Params();
  params.gravity = -9.81;
  EXPECT_TRUE(Refuses<SwingPlanner>(params, "gravity"));
}

TEST(SwingPlannerTest, TheStepIsSetInARun) {
  SwingPlannerParams changed = Params();
  changed.step = {.height = 0.08,
                  .touchdown_speed = 0.3,
                  .search_depth = 0.07,
                  .velocity_feedback = 0.1,
                  .retarget_phase = 0.3,
                  .free_shift = 0.01,
                  .shift_bandwidth = 30,
                  .largest_shift = 0.05};
  const auto swing = [](Trot& trot) {
    trot.path.velocity = {0.2, 0};
    trot.wrench.force_W = {0, 40, 0};
    std::vector<double> numbers;
    for (const FootReference& foot : trot.Swing(40)) {
      numbers.insert(numbers.end(), foot.p_W.begin(), foot.p_W.end());
      numbers.insert(numbers.end(), foot.a_W.begin(), foot.a_W.end());
    }
    return numbers;
  };
  Trot plain, set, built(changed);
  set.rig().Set(set.rig()->step, changed.step);
  const std::vector<double> expected = swing(built);
  EXPECT_EQ(swing(set), expected);
  EXPECT_NE(swing(plain), expected);
}

}  // namespace tenon::swing_planner_test
