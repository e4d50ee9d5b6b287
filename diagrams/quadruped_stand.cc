#include "tenon/diagrams/quadruped_stand.h"

namespace tenon {

QuadrupedStand::QuadrupedStand(const QuadrupedStandParams& params)
    : pd(Add<JointPd>("pd", params.pd)),
      plant(Add<QuadrupedPlant>("plant", params.plant)),
      encoders(Add<JointEncoders>("encoders", params.encoders)) {
  auto& monitor = Add<FallMonitor>(
      "monitor", FallMonitorParams{params.plant.terrain, params.min_height, params.max_tilt, params.pd.rate});

  Connect(plant.state, encoders.state);
  Connect(encoders.joints, pd.joints);
  Connect(pd.torque, plant.torque);
  Connect(plant.state, monitor.state);
  Connect(plant.state, state);
}

}  // namespace tenon
