#include <tenon/diagrams/legged/quadruped_world.h>

#include <string>

namespace tenon {
namespace {

ImuParams OnRobot(ImuParams imu, const QuadrupedDescription& robot) {
  imu.p_B = robot.imu_B;
  return imu;
}

}  // namespace

QuadrupedWorld::QuadrupedWorld(const QuadrupedWorldParams& params)
    : plant(Add<QuadrupedPlant>("plant", params.plant)),
      encoders(Add<JointEncoders>("encoders", params.encoders)),
      torque_sensor(Add<JointTorqueSensor>("torque_sensor", params.torque_sensor)),
      foot_sensor(Add<FootForceSensor>("foot_sensor", params.foot_sensor)),
      imu(Add<TrunkImu>("imu", OnRobot(params.imu, params.plant.robot))),
      disturbances(Add<ForceBundle>(
          "disturbances",
          ForceBundleParams{1 + params.pulses.size() + params.sines.size() + params.random.size()})) {
  auto& monitor =
      Add<FallMonitor>("monitor", FallMonitorParams{params.plant.terrain, params.min_height, params.max_tilt,
                                                    params.max_height, Hz(1000)});

  std::size_t next = 0;
  Connect(pull, disturbances.force[next++]);
  const auto disturb = [&]<class Block>(const std::string& name, const auto& each) {
    for (std::size_t i = 0; i < each.size(); ++i)
      Connect(Add<Block>(name + "_" + std::to_string(i), each[i]).force, disturbances.force[next++]);
  };
  disturb.template operator()<PulseForce>("pulse", params.pulses);
  disturb.template operator()<SineForce>("sine", params.sines);
  disturb.template operator()<RandomForce>("random", params.random);

  Connect(torque, plant.torque);
  Connect(disturbances.forces, plant.external);
  Connect(plant.state, encoders.state);
  Connect(plant.joint_torque, torque_sensor.torque);
  Connect(plant.foot_forces, foot_sensor.forces);
  Connect(plant.state, imu.body);
  Connect(plant.acceleration, imu.acceleration);
  Connect(plant.state, monitor.state);

  Connect(plant.state, state);
  Connect(plant.foot_forces, ground_forces);
  Connect(plant.external_torque, external_torque);
  Connect(encoders.joints, joints);
  Connect(torque_sensor.measured, measured_torque);
  Connect(foot_sensor.measured, foot_forces);
  Connect(imu.measurement, inertial);
}

}  // namespace tenon
