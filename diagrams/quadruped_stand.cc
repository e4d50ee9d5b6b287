#include "tenon/diagrams/quadruped_stand.h"

#include <string>

namespace tenon {

QuadrupedStand::QuadrupedStand(const QuadrupedStandParams& params)
    : pd(Add<JointPd>("pd", params.pd)),
      plant(Add<QuadrupedPlant>("plant", params.plant)),
      encoders(Add<JointEncoders>("encoders", params.encoders)),
      torque_sensor(Add<JointTorqueSensor>("torque_sensor", params.torque_sensor)),
      foot_sensor(Add<FootForceSensor>("foot_sensor", params.foot_sensor)),
      imu(Add<TrunkImu>("imu", params.imu)),
      disturbances(Add<ForceBundle>(
          "disturbances",
          ForceBundleParams{params.pulses.size() + params.sines.size() + params.random.size()})) {
  auto& monitor = Add<FallMonitor>(
      "monitor", FallMonitorParams{params.plant.terrain, params.min_height, params.max_tilt, params.pd.rate});

  std::size_t next = 0;
  const auto disturb = [&]<class Block>(const std::string& name, const auto& each) {
    for (std::size_t i = 0; i < each.size(); ++i)
      Connect(Add<Block>(name + "_" + std::to_string(i), each[i]).force, disturbances.force[next++]);
  };
  disturb.template operator()<PulseForce>("pulse", params.pulses);
  disturb.template operator()<SineForce>("sine", params.sines);
  disturb.template operator()<RandomForce>("random", params.random);

  Connect(disturbances.forces, plant.external);
  Connect(pd.torque, plant.torque);
  Connect(plant.state, encoders.state);
  Connect(encoders.joints, pd.joints);
  Connect(plant.joint_torque, torque_sensor.torque);
  Connect(plant.foot_forces, foot_sensor.forces);
  Connect(plant.state, imu.body);
  Connect(plant.acceleration, imu.acceleration);
  Connect(plant.state, monitor.state);
  Connect(plant.state, state);
}

}  // namespace tenon
