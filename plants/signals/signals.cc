#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/elevation_map.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/joint_command.h>
#include <tenon/plants/signals/leash_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/plants/signals/quaternion.h>
#include <tenon/plants/signals/ros2_signals.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {

void CheckNumCables(int num_cables, Eigen::Index num, const char* who) {
  if (num == num_cables) return;
  throw RunError(
      fmt::format("{} reads signals of {} cables, but its robot has {}: give both blocks the same robot", who,
                  num, num_cables));
}

Eigen::Matrix2d PlanarPath::Heading() const {
  return Eigen::Rotation2Dd(yaw).toRotationMatrix();
}

// The velocity in W at time s is R(yaw + yaw_rate s) velocity; its integral from 0 to t is t R(yaw) S
// velocity with S = [a -b; b a], a = sin(angle) / angle, b = (1 - cos(angle)) / angle, angle = yaw_rate t.
PlanarPath PlanarPath::At(double t) const {
  const double angle = yaw_rate * t;
  const double a = angle == 0 ? 1 : std::sin(angle) / angle;
  const double b = angle == 0 ? 0 : std::sin(angle / 2) * std::sin(angle / 2) / (angle / 2);
  PlanarPath next = *this;
  next.position_W +=
      t * (Heading() * Eigen::Vector2d(a * velocity[0] - b * velocity[1], b * velocity[0] + a * velocity[1]));
  next.yaw += angle;
  return next;
}

}  // namespace tenon

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

TENON_DEFINE_SIGNAL(tenon::CableVector);
TENON_DEFINE_SIGNAL(tenon::PlatformState);
TENON_DEFINE_SIGNAL(tenon::PlatformAcceleration);
TENON_DEFINE_SIGNAL(tenon::PlatformWrench);
TENON_DEFINE_SIGNAL(tenon::CableSignals);
TENON_DEFINE_SIGNAL(tenon::CableFaults);
TENON_DEFINE_SIGNAL(tenon::CdprEnergy);
TENON_DEFINE_SIGNAL(tenon::PoseMeasurement);
TENON_DEFINE_SIGNAL(tenon::Payload);
TENON_DEFINE_SIGNAL(tenon::LoadEstimate);
TENON_DEFINE_SIGNAL(tenon::WrenchEstimate);
TENON_DEFINE_SIGNAL(tenon::LegForceEstimate);
TENON_DEFINE_SIGNAL(tenon::ContactSchedule);
TENON_DEFINE_SIGNAL(tenon::WalkCommand);
TENON_DEFINE_SIGNAL(tenon::GroundPlane);
TENON_DEFINE_SIGNAL(tenon::ElevationMap);
TENON_DEFINE_SIGNAL(tenon::ImuMeasurement);
TENON_DEFINE_SIGNAL(tenon::PersonState);
TENON_DEFINE_SIGNAL(tenon::LeashState);
TENON_DEFINE_SIGNAL(tenon::LeggedState);
TENON_DEFINE_SIGNAL(tenon::LeggedAcceleration);
TENON_DEFINE_SIGNAL(tenon::JointMotion);
TENON_DEFINE_SIGNAL(tenon::FootForces);
TENON_DEFINE_SIGNAL(tenon::JointLocks);
TENON_DEFINE_SIGNAL(tenon::JointCommand);
TENON_DEFINE_SIGNAL(tenon::ExternalForce);
TENON_DEFINE_SIGNAL(tenon::ExternalForces);
TENON_DEFINE_SIGNAL(tenon::BodyReference);
TENON_DEFINE_SIGNAL(tenon::FeetReference);
TENON_DEFINE_SIGNAL(tenon::PlanarPath);
