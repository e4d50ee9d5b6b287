#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/robot_links.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/ros2_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct QuadrupedMessagesParams {
  QuadrupedDescription robot;
  RobotLinks links = {};  ///< frames of `tf` and `tf_static`; empty: only those of trunk and feet
  double epoch = 0;       ///< added to the time of the run in all stamps [s]
};

/// The messages of ROS 2 on a quadruped. W is the frame odom, and the trunk's frame B is base_link, or
/// RobotLinks::base; the centres of the feet have frames of their own, `contact_front_left` and so on, with
/// the axes of B.
///
/// `state` is the one that the controller uses. Joints have the names in the URDF, `joint_commands` has the
/// commanded torques as efforts, and the IMU does not measure its orientation. `disturbance` is the wrench
/// about the origin of B, in B, the forces on the feet are in the frames of their centres, and `tf_static`
/// has the links at rest relative to their parents. All covariances are unknown.
class QuadrupedMessages final : public LeafSystem<QuadrupedMessagesParams> {
 public:
  using LeafSystem::LeafSystem;
  using Wrench = ros2::geometry_msgs::WrenchStamped;
  static constexpr const char* kOdom = "odom";

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<JointMotion> joints{this, {"joints"}};
  InputPort<Vec<12>> torque{this, {"torque", "N m", kJointElements}};
  InputPort<ImuMeasurement> inertial{this, {"inertial"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}, FootForces{}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate{}};
  InputPort<Vec<12>> command{this, {"command", "N m", kJointElements}, Vec<12>::Zero()};

  OutputPort<ros2::sensor_msgs::JointState> joint_states{
      this, {"joint_states"}, MakeJoints(), Uses(time, joints, torque), &QuadrupedMessages::CalcJoints};
  OutputPort<ros2::sensor_msgs::JointState> joint_commands{
      this, {"joint_commands"}, MakeCommands(), Uses(time, command), &QuadrupedMessages::CalcCommands};
  OutputPort<ros2::sensor_msgs::Imu> imu{
      this,
      {"imu"},
      ros2::MakeImu(params.links.base),
      Uses(time, inertial),
      [this](double t, const ImuMeasurement& measured, ros2::sensor_msgs::Imu* out) {
        out->header.stamp = ros2::StampOf(params.epoch + t);
        ros2::SetImu(measured, out);
      }};
  OutputPort<ros2::nav_msgs::Odometry> odometry{
      this,
      {"odometry"},
      ros2::MakeOdometry(kOdom, params.links.base),
      Uses(time, state),
      [this](double t, const LeggedState& x, ros2::nav_msgs::Odometry* out) {
        out->header.stamp = ros2::StampOf(params.epoch + t);
        ros2::SetOdometry(x.p_WB, x.q_WB, x.v_W, x.w_W, out);
      }};
  OutputPort<Wrench> disturbance{this,
                                 {"disturbance"},
                                 Wrench{{{}, params.links.base}, {}},
                                 Uses(time, state, wrench),
                                 &QuadrupedMessages::CalcDisturbance};
  OutputPort<ros2::tf2_msgs::TFMessage> tf{
      this, {"tf"}, MakeTf(false), Uses(time, state), &QuadrupedMessages::CalcTf};
  OutputPort<ros2::tf2_msgs::TFMessage> tf_static{
      this, {"tf_static"}, MakeTf(true), Uses(time), [](double, ros2::tf2_msgs::TFMessage*) {}};
  OutputPort<Wrench> front_left = MakeFoot(kFrontLeft);
  OutputPort<Wrench> front_right = MakeFoot(kFrontRight);
  OutputPort<Wrench> rear_left = MakeFoot(kRearLeft);
  OutputPort<Wrench> rear_right = MakeFoot(kRearRight);

 private:
  ros2::sensor_msgs::JointState MakeJoints() const;
  ros2::sensor_msgs::JointState MakeCommands() const;
  ros2::tf2_msgs::TFMessage MakeTf(bool at_rest) const;
  OutputPort<Wrench> MakeFoot(int leg);

  void CalcJoints(double t, const JointMotion& motion, const Vec<12>& effort,
                  ros2::sensor_msgs::JointState* out) const;
  void CalcCommands(double t, const Vec<12>& torque, ros2::sensor_msgs::JointState* out) const;
  void CalcDisturbance(double t, const LeggedState& x, const WrenchEstimate& estimate, Wrench* out) const;
  void CalcTf(double t, const LeggedState& x, ros2::tf2_msgs::TFMessage* out) const;
};

}  // namespace tenon
