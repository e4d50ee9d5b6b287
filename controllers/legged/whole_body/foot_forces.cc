#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>

namespace tenon {
namespace {

/// Weight of |f|^2, see SolveFootForces: 0 for a regular leg.
double Damping(const Eigen::Matrix3d& J, double min_singular_value) {
  // The smallest singular value is |det J| over the product of the others, which is at most |J|^2 / 2.
  if (2 * std::abs(J.determinant()) >= min_singular_value * J.squaredNorm()) return 0;
  const double square = internal::DirectSymmetricEigenvalues3(J * J.transpose())[0];
  return std::max(0.0, min_singular_value * min_singular_value - std::max(0.0, square));
}

}  // namespace

Vec<3> SolveForce(const Eigen::Matrix3d& J, const Vec<3>& torque, double min_singular_value) {
  const double damping = Damping(J, min_singular_value);
  if (damping == 0) return J.transpose().inverse() * torque;
  const Eigen::Matrix3d normal = J * J.transpose() + damping * Eigen::Matrix3d::Identity();
  return internal::SolveCholesky<3>(normal, J * torque);
}

FootForces SolveFootForces(const QuadrupedDynamics& dynamics, const Vec<12>& torque,
                           double min_singular_value) {
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg)
    forces[leg] = SolveForce(dynamics.foot(leg).J_leg, torque.segment<3>(3 * leg), min_singular_value);
  return forces;
}

FootForces SolveFootForces(const QuadrupedDynamics& dynamics, const DecoupledDynamics& decoupled,
                           const Vec<12>& torque, double min_singular_value) {
  double damping = 0;
  for (int leg = 0; leg < kNumLegs; ++leg)
    damping = std::max(damping, Damping(dynamics.foot(leg).J_leg, min_singular_value));
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  Vec<12> f;
  if (damping == 0) {
    f = internal::SolveLu<12>(decoupled.J_q.transpose(), torque);
  } else {
    Matrix12 normal = Matrix12::Identity() * damping;
    normal.noalias() += decoupled.J_q * decoupled.J_q.transpose();
    f = internal::SolveCholesky<12>(normal, decoupled.J_q * torque);
  }
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg) forces[leg] = f.segment<3>(3 * leg);
  return forces;
}

Vec<12> GroundTorque(const QuadrupedDynamics& dynamics, const FootForces& forces, const Vec<3>& arm_W) {
  Vec<12> torque;
  for (int leg = 0; leg < kNumLegs; ++leg)
    torque.segment<3>(3 * leg) =
        dynamics.LegJacobian(leg, dynamics.foot(leg).p_W + arm_W).transpose() * forces[leg];
  return torque;
}

Vec<12> DecoupledGroundTorque(const QuadrupedDynamics& dynamics, const FootForces& forces,
                              const Vec<3>& arm_W) {
  Eigen::Matrix<double, 6, 1> on_trunk = Eigen::Matrix<double, 6, 1>::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    on_trunk.head<3>() += forces[leg];
    on_trunk.tail<3>() += (dynamics.foot(leg).p_W + arm_W - dynamics.base_W).cross(forces[leg]);
  }
  const internal::Cholesky<6> inertia(dynamics.M.topLeftCorner<6, 6>());
  return GroundTorque(dynamics, forces, arm_W) -
         dynamics.M.bottomLeftCorner<12, 6>() * inertia.Solve<1>(on_trunk);
}

}  // namespace tenon
