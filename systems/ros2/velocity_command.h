#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// A velocity that a person or another program commands; not active before the first command.
struct VelocityCommand {
  bool active = false;
  Vec<3> velocity = Vec<3>::Zero();  ///< forward, left [m/s], yaw rate [rad/s]

  static FieldList Fields() {
    return {{"active", &VelocityCommand::active},
            {"velocity", &VelocityCommand::velocity, "m/s, m/s, rad/s", "forward,left,yaw"}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::VelocityCommand);
