#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/multibody/robot_multibody.h>

namespace tenon {

/// A quadruped in Simbody, to which QuadrupedPlantParams::extend adds. robot_multibody.h is the guide: what
/// is possible and what is not, names and coordinates of added joints, threads. See QuadrupedPlant for what
/// follows from an addition.
///
///     params.extend = [](QuadrupedMultibody& robot) {
///       SimTK::Body::Rigid load(SimTK::MassProperties(2, SimTK::Vec3(0), SimTK::UnitInertia::sphere(0.05)));
///       SimTK::MobilizedBody::Universal swing(robot.trunk(), SimTK::Vec3(0, 0, -0.1),
///                                             load, SimTK::Vec3(0, 0, 0.2));
///       robot.Name(swing, "swing");
///       robot.Draw(swing, Shape::Sphere(ShapeRole::kLoad, "load", 0.05));
///     };
///
/// **Bodies and frames.** Ground is W. The trunk's body frame is B of the QuadrupedDescription, at the origin
/// of the URDF's root link. The body that a joint moves, link("front_left_knee") for example, has the frame J
/// of this joint, whose axes are parallel to B if all joint angles are 0. The plant's own forces are the
/// drives, the feet on the terrain, and external forces.
///
/// **Cost.** An evaluation of the derivatives takes about seven times as long as without additions: 60
/// instead of 8.5 microseconds for DogBot. In processor time of one core (AMD EPYC), A1 by Aliengo with its
/// controller runs at 31 times real time, and A1-arm, with three added joints, at 5.3.
class QuadrupedMultibody final : public RobotMultibody {
 public:
  /// The robot under gravity [m/s^2].
  QuadrupedMultibody(const QuadrupedDescription& robot, double gravity);

  SimTK::MobilizedBody& trunk() { return base(); }
  /// The body that a joint moves, by the joint's name in the URDF. Throws ParameterError if there is none.
  SimTK::MobilizedBody& link(const std::string& joint);

 private:
  std::array<std::string, kNumJoints> joints_;
};

}  // namespace tenon
