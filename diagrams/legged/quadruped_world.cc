#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/sensors/shank_forces.h>
#include <tenon/systems/primitives/late.h>

namespace tenon {

namespace {

ImuParams OnRobot(ImuParams imu, const QuadrupedDescription& robot) {
  imu.p_B = robot.imu_B;
  return imu;
}

}  // namespace

QuadrupedWorldParams MakeQuadrupedWorld(const QuadrupedDescription& robot, const TerrainParams& terrain) {
  const Terrain::Surface ground = Terrain(terrain).At(0, 0);
  const Vec<2> slope = -ground.normal_W.head<2>() / ground.normal_W[2];
  QuadrupedWorldParams params;
  params.plant.robot = robot;
  params.plant.terrain = terrain;
  params.plant.initial = StandingOn(robot, {.p_W = {0, 0, ground.height}, .slope = slope});
  params.min_height = kFallHeightRatio * robot.StanceHeight();
  return params;
}

QuadrupedWorld::QuadrupedWorld(const QuadrupedWorldParams& params)
    : plant(Add<QuadrupedPlant>("plant", params.plant)),
      encoders(Add<JointEncoders>("encoders", params.encoders)),
      torque_sensor(Add<JointTorqueSensor>("torque_sensor", params.torque_sensor)),
      foot_sensor(Add<FootForceSensor>("foot_sensor", params.foot_sensor)),
      imu(Add<TrunkImu>("imu", OnRobot(params.imu, params.plant.robot))),
      disturbances(Add<ForceBundle>(
          "disturbances", ForceBundleParams{1 + (params.sliding_load ? 1 : 0) + params.pulses.size() +
                                            params.sines.size() + params.random.size()})),
      monitor(Add<FallMonitor>("monitor", FallMonitorParams{params.plant.terrain, params.min_height,
                                                            params.max_tilt, params.max_height, Hz(1000)})) {
  std::size_t next = 0;
  Connect(pull, disturbances.force[next++]);
  if (params.sliding_load) {
    SlidingLoadParams on_trunk = *params.sliding_load;
    on_trunk.robot = params.plant.initial;
    on_trunk.gravity = params.plant.gravity;
    sliding_load = &Add<SlidingLoad>("sliding_load", on_trunk);
    Connect(plant.state, sliding_load->robot);
    Connect(sliding_load->force, disturbances.force[next++]);
  }
  const auto disturb = [&]<class Block>(const std::string& name, const auto& each) {
    for (std::size_t i = 0; i < each.size(); ++i)
      Connect(Add<Block>(name + "_" + std::to_string(i), each[i]).force, disturbances.force[next++]);
  };
  disturb.template operator()<PulseForce>("pulse", params.pulses);
  disturb.template operator()<SineForce>("sine", params.sines);
  disturb.template operator()<RandomForce>("random", params.random);

  ConnectDrives(params.hardware);
  Connect(disturbances.forces, plant.external);
  Connect(plant.state, encoders.state);
  Connect(plant.joint_torque, torque_sensor.torque);
  if (params.foot_sensor.mounted == FootSensing::kShank) {
    auto& shanks = Add<ShankForces>("shank_forces", ShankForcesParams{params.plant.robot});
    Connect(plant.state, shanks.state);
    Connect(plant.foot_forces, shanks.forces);
    Connect(shanks.shank, foot_sensor.forces);
  } else {
    Connect(plant.foot_forces, foot_sensor.forces);
  }
  Connect(plant.state, imu.body);
  Connect(plant.acceleration, imu.acceleration);
  Connect(plant.state, monitor.state);

  Connect(plant.state, state);
  Connect(plant.foot_forces, ground_forces);
  Connect(plant.external_torque, external_torque);
  Connect(plant.added_wrench, added_wrench);
  const OutputPort<ImuMeasurement>* unit = &imu.measurement;
  if (ImuErrorsParams of_unit = params.imu.unit; of_unit.any()) {
    of_unit.rate = params.imu.rate;
    auto& errors = Add<ImuErrors>("imu_errors", of_unit);
    Connect(*unit, errors.measurement);
    unit = &errors.measured;
  }
  // Outputs before the first delayed sample arrives: the measurements of a robot at rest.
  const LeggedState& initial = params.plant.initial;
  const ImuMeasurement at_rest{Vec<3>::Zero(),
                               initial.R_WB().transpose() * Vec<3>(0, 0, params.plant.gravity)};
  Connect(Late<JointMotion>(*this, "joints", encoders.joints, {initial.q, initial.qd}, params.encoders.rate,
                            params.encoders.latency),
          joints);
  Connect(Late<Vec<12>>(*this, "measured_torque", torque_sensor.measured, Vec<12>::Zero(),
                        params.torque_sensor.rate, params.torque_sensor.latency),
          measured_torque);
  Connect(Late<FootForces>(*this, "foot_forces", foot_sensor.measured, {}, params.foot_sensor.rate,
                           params.foot_sensor.latency),
          foot_forces);
  Connect(Late(*this, "inertial", *unit, at_rest, params.imu.rate, params.imu.latency), inertial);
}

void QuadrupedWorld::ConnectDrives(const QuadrupedHardwareParams& hardware) {
  InputPort<Vec<12>>* in = &plant.torque;  // input to which the next block is connected, against the flow
  if (hardware.drive_lag) {
    auto& lag = Add<HeldLag<Vec<12>>>("drive_lag", *hardware.drive_lag);
    Connect(lag.y, *in);
    in = &lag.u;
  }
  if (hardware.drive_errors) {
    auto& errors = Add<DriveErrors>("drive_errors", *hardware.drive_errors);
    Connect(errors.torque, *in);
    in = &errors.command;
  }
  if (hardware.command_delay) {
    auto& delay = Add<JitteredDelay<Vec<12>>>("command_delay", *hardware.command_delay);
    Connect(delay.y, *in);
    in = &delay.u;
  }
  Connect(torque, *in);
}

QuadrupedStandParams MakeQuadrupedStand(const QuadrupedDescription& robot) {
  return {.world = MakeQuadrupedWorld(robot), .pd = MakeJointPd(robot)};
}

QuadrupedStand::QuadrupedStand(const QuadrupedStandParams& params)
    : pd(Add<JointPd>("pd", params.pd)), world(Add<QuadrupedWorld>("world", params.world)) {
  Connect(pd.torque, world.torque);
  Connect(world.joints, pd.joints);
}

}  // namespace tenon
