#include <tenon/plants/model/model_error.h>
#include <tenon/systems/framework/types/errors.h>

namespace tenon {
namespace {

double TrunkLength(const QuadrupedDescription& robot) {
  const auto hip = [&](Leg leg) -> const Eigen::Vector3d& { return robot.legs[leg].joints[0].p_PJ; };
  return (hip(kFrontLeft) + hip(kFrontRight) - hip(kRearLeft) - hip(kRearRight)).norm() / 2;
}

}  // namespace

QuadrupedDescription WithModelError(QuadrupedDescription robot, const ModelErrorParams& error,
                                    RandomStream& random) {
  CheckRanges(error);
  const auto off = [&](double bound) { return random.Uniform(-bound, bound); };
  const auto disturb = [&](RigidInertia& body, double length) {
    const double mass_factor = 1 + off(error.mass_ratio);
    body.mass *= mass_factor;
    body.inertia *= mass_factor * (1 + off(error.inertia_ratio));
    for (int axis = 0; axis < 3; ++axis) body.com[axis] += length * off(error.com_ratio);
  };
  disturb(robot.trunk, TrunkLength(robot));
  for (LegDescription& leg : robot.legs) {
    for (std::size_t i = 0; i < leg.bodies.size(); ++i) {
      Eigen::Vector3d& end = i + 1 < leg.joints.size() ? leg.joints[i + 1].p_PJ : leg.foot_J;
      disturb(leg.bodies[i], end.norm());
      end *= 1 + off(error.length_ratio);
    }
  }
  return robot;
}

}  // namespace tenon
