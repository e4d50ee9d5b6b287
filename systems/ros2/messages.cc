#include <tenon/systems/ros2/messages.h>
#include <tenon/systems/ros2/velocity_command.h>

#include <algorithm>

namespace tenon::ros2 {
namespace {

constexpr std::int64_t kNanoseconds = 1'000'000'000;  // per second

/// The namespace that is the package, and the name of the struct.
std::pair<std::string, std::string> PackageAndName(const internal::TypeInfo& type) {
  std::string full = internal::Demangled(type.id->name());
  const std::size_t name = full.rfind("::");
  if (name == full.npos) return {"", full};
  const std::size_t before = full.rfind("::", name - 1), package = before == full.npos ? 0 : before + 2;
  return {full.substr(package, name - package), full.substr(name + 2)};
}

}  // namespace

builtin_interfaces::Time StampOf(double time) {
  constexpr double kLast = 2147483647;
  const double within = std::clamp(time, 0.0, kLast);
  const std::int64_t nanoseconds = std::llround(within * static_cast<double>(kNanoseconds));
  return {.sec = static_cast<std::int32_t>(nanoseconds / kNanoseconds),
          .nanosec = static_cast<std::uint32_t>(nanoseconds % kNanoseconds)};
}

double TimeOf(const builtin_interfaces::Time& stamp) {
  return stamp.sec + stamp.nanosec / static_cast<double>(kNanoseconds);
}

std::string NameOf(const internal::TypeInfo& type) {
  const auto [package, name] = PackageAndName(type);
  return package + "/msg/" + name;
}

std::string DdsNameOf(const internal::TypeInfo& type) {
  const auto [package, name] = PackageAndName(type);
  return package + "::msg::dds_::" + name + "_";
}

}  // namespace tenon::ros2

TENON_DEFINE_SIGNAL(tenon::ros2::std_msgs::String);
TENON_DEFINE_SIGNAL(tenon::ros2::geometry_msgs::Twist);
TENON_DEFINE_SIGNAL(tenon::ros2::geometry_msgs::WrenchStamped);
TENON_DEFINE_SIGNAL(tenon::ros2::sensor_msgs::JointState);
TENON_DEFINE_SIGNAL(tenon::ros2::sensor_msgs::Imu);
TENON_DEFINE_SIGNAL(tenon::ros2::sensor_msgs::Joy);
TENON_DEFINE_SIGNAL(tenon::ros2::nav_msgs::Odometry);
TENON_DEFINE_SIGNAL(tenon::ros2::tf2_msgs::TFMessage);
TENON_DEFINE_SIGNAL(tenon::ros2::rosgraph_msgs::Clock);
TENON_DEFINE_SIGNAL(tenon::VelocityCommand);
