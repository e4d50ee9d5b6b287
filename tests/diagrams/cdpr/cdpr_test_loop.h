#pragma once

#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

namespace tenon::test {

inline CdprDescription ShippedFourCableRobot() {
  return LoadCdpr(FindResource("robots", "cdpr_4"));
}

/// A loop along a path, with a PD controller.
inline CdprLoopParams WithPd(const CdprDescription& robot, std::shared_ptr<const EquilibriumPath> path) {
  return {.robot = robot, .path = path, .pd_stiffness_N_per_m = 2000, .pd_damping_N_s_per_m = 200};
}

/// A loop along a path, with an MPC that has no estimate of the load. Cables may be slack.
inline CdprLoopParams WithMpc(const CdprDescription& robot, std::shared_ptr<const EquilibriumPath> path) {
  CdprLoopParams params{.robot = robot, .path = path};
  params.mpc.emplace();
  params.mpc->path = path;
  params.mpc->horizon = 1.2;
  params.mpc->num_steps = 25;
  params.mpc->weights = {.position = Vec<3>::Constant(1000),
                         .velocity = Vec<3>::Constant(20),
                         .attitude = Vec<3>::Constant(20),
                         .angular_velocity = Vec<3>::Ones(),
                         .tension = 3e-3};
  params.offset_free = false;
  params.forbid_slack = false;
  return params;
}

/// A circle of 0.5 m radius in 10 s, 2 m above the floor, for the robot that the path is planned with.
inline std::shared_ptr<const EquilibriumPath> CirclePath(const CdprDescription& robot) {
  return std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.5, 10, 2));
}
inline CdprLoopParams CircleWithPd() {
  const CdprDescription robot = ShippedFourCableRobot();
  return WithPd(robot, CirclePath(robot));
}
inline CdprLoopParams CircleWithMpc() {
  const CdprDescription robot = ShippedFourCableRobot();
  return WithMpc(robot, CirclePath(robot));
}

}  // namespace tenon::test
