#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/diagrams/unitree/unitree_world.h>

namespace tenon {
namespace {

constexpr int kStopButtons = 1 << UnitreeState::kL2 | 1 << UnitreeState::kB;

UnitreeState AtRest(const LeggedState& x) {
  UnitreeState state;
  state.joints = {x.q, x.qd};
  state.q_WB = x.q_WB;
  state.inertial.specific_force_B = x.R_WB().transpose() * Vec<3>(0, 0, kGravity);
  return state;
}

}  // namespace

UnitreeWorld::UnitreeWorld(const UnitreeWorldParams& params)
    : from_robot(Add<DdsInput<UnitreeState>>("from_robot", {.topic = "rt/lowstate",
                                                            .link = params.link,
                                                            .initial = AtRest(params.initial),
                                                            .rate = params.rate,
                                                            .lock_step = params.lock_step,
                                                            .timeout_s = params.timeout_s,
                                                            .record = params.record,
                                                            .replay = params.replay})),
      to_robot(Add<DdsPublisher<UnitreeCommand>>("to_robot", {.topic = "rt/lowcmd",
                                                              .link = params.link,
                                                              .rate = params.rate,
                                                              .lock_step = params.lock_step,
                                                              .silent = !params.replay.empty()})) {
  const auto& sent =
      AddFunction({"sent"}, Uses(torque, command), [](const Vec<12>& torque, const JointCommand& command) {
        UnitreeCommand sent{command};
        sent.torque += torque;
        return sent;
      });
  Connect(sent, to_robot.u);
  Connect(
      AddFunction({"checksum_of_sent"}, Uses(sent), [](const UnitreeCommand& c) { return ChecksumOf(c); }),
      checksum);
  const auto out = [&](auto& port, auto function) {
    Connect(AddFunction({port.name() + "_of_robot", port.spec().units, port.spec().elements},
                        Uses(from_robot.y), function),
            port);
  };
  out(state, [initial = params.initial](const UnitreeState& now) {
    LeggedState x = initial;
    x.q_WB = now.q_WB.normalized();
    x.q = now.joints.q;
    x.qd = now.joints.qd;
    x.v_W.setZero();
    x.w_W = x.R_WB() * now.inertial.angular_velocity_B;
    return x;
  });
  const auto forces = [](const UnitreeState& now) {
    FootForces forces;
    for (int leg = 0; leg < kNumLegs; ++leg) forces[leg][2] = now.foot_force[leg];
    return forces;
  };
  out(ground_forces, forces);
  out(foot_forces, forces);
  out(external_torque, [](const UnitreeState&) -> Vec<12> { return Vec<12>::Zero(); });
  out(added_wrench, [](const UnitreeState&) { return WrenchEstimate(); });
  out(joints, [](const UnitreeState& now) { return now.joints; });
  out(measured_torque, [](const UnitreeState& now) { return now.torque; });
  out(inertial, [](const UnitreeState& now) { return now.inertial; });
  out(heartbeat, [](const UnitreeState& now) { return now.time; });
  out(goal, [](const UnitreeState& now) {
    return (now.buttons & kStopButtons) == kStopButtons ? DeploymentGoal::kStop : DeploymentGoal::kWalk;
  });
}

UnitreeWorld& DriveUnitree(DiagramBuilder& builder, QuadrupedWalk& walk, const UnitreeWorldParams& params) {
  Demand(walk.estimator != nullptr, "a robot does not measure its position: give the walk an estimator");
  Demand(walk.foot_forces_of_legs != nullptr,
         "a robot measures magnitudes of its foot forces only: set the foot sensors to FootSensing::kNone");
  auto& robot = builder.Replace<UnitreeWorld>(walk.world, params);
  for (InputPort<LeggedState>* judged : {&walk.errors.state, &walk.view.state}) {
    builder.Disconnect(*judged);
    builder.Connect(walk.estimator->state, *judged);
  }
  if (walk.deployment == nullptr) return robot;
  builder.Disconnect(robot.torque);
  builder.Connect(walk.deployment->command, robot.command);
  builder.Disconnect(walk.deployment->heartbeat);
  builder.Connect(robot.heartbeat, walk.deployment->heartbeat);
  builder.Connect(robot.goal, walk.deployment->goal);
  return robot;
}

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
