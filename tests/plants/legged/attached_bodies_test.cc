// Bodies attached to a quadruped by parameters: springs at rest, drives, balance, errors.

#include <tenon/plants/legged/attached_bodies.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tenon::attached_bodies_test {
namespace {

using test::DogBot;
using test::Standing;
using Rig = TestRig<QuadrupedPlant>;

AttachedBody Ball(const std::string& name, AttachedJoint joint) {
  AttachedBody body;
  body.name = name;
  body.joint = joint;
  body.mass = 2;
  body.radius = 0.05;
  return body;
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
  EXPECT_EQ(rig->additions.u.elements, "slider");
  EXPECT_EQ(rig[rig->added_positions][0], 0.1);
  EXPECT_NEAR(rig.Derivative(rig->added_u)[0], 0, 1e-9);
  rig.Set(rig->added_q, Eigen::VectorXd::Constant(1, 0.15))
      .Set(rig->added_u, Eigen::VectorXd::Constant(1, 2.0));
  const double force = -300 * 0.05 - 20 * 2;
  EXPECT_NEAR(rig.Derivative(rig->added_u)[0] + rig[rig->acceleration].a_W[2], force / 2, 1e-9);
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

/// Two links: the second one, on the first, follows a sine about its rest angle.
TEST(AttachedBodiesTest, ADriveFollowsItsSine) {
  AttachedBody upper = Ball("upper", AttachedJoint::kWeld), fore = Ball("fore", AttachedJoint::kPin);
  upper.position = {0, 0, 0.1};
  fore.on = "upper";
  fore.mass = 0.1;
  fore.centre = {0, 0, 0.1};
  fore.stiffness = 50;
  fore.damping = 0.5;
  fore.rest = 0.3;
  fore.amplitude = 0.5;
  fore.frequency = 2;
  Rig rig = [&] {
    QuadrupedPlantParams params = With({upper, fore});
    params.gravity = 0;
    params.initial.p_WB[2] = 10;
    return Rig(params);
  }();
  rig.Fix(rig->torque, Vec<12>::Zero());
  EXPECT_EQ(rig->additions.u.elements, "fore");
  EXPECT_EQ(rig[rig->added_positions][0], 0.3);
  rig.RunTo(1);
  EXPECT_NEAR(rig[rig->added_positions][0], 0.3 + 0.5 * std::sin(2.0), 0.05);
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

}  // namespace
}  // namespace tenon::attached_bodies_test
