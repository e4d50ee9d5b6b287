#pragma once

#include <tenon/plants/signals/imu_signals.h>
#include <tenon/systems/ros2/messages.h>

namespace tenon::ros2 {

/// @file
/// Messages of ROS 2 from signals, and back. The first functions make messages with all names and lists that
/// a run does not change; the others set numbers and do not allocate.

sensor_msgs::JointState MakeJointState(const std::vector<std::string>& names);
/// An IMU that does not measure its orientation.
sensor_msgs::Imu MakeImu(const std::string& frame);
nav_msgs::Odometry MakeOdometry(const std::string& parent, const std::string& child);
geometry_msgs::TransformStamped MakeTransform(const std::string& parent, const std::string& child);

/// Sets x, y and z.
void Set(const Eigen::Vector3d& v, auto* to) {
  to->x = v[0], to->y = v[1], to->z = v[2];
}
/// The message of a quaternion (w, x, y, z).
geometry_msgs::Quaternion QuaternionOf(const Vec<4>& q);
void SetImu(const ImuMeasurement& measured, sensor_msgs::Imu* to);
/// Pose and velocity of B in W.
void SetOdometry(const Vec<3>& p_WB, const Vec<4>& q_WB, const Vec<3>& v_W, const Vec<3>& w_W,
                 nav_msgs::Odometry* to);

inline Vec<3> VectorOf(const geometry_msgs::Vector3& v) {
  return {v.x, v.y, v.z};
}
ImuMeasurement ImuOf(const sensor_msgs::Imu& imu);

}  // namespace tenon::ros2
