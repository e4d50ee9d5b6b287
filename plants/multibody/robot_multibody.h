#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/simbody.h>
#include <tenon/systems/geometry.h>

#include <deque>

namespace tenon {

/// A robot in Simbody, to which the parameter `extend` of its plant adds bodies, joints, forces, constraints
/// and contacts with everything that Simbody offers. The robots are QuadrupedMultibody and CdprMultibody,
/// whose headers name their bodies and frames; this header is the guide to what both have in common.
///
/// Include these headers only where you write the function: they include Simbody, which takes some seconds to
/// compile. Link `tenon::multibody`, which brings Simbody's directories, libraries and options.
///
/// **Possible** are all joints, bodies, force elements, constraints and contacts of Simbody, on the robot's
/// bodies, on added bodies and on Ground, which is W; also those that depend on time. `forces` already
/// contains gravity and the plant's own forces. Contacts of Simbody know only the surfaces that are added
/// with them, not the plant's terrain. Lengths are in metres, masses in kilograms.
///
/// **Coordinates** begin at the default values of their joints (setDefaultAngle and the like), speeds at 0;
/// set others by `context.Set(plant.added_u, ...)`. A coordinate has the name of its joint, or that name with
/// _0, _1, … if the joint has several. The first four of a ball or free joint are a quaternion (w, x, y, z)
/// of any length, which returns to 1 like that of the robot. Constraints are met at the start by moving the
/// added coordinates and speeds; the robot stays at its initial state.
///
/// **Impossible:** prescribed motions and locked joints are refused. Event handlers and reporters of Simbody
/// never run, and discrete variables of force elements keep their defaults. External forces, faults and
/// controllers of Tenon know the robot's bodies alone. Jumps in the added forces are not declared to the
/// integrator, whose error control finds them.
///
/// **Calls.** Each context has a System of its own, so that contexts can run in threads: the function is
/// called when the plant is made, and again for each context and each clone of one, in one thread at a time.
/// It must add the same each time.
class RobotMultibody {
 public:
  RobotMultibody(const RobotMultibody&) = delete;
  RobotMultibody& operator=(const RobotMultibody&) = delete;
  virtual ~RobotMultibody() = default;

  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};

  /// The trunk of a quadruped, or the platform of a cable robot.
  SimTK::MobilizedBody& base() { return bodies_[0]; }
  /// Body 0 is the base, 1 + j the body that joint j moves.
  const SimTK::MobilizedBody& body(std::size_t index) const { return bodies_.at(index); }
  std::size_t num_bodies() const { return bodies_.size(); }  ///< of the robot without additions

  /// Takes `part`, given in B, from the base, because added bodies take its place: an arm that moves. The
  /// plant's `robot` still has this part, so that controllers, `external_wrench` and `added_wrench` take it
  /// for fixed to the base. Throws ParameterError unless a possible base remains.
  void Replace(const RigidInertia& part);
  /// Names the joint of an added body, for the elements of the plant's ports. A joint without a name is
  /// `added_0`, `added_1`, …. Throws ParameterError for an empty name, a name with a comma, and a name in
  /// use.
  void Name(const SimTK::MobilizedBody& added, const std::string& name);
  /// Draws a shape on a body. The pose of the shape, and the vector of a segment, are given in the body's
  /// frame.
  void Draw(const SimTK::MobilizedBody& body, const Shape& shape) {
    drawn_.push_back({body.getMobilizedBodyIndex(), shape});
  }

  /// Present reference of the drive of an added joint, from the plant's inputs.
  struct Reference {
    SimTK::MobilizedBodyIndex joint;
    double position = std::numeric_limits<double>::quiet_NaN();  ///< [rad, m]; NaN: not connected
    double speed = 0;                                            ///< [rad/s, m/s]
  };
  /// Adds an element to the plant's inputs `added_position_references` and `added_speed_references`, for a
  /// joint with one coordinate. A force element of yours reads the result, which lives as long as the robot.
  const Reference& AddReference(const SimTK::MobilizedBody& added) {
    return references_.emplace_back(Reference{added.getMobilizedBodyIndex()});
  }

  struct Drawn {
    SimTK::MobilizedBodyIndex body;
    Shape shape_B;
  };
  const std::vector<Drawn>& drawn() const { return drawn_; }
  const std::map<int, std::string>& names() const { return names_; }  ///< by index of the body
  const RigidInertia& replaced() const { return replaced_; }
  std::deque<Reference>& references() { return references_; }  ///< in the order of AddReference

 protected:
  /// The base, under gravity [m/s^2].
  RobotMultibody(const RigidInertia& base, double gravity);

  std::vector<SimTK::MobilizedBody> bodies_;

 private:
  RigidInertia base_, replaced_;
  std::map<int, std::string> names_;
  std::vector<Drawn> drawn_;
  std::deque<Reference> references_;
};

}  // namespace tenon
