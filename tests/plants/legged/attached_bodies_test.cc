// Bodies attached to a quadruped by parameters: springs at rest, drives, balance, errors.

#include <tenon/plants/attached_bodies.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_arm.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>
#include <tenon/tests/testing/temporary_path.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <numbers>

namespace tenon::attached_bodies_test {

using test::DogBot, test::Standing;
using Rig = TestRig<QuadrupedPlant>;

AttachedBody Ball(const std::string& name, AttachedJoint joint) {
  return {.name = name, .joint = joint, .mass = 2, .radius = 0.05};
}

QuadrupedPlantParams With(const std::vector<AttachedBody>& bodies) {
  return {.robot = DogBot(), .initial = Standing(DogBot()), .extend = Attach(bodies)};
}

/// The robot without gravity, so that the accelerations are those of the springs.
Rig Weightless(const AttachedBody& body) {
  QuadrupedPlantParams params = With({body});
  params.gravity = 0;
  params.initial.p_WB[2] = 10;
  return Rig(params);
}

/// A slider on the trunk moves relative to it with the reduced mass of both: f = k (r - q) - d u.
TEST(AttachedBodiesTest, ASliderHasItsSpringAndDamper) {
  AttachedBody body = Ball("slider", AttachedJoint::kSlider);
  body.axis = {0, 0, 2};
  body.rest = 0.1;
  body.stiffness = 300;
  body.damping = 20;
  Rig rig = Weightless(body);
  rig.Fix(rig->torque, Vec<12>::Zero());
  EXPECT_EQ(rig->additions.u.spec.elements, "slider");
  EXPECT_EQ(rig[rig->added_positions][0], 0.1);
  EXPECT_NEAR(rig.Derivative(rig->added_u)[0], 0, 1e-9);
  rig.Set(rig->added_q, Eigen::VectorXd::Constant(1, 0.15))
      .Set(rig->added_u, Eigen::VectorXd::Constant(1, 2.0));
  const double force = -300 * 0.05 - 20 * 2;
  EXPECT_NEAR(rig.Derivative(rig->added_u)[0] + rig[rig->acceleration].a_W[2], force / 2, 1e-9);
  body.limit = 12;
  Rig weak = Weightless(body);
  weak.Fix(weak->torque, Vec<12>::Zero())
      .Set(weak->added_q, Eigen::VectorXd::Constant(1, 0.15))
      .Set(weak->added_u, Eigen::VectorXd::Constant(1, 2.0));
  EXPECT_NEAR(weak.Derivative(weak->added_u)[0] + weak[weak->acceleration].a_W[2], -6, 1e-9);
}

TEST(AttachedBodiesTest, ABallJointReturnsToItsRest) {
  AttachedBody body = Ball("ball", AttachedJoint::kBall);
  body.centre = {0, 0, 0.2};
  body.stiffness = 20;
  Rig rig = Weightless(body);
  rig.Fix(rig->torque, Vec<12>::Zero());
  EXPECT_NEAR(rig.Derivative(rig->added_u).norm(), 0, 1e-9);
  Eigen::VectorXd q(4);
  q << std::cos(0.1), std::sin(0.1), 0, 0;  // turned by 0.2 rad about x
  rig.Set(rig->added_q, q);
  EXPECT_LT(rig.Derivative(rig->added_u)[0], -10);
}

/// Two links: the second one, on the first, follows a sine that begins at its rest angle.
void FollowsItsSine(double phase) {
  AttachedBody upper = Ball("upper", AttachedJoint::kWeld), fore = Ball("fore", AttachedJoint::kPin);
  upper.position = {0, 0, 0.1};
  upper.stiffness = 9;  // means nothing at a weld
  fore.on = "upper";
  fore.mass = 0.1;
  fore.centre = {0, 0, 0.1};
  fore.stiffness = 50;
  fore.damping = 0.5;
  fore.rest = 0.3;
  fore.amplitude = 0.5;
  fore.frequency = 2;
  fore.phase = phase;
  Rig rig = [&] {
    QuadrupedPlantParams params = With({upper, fore});
    params.gravity = 0;
    params.initial.p_WB[2] = 10;
    return Rig(params);
  }();
  rig.Fix(rig->torque, Vec<12>::Zero());
  EXPECT_EQ(rig->additions.u.spec.elements, "fore");
  EXPECT_EQ(rig[rig->added_positions][0], 0.3);
  rig.RunTo(1);
  EXPECT_NEAR(rig[rig->added_positions][0], 0.3 + 0.5 * (std::sin(2 + phase) - std::sin(phase)), 0.05);
}
TEST(AttachedBodiesTest, ADriveFollowsItsSine) {
  FollowsItsSine(0);
  FollowsItsSine(-std::numbers::pi / 2);
}

/// Connected references replace those of the parameters joint by joint, and speeds act through the damping.
TEST(AttachedBodiesTest, ADriveFollowsConnectedReferences) {
  AttachedBody one = Ball("one", AttachedJoint::kSlider), other = one,
               limp = Ball("limp", AttachedJoint::kPin);
  one.stiffness = 300;
  one.damping = 20;
  one.rest = 0.1;
  other.name = "other";
  other.stiffness = 500;
  other.axis = {0, 0, 1};
  QuadrupedPlantParams params = With({one, limp, other});
  params.gravity = 0;
  params.initial.p_WB[2] = 10;
  Rig rig(params);
  rig.Fix(rig->torque, Vec<12>::Zero());
  EXPECT_EQ(rig->additions.position_references.spec.elements, "one,other");
  EXPECT_EQ(rig->additions.speed_references.spec.units, "m/s,m/s");
  rig.Fix(rig->added_position_references, Eigen::Vector2d(0.3, NAN))
      .Fix(rig->added_speed_references, Eigen::Vector2d(2, 0));
  const double force = 300 * 0.2 + 20 * 2;
  EXPECT_NEAR(rig.Derivative(rig->added_u)[0] + rig[rig->acceleration].a_W[1], force / 2, 1e-9);
  EXPECT_NEAR(rig.Derivative(rig->added_u)[2] + rig[rig->acceleration].a_W[2], 0, 1e-9);
  EXPECT_NEAR(rig[rig->energy].potential, 300 / 2.0 * 0.2 * 0.2, 1e-9);
}

/// By Newton and Euler for the load: f = m (g - a) and, about the robot's CoM, t = r x f - I alpha. A weld is
/// an arm at rest on the trunk; a pin is a pendulum that swings.
TEST(AttachedBodiesTest, TheAddedWrenchIsTheReactionOfTheLoad) {
  for (const AttachedJoint joint : {AttachedJoint::kWeld, AttachedJoint::kPin}) {
    AttachedBody load = Ball("load", joint);
    load.position = {0.1, 0.05, 0.1};
    load.centre = {0.2, 0.03, 0.1};
    load.stiffness = joint == AttachedJoint::kPin ? 5 : 0;
    QuadrupedPlantParams params = With({load});
    params.payload = {1, {0.05, 0, 0.1}, 0.01 * Eigen::Matrix3d::Identity()};
    params.initial.w_W = {0.3, -0.5, 0.4};
    params.initial.qd.setConstant(0.7);
    Rig rig(params);
    rig.Fix(rig->torque, Vec<12>::Constant(3))
        .Fix(rig->external, {ExternalForce{.body = 2, .force_W = {20, -10, 5}}});
    Vec<3> w = params.initial.w_W, alpha = rig[rig->acceleration].alpha_W;
    Vec<3> a = rig[rig->acceleration].a_W + alpha.cross(load.position) + w.cross(w.cross(load.position));
    if (joint == AttachedJoint::kPin) {
      rig.Set(rig->added_u, Eigen::VectorXd::Constant(1, 4.0));
      alpha = rig[rig->acceleration].alpha_W;
      a = rig[rig->acceleration].a_W + alpha.cross(load.position) + w.cross(w.cross(load.position));
      const Vec<3> axis = Vec<3>::UnitY();
      alpha += rig.Derivative(rig->added_u)[0] * axis + 4 * w.cross(axis);
      w += 4 * axis;
    }
    a += alpha.cross(load.centre) + w.cross(w.cross(load.centre));
    QuadrupedBody robot(DogBot());
    robot.SetState(params.initial);
    const Vec<3> force = load.mass * (Vec<3>(0, 0, -params.gravity) - a);
    const Vec<3> arm = params.initial.p_WB + load.position + load.centre - robot.Com();
    const double inertia = 0.4 * load.mass * load.radius * load.radius;
    EXPECT_THAT(rig[rig->added_wrench].force_W, IsNear(force, 1e-8));
    EXPECT_THAT(rig[rig->added_wrench].torque_W, IsNear((arm.cross(force) - inertia * alpha).eval(), 1e-8));
  }
}

/// Aliengo with an arm whose joints are under the key `joints`, with `drive` as further keys of each.
struct ArmFile {
  ArmFile(const std::string& joints, const Vec<3>& angles, const std::string& drive = "") {
    const std::filesystem::path home = test::TemporaryPath("arm");
    std::filesystem::create_directories(home);
    std::ofstream(home / "aliengo.urdf") << test::WithArm(ReadText(TENON_ROBOTS_DIR "/aliengo.urdf"));
    const std::filesystem::path file = home / "aliengo.yaml";
    std::ofstream(file) << ReadText(TENON_ROBOTS_DIR "/aliengo.yaml") << joints << ":\n"
                        << fmt::format("  - {{joint: arm_yaw, angle_rad: {}{}}}\n", angles[0], drive)
                        << fmt::format("  - {{joint: arm_pitch, angle_rad: {}{}}}\n", angles[1], drive)
                        << fmt::format("  - {{joint: arm_elbow, angle_rad: {}{}}}\n", angles[2], drive);
    robot = LoadQuadruped(file.string());
    arm = LoadMovingParts(YamlFile{file.string()});
    std::filesystem::remove_all(home);
  }
  QuadrupedDescription robot;
  MovingParts arm;
};
const std::string kLimp = ", stiffness_N_m_per_rad: 0, damping_N_m_s_per_rad: 0";

/// Torques that hold the joints of the arm still make it a part of the trunk. The robot with the locked arm
/// has Tenon's own equations of motion.
TEST(AttachedBodiesTest, AnArmThatIsHeldIsAPartOfTheTrunk) {
  const Vec<3> angles(0.4, -0.7, 1.1);
  const ArmFile locked("locked_joints", angles), moves("actuated_joints", angles, kLimp);
  EXPECT_TRUE(locked.arm.bodies.empty());
  EXPECT_NEAR(moves.arm.at_rest.mass, 2.9, 1e-12);
  EXPECT_NEAR(moves.robot.mass(), locked.robot.mass(), 1e-12);
  RandomStream random(7);
  QuadrupedPlantParams params{.robot = locked.robot, .initial = test::RandomState(random)};
  params.payload = {2, {0.1, 0, 0.1}, 0.01 * Eigen::Matrix3d::Identity()};
  const Vec<12> torque = test::RandomVector<12>(random, 20);
  const ExternalForces external{ExternalForce{.body = 3, .force_W = {20, -10, 5}}};
  Rig plain(params);
  plain.Fix(plain->torque, torque).Fix(plain->external, external);
  params.robot = moves.robot;
  params.extend = Attach(moves.arm.bodies, moves.arm.at_rest);
  Rig rig(params);
  rig.Fix(rig->torque, torque).Fix(rig->external, external);
  ASSERT_EQ(rig->additions.u.spec.elements, "arm_yaw,arm_pitch,arm_elbow");
  const RigidInertia trunk = LoadQuadruped(TENON_ROBOTS_DIR "/aliengo.yaml").trunk,
                     bare = rig->bare_robot.trunk;
  EXPECT_NEAR(bare.mass, trunk.mass, 1e-12);
  EXPECT_THAT(bare.com, IsNear(trunk.com, 1e-12));
  EXPECT_THAT(bare.inertia, IsNear(trunk.inertia, 1e-10));
  const Eigen::VectorXd free = rig.Derivative(rig->added_u);
  Eigen::MatrixXd response(3, 3);
  for (int i = 0; i < 3; ++i)
    response.col(i) = rig.Fix(rig->added_forces, Eigen::VectorXd::Unit(3, i)).Derivative(rig->added_u) - free;
  rig.Fix(rig->added_forces, -test::Solve(response, free));
  EXPECT_THAT(rig.Derivative(rig->added_u), IsNear(Eigen::VectorXd::Zero(3), 1e-9));
  EXPECT_THAT(test::Stacked(rig[rig->acceleration]), IsNear(test::Stacked(plain[plain->acceleration]), 1e-8));
  EXPECT_THAT(rig[rig->added_wrench].force_W, IsNear(Vec<3>::Zero(), 1e-8));
  EXPECT_THAT(rig[rig->added_wrench].torque_W, IsNear(Vec<3>::Zero(), 1e-8));
  EXPECT_THAT(rig[rig->external_wrench].torque_W, IsNear(plain[plain->external_wrench].torque_W, 1e-10));
}

/// Without gravity, the CoM of robot and arm stays where it is while the arm moves. The CoM is that of the
/// robot whose arm is locked at the present angles.
TEST(AttachedBodiesTest, AnArmThatMovesKeepsTheCom) {
  const auto com = [](const LeggedState& x, const Vec<3>& angles) {
    QuadrupedBody whole(ArmFile("locked_joints", angles).robot);
    whole.SetState(x);
    return whole.Com();
  };
  const Vec<3> angles(0.4, -0.7, 1.1);
  const ArmFile moves(
      "actuated_joints", angles,
      ", amplitude_rad: 0.5, period_s: 1, stiffness_N_m_per_rad: 30, damping_N_m_s_per_rad: 1");
  QuadrupedPlantParams params{.robot = moves.robot, .initial = Standing(moves.robot)};
  params.gravity = 0;
  params.initial.p_WB[2] = 10;
  params.extend = Attach(moves.arm.bodies, moves.arm.at_rest);
  Rig rig(params);
  rig.Fix(rig->torque, Vec<12>::Zero());
  const Vec<3> before = com(rig[rig->state], angles);
  rig.RunTo(0.3);
  const Vec<3> reached = rig[rig->added_positions];
  EXPECT_THAT((reached - angles).cwiseAbs().minCoeff(), ::testing::Gt(0.1));
  EXPECT_GT((rig[rig->state].p_WB - params.initial.p_WB).norm(), 1e-3);
  EXPECT_THAT(com(rig[rig->state], reached), IsNear(before, 1e-8));
}

TEST(AttachedBodiesTest, RefusesToReplaceMoreThanTheTrunk) {
  QuadrupedPlantParams params = With({});
  params.extend = Attach({}, {1000, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()});
  EXPECT_TRUE(Throws<ParameterError>([&] { Rig rig(params); }, "1000 kg"));
}

TEST(AttachedBodiesTest, RefusesBodiesThatMakeNoSense) {
  const auto refuses = [](const std::vector<AttachedBody>& bodies, const auto&... parts) {
    return Throws<ParameterError>([&] { Rig rig(With(bodies)); }, parts...);
  };
  AttachedBody body = Ball("load", AttachedJoint::kPin);
  EXPECT_TRUE(refuses({body, body}, "load"));
  body.on = "front_left_nee";
  EXPECT_TRUE(refuses({body}, "front_left_knee"));
  body = Ball("load", AttachedJoint::kPin);
  body.axis.setZero();
  EXPECT_TRUE(refuses({body}, "axis"));
  body = Ball("load", AttachedJoint::kPin);
  body.edges.setConstant(0.1);
  EXPECT_TRUE(refuses({body}, "edges_m", "load"));
  body = Ball("load", AttachedJoint::kBall);
  body.rest = 1;
  EXPECT_TRUE(refuses({body}, "rest"));
}

}  // namespace tenon::attached_bodies_test
