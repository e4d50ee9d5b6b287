#pragma once

#include <string>
#include <tuple>

#include "tenon/diagrams/legged_locomotion.h"

namespace tenon {

/// How a walking controller is tuned; read from a file such as controllers/profiles/standard.yaml.
struct LocomotionProfile {
  WholeBodyGains whole_body;
  double qp_rate_hz = 1000;

  static constexpr auto Fields() {
    return std::tuple{Required("whole_body", &LocomotionProfile::whole_body),
                      Required("qp_rate_hz", &LocomotionProfile::qp_rate_hz)};
  }
};

/// The profile that ships with Tenon under a name, or a file. Throws ParameterError.
LocomotionProfile LoadLocomotionProfile(const std::string& name);

/// Parameters of a LeggedLocomotion for a robot as its controller knows it, with gaits that ship under a name
/// or stand in a file. Throws ParameterError.
LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot,
                                      const LocomotionProfile& profile = LoadLocomotionProfile("standard"),
                                      const std::string& gaits = "standard");

}  // namespace tenon
