#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/simbody.h>
#include <tenon/systems/geometry.h>

#include <array>
#include <map>
#include <string>
#include <vector>

namespace tenon {

/// A quadruped in Simbody, to which QuadrupedPlantParams::extend adds bodies, joints, forces, constraints and
/// contacts with everything that Simbody offers. See QuadrupedPlant for what follows from an addition.
///
/// Include this header only where you write the function: it includes Simbody, which takes some seconds to
/// compile. Link `tenon::multibody`, which brings Simbody's directories, libraries and options.
///
///     params.extend = [](QuadrupedMultibody& robot) {
///       SimTK::Body::Rigid load(SimTK::MassProperties(2, SimTK::Vec3(0), SimTK::UnitInertia::sphere(0.05)));
///       SimTK::MobilizedBody::Universal swing(robot.trunk(), SimTK::Vec3(0, 0, -0.1),
///                                             load, SimTK::Vec3(0, 0, 0.2));
///       robot.Name(swing, "swing");
///       robot.Draw(swing, Shape::Sphere(ShapeRole::kLoad, "load", 0.05));
///     };
///
/// **Frames.** Ground is W. The trunk's body frame is B of the QuadrupedDescription, at the origin of the
/// URDF's root link. The body that a joint moves has the frame J of this joint, whose axes are parallel to B
/// if all joint angles are 0. Lengths are in metres, masses in kilograms.
///
/// **Possible** are all joints, bodies, force elements, constraints and contacts of Simbody, on the robot's
/// bodies, on added bodies and on Ground, also those that depend on time. `forces` already contains gravity
/// and the plant's forces: drives, feet on the terrain, external forces. Contacts of Simbody know only the
/// surfaces that are added with them, not the plant's terrain.
///
/// **Coordinates** begin at the default values of their joints (setDefaultAngle and the like), speeds at 0;
/// set others by `context.Set(plant.added_u, ...)`. A coordinate has the name of its joint, or that name with
/// _0, _1, … if the joint has several. The first four of a ball or free joint are a quaternion (w, x, y, z)
/// of any length, which returns to 1 like that of the trunk. Constraints are met at the start by moving the
/// added coordinates and speeds; the robot stays where QuadrupedPlantParams::initial puts it.
///
/// **Impossible:** prescribed motions and locked joints are refused. Event handlers and reporters of Simbody
/// never run, and discrete variables of force elements keep their defaults. External forces, faults and
/// controllers of Tenon know the robot's bodies alone. Jumps in the added forces are not declared to the
/// integrator, whose error control finds them.
///
/// **Calls.** Each context has a System of its own, so that contexts can run in threads: the function is
/// called when the plant is made, and again for each context and each clone of one, in one thread at a time.
/// It must add the same each time.
///
/// **Cost.** An evaluation of the derivatives takes about seven times as long as without additions: 60
/// instead of 8.5 microseconds for DogBot where its trot under joint PD ran at 2.6 instead of 18 times real
/// time.
class QuadrupedMultibody {
 public:
  /// The robot under gravity [m/s^2].
  QuadrupedMultibody(const QuadrupedDescription& robot, double gravity);
  QuadrupedMultibody(const QuadrupedMultibody&) = delete;
  QuadrupedMultibody& operator=(const QuadrupedMultibody&) = delete;

  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};

  SimTK::MobilizedBody& trunk() { return bodies_[0]; }
  /// The body that a joint moves, by the joint's name in the URDF. Throws ParameterError if there is none.
  SimTK::MobilizedBody& link(const std::string& joint);
  /// Body 0 is the trunk, 1 + j the body that joint j moves, as in ExternalForce.
  const SimTK::MobilizedBody& body(std::size_t index) const { return bodies_.at(index); }

  /// Takes `part`, given in B, from the trunk, because added bodies take its place: an arm that moves. The
  /// plant's `robot` still has this part, so that controllers, `external_wrench` and `added_wrench` take it
  /// for fixed to the trunk. Throws ParameterError unless a possible trunk remains.
  void Replace(const RigidInertia& part);
  /// Names the joint of an added body, for the elements of the plant's ports. A joint without a name is
  /// `added_0`, `added_1`, …. Throws ParameterError for an empty name, a name with a comma, and a name in
  /// use.
  void Name(const SimTK::MobilizedBody& added, const std::string& name);
  /// Draws a shape on a body. The pose of the shape, and the vector of a segment, are given in the body's
  /// frame.
  void Draw(const SimTK::MobilizedBody& body, const Shape& shape);

  struct Drawn {
    SimTK::MobilizedBodyIndex body;
    Shape shape_B;
  };
  const std::vector<Drawn>& drawn() const { return drawn_; }
  const std::map<int, std::string>& names() const { return names_; }  ///< by index of the body
  const RigidInertia& replaced() const { return replaced_; }

 private:
  RigidInertia trunk_, replaced_;
  std::array<std::string, kNumJoints> joints_;
  std::array<SimTK::MobilizedBody, 1 + kNumJoints> bodies_;
  std::map<int, std::string> names_;
  std::vector<Drawn> drawn_;
};

}  // namespace tenon
