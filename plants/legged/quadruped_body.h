#pragma once

#include <tenon/plants/legged/foot_contact.h>
#include <tenon/plants/signals/legged_signals.h>

#include <Eigen/Core>

#include <memory>
#include <span>

namespace tenon {

/// A force on a point of a quadruped, the point given in W, and a torque.
struct PointForce {
  int body;                          ///< 0 the trunk, 1 + j the body that joint j moves
  Vec<3> p_W;                        ///< [m]
  Vec<3> force_W;                    ///< [N]
  Vec<3> torque_W = Vec<3>::Zero();  ///< [N m]
};

/// The bodies of a quadruped as a Simbody model: a Free mobilizer for the trunk and twelve Pins.
///
/// Simbody gives what depends on the pose: where the bodies are, and their inertias in W. Stages of its
/// System are not used, nor its velocities, which cost it as much as the poses. One pass from the trunk to
/// the feet adds what the motion does without accelerations: velocities, and the forces that bodies take for
/// centrifugal and gyroscopic effects. What remains is linear: with 6 rows of the trunk (0) and 3 of each leg
/// (l), which touch no other leg's,
///
///     M_0 u_0' + sum F_l u_l' = f_0,   F_l^T u_0' + (M_l + D) u_l' = f_l,
///
/// with M and F by composite rigid bodies (Featherstone 2008, section 6.2) about the trunk's origin, and the
/// rotors' inertia D on the diagonal. Each leg is eliminated by its 3 x 3 inverse, and 6 rows are left. This
/// takes a third as long as Simbody's articulated bodies, which know no rotors: all legs go through it at a
/// time, in the lanes of vectors. Gravity accelerates all masses alike, so it is added to the trunk's
/// acceleration at the end, as is exact.
///
/// Copies share the Simbody System, which is constant, and have a Simbody State each, so that threads can run
/// one of them each; hence forces are arguments and no force subsystem is in the System. What is returned
/// depends on the arguments alone.
class QuadrupedBody {
 public:
  /// No robot yet: good to be assigned to.
  QuadrupedBody();
  explicit QuadrupedBody(const QuadrupedDescription& robot);
  QuadrupedBody(const QuadrupedBody& other);
  QuadrupedBody& operator=(const QuadrupedBody& other);
  ~QuadrupedBody();

  /// Everything below is for this state. The quaternion may have any length but zero.
  void SetState(const LeggedState& x);

  FootMotion Foot(int leg) const;
  /// A point in a body's frame, in W [m].
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
