#pragma once

#include <tenon/plants/legged/foot_contact.h>
#include <tenon/plants/multibody/point_force.h>
#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

/// The bodies of a quadruped as a Simbody model: a Free mobilizer for the trunk and twelve Pins.
///
/// Simbody computes the quantities that depend on the pose: body poses, and inertias in W. The stages of its
/// System are not used, nor its velocities, which take as long as the poses. A pass from the trunk to the
/// feet adds velocities and the centrifugal and gyroscopic forces. The equations of motion are then linear:
/// with 6 rows of the trunk (0) and 3 of each leg (l), which are coupled only through the trunk,
///
///     M_0 u_0' + sum F_l u_l' = f_0,   F_l^T u_0' + (M_l + D) u_l' = f_l,
///
/// with M and F from the composite rigid body algorithm (Featherstone 2008, section 6.2) about the trunk's
/// origin, and the rotors' inertia D on the diagonal. Each leg is eliminated by a 3 x 3 inverse, which leaves
/// 6 rows. This takes a third of the time of Simbody's articulated bodies, which do not model rotors, since
/// all legs are computed in parallel in vector registers. Gravity accelerates all masses equally, so it is
/// added to the trunk's acceleration at the end, which is exact.
///
/// Copies share the Simbody System, which is constant, and own a Simbody State, so threads can use one copy
/// each. For this reason forces are arguments, and the System has no force subsystem. All results depend on
/// the arguments and SetState() alone.
class QuadrupedBody {
 public:
  /// An empty model, to be assigned to.
  QuadrupedBody();
  explicit QuadrupedBody(const QuadrupedDescription& robot);
  QuadrupedBody(const QuadrupedBody& other);
  QuadrupedBody& operator=(const QuadrupedBody& other);
  ~QuadrupedBody();

  /// Sets the state of all functions below. The quaternion may have any non-zero length.
  void SetState(const LeggedState& x);

  FootMotion Foot(int leg) const;
  /// Motion of a point given in a body's frame.
  FootMotion MotionOf(int body, const Vec<3>& p_B) const;
  /// Origin of a body in W [m].
  Vec<3> Origin(int body) const;
  /// Position in W of a point given in a body's frame [m].
  Vec<3> Position(int body, const Vec<3>& p_B) const;
  double KineticEnergy() const;  ///< rotors included [J]
  Vec<3> Com() const;            ///< [m]

  /// Accelerations under joint torques, forces and gravity [m/s^2].
  LeggedAcceleration Acceleration(const Vec<12>& torque, std::span<const PointForce> forces,
                                  double gravity) const;

 private:
  struct Model;
  struct Work;
  void Factorise();
  std::shared_ptr<const Model> model_;
  std::unique_ptr<Work> work_;
};

}  // namespace tenon
