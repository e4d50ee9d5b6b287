#include <tenon/systems/dds/ros2.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>
#include <ros2.h>

namespace tenon {

namespace internal {

DdsMessage MakeShippedRos2Message(const TypeInfo& type) {
  const std::string name = ros2::DdsNameOf(type);
  for (const dds_topic_descriptor_t* descriptor :
       {&std_msgs_msg_dds__String__desc, &geometry_msgs_msg_dds__Twist__desc,
        &geometry_msgs_msg_dds__WrenchStamped__desc, &sensor_msgs_msg_dds__JointState__desc,
        &sensor_msgs_msg_dds__Imu__desc, &sensor_msgs_msg_dds__Joy__desc, &nav_msgs_msg_dds__Odometry__desc,
        &tf2_msgs_msg_dds__TFMessage__desc, &rosgraph_msgs_msg_dds__Clock__desc})
    if (name == descriptor->m_typename)
      return {.descriptor = descriptor, .size = descriptor->m_size, .as_is = &type};
  throw ParameterError(
      fmt::format("the type {} is not one of Tenon's messages: write its IDL and specialise DdsMessageOf by "
                  "MakeRos2Message",
                  name));
}

}  // namespace internal

namespace {

constexpr std::uint32_t kEnable = 4;           // button
constexpr std::uint32_t kAxes[3] = {1, 0, 3};  // forward, left, turn

void WriteGamepad(const Gamepad&, sensor_msgs_msg_dds__Joy_&) {}  // only received

std::string ReadGamepad(const sensor_msgs_msg_dds__Joy_& joy, Gamepad& gamepad) {
  if (joy.buttons._length <= kEnable || joy.axes._length <= kAxes[2])
    return fmt::format("a gamepad with {} axes and {} buttons; at least 4 and 5 are needed", joy.axes._length,
                       joy.buttons._length);
  gamepad.enabled = joy.buttons._buffer[kEnable] != 0;
  for (int i = 0; i < 3; ++i) gamepad.stick[i] = static_cast<double>(joy.axes._buffer[kAxes[i]]);
  return "";
}

}  // namespace

const DdsMessage& DdsMessageOf<Gamepad>::Get() {
  static const auto kMessage = MakeDdsMessage<sensor_msgs_msg_dds__Joy_, Gamepad, WriteGamepad, ReadGamepad>(
      &sensor_msgs_msg_dds__Joy__desc);
  return kMessage;
}

DdsLink Ros2Link(const std::string& interface) {
  const char* domain = std::getenv("ROS_DOMAIN_ID");
  if (domain == nullptr || *domain == '\0') return {.domain = 0, .interface = interface};
  const auto number = internal::NumberIn<int>(domain);
  Demand(number && *number >= 0 && *number <= 230,
         fmt::format("the environment variable ROS_DOMAIN_ID = '{}' must be 0 to 230",
                     internal::Excerpt(domain)));
  return {.domain = *number, .interface = interface};
}

void Ros2VelocityParams::Validate() const {
  Demand((lowest.array() <= 0).all() && (highest.array() >= 0).all() && lowest.allFinite() &&
             highest.allFinite(),
         "`lowest` must not be above 0 and `highest` not below, so that zero velocity is between them");
  Demand(timeout > 0, fmt::format("timeout_s = {} must be positive", timeout));
}

void Ros2Velocity::TakeOver(double t, Heard& now, TakenOver<VelocityCommand>& taken_now,
                            RefusedMessages& refused_now, VelocityCommand* out) const {
  if (!params.replay.empty()) {
    taken_now.Replay(params.replay, t);
  } else {
    if (twist_->Take(t, &now.twist, refused_now)) now.twist_time = t;
    if (joy_->Take(t, &now.gamepad, refused_now)) now.gamepad_time = t;
    VelocityCommand next;
    const bool has_twist = t - now.twist_time <= params.timeout;
    const bool has_gamepad = t - now.gamepad_time <= params.timeout && now.gamepad.enabled;
    next.active = taken_now.value.active || has_twist || has_gamepad;
    if (has_gamepad) {
      const Vec<3>& stick = now.gamepad.stick;
      next.velocity =
          (stick.array() > 0).select(stick.cwiseProduct(params.highest), stick.cwiseProduct(-params.lowest));
    } else if (has_twist) {
      next.velocity = {now.twist.linear.x, now.twist.linear.y, now.twist.angular.z};
    }
    next.velocity = next.velocity.cwiseMax(params.lowest).cwiseMin(params.highest);
    if (next.active != taken_now.value.active || next.velocity != taken_now.value.velocity)
      taken_now.Take(t, next, params.record);
  }
  *out = taken_now.value;
}

}  // namespace tenon
