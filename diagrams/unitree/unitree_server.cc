#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/plants/legged/joint_drives.h>
#include <tenon/systems/primitives/unit_delay.h>

namespace tenon {

UnitreeCommand HoldStance(const JointPdParams& pd) {
  UnitreeCommand command;
  command.q = pd.robot.stance;
  if (pd.gravity_compensation) command.torque = StandingTorque(pd.robot, pd.gravity);
  command.kp.setConstant(pd.stiffness);
  command.kd.setConstant(pd.damping);
  return command;
}

UnitreeCommand DampedJoints(const QuadrupedDescription& robot) {
  return {Deployment({.robot = robot}).Damped()};
}

UnitreeServer::UnitreeServer(const UnitreeServerParams& params)
    : command(Add<DdsInput<UnitreeCommand>>(
          "command", {.topic = "rt/lowcmd",
                      .link = params.link,
                      .initial = params.initial,
                      .rate = params.lock_step ? params.state_rate : params.command_rate,
                      .lock_step = params.lock_step,
                      .timeout_s = params.timeout_s,
                      .valid_s = params.valid_s,
                      .expired = params.expired,
                      .record = params.record,
                      .replay = params.replay})),
      to_client(Add<DdsPublisher<UnitreeState>>("to_client", {.topic = "rt/lowstate",
                                                              .link = params.link,
                                                              .rate = params.state_rate,
                                                              .lock_step = params.lock_step,
                                                              .silent = !params.replay.empty()})),
      switcher(Add<MotionSwitcher>("switcher", {.link = params.link, .silent = !params.replay.empty()})) {
  auto& drives = Add<JointDrives>("drives", {.rate = params.command_rate});
  Connect(AddFunction({"joint_command"}, Uses(command.y),
                      [](const UnitreeCommand& c) -> JointCommand { return c; }),
          drives.command);
  Connect(joints, drives.joints);
  Connect(drives.torque, torque);
  // Torque and acceleration depend on the command of the tick, which in lock-step is the answer to the state.
  const auto delayed = [&]<class T>(const char* name, const InputPort<T>& from, const T& initial) -> auto& {
    auto& delay = Add<UnitDelay<T>>(name, {.initial = initial, .rate = params.command_rate});
    Connect(from, delay.u);
    return delay.y;
  };
  const auto& torque_before = delayed("torque_before", measured_torque, Vec<12>(Vec<12>::Zero()));
  const ImuMeasurement at_rest{Vec<3>::Zero(), Vec<3>(0, 0, kGravity)};
  const auto& inertial_before = delayed("inertial_before", inertial, at_rest);
  const auto& sensors =
      AddFunction({"sensors"}, Uses(time, joints, torque_before, inertial_before, foot_forces, state),
                  [](double time, const JointMotion& joints, const Vec<12>& torque,
                     const ImuMeasurement& inertial, const FootForces& forces, const LeggedState& x) {
                    UnitreeState state{time, joints, torque, inertial, x.q_WB};
                    for (int leg = 0; leg < kNumLegs; ++leg) state.foot_force[leg] = forces[leg].norm();
                    return state;
                  });
  Connect(sensors, to_client.u);
  Connect(AddFunction({"checksum_of_sensors"}, Uses(sensors),
                      [](const UnitreeState& s) { return ChecksumOf(s); }),
          checksum);
}

void UnitreeServer::ConnectSensors(DiagramBuilder& builder, const QuadrupedWorld& world) {
  builder.Connect(world.measured_torque, measured_torque);
  builder.Connect(world.inertial, inertial);
  builder.Connect(world.foot_forces, foot_forces);
  builder.Connect(world.state, state);
}

}  // namespace tenon
