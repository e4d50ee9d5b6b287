#pragma once

#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>

namespace tenon::test {

/// At rest 1.5 m above the floor in the middle, where by symmetry all cables carry
/// m g / (4 s) with s the sine of their angle above the horizontal.
inline CdprPlantParams Hanging(CdprDescription robot = FourCableRobot()) {
  CdprPlantParams params{.robot = robot, .p_WB = {0, 0, 1.5}};
  const Vec<3> span = robot.cables[0].anchor_W - params.p_WB - robot.cables[0].attachment_B;
  const double tension = robot.mass * params.gravity / (4 * span.normalized()[2]);
  params.initial_tension = CableVector::Constant(robot.num_cables(), tension);
  return params;
}

inline Vec<3> RandomVector(RandomStream& random, double size) {
  return {random.Uniform(-size, size), random.Uniform(-size, size), random.Uniform(-size, size)};
}

inline PlatformState RandomPlatform(RandomStream& random) {
  return {Vec<3>(0, 0, 1.5) + RandomVector(random, 1), QuaternionFromRotationVector(RandomVector(random, 2)),
          RandomVector(random, 2), RandomVector(random, 5)};
}

}  // namespace tenon::test
