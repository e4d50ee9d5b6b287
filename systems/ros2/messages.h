#pragma once

#include <tenon/systems/framework/types/signal.h>

/// @file
/// Messages of ROS 2 as signals, with the packages, names and members that they have there: the message
/// sensor_msgs/msg/JointState is tenon::ros2::sensor_msgs::JointState. A message of your own is a struct like
/// these in a namespace that is named as its package. Conventions are those of ROS: SI units, x forward, y
/// left and z up (REP 103), the frames map, odom and base_link (REP 105), quaternions (x, y, z, w). A
/// covariance of zeros is unknown; a measurement that does not exist has -1 in the first element of its
/// covariance.

namespace tenon::ros2 {

/// A struct that is a message of its own, with a topic.
template <class T>
concept Message = requires {
  typename T::IsMessage;
};

namespace builtin_interfaces {
struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static FieldList Fields() { return {{"sec", &Time::sec}, {"nanosec", &Time::nanosec}}; }
};
}  // namespace builtin_interfaces

/// The stamp of a time that is not negative [s]; later than 2^31 s, it stays at the last one.
builtin_interfaces::Time StampOf(double time);
/// The time of a stamp [s].
double TimeOf(const builtin_interfaces::Time& stamp);

namespace std_msgs {
struct Header {
  builtin_interfaces::Time stamp = {};
  std::string frame_id = {};
  static FieldList Fields() { return {{"stamp", &Header::stamp}, {"frame_id", &Header::frame_id}}; }
};
struct String {
  using IsMessage = void;
  std::string data = {};
  static FieldList Fields() { return {{"data", &String::data}}; }
};
}  // namespace std_msgs

namespace geometry_msgs {
struct Vector3 {
  double x = 0, y = 0, z = 0;
  static FieldList Fields() { return {{"x", &Vector3::x}, {"y", &Vector3::y}, {"z", &Vector3::z}}; }
};
struct Point {
  double x = 0, y = 0, z = 0;
  static FieldList Fields() { return {{"x", &Point::x}, {"y", &Point::y}, {"z", &Point::z}}; }
};
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
  static FieldList Fields() {
    return {{"x", &Quaternion::x}, {"y", &Quaternion::y}, {"z", &Quaternion::z}, {"w", &Quaternion::w}};
  }
};
struct Pose {
  Point position = {};
  Quaternion orientation = {};
  static FieldList Fields() { return {{"position", &Pose::position}, {"orientation", &Pose::orientation}}; }
};
struct PoseWithCovariance {
  Pose pose = {};
  std::array<double, 36> covariance{};  ///< of x, y, z and rotations about fixed x, y, z; row by row
  static FieldList Fields() {
    return {{"pose", &PoseWithCovariance::pose}, {"covariance", &PoseWithCovariance::covariance}};
  }
};
struct Twist {
  using IsMessage = void;
  Vector3 linear = {};
  Vector3 angular = {};
  static FieldList Fields() { return {{"linear", &Twist::linear}, {"angular", &Twist::angular}}; }
};
struct TwistWithCovariance {
  Twist twist = {};
  std::array<double, 36> covariance{};
  static FieldList Fields() {
    return {{"twist", &TwistWithCovariance::twist}, {"covariance", &TwistWithCovariance::covariance}};
  }
};
struct Wrench {
  Vector3 force = {};
  Vector3 torque = {};
  static FieldList Fields() { return {{"force", &Wrench::force}, {"torque", &Wrench::torque}}; }
};
/// Force and torque about the origin of the header's frame, in its axes.
struct WrenchStamped {
  using IsMessage = void;
  std_msgs::Header header = {};
  Wrench wrench = {};
  static FieldList Fields() {
    return {{"header", &WrenchStamped::header}, {"wrench", &WrenchStamped::wrench}};
  }
};
struct Transform {
  Vector3 translation = {};
  Quaternion rotation = {};
  static FieldList Fields() {
    return {{"translation", &Transform::translation}, {"rotation", &Transform::rotation}};
  }
};
/// Pose of the child's frame in the header's.
struct TransformStamped {
  std_msgs::Header header = {};
  std::string child_frame_id = {};
  Transform transform = {};
  static FieldList Fields() {
    return {{"header", &TransformStamped::header},
            {"child_frame_id", &TransformStamped::child_frame_id},
            {"transform", &TransformStamped::transform}};
  }
};
}  // namespace geometry_msgs

namespace sensor_msgs {
/// Joints by name; each list has one entry per joint or none.
struct JointState {
  using IsMessage = void;
  std_msgs::Header header = {};
  std::vector<std::string> name = {};
  std::vector<double> position = {};
  std::vector<double> velocity = {};
  std::vector<double> effort = {};
  static FieldList Fields() {
    return {{"header", &JointState::header},
            {"name", &JointState::name},
            {"position", &JointState::position},
            {"velocity", &JointState::velocity},
            {"effort", &JointState::effort}};
  }
};
/// Angular velocity and acceleration less gravity (9.81 upwards at rest), in the header's frame.
struct Imu {
  using IsMessage = void;
  std_msgs::Header header = {};
  geometry_msgs::Quaternion orientation = {};
  std::array<double, 9> orientation_covariance{};
  geometry_msgs::Vector3 angular_velocity = {};
  std::array<double, 9> angular_velocity_covariance{};
  geometry_msgs::Vector3 linear_acceleration = {};
  std::array<double, 9> linear_acceleration_covariance{};
  static FieldList Fields() {
    return {{"header", &Imu::header},
            {"orientation", &Imu::orientation},
            {"orientation_covariance", &Imu::orientation_covariance},
            {"angular_velocity", &Imu::angular_velocity},
            {"angular_velocity_covariance", &Imu::angular_velocity_covariance},
            {"linear_acceleration", &Imu::linear_acceleration},
            {"linear_acceleration_covariance", &Imu::linear_acceleration_covariance}};
  }
};
struct Joy {
  using IsMessage = void;
  std_msgs::Header header = {};
  std::vector<float> axes = {};
  std::vector<std::int32_t> buttons = {};
  static FieldList Fields() {
    return {{"header", &Joy::header}, {"axes", &Joy::axes}, {"buttons", &Joy::buttons}};
  }
};
}  // namespace sensor_msgs

namespace nav_msgs {
/// Pose of the child's frame in the header's, and twist in the child's.
struct Odometry {
  using IsMessage = void;
  std_msgs::Header header = {};
  std::string child_frame_id = {};
  geometry_msgs::PoseWithCovariance pose = {};
  geometry_msgs::TwistWithCovariance twist = {};
  static FieldList Fields() {
    return {{"header", &Odometry::header},
            {"child_frame_id", &Odometry::child_frame_id},
            {"pose", &Odometry::pose},
            {"twist", &Odometry::twist}};
  }
};
}  // namespace nav_msgs

namespace tf2_msgs {
struct TFMessage {
  using IsMessage = void;
  std::vector<geometry_msgs::TransformStamped> transforms = {};
  static FieldList Fields() { return {{"transforms", &TFMessage::transforms}}; }
};
}  // namespace tf2_msgs

namespace rosgraph_msgs {
struct Clock {
  using IsMessage = void;
  builtin_interfaces::Time clock = {};
  static FieldList Fields() { return {{"clock", &Clock::clock}}; }
};
}  // namespace rosgraph_msgs

/// Name of a message in ROS 2, such as "sensor_msgs/msg/JointState", or in DDS, such as
/// "sensor_msgs::msg::dds_::JointState_", from the name of its struct.
std::string NameOf(const internal::TypeInfo& type);
std::string DdsNameOf(const internal::TypeInfo& type);

}  // namespace tenon::ros2

TENON_DECLARE_SIGNAL(tenon::ros2::std_msgs::String);
TENON_DECLARE_SIGNAL(tenon::ros2::geometry_msgs::Twist);
TENON_DECLARE_SIGNAL(tenon::ros2::geometry_msgs::WrenchStamped);
TENON_DECLARE_SIGNAL(tenon::ros2::sensor_msgs::JointState);
TENON_DECLARE_SIGNAL(tenon::ros2::sensor_msgs::Imu);
TENON_DECLARE_SIGNAL(tenon::ros2::sensor_msgs::Joy);
TENON_DECLARE_SIGNAL(tenon::ros2::nav_msgs::Odometry);
TENON_DECLARE_SIGNAL(tenon::ros2::tf2_msgs::TFMessage);
TENON_DECLARE_SIGNAL(tenon::ros2::rosgraph_msgs::Clock);
