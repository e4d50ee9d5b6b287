#include <tenon/plants/signals/quaternion.h>
#include <tenon/plants/signals/ros2_signals.h>

namespace tenon::ros2 {

sensor_msgs::JointState MakeJointState(const std::vector<std::string>& names) {
  const std::vector<double> zeros(names.size());
  return {.header = {}, .name = names, .position = zeros, .velocity = zeros, .effort = zeros};
}

sensor_msgs::Imu MakeImu(const std::string& frame) {
  sensor_msgs::Imu imu{.header = {{}, frame}};
  imu.orientation_covariance[0] = -1;
  return imu;
}

nav_msgs::Odometry MakeOdometry(const std::string& parent, const std::string& child) {
  return {.header = {{}, parent}, .child_frame_id = child};
}

geometry_msgs::TransformStamped MakeTransform(const std::string& parent, const std::string& child) {
  return {{{}, parent}, child, {}};
}

geometry_msgs::Quaternion QuaternionOf(const Vec<4>& q) {
  return {.x = q[1], .y = q[2], .z = q[3], .w = q[0]};
}

void SetImu(const ImuMeasurement& measured, sensor_msgs::Imu* to) {
  Set(measured.angular_velocity_B, &to->angular_velocity);
  Set(measured.specific_force_B, &to->linear_acceleration);
}

void SetOdometry(const Vec<3>& p_WB, const Vec<4>& q_WB, const Vec<3>& v_W, const Vec<3>& w_W,
                 nav_msgs::Odometry* to) {
  const Eigen::Matrix3d R_BW = RotationFromQuaternion(q_WB).transpose();
  Set(p_WB, &to->pose.pose.position);
  to->pose.pose.orientation = QuaternionOf(q_WB);
  Set(R_BW * v_W, &to->twist.twist.linear);
  Set(R_BW * w_W, &to->twist.twist.angular);
}

ImuMeasurement ImuOf(const sensor_msgs::Imu& imu) {
  return {VectorOf(imu.angular_velocity), VectorOf(imu.linear_acceleration)};
}

}  // namespace tenon::ros2
