#pragma once

#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/systems/block.h>
#include <tenon/systems/network/udp.h>

#include <chrono>
#include <string>
#include <vector>

inline const tenon::Rate kRate = tenon::Hz(1000);  // rate of the messages and of the controller

// Addresses of the two programs. The plant's program listens at one port, the controller's at one port for
// each signal, numbered from controller_port.
struct Link {
  std::string plant = "127.0.0.1";
  std::string controller = "127.0.0.1";
  int plant_port = 9881;
  int controller_port = 9882;
};

// Calls `remote` with the name and output of each signal that is sent from the robot to its controller.
template <class Remote>
void ForEachSignal(Remote&& remote, auto& world) {
  remote("state", world.state);
  remote("foot_forces", world.foot_forces);
  remote("measured_torque", world.measured_torque);
  remote("inertial", world.inertial);
  remote("ground_forces", world.ground_forces);      // read by the errors of the walk,
  remote("external_torque", world.external_torque);  // not for the controller
}

// Replaces the robot in the controller's program and has its ports.
class RemoteWorld final : public tenon::Subdiagram {
 public:
  explicit RemoteWorld(const Link& link) {
    auto& to_plant = Add<tenon::UdpPublisher<tenon::Vec<12>>>(
        "to_plant", {.name = "torque", .address = link.plant, .port = link.plant_port, .rate = kRate});
    Connect(torque, to_plant.u);
    int port = link.controller_port;
    ForEachSignal(
        [&]<class T>(const std::string& name, tenon::OutputPort<T>& output) {
          auto& input = Add<tenon::UdpInput<T>>("from_" + name, {.name = name,
                                                                 .rate = kRate,
                                                                 .unit = output.spec().units,
                                                                 .elements = output.spec().elements,
                                                                 .address = link.controller,
                                                                 .port = port++,
                                                                 .lock_step = true});
          Connect(input.y, output);
        },
        *this);
  }
  tenon::InputPort<tenon::Vec<12>> torque{this, {"torque", "N m"}};
  tenon::OutputPort<tenon::LeggedState> state{this, {"state"}};
  tenon::OutputPort<tenon::FootForces> ground_forces{this, {"ground_forces"}};
  tenon::OutputPort<tenon::Vec<12>> external_torque{this, {"external_torque", "N m", tenon::kJointElements}};
  tenon::OutputPort<tenon::Vec<12>> measured_torque{this, {"measured_torque", "N m", tenon::kJointElements}};
  tenon::OutputPort<tenon::FootForces> foot_forces{this, {"foot_forces"}};
  tenon::OutputPort<tenon::ImuMeasurement> inertial{this, {"inertial"}};
};

// Measures the round-trip time from sending the state to receiving the torque. The times are members of the
// block, so that only one run at a time is possible.
struct StopwatchParams {};
class Stopwatch final : public tenon::LeafSystem<StopwatchParams> {
 public:
  using Clock = std::chrono::steady_clock;
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::LeggedState> sent{this, {"sent"}};
  tenon::InputPort<tenon::Vec<12>> answered{this, {"answered", "N m"}};
  tenon::Publish start{this, "start", tenon::Sampled{kRate}, tenon::Uses(sent),
                       [this](const tenon::LeggedState&) { begin_ = Clock::now(); }};
  tenon::Publish stop{this, "stop", tenon::Sampled{kRate}, tenon::Uses(answered),
                      [this](const tenon::Vec<12>&) {
                        trips.push_back(std::chrono::duration<double>(Clock::now() - begin_).count());
                      }};
  std::vector<double> trips;  // s

 private:
  Clock::time_point begin_{};
};

// The robot in the plant's program: sends its measurements, and waits for the torque.
class RobotOnly final : public tenon::Subdiagram {
 public:
  RobotOnly(const tenon::QuadrupedWorldParams& params, const Link& link)
      : world(Add<tenon::QuadrupedWorld>("world", params)),
        from_controller(
            Add<tenon::UdpInput<tenon::Vec<12>>>("from_controller", {.name = "torque",
                                                                     .rate = kRate,
                                                                     .unit = "N m",
                                                                     .elements = tenon::kJointElements,
                                                                     .address = link.plant,
                                                                     .port = link.plant_port,
                                                                     .lock_step = true})),
        stopwatch(Add<Stopwatch>("stopwatch")) {
    int port = link.controller_port;
    ForEachSignal(
        [&]<class T>(const std::string& name, tenon::OutputPort<T>& output) {
          auto& publisher = Add<tenon::UdpPublisher<T>>(
              "to_" + name, {.name = name, .address = link.controller, .port = port++, .rate = kRate});
          Connect(output, publisher.u);
        },
        world);
    Connect(from_controller.y, world.torque);
    Connect(world.state, stopwatch.sent);
    Connect(from_controller.y, stopwatch.answered);
  }
  tenon::QuadrupedWorld& world;
  tenon::UdpInput<tenon::Vec<12>>& from_controller;
  Stopwatch& stopwatch;
};
