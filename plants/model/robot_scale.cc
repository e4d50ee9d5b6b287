#include <tenon/plants/model/robot_scale.h>

namespace tenon {

RobotScale ScaleOf(const QuadrupedDescription& robot, double gravity) {
  double length = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) length += robot.LegLength(leg) / kNumLegs;
  return {robot.mass(), length, gravity};
}

}  // namespace tenon
