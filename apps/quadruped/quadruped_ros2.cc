#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_messages.h>
#include <tenon/plants/robots/load_robot.h>

namespace tenon::apps {
namespace {

QuadrupedMessages& AddMessages(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
                               const QuadrupedWorld& world, const OutputPort<LeggedState>& state,
                               const std::optional<RobotTimes>& wire) {
  const QuadrupedMessagesParams params = Blame("robot", [&] {
    return QuadrupedMessagesParams{LoadQuadruped(scenario.robot), LoadRobotLinks(scenario.robot),
                                   wire ? wire->epoch : 0};
  });
  auto& messages = builder.Add<QuadrupedMessages>("messages", params);
  builder.Connect(state, messages.state);
  builder.Connect(world.joints, messages.joints);
  builder.Connect(world.measured_torque, messages.torque);
  builder.Connect(world.inertial, messages.inertial);
  outputs.Send("joint_states", messages.joint_states, wire ? wire->rate : world.encoders.params.rate);
  outputs.Send("imu", messages.imu, wire ? wire->rate : world.imu.params.rate);
  outputs.Send("odom", messages.odometry);
  outputs.Send("tf", messages.tf);
  outputs.SendOnce("tf_static", messages.tf_static);
  outputs.SendDescription(params.links.urdf);
  if (!wire) outputs.SendClock();
  return messages;
}

void SendFootForces(DiagramBuilder& builder, Ros2Outputs& outputs, const OutputPort<FootForces>& forces,
                    QuadrupedMessages& messages, Rate rate) {
  builder.Connect(forces, messages.foot_forces);
  for (const auto* foot :
       {&messages.front_left, &messages.front_right, &messages.rear_left, &messages.rear_right})
    outputs.Send("foot_force/" + foot->name(), *foot, rate);
}

void SendCommands(DiagramBuilder& builder, Ros2Outputs& outputs, const OutputPort<Vec<12>>& torque,
                  QuadrupedMessages& messages, Rate rate) {
  builder.Connect(torque, messages.command);
  outputs.Send("joint_commands", messages.joint_commands, rate);
}

}  // namespace

void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedWalk& walk, WalkDrive* drive, const std::optional<RobotTimes>& wire) {
  if (!outputs.any()) return;
  QuadrupedMessages& messages = AddMessages(builder, outputs, scenario, walk.world, walk.state, wire);
  SendFootForces(builder, outputs,
                 walk.foot_forces_of_legs != nullptr   ? walk.foot_forces_of_legs->forces
                 : walk.foot_force_estimate != nullptr ? walk.foot_force_estimate->forces
                                                       : walk.world.foot_forces,
                 messages, wire ? wire->rate : walk.world.foot_sensor.params.rate);
  if (walk.estimator != nullptr && !wire)
    outputs.Send("ground_truth",
                 builder.AddFunction("ground_truth", Uses(builder.time, walk.world.state),
                                     [base = messages.params.links.base](double t, const LeggedState& x) {
                                       auto truth = ros2::MakeOdometry(QuadrupedMessages::kOdom, base);
                                       truth.header.stamp = ros2::StampOf(t);
                                       ros2::SetOdometry(x.p_WB, x.q_WB, x.v_W, x.w_W, &truth);
                                       return truth;
                                     }));
  builder.Connect(walk.observer.wrench, messages.wrench);
  SendCommands(builder, outputs, walk.deployment != nullptr ? walk.drives->torque : walk.locomotion.torque,
               messages, wire ? wire->rate : walk.locomotion.whole_body.params.rate);
  outputs.Send("disturbance", messages.disturbance);
  const LiveScenario& live = scenario.live;
  const auto ends = [&](int i) {
    return Vec<3>(live.forward_m_per_s[i], live.sideways_m_per_s[i], live.yaw_rad_per_s[i]);
  };
  const OutputPort<VelocityCommand>* velocity = outputs.VelocityIn(ends(0), ends(1));
  if (velocity == nullptr) return;
  if (drive == nullptr) {
    const WalkScheduleParams& planned = CurrentAs<LeafSystem<WalkScheduleParams>>(walk.walk).params;
    drive = &builder.Add<WalkDrive>("ros2_drive", {.acceleration = planned.acceleration,
                                                   .yaw_acceleration = planned.yaw_acceleration,
                                                   .rate = planned.rate});
    builder.Insert(walk.walk.command, drive->planned, drive->command);
  }
  builder.Connect(*velocity, drive->request);
}

void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedStand& stand, WalkDrive*) {
  if (!outputs.any()) return;
  QuadrupedMessages& messages = AddMessages(builder, outputs, scenario, stand.world, stand.world.state, {});
  SendFootForces(builder, outputs, stand.world.foot_forces, messages, stand.world.foot_sensor.params.rate);
  SendCommands(builder, outputs, stand.pd.torque, messages, stand.pd.params.rate);
}

}  // namespace tenon::apps
