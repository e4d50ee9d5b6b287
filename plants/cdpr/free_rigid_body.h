#pragma once

#include <tenon/plants/signals/cdpr_signals.h>

#include <Eigen/Core>

#include <memory>

namespace tenon {

/// One rigid body that moves freely, as a Simbody model (a Free mobilizer with a quaternion), and perhaps a
/// point mass fixed to it.
///
/// Simbody gives the spatial inertia M in W, from which comes the gyroscopic force b. The mass properties of
/// its bodies belong to the topology and cannot change in a run, so the point mass m at r = R_WB p_B adds its
/// own share: with the spatial inertia M_m about the body's origin and w the angular velocity, all spatial
/// vectors angular before linear,
///
///     (M + M_m) [alpha; a] = [torque; force] - b - [r x c; c],   c = m w x (w x r),
///
/// which is exact, with one Cholesky factorisation for both. It needs Simbody's Position stage alone: forward
/// dynamics, which for one body solves the same six equations, would take five times as long and allocate.
/// Gravity accelerates all masses alike: it is added to a last, as is exact.
///
/// Copies share the Simbody System, which is constant, and have a Simbody State each, so that threads can run
/// one of them each. This requires a System without force subsystems; forces are therefore arguments.
/// Values depend only on the arguments of the last Calc. Calc does not allocate. Throws ParameterError if
/// Simbody refuses the inertia.
class FreeRigidBody {
 public:
  /// An empty object, to be assigned to.
  FreeRigidBody();
  /// `mass` [kg] and `inertia_B` [kg m^2] about the CoM, which is the origin of B.
  FreeRigidBody(double mass, const Eigen::Matrix3d& inertia_B);
  FreeRigidBody(const FreeRigidBody& other);
  FreeRigidBody& operator=(const FreeRigidBody& other);
  ~FreeRigidBody();

  /// Computes what the functions below return. The quaternion may have any length but zero.
  void Calc(const PlatformState& x, const PlatformWrench& wrench, const Payload& payload, double gravity);

  const PlatformAcceleration& acceleration() const { return acceleration_; }
  /// d q_WB / dt, which leaves the length of the quaternion as it is.
  const Vec<4>& quaternion_rate() const { return quaternion_rate_; }
  /// Kinetic energy of body and point mass [J].
  double kinetic_energy() const { return kinetic_energy_; }

 private:
  struct Model;
  struct Work;
  std::shared_ptr<const Model> model_;
  std::unique_ptr<Work> work_;
  PlatformAcceleration acceleration_;
  Vec<4> quaternion_rate_ = Vec<4>::Zero();
  double kinetic_energy_ = 0;
};

}  // namespace tenon
