#pragma once

#include <tenon/controllers/cdpr/loaded_platform.h>
#include <tenon/controllers/optimization/runge_kutta.h>
#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/cdpr_signals.h>

#include <Eigen/Core>

namespace tenon {

/// State of the kino-centroidal model, (3.5): velocity of the CoM [m/s], angular momentum about the CoM over
/// the mass [m^2/s], position of the CoM [m], ZYX Euler angles [rad], all in W.
using CentroidalState = Eigen::Matrix<double, 12, 1>;

/// The state (3.5) of a platform and its payload, about their common CoM; `euler` are the angles of R_WB.
CentroidalState CentroidalStateOf(const LoadedPlatform& body, const Eigen::Vector3d& p_WB,
                                  const Eigen::Matrix3d& R_WB, const Eigen::Vector3d& euler,
                                  const Eigen::Vector3d& v_W, const Eigen::Vector3d& w_W);
CentroidalState CentroidalStateOf(const CdprDescription& robot, const PlatformState& platform,
                                  const Payload& payload = {});

/// d(state of the platform alone)/d(state of `body`, the platform with its payload), both of one motion, near
/// rest at the attitude `euler` [rad]: v = v' - w x c, p = p' - c, and w = m I^{-1} L' gives L.
Eigen::Matrix<double, 12, 12> ErrorsOfPlatform(const CdprDescription& robot, const LoadedPlatform& body,
                                               const Eigen::Vector3d& euler);

/// The kino-centroidal model of a cable robot with n massless cables, whose input are the tensions u >= 0
/// (Morlando 2023, eqs. (3.3)-(3.9), with (3.9) as it must read in Euler angles):
///
///     dv/dt     = (1/m) (sum_i u_i lambda_i + f) + g,      g = (0, 0, -9.81)
///     dL/dt     = (1/m) (sum_i R r_i x u_i lambda_i + tau)
///     dp/dt     = v
///     dTheta/dt = E(Theta)^{-1} w,   w = R I^{-1} R^T m L
///
/// f and tau are a constant load. lambda_i is the direction from attachment p + R r_i to anchor. Exact for a
/// rigid platform. Singular at pitch = +-pi/2 and where a cable has no length: the result is not finite
/// there.
///
/// n is 4 to 8, for which the loops over the cables are unrolled, or Eigen::Dynamic for any number. These are
/// instantiated in the library. They are not declared `extern template`: GCC 12 then drops the vector clones
/// of the members without a word.
template <int n>
class KinoCentroidalModel {
 public:
  static constexpr int kStates = 12, kInputs = n;
  using State = CentroidalState;
  using Input = Eigen::Matrix<double, n, 1>;

  /// The Jacobians by blocks; the rest of fx is zero but for d(dp/dt)/dv = 1.
  struct Linearization {
    Eigen::Matrix<double, 6, 6> momentum_by_pose;  ///< rows v, L; columns p, Theta
    Eigen::Matrix<double, 6, n> momentum_by_tension;
    Eigen::Matrix3d euler_by_momentum;  ///< d(dTheta/dt)/dL
    Eigen::Matrix3d euler_by_euler;     ///< d(dTheta/dt)/dTheta
    using Tangent = typename DenseLinearization<12, n>::Tangent;

    explicit Linearization(int = kStates, int cables = n) : momentum_by_tension(6, cables) {}
    int cables() const { return n == Eigen::Dynamic ? static_cast<int>(momentum_by_tension.cols()) : n; }
    void Multiply(const Tangent& tangent, Tangent& rate) const;
    void MultiplyIdentity(Tangent& rate) const {
      rate.setZero();
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) rate(r, 6 + c) = momentum_by_pose(r, c);
        for (int c = 0; c < cables(); ++c) rate(r, 12 + c) = momentum_by_tension(r, c);
      }
      for (int r = 0; r < 3; ++r) {
        rate(6 + r, r) = 1;
        for (int c = 0; c < 3; ++c) {
          rate(9 + r, 3 + c) = euler_by_momentum(r, c);
          rate(9 + r, 9 + c) = euler_by_euler(r, c);
        }
      }
    }
  };

  Eigen::Matrix<double, 6, 1> load =
      Eigen::Matrix<double, 6, 1>::Zero();  ///< [f ; tau] in W, about the CoM of all that moves [N, N m]
  /// From now on the platform with what it carries.
  void SetPayload(const CdprDescription& robot, const LoadedPlatform& body);

  /// @throws ParameterError if the robot has not n cables, n not Eigen::Dynamic.
  explicit KinoCentroidalModel(const CdprDescription& robot);

  int num_states() const { return kStates; }
  int num_inputs() const { return static_cast<int>(anchor_W_.cols()); }
  void Derivative(const State& x, const Input& u, State& dx) const;
  void Linearize(const State& x, const Input& u, State& dx, Linearization& f) const;

 private:
  struct Attitude;
  double mass_inverse_;
  Eigen::Matrix3d inertia_inverse_;                                       // m I^{-1}, in B
  Eigen::Matrix<double, 3, n, Eigen::RowMajor> anchor_W_, attachment_B_;  // cables side by side
};

}  // namespace tenon
