// A pendulum that ROS 2 sees as a joint, hears on /cmd_vel, and that is recorded in pendulum.mcap.

#include <tenon/systems/dds/ros2.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/systems/simulation.h>

#include <cmath>
#include <cstdio>

using tenon::ros2::sensor_msgs::JointState;

class Pendulum final : public tenon::Leaf {
 public:
  tenon::InputPort<double> torque{this, {"torque", "N m"}};
  tenon::ContinuousState<tenon::Vec<2>> x{this, {"x", "rad, rad/s"}, {0.5, 0}};
  tenon::OutputPort<tenon::Vec<2>> state{this, x};
  tenon::TimeDerivative<tenon::Vec<2>> dx{x, Uses(x, torque), [](const tenon::Vec<2>& x, double torque) {
                                            return tenon::Vec<2>(x[1], torque - 9.81 * std::sin(x[0]));
                                          }};
};

int main() {
  tenon::DiagramBuilder builder;
  auto& pendulum = builder.Add<Pendulum>("pendulum");

  // Out: the message, once for all who listen and once for the file.
  auto& message = builder.AddFunction("message", Uses(builder.time, pendulum.state),
                                      [](double t, const tenon::Vec<2>& x) {
                                        return JointState{.header = {tenon::ros2::StampOf(t), "base"},
                                                          .name = {"pivot"},
                                                          .position = {x[0]},
                                                          .velocity = {x[1]}};
                                      });
  const tenon::DdsLink link = tenon::Ros2Link("lo");  // of the domain ROS_DOMAIN_ID
  auto& publisher =
      builder.Add<tenon::DdsPublisher<JointState>>("publisher", {.topic = "rt/joint_states", .link = link});
  builder.Connect(message, publisher.u);
  const auto file = std::make_shared<tenon::McapFile>("pendulum.mcap");
  auto& recorder =
      builder.Add<tenon::McapPublisher<JointState>>("recorder", {.file = file, .topic = "/joint_states"});
  builder.Connect(message, recorder.u);

  // In: the yaw rate of /cmd_vel, or of a gamepad on /joy, as a torque.
  auto& velocity = builder.Add<tenon::Ros2Velocity>("velocity", {.link = link});
  builder.Connect(builder.AddFunction({"torque", "N m"}, Uses(velocity.y),
                                      [](const tenon::VelocityCommand& y) { return y.velocity[2]; }),
                  pendulum.torque);

  tenon::Simulator simulator(builder.Build(), {.real_time_rate = 1});
  simulator.RunTo(1);
  file->Close();
  int messages = 0;
  tenon::ReadMcap("pendulum.mcap", [&](const tenon::McapMessage&) { ++messages; });
  std::printf("%d messages recorded, %d not sent\n", messages,
              static_cast<int>(simulator.context().Eval(publisher.unsent)));
}
