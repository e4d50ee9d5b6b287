#pragma once

#include <tenon/systems/dds/dds.h>
#include <tenon/systems/ros2/velocity_command.h>

namespace tenon {

/// Returns the place where the programs of ROS 2 meet: the domain ROS_DOMAIN_ID of the environment, or 0.
/// Throws ParameterError if that is not 0 to 230.
DdsLink Ros2Link(const std::string& interface = "");

/// A gamepad in sensor_msgs/msg/Joy, with the axes of an Xbox controller.
struct Gamepad {
  bool enabled = false;           ///< button 4, the left shoulder button, is pressed
  Vec<3> stick = Vec<3>::Zero();  ///< axes 1, 0 and 3: forward, left, turn to the left, from -1 to 1

  static FieldList Fields() { return {{"enabled", &Gamepad::enabled}, {"stick", &Gamepad::stick}}; }
};
template <>
struct DdsMessageOf<Gamepad> {
  static const DdsMessage& Get();
};

struct Ros2VelocityParams {
  std::string twist = "rt/cmd_vel";
  std::string joy = "rt/joy";
  DdsLink link = {};
  Vec<3> lowest{-0.3, -0.15, -0.5};  ///< bounds of y.velocity; a gamepad's stick spans them
  Vec<3> highest{0.4, 0.15, 0.5};
  double timeout = 0.5;  ///< time without a message after which the velocity is zero [s]
  Rate rate = Hz(50);
  bool record = false;                     ///< records y, as DdsInput does
  Recording<VelocityCommand> replay = {};  ///< if not empty, y follows this recording

  void Validate() const;  ///< throws ParameterError
};

/// The velocity that geometry_msgs/msg/Twist or a gamepad in sensor_msgs/msg/Joy commands.
///
///     auto& velocity = builder.Add<Ros2Velocity>("cmd_vel", {.link = Ros2Link()});
///     builder.Connect(velocity.y, drive.request);  // of a WalkDrive
///
/// From a Twist, the block takes linear.x, linear.y and angular.z. While its button is pressed, the gamepad
/// overrides the Twist. Refused messages are counted as in DdsInput. A message is too old `timeout` after the
/// tick that took it over.
class Ros2Velocity final : public LeafSystem<Ros2VelocityParams> {
 public:
  using LeafSystem::LeafSystem;

  struct Heard {
    ros2::geometry_msgs::Twist twist;
    Gamepad gamepad;
    double twist_time = kNever, gamepad_time = kNever;  ///< [s]
    static constexpr double kNever = -1e9;
    static FieldList Fields() {
      return {{"twist", &Heard::twist},
              {"gamepad", &Heard::gamepad},
              {"twist_time", &Heard::twist_time, "s"},
              {"gamepad_time", &Heard::gamepad_time, "s"}};
    }
  };
  Scratch<Heard> heard{this, "heard", Heard{}};
  Scratch<TakenOver<VelocityCommand>> taken{this, "taken"};
  Scratch<RefusedMessages> refused{this, "refused"};
  ExternalPort<VelocityCommand> y{this,
                                  "y",
                                  VelocityCommand{},
                                  Sampled{params.rate},
                                  Uses(time, heard, taken, refused),
                                  &Ros2Velocity::TakeOver};

 private:
  void TakeOver(double t, Heard& now, TakenOver<VelocityCommand>& taken_now, RefusedMessages& refused_now,
                VelocityCommand* out) const;
  template <class T>
  std::unique_ptr<internal::Inbox> Open(const std::string& topic) const {
    if (!params.replay.empty()) return nullptr;
    return internal::MakeDdsInbox({topic, params.link, false}, DdsMessageOf<T>::Get(), 1);
  }
  std::unique_ptr<internal::Inbox> twist_ = Open<ros2::geometry_msgs::Twist>(params.twist);
  std::unique_ptr<internal::Inbox> joy_ = Open<Gamepad>(params.joy);
};

}  // namespace tenon
