#pragma once

#include <tenon/controllers/legged/deployment/deployment.h>
#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/diagrams/unitree/motion_switcher.h>
#include <tenon/diagrams/unitree/unitree_messages.h>

namespace tenon {

struct UnitreeServerParams {
  DdsLink link = {.domain = 1, .interface = "lo"};
  UnitreeCommand initial = {};   ///< applied until a client commands; zero torques, or see HoldStance
  double valid_s = 0.02;         ///< time without a command after which `expired` is applied
  UnitreeCommand expired = {};   ///< zero torques, or see DampedJoints
  Rate command_rate = Hz(1000);  ///< rate of commands and torques
  Rate state_rate = Hz(500);
  bool lock_step =
      false;  ///< each state waits for the command with its time, so that the run repeats bit for bit
  double timeout_s = 10;                  ///< timeout of lock-step [s of wall-clock time]
  bool record = false;                    ///< records the commands, see DdsInput
  Recording<UnitreeCommand> replay = {};  ///< if not empty, repeats these commands and does not join DDS
};

/// The command that holds the nominal stance as JointPd does.
UnitreeCommand HoldStance(const JointPdParams& pd);
/// The command that damps the joints as Deployment does.
UnitreeCommand DampedJoints(const QuadrupedDescription& robot);

/// The interface of a Unitree robot, Go2 or B2, to a client on DDS. Together with a QuadrupedWorld it takes
/// the robot's place: clients of the maker's SDK and of others control it without a change.
///
///     auto& world = builder.Add<QuadrupedWorld>("world", MakeQuadrupedWorld(robot));
///     auto& server = builder.Add<UnitreeServer>("server", {.initial = HoldStance(MakeJointPd(robot))});
///     builder.Connect(server.torque, world.torque);
///     builder.Connect(world.joints, server.joints);
///     server.ConnectSensors(builder, world);
///
/// It takes commands from "rt/lowcmd" and computes joint PD and feedforward torques at `command_rate`; the
/// plant limits them. It sends "rt/lowstate" at `state_rate` with the encoders, torques, inertial unit and
/// foot forces of the world's sensors; torques and inertial unit are those one period of `command_rate`
/// before. A client that asks for the built-in mode, or to release it, gets an answer. The attitude, which
/// the robots estimate, is the true one. Battery, temperatures, the remote and the 8 motors that the robots
/// do not have are zero. `checksum` is that of the state's message.
class UnitreeServer final : public Subdiagram {
 public:
  using Params = UnitreeServerParams;
  explicit UnitreeServer(const UnitreeServerParams& params);

  InputPort<JointMotion> joints{this, {"joints"}};
  InputPort<Vec<12>> measured_torque{this, {"measured_torque", "N m"}};
  InputPort<ImuMeasurement> inertial{this, {"inertial"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<LeggedState> state{this, {"state"}};

  DdsInput<UnitreeCommand>& command;
  DdsPublisher<UnitreeState>& to_client;
  MotionSwitcher& switcher;

  OutputPort<Vec<12>> torque{this, {"torque", "N m", kJointElements}};
  OutputPort<std::uint32_t> checksum{this, {"checksum"}};

  /// Connects all inputs but `joints`.
  void ConnectSensors(DiagramBuilder& builder, const QuadrupedWorld& world);
};

}  // namespace tenon
