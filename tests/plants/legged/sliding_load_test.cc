#include <tenon/plants/legged/ropes.h>
#include <tenon/plants/legged/sliding_load.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::sliding_load_test {

LeggedState Trunk(double pitch = 0) {
  return {.p_WB = {0.3, -0.2, 0.5}, .q_WB = QuaternionFromRotationVector({0, pitch, 0})};
}

SlidingLoadParams Load(double pitch = 0) {
  return {.mass = 5, .position_B = {0.05, 0.02, 0.1}, .robot = Trunk(pitch)};
}

TEST(SlidingLoadTest, LiesStillOnALevelTrunkAndWeighsOnIt) {
  TestRig<SlidingLoad> rig(Load());
  rig.Fix(rig->robot, Trunk()).RunTo(1);
  EXPECT_THAT(rig[rig->place], IsNear(Vec<3>(0.05, 0.02, 0.1), 1e-9));
  EXPECT_EQ(rig[rig->force].body, 0);
  EXPECT_THAT(rig[rig->force].p_B, IsNear(Vec<3>(0.05, 0.02, 0.1), 1e-9));
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, 0, -5 * 9.81), 1e-6));
}

TEST(SlidingLoadTest, IsNotThereWithoutMassUntilItIsDropped) {
  SlidingLoadParams params = Load();
  params.mass = 0;
  TestRig<SlidingLoad> rig(params);
  rig.Fix(rig->robot, Trunk()).RunTo(1);
  EXPECT_TRUE(rig[rig->force].force_W.isZero(0));
  EXPECT_TRUE(rig[rig->motion].v_W.isZero(0));
  EXPECT_FALSE(rig[rig->geometry][0].visible);
  LoadMotion above = rig[rig->motion];
  above.p_W[2] += 0.1;
  rig.Set(rig->mass, 2.0).Set(rig->motion, above);
  rig.RunTo(1.1);
  EXPECT_NEAR(rig[rig->motion].p_W[2], above.p_W[2] - 9.81 / 2 * 0.01, 1e-6);  // falls freely
  rig.RunTo(3);
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, 0, -2 * 9.81), 1e-3));
  EXPECT_TRUE(rig[rig->geometry][0].visible);
}

// A load that gets its mass during a walk lies on the trunk and does not pull it back to the start.
TEST(SlidingLoadTest, LiesOnTheTrunkWhereverItGetsItsMass) {
  SlidingLoadParams params = Load();
  params.mass = 0;
  TestRig<SlidingLoad> rig(params);
  LeggedState walking = Trunk();
  walking.v_W = {0.5, 0, 0};
  for (int n = 0; n < 400; ++n) {
    rig.Fix(rig->robot, walking).RunTo(0.01 * (n + 1));
    walking.p_WB[0] += 0.005;
  }
  EXPECT_THAT(rig[rig->place], IsNear(params.position_B, 0.02));
  rig.Set(rig->mass, 2.0);
  EXPECT_LT(rig[rig->force].force_W.norm(), 50);
}

// On a trunk steeper than the friction angle: a = g (sin - mu cos), up to the stop.
TEST(SlidingLoadTest, SlidesDownASteepTrunkToItsStop) {
  const double pitch = 0.5;
  SlidingLoadParams params = Load(pitch);
  params.reach = {0.3, 0.3};
  params.slip_speed = 1e-3;
  TestRig<SlidingLoad> rig(params);
  rig.Fix(rig->robot, Trunk(pitch)).RunTo(0.3);
  const double acceleration = 9.81 * (std::sin(pitch) - 0.3 * std::cos(pitch));
  EXPECT_NEAR(rig[rig->place][0], 0.05 + acceleration / 2 * 0.09, 5e-3);
  EXPECT_NEAR(rig[rig->motion].v_W.norm(), acceleration * 0.3, 0.02);
  rig.RunTo(3);
  EXPECT_NEAR(rig[rig->place][0], 0.35, 2e-3);
  EXPECT_NEAR(rig[rig->motion].v_W.norm(), 0, 1e-4);
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, 0, -5 * 9.81), 1e-3));
}

TEST(SlidingLoadTest, CreepsOnAGentleSlope) {
  const double pitch = 0.1;
  TestRig<SlidingLoad> rig(Load(pitch));
  rig.Fix(rig->robot, Trunk(pitch)).RunTo(1);
  // mu s / sqrt(s^2 + v_s^2) = tan(pitch)
  const double share = std::tan(pitch) / 0.3, creep = 0.01 * share / std::sqrt(1 - share * share);
  EXPECT_NEAR(rig[rig->motion].v_W.norm(), creep, 0.02 * creep);
}

TEST(SlidingLoadTest, MovesWithTheTrunkUnderIt) {
  LeggedState robot = Trunk();
  robot.v_W = {0.4, 0, 0};
  robot.w_W = {0, 0, 1};
  SlidingLoadParams params = Load();
  params.robot = robot;
  TestRig<SlidingLoad> rig(params);
  rig.Fix(rig->robot, robot);
  EXPECT_THAT(rig[rig->motion].v_W, IsNear(Vec<3>(0.4 - 0.02, 0.05, 0), 1e-12));
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(0, 0, -5 * 9.81), 1e-9)) << "no slip, no rub";
  // A trunk that falls away faster than the load: it is in the air, and weighs nothing.
  robot.v_W = {0, 0, -2};
  rig.Fix(rig->robot, robot);
  EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>::Zero().eval(), 0));
}

TEST(SlidingLoadTest, IsDrawnWhereItIs) {
  TestRig<SlidingLoad> rig(Load());
  rig.Fix(rig->robot, Trunk());
  EXPECT_THAT(rig[rig->geometry].at(0).p_W, IsNear(Vec<3>(0.35, -0.18, 0.6), 1e-12));
}

const Rope kLeft{"left", {3, 1, 2}, {0.1, 0.2, 0.05}, 0, 100};
const Rope kRight{"right", {3, -1, 2}, {0.1, -0.2, 0.05}, 0, 100};

LeggedState Robot() {
  return {.p_WB = {0.3, 0.2, 0.5}, .q_WB = QuaternionFromRotationVector({0.1, -0.4, 0.3})};
}

// The resultant at B's origin has the force and the moment of the single pulls; winches do not push.
TEST(RopesTest, PullTheirAttachmentsTowardsTheirAnchors) {
  TestRig<Ropes> rig({{kLeft, kRight}});
  const LeggedState robot = Robot();
  rig.Fix(rig->robot, robot).Fix(rig->command, CableVector(Vec<2>(70, 250)));
  EXPECT_THAT(rig[rig->tension], IsNear(Vec<2>(70, 100), 0));
  Vec<3> force = Vec<3>::Zero(), torque = Vec<3>::Zero();
  for (const auto& [rope, tension] : {std::pair(kLeft, 70.0), std::pair(kRight, 100.0)}) {
    const Vec<3> arm = robot.R_WB() * rope.attachment_B;
    const Vec<3> pull = tension * (rope.anchor_W - robot.p_WB - arm).normalized();
    force += pull;
    torque += arm.cross(pull);
  }
  EXPECT_EQ(rig[rig->force].body, 0);
  EXPECT_THAT(rig[rig->force].force_W, IsNear(force, 1e-12));
  EXPECT_THAT(rig[rig->force].torque_W, IsNear(torque, 1e-12));
  const Geometry& lines = rig[rig->geometry];
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[1].name, "right");
  EXPECT_THAT(Vec<3>(lines[1].p_W + lines[1].vector_W), IsNear(kRight.anchor_W, 1e-12));
  EXPECT_EQ(lines[1].value, 100);

  rig.Fix(rig->command, CableVector(Vec<2>(-5, 0)));
  EXPECT_TRUE(rig[rig->force].force_W.isZero(0));
}

TEST(RopesTest, RefuseWhatIsNoRope) {
  const auto with = [](auto change) {
    Rope rope = kLeft;
    change(rope);
    return RopesParams{{rope}};
  };
  EXPECT_TRUE(Refuses<Ropes>({}, "ropes"));
  std::vector<Rope> five(5, kLeft);
  for (std::size_t i = 0; i < five.size(); ++i) five[i].name += std::to_string(i);
  EXPECT_TRUE(Refuses<Ropes>({five}, "ropes"));
  EXPECT_TRUE(Refuses<Ropes>({{kLeft, kLeft}}, "left"));
  EXPECT_TRUE(Refuses<Ropes>(with([](Rope& rope) { rope.tension_max = 0; }), "tension_max_N"));
  EXPECT_TRUE(Refuses<Ropes>(with([](Rope& rope) { rope.tension_min = -1; }), "tension_min_N"));
  EXPECT_TRUE(Refuses<Ropes>(with([](Rope& rope) { rope.tension_min = 200; }), "tension_min_N"));
  EXPECT_TRUE(Refuses<Ropes>(with([](Rope& rope) { rope.name = "a,b"; }), "a,b"));
}

TEST(RopesTest, ARopeWithoutLengthHasNoDirection) {
  const LeggedState robot = Robot();
  Rope rope = kLeft;
  rope.anchor_W = robot.p_WB + robot.R_WB() * rope.attachment_B;
  EXPECT_TRUE(Throws<RunError>([&] { LineOf(rope, robot); }, "left"));
}

}  // namespace tenon::sliding_load_test
