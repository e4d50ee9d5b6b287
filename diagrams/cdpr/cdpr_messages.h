#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/plants/signals/ros2_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct CdprMessagesParams {
  int num_cables = 8;
};

/// The messages of ROS 2 on a cable robot. W is the frame map, and the platform's frame B is base_link.
///
/// The cables are joints `cable_1` and so on, with length, rate and tension. `disturbance` is the wrench of
/// the load without its point mass about the origin of B, in B. All covariances are unknown.
class CdprMessages final : public LeafSystem<CdprMessagesParams> {
 public:
  using LeafSystem::LeafSystem;
  using Wrench = ros2::geometry_msgs::WrenchStamped;

  InputPort<PlatformState> platform{this, {"platform"}};
  InputPort<CableSignals> cables{this, {"cables"}, CableSignals::Zero(params.num_cables)};
  InputPort<ImuMeasurement> inertial{this, {"inertial"}};
  InputPort<LoadEstimate> load{this, {"load"}, LoadEstimate{}};

  OutputPort<ros2::sensor_msgs::JointState> joint_states{
      this, {"joint_states"}, MakeCables(), Uses(time, cables), &CdprMessages::CalcCables};
  OutputPort<ros2::sensor_msgs::Imu> imu{
      this,
      {"imu"},
      ros2::MakeImu("base_link"),
      Uses(time, inertial),
      [](double t, const ImuMeasurement& measured, ros2::sensor_msgs::Imu* out) {
        out->header.stamp = ros2::StampOf(t);
        ros2::SetImu(measured, out);
      }};
  OutputPort<ros2::nav_msgs::Odometry> odometry{
      this,
      {"odometry"},
      ros2::MakeOdometry("map", "base_link"),
      Uses(time, platform),
      [](double t, const PlatformState& x, ros2::nav_msgs::Odometry* out) {
        out->header.stamp = ros2::StampOf(t);
        ros2::SetOdometry(x.p_WB, x.q_WB, x.v_W, x.w_W, out);
      }};
  OutputPort<Wrench> disturbance{this,
                                 {"disturbance"},
                                 Wrench{{{}, "base_link"}, {}},
                                 Uses(time, platform, load),
                                 &CdprMessages::CalcDisturbance};
  OutputPort<ros2::tf2_msgs::TFMessage> tf{
      this, {"tf"}, {{ros2::MakeTransform("map", "base_link")}}, Uses(time, platform), &CdprMessages::CalcTf};

 private:
  ros2::sensor_msgs::JointState MakeCables() const;
  void CalcCables(double t, const CableSignals& measured, ros2::sensor_msgs::JointState* out) const;
  void CalcDisturbance(double t, const PlatformState& x, const LoadEstimate& estimate, Wrench* out) const;
  void CalcTf(double t, const PlatformState& x, ros2::tf2_msgs::TFMessage* out) const;
};

}  // namespace tenon
