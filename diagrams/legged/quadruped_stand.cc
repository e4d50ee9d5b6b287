#include <tenon/diagrams/legged/quadruped_stand.h>

namespace tenon {

QuadrupedStandParams MakeQuadrupedStand(const QuadrupedDescription& robot) {
  return {.world = MakeQuadrupedWorld(robot), .pd = MakeJointPd(robot)};
}

QuadrupedStand::QuadrupedStand(const QuadrupedStandParams& params)
    : pd(Add<JointPd>("pd", params.pd)), world(Add<QuadrupedWorld>("world", params.world)) {
  Connect(pd.torque, world.torque);
  Connect(world.joints, pd.joints);
}

}  // namespace tenon
