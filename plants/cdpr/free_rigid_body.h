#pragma once

#include <tenon/plants/signals/cdpr_signals.h>

namespace tenon {

/// One rigid body that moves freely, as a Simbody model (a Free mobilizer with a quaternion), optionally with
/// a point mass fixed to it.
///
/// Simbody computes the spatial inertia M in W, from which the gyroscopic force b follows. Simbody's mass
/// properties belong to the topology and cannot change during a run, so the point mass m at r = R_WB p_B is
/// added here. With its spatial inertia M_m about the body's origin and the angular velocity w, and with
/// spatial vectors angular before linear,
///
///     (M + M_m) [alpha; a] = [torque; force] - b - [r x c; c],   c = m w x (w x r),
///
/// which is exact and needs one Cholesky factorisation for both. Only Simbody's Position stage is used: its
/// forward dynamics, which solves the same six equations for one body, would take five times as long and
/// allocate. Gravity accelerates all masses equally, so it is added to a at the end, which is exact.
///
/// Copies share the Simbody System, which is constant, and own a Simbody State, so that threads can use one
/// copy each. For this reason forces are arguments, and the System has no force subsystem. Results depend
/// only on the arguments of the last Calc, which does not allocate. Throws ParameterError if Simbody rejects
/// the inertia.
class FreeRigidBody {
 public:
  /// An empty object, to be assigned to.
  FreeRigidBody();
  /// `mass` [kg] and `inertia_B` [kg m^2] about the CoM, which is the origin of B.
  FreeRigidBody(double mass, const Eigen::Matrix3d& inertia_B);
  FreeRigidBody(const FreeRigidBody& other);
  FreeRigidBody& operator=(const FreeRigidBody& other);
  ~FreeRigidBody();

  /// Computes the results of the functions below. The quaternion may have any non-zero length.
  void Calc(const PlatformState& x, const PlatformWrench& wrench, const Payload& payload, double gravity);

  const PlatformAcceleration& acceleration() const { return acceleration_; }
  /// Kinetic energy of body and point mass [J].
  double kinetic_energy() const { return kinetic_energy_; }

 private:
  struct Model;
  struct Work;
  std::shared_ptr<const Model> model_;
  std::unique_ptr<Work> work_;
  PlatformAcceleration acceleration_;
  double kinetic_energy_ = 0;
};

}  // namespace tenon
