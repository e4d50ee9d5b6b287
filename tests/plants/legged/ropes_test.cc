#include <tenon/plants/legged/ropes.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::ropes_test {

const Rope kLeft{"left", {3, 1, 2}, {0.1, 0.2, 0.05}, 0, 100};
const Rope kRight{"right", {3, -1, 2}, {0.1, -0.2, 0.05}, 0, 100};

LeggedState Robot() {
  LeggedState x;
  x.p_WB = {0.3, 0.2, 0.5};
  x.q_WB = QuaternionFromRotationVector({0.1, -0.4, 0.3});
  return x;
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

}  // namespace tenon::ropes_test
