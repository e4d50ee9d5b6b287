#pragma once

#include "tenon/plants/cdpr_plant.h"
#include "tenon/systems/random_stream.h"

namespace tenon::test {

/// A platform of 15 kg under four cables from the corners of a ceiling of 7 m by 9 m; attachments 93 mm above
/// the CoM, each on its anchor's side.
inline CdprDescription FourCables() {
  CdprDescription robot;
  robot.name = "four";
  robot.mass = 15;
  robot.inertia_B = Eigen::Vector3d(0.213, 0.133, 0.215).asDiagonal();
  for (const double x : {1, -1})
    for (const double y : {1, -1})
      robot.cables.push_back({{3.5 * x, 4.5 * y, 4}, {0.075 * x, 0.075 * y, 0.093}});
  robot.cable = {.axial_stiffness = 27e3, .axial_damping = 135, .tension_min = 0, .tension_max = 800};
  robot.winch = {.mode = WinchMode::kTension, .time_constant = 0.02, .reel_damping = 90, .effective_mass = 8};
  return robot;
}

/// At rest 1.5 m above the floor in the middle, where by symmetry all cables carry
/// m g / (4 s) with s the sine of their angle above the horizontal.
inline CdprPlantParams Hanging(CdprDescription robot = FourCables()) {
  CdprPlantParams params;
  params.robot = robot;
  params.p_WB = {0, 0, 1.5};
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
