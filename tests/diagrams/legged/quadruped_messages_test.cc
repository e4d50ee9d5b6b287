// The messages of ROS 2 on robots, with the conventions of REP 103 and 105.

#include <tenon/diagrams/cdpr/cdpr_messages.h>
#include <tenon/diagrams/legged/quadruped_messages.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::quadruped_messages_test {

using namespace ros2;
using Eigen::Isometry3d, Eigen::Vector3d;

Vector3d Of(const auto& v) {
  return {v.x, v.y, v.z};
}
Eigen::Quaterniond Of(const geometry_msgs::Quaternion& q) {
  return {q.w, q.x, q.y, q.z};
}

/// A robot somewhere, turned, in motion and with bent legs.
LeggedState SomeState(const QuadrupedDescription& robot) {
  return {.p_WB = {1, -2, 0.5},
          .q_WB = QuaternionFromEuler({0.1, -0.2, 2.5}),
          .q = robot.stance + Vec<12>::LinSpaced(-0.3, 0.4),
          .v_W = {0.3, 0.1, -0.2},
          .w_W = {0.4, -0.5, 0.6}};
}

QuadrupedMessagesParams Go2() {
  return {.robot = LoadQuadruped(YamlFile{"go2"}), .links = LoadRobotLinks({"go2"}), .epoch = 1000};
}

class QuadrupedMessagesTest : public ::testing::Test {
 protected:
  explicit QuadrupedMessagesTest(const QuadrupedMessagesParams& params = Go2())
      : rig(params), x(SomeState(params.robot)) {
    rig.Fix(rig->state, x).Fix(rig->joints, {x.q, Vec<12>::LinSpaced(1, 12)});
    rig.Fix(rig->torque, Vec<12>::LinSpaced(0, -11));
    rig.Fix(rig->inertial, {{1, 2, 3}, {4, 5, 6}});
    rig.Fix(rig->wrench, {{10, 20, 30}, {1, 2, 3}});
    FootForces forces;
    forces[kRearLeft] << 1, 2, 50;
    rig.Fix(rig->foot_forces, forces).Tick();
  }
  TestRig<QuadrupedMessages> rig;
  LeggedState x;
};

TEST_F(QuadrupedMessagesTest, JointsAndImuAreThoseOfTheSignals) {
  const sensor_msgs::JointState& joints = rig[rig->joint_states];
  ASSERT_EQ(joints.name.size(), 12u);
  for (int j = 0; j < kNumJoints; ++j) {
    const auto i = static_cast<std::size_t>(j);
    EXPECT_EQ(joints.name[i], rig->params.robot.joint(j).name);
    EXPECT_EQ(joints.position[i], x.q[j]);
    EXPECT_EQ(joints.velocity[i], j + 1);
    EXPECT_EQ(joints.effort[i], -j);
  }
  EXPECT_EQ(joints.header.stamp.sec, 1000);
  const sensor_msgs::Imu& imu = rig[rig->imu];
  EXPECT_EQ(imu.header.frame_id, "base_link");
  EXPECT_EQ(imu.orientation_covariance[0], -1) << "not measured";
  EXPECT_EQ(imu.angular_velocity_covariance[0], 0) << "unknown";
  EXPECT_EQ(Of(imu.angular_velocity), Vector3d(1, 2, 3));
  EXPECT_EQ(Of(imu.linear_acceleration), Vector3d(4, 5, 6));
}

TEST_F(QuadrupedMessagesTest, OdometryHasThePoseInOdomAndTheTwistInTheBase) {
  const nav_msgs::Odometry& odometry = rig[rig->odometry];
  EXPECT_EQ(odometry.header.frame_id, "odom");
  EXPECT_EQ(odometry.child_frame_id, "base_link");
  EXPECT_EQ(Of(odometry.pose.pose.position), x.p_WB);
  const Eigen::Matrix3d R_WB = Of(odometry.pose.pose.orientation).toRotationMatrix();
  EXPECT_TRUE(R_WB.isApprox(x.R_WB(), 1e-14));
  EXPECT_TRUE((R_WB * Of(odometry.twist.twist.linear)).isApprox(Vector3d(x.v_W), 1e-14));
  EXPECT_TRUE((R_WB * Of(odometry.twist.twist.angular)).isApprox(Vector3d(x.w_W), 1e-14));
}

TEST_F(QuadrupedMessagesTest, TheDisturbanceIsTheSameWrenchAboutTheBase) {
  QuadrupedDynamics dynamics;
  QuadrupedModel(rig->params.robot).Calc(x, &dynamics);
  const geometry_msgs::WrenchStamped& wrench = rig[rig->disturbance];
  EXPECT_EQ(wrench.header.frame_id, "base_link");
  const Vector3d force_W = x.R_WB() * Of(wrench.wrench.force), arm_W = x.p_WB - dynamics.com_W;
  EXPECT_TRUE(force_W.isApprox(Vector3d(10, 20, 30), 1e-14));
  EXPECT_TRUE(
      (x.R_WB() * Of(wrench.wrench.torque) + arm_W.cross(force_W)).isApprox(Vector3d(1, 2, 3), 1e-12));
}

/// Composes the transforms of /tf and /tf_static, as tf2 does.
Isometry3d PoseOf(const std::string& frame, const std::vector<const tf2_msgs::TFMessage*>& all) {
  for (const tf2_msgs::TFMessage* tf : all)
    for (const geometry_msgs::TransformStamped& each : tf->transforms) {
      if (each.child_frame_id != frame) continue;
      const Eigen::Translation3d translation(Of(each.transform.translation));
      return PoseOf(each.header.frame_id, all) * (translation * Of(each.transform.rotation));
    }
  EXPECT_EQ(frame, "odom") << "has no parent";
  return Isometry3d::Identity();
}

TEST(QuadrupedFramesTest, EndAtTheFeetOfEachRobot) {
  for (const char* name : {"go2", "b2", "dogbot", "anymal_c"}) {
    SCOPED_TRACE(name);
    const QuadrupedDescription robot = LoadQuadruped(YamlFile{name});
    TestRig<QuadrupedMessages> rig({.robot = robot, .links = LoadRobotLinks({name})});
    const LeggedState x = SomeState(robot);
    rig.Fix(rig->state, x)
        .Fix(rig->joints, {})
        .Fix(rig->torque, Vec<12>::Zero())
        .Fix(rig->inertial, {})
        .Tick();
    const std::vector<const tf2_msgs::TFMessage*> all{&rig[rig->tf], &rig[rig->tf_static]};
    EXPECT_GE(all[0]->transforms.size(), 17u);
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Vector3d foot_W = x.p_WB + x.R_WB() * robot.FootPosition(leg, x.q);
      const std::string leg_name = kLegNames[static_cast<std::size_t>(leg)];
      EXPECT_TRUE(PoseOf("contact_" + leg_name, all).translation().isApprox(foot_W, 1e-12));
      EXPECT_LT((PoseOf(leg_name + "_foot", all).translation() - foot_W).norm(), 1e-9) << leg_name;
    }
    EXPECT_NE(rig->params.links.urdf.find("<robot"), std::string::npos);
  }
}

TEST_F(QuadrupedMessagesTest, FootForcesAreInTheFramesOfTheFeet) {
  const geometry_msgs::WrenchStamped& foot = rig[rig->rear_left];
  EXPECT_EQ(foot.header.frame_id, "contact_rear_left");
  const Isometry3d pose = PoseOf(foot.header.frame_id, {&rig[rig->tf], &rig[rig->tf_static]});
  EXPECT_TRUE((pose.linear() * Of(foot.wrench.force)).isApprox(Vector3d(1, 2, 50), 1e-14));
  EXPECT_EQ(Of(rig[rig->front_left].wrench.force), Vector3d::Zero());
}

TEST(CdprMessagesTest, AreThoseOfTheSignals) {
  TestRig<CdprMessages> rig({.num_cables = 2});
  const CableVector two = Eigen::Vector2d(2, 3);
  rig.Fix(rig->platform, {.p_WB = {1, 2, 3}, .q_WB = QuaternionFromEuler({0, 0, 1}), .v_W = {0.5, 0, 0}})
      .Fix(rig->cables, {two, -two, 100 * two, two})
      .Fix(rig->inertial, {});
  rig.Fix(rig->load, {.rest = {.force_W = {0, 0, -7}}}).Tick();
  EXPECT_THAT(rig[rig->joint_states].name, testing::ElementsAre("cable_1", "cable_2"));
  EXPECT_THAT(rig[rig->joint_states].position, testing::ElementsAre(2, 3));
  EXPECT_THAT(rig[rig->joint_states].velocity, testing::ElementsAre(-2, -3));
  EXPECT_THAT(rig[rig->joint_states].effort, testing::ElementsAre(200, 300));
  EXPECT_EQ(rig[rig->odometry].header.frame_id, "map");
  EXPECT_NEAR(rig[rig->odometry].twist.twist.linear.y, -0.5 * std::sin(1), 1e-15);
  ASSERT_EQ(rig[rig->tf].transforms.size(), 1u);
  EXPECT_EQ(rig[rig->tf].transforms[0].header.frame_id, "map");
  EXPECT_EQ(Of(rig[rig->tf].transforms[0].transform.translation), Vector3d(1, 2, 3));
  EXPECT_NEAR(rig[rig->disturbance].wrench.force.z, -7, 1e-15);
}

}  // namespace tenon::quadruped_messages_test
