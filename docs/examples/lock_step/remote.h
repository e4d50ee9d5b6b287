#pragma once

#include <tenon/systems/network/udp.h>
#include <tenon/systems/simulation.h>

#include <string>

// Addresses of the two programs. Each program listens at its own address and sends to the other's.
struct Link {
  std::string plant = "127.0.0.1";
  std::string controller = "127.0.0.1";
  int plant_port = 9871;
  int controller_port = 9872;
  tenon::Rate rate = tenon::Hz(1000);  // rate of both programs
};

// Replaces the controller in the plant's program and has its ports: sends its inputs, and waits for the
// outputs of the other program.
class RemotePd final : public tenon::Subdiagram {
 public:
  explicit RemotePd(const Link& link) {
    auto& to_controller = Add<tenon::UdpPublisher<tenon::Vec<2>>>(
        "to_controller",
        {.name = "cart", .address = link.controller, .port = link.controller_port, .rate = link.rate});
    auto& from_controller = Add<tenon::UdpInput<double>>("from_controller", {.name = "force",
                                                                             .rate = link.rate,
                                                                             .unit = "N",
                                                                             .address = link.plant,
                                                                             .port = link.plant_port,
                                                                             .lock_step = true});
    Connect(x, to_controller.u);
    Connect(from_controller.y, u);
  }
  tenon::InputPort<tenon::Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  tenon::OutputPort<double> u{this, {"u", "N"}};
};

// Replaces the plant in the controller's program and has its ports.
class RemoteCart final : public tenon::Subdiagram {
 public:
  explicit RemoteCart(const Link& link) {
    auto& from_plant = Add<tenon::UdpInput<tenon::Vec<2>>>("from_plant", {.name = "cart",
                                                                          .rate = link.rate,
                                                                          .unit = "m, m/s",
                                                                          .elements = "position, velocity",
                                                                          .address = link.controller,
                                                                          .port = link.controller_port,
                                                                          .lock_step = true});
    auto& to_plant = Add<tenon::UdpPublisher<double>>(
        "to_plant", {.name = "force", .address = link.plant, .port = link.plant_port, .rate = link.rate});
    Connect(from_plant.y, state);
    Connect(force, to_plant.u);
  }
  tenon::InputPort<double> force{this, {"force", "N"}};
  tenon::OutputPort<tenon::Vec<2>> state{this, {"x", "m, m/s", "position, velocity"}};
};
