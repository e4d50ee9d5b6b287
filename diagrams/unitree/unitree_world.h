#pragma once

#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/unitree/unitree_messages.h>

namespace tenon {

struct UnitreeWorldParams {
  DdsLink link = {.domain = 1, .interface = "lo"};
  LeggedState initial = {};  ///< state of the robot until it sends one
  Rate rate = Hz(500);       ///< rate of states and commands
  bool lock_step =
      false;  ///< each tick waits for the state with its time, so that the run repeats bit for bit
  double timeout_s = 10;                ///< timeout of lock-step [s of wall-clock time]
  bool record = false;                  ///< records the states, see DdsInput
  Recording<UnitreeState> replay = {};  ///< if not empty, repeats these states and does not join DDS
};

/// A Unitree robot, Go2 or B2, on DDS in the place of a QuadrupedWorld: it has the ports that a walking
/// controller needs.
///
///     // The walk has an estimator and no foot sensors.
///     auto& walk = builder.Add<QuadrupedWalk>("walk", params);
///     auto& robot = DriveUnitree(builder, walk, {.initial = params.world.plant.initial});
///
/// It takes the robot's state from "rt/lowstate" and sends the command to "rt/lowcmd", both at `rate`. The
/// built-in mode of the robot must have left before, see docs/robot.md.
///
/// `command` is added to `torque`. The robot does not measure its position and velocity, which are those of
/// `initial` and 0, and its feet measure magnitudes, upwards; `external_torque` and `added_wrench` are zero.
/// `heartbeat` is the time of the last state, 0 before the first, and `checksum` that of the message that is
/// sent. `goal` is kStop while L2 and B of the remote are pressed, as in the maker's controller, else kWalk.
class UnitreeWorld final : public Subdiagram {
 public:
  using Params = UnitreeWorldParams;
  explicit UnitreeWorld(const UnitreeWorldParams& params);

  InputPort<Vec<12>> torque{this, {"torque", "N m"}, Vec<12>(Vec<12>::Zero())};
  InputPort<JointCommand> command{this, {"command"}, JointCommand()};

  DdsInput<UnitreeState>& from_robot;
  DdsPublisher<UnitreeCommand>& to_robot;

  OutputPort<LeggedState> state{this, {"state"}};
  OutputPort<FootForces> ground_forces{this, {"ground_forces"}};
  OutputPort<Vec<12>> external_torque{this, {"external_torque", "N m", kJointElements}};
  OutputPort<WrenchEstimate> added_wrench{this, {"added_wrench"}};
  OutputPort<JointMotion> joints{this, {"joints"}};
  OutputPort<Vec<12>> measured_torque{this, {"measured_torque", "N m", kJointElements}};
  OutputPort<FootForces> foot_forces{this, {"foot_forces"}};
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};
  OutputPort<double> heartbeat{this, {"heartbeat", "s"}};
  OutputPort<DeploymentGoal> goal{this, {"goal"}};
  OutputPort<std::uint32_t> checksum{this, {"checksum"}};
};

/// Puts the robot in the place of walk.world. The walk must have an estimator, whose state is then also the
/// one that is judged, and no foot sensors. Its supervisor, if it has one, reads heartbeat and goal, and its
/// commands go to the drives of the robot. Throws ParameterError.
UnitreeWorld& DriveUnitree(DiagramBuilder& builder, QuadrupedWalk& walk, const UnitreeWorldParams& params);

}  // namespace tenon
