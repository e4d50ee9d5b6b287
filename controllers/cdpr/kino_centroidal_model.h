#pragma once

#include <tenon/controllers/cdpr/loaded_platform.h>
#include <tenon/controllers/optimization/runge_kutta.h>
#include <tenon/plants/model/path.h>

namespace tenon {

/// State of the kino-centroidal model, (3.5): velocity of the CoM [m/s], angular momentum about the CoM over
/// the mass [m^2/s], position of the CoM [m], ZYX Euler angles [rad], all in W.
using CentroidalState = Eigen::Matrix<double, 12, 1>;

/// Returns the state (3.5) of a platform and its payload, about their common CoM; `euler` are the angles of
/// R_WB.
CentroidalState CentroidalStateOf(const LoadedPlatform& body, const Eigen::Vector3d& p_WB,
                                  const Eigen::Matrix3d& R_WB, const Eigen::Vector3d& euler,
                                  const Eigen::Vector3d& v_W, const Eigen::Vector3d& w_W);
CentroidalState CentroidalStateOf(const CdprDescription& robot, const PlatformState& platform,
                                  const Payload& payload = {});

/// Returns d(state of the platform alone)/d(state of `body`, the platform with its payload) for one motion,
/// near rest at the attitude `euler` [rad]: v = v' - w x c, p = p' - c, and w = m I^{-1} L' gives L.
Eigen::Matrix<double, 12, 12> ErrorsOfPlatform(const CdprDescription& robot, const LoadedPlatform& body,
                                               const Eigen::Vector3d& euler);

/// The kino-centroidal model of a cable robot with n massless cables, whose input are the tensions u >= 0
/// (Morlando 2023, eqs. (3.3)-(3.9), with (3.9) corrected for Euler angles):
///
///     dv/dt     = (1/m) (sum_i u_i lambda_i + f_s + f) + g,      g = (0, 0, -9.81)
///     dL/dt     = (1/m) (sum_i R r_i x u_i lambda_i + tau_s + tau)
///     dp/dt     = v
///     dTheta/dt = E(Theta)^{-1} w,   w = R I^{-1} R^T m L
///
/// f and tau are a constant load, f_s and tau_s the wrench of the robot's springs at p, R. lambda_i is the
/// direction from the attachment p + R r_i to the anchor. With pulleys it points to where the cable leaves
/// its pulley at a given pose, see SetPose(). The model is exact for a rigid platform. The result is not
/// finite at pitch = +-pi/2, where the Euler angles are singular, for a cable without length, and for angles
/// beyond a million rad.
///
/// It implements the steps of RungeKutta itself, see TakesOwnSteps. Step() computes four cables at a time,
/// one in each lane of a register; LinearizeSteps() computes four steps at a time.
///
/// n is 4 or 8, for which the loops over the cables are unrolled, or Eigen::Dynamic for any number. These are
/// instantiated in the library. They are not declared `extern template`, because GCC 12 then silently drops
/// the vector clones of the members.
template <int n>
class KinoCentroidalModel {
 public:
  static constexpr int kStates = 12, kInputs = n;
  using State = CentroidalState;
  using Input = Eigen::Matrix<double, n, 1>;
  using Tangent = typename DenseLinearization<12, n>::Tangent;

  Eigen::Matrix<double, 6, 1> load =
      Eigen::Matrix<double, 6, 1>::Zero();  ///< [f ; tau] in W, about the common CoM [N, N m]
  /// Sets the mass properties to those of the platform with its payload.
  void SetPayload(const CdprDescription& robot, const LoadedPlatform& body);
  /// Gives each of `nodes` nodes of a horizon anchors of its own, for anchors that move; SetAnchors() sets
  /// them.
  void SeparateNodes(int nodes) { anchor_W_ = anchor_W_.leftCols(3).eval().replicate(1, nodes); }
  /// Sets the points from which the cables run at node k to those at `time` [s], with pulleys to those at
  /// this pose, see SetPose(). Does not allocate.
  void SetAnchors(int k, const CdprDescription& robot, const MovingAnchors& anchors, double time,
                  const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  /// Sets the points where the cables leave their pulleys to those at this pose; before the first call they
  /// are the anchors, or the attachments for pulleys on the platform. Near the pose, forces are exact to
  /// first order in the pulley's plane, where the tangent turns about the exit point. If the platform moves
  /// by 40 cm on a cable of 4 m, the exit point of a pulley of 4 cm moves by 4 mm.
  void SetPose(const CdprDescription& robot, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);

  /// @throws ParameterError if n is not Eigen::Dynamic and the robot does not have n cables.
  explicit KinoCentroidalModel(const CdprDescription& robot);

  int num_states() const { return kStates; }
  int num_inputs() const { return n == Eigen::Dynamic ? cables_ : n; }
  void Derivative(const State& x, const Input& u, State& dx) const;

  /// See TakesOwnSteps.
  struct StepWorkspace {
    /// Derivative of the momentum's rate with respect to the tension of each cable, for all stages and lanes.
    Eigen::Matrix<double, 6 * 4 * StepTableau::kMaxStages, n> wrench;

    explicit StepWorkspace(int cables) : wrench(wrench.RowsAtCompileTime, cables) {}
  };
  void Step(int k, StepMethod method, double h, const State& x, const Input& u, State& next) const;
  void LinearizeSteps(StepMethod method, int count, const double* h, const State* x, const Input* u,
                      Tangent* tangents, StepWorkspace& workspace) const;

 protected:
  /// The point from which a cable runs at node k.
  Eigen::Vector3d ExitOf(int cable, int k) const { return anchor_W_.row(cable).segment(ColumnOf(k), 3); }

 private:
  static constexpr int kLanes =
      n == Eigen::Dynamic ? n : (n + 3) / 4 * 4;  // number of cables, rounded up to full registers
  struct Stage;
  /// First of the three columns of anchor_W_ at node k.
  Eigen::Index ColumnOf(int k) const { return anchor_W_.cols() == 3 ? 0 : 3 * k; }
  void CalcRate(Eigen::Index column, const internal::Lanes (&x)[3], const double* u,
                internal::Lanes (&dx)[3]) const;
  template <class Tension, class Wrench>
  void LinearizeFour(const int (&node)[4], const internal::Lanes (&x)[12], const Tension& u,
                     internal::Lanes (&dx)[12], Stage& f, const Wrench& wrench) const;
  template <int block>
  static void CalcColumn(const Stage* stages, const StepTableau& tableau, const internal::Lanes& h, int c,
                         const double* wrench, internal::Lanes (&sum)[12]);

  /// Rates of v and L by the springs; `by_pose` receives their derivatives with respect to p and Theta.
  Eigen::Matrix<double, 6, 1> RatesBySprings(const Eigen::Vector3d& p_W, const Eigen::Vector3d& euler,
                                             Eigen::Matrix<double, 6, 6>* by_pose) const;

  int cables_;
  std::vector<SpringDescription> springs_;  // attachments from the common CoM
  double gravity_;                          // 0 on a table [m/s^2]
  double mass_inverse_;
  Eigen::Matrix3d inertia_inverse_;  // m I^{-1}, in B
  // One row per cable; anchors that move have three columns per node of the horizon.
  Eigen::Matrix<double, kLanes, Eigen::Dynamic> anchor_W_;
  Eigen::Matrix<double, kLanes, 3> attachment_B_;
  Eigen::Vector3d com_B_ = Eigen::Vector3d::Zero();  // the common CoM of platform and payload
};

}  // namespace tenon
