#pragma once

#include <tenon/controllers/optimization/runge_kutta.h>
#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// The optimal control problem of CentroidalMpc, for Slq: the centroidal dynamics of a walking robot whose
/// feet push on the ground, and the choice of its footholds.
///
/// **Units.** Lengths are over the nominal height h of the CoM, masses over m, times over sqrt(h / g):
/// forces over m g, velocities over sqrt(g h), angular momenta over m h sqrt(g h). The equations and weights
/// then hold for robots of any size, and the linear inverted pendulum has the eigenvalues +-1.
///
/// **State.** Position c and velocity v of the CoM, rotation vector e from the reference attitude to the
/// actual one, angular momentum L about the CoM, and the horizontal positions p_i of the four feet, all in W.
///
/// **Inputs.** Each leg has four. On the ground they are the forces u_j >= 0 along the edges e_j of the
/// friction pyramid, f_i = sum_j u_j e_j, so bounds on inputs are friction cones. At a node at which the leg
/// lands (see Node::lands), the first two are the displacement d of the foothold from its nominal place below
/// the CoM.
///
/// **Steps.** A foot that stands for the fraction s_i of a step pushes with s_i f_i during all of it. With
/// the load (f, t), constant in a step of length T,
///
///     a  = sum s_i f_i + f - e_z                 c' = c + T v + T^2 a / 2,   v' = v + T a
///     tau = sum (r_i - c - T v / 2) x s_i f_i + t   L' = L + T tau
///     e' = e + T (J (L + T tau / 2) - w_ref)        p_i' = p_i, or c_xy + T v_xy + H (p_nom,i + d) at a
///     landing
///
/// with the contact point r_i = (p_i, z_i), the inverse J of the inertia at the reference attitude, its
/// angular velocity w_ref, and the heading H. The products of feet, CoM and forces are exact; the attitude is
/// of first order in e. The gyroscopic term is in L, which is the momentum in W.
class CentroidalWalkProblem {
 public:
  static constexpr int kStates = 12 + 2 * kNumLegs, kInputs = 4 * kNumLegs;
  using State = Eigen::Matrix<double, kStates, 1>;
  using Input = Eigen::Matrix<double, kInputs, 1>;
  using StateMatrix = Eigen::Matrix<double, kStates, kStates>;
  using InputMatrix = Eigen::Matrix<double, kInputs, kInputs>;
  using Tangent = Eigen::Matrix<double, kStates, kStates + kInputs>;
  using Vector = Eigen::Vector3d;

  /// Contacts, reference and bounds from a node to the next one.
  struct Node {
    std::array<double, kNumLegs> stands{};  ///< s_i, 0 to 1
    std::array<bool, kNumLegs> lands{};     ///< whether the foothold is chosen here; s_i is 0 then
    std::array<Vec<2>, kNumLegs> nominal;   ///< H p_nom,i
    std::array<double, kNumLegs> height{};  ///< z_i
    Vec<6> load = Vec<6>::Zero();           ///< (f, t)
    Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Identity();                        ///< J
    Eigen::Matrix<double, 2, 2, Eigen::DontAlign> heading = Eigen::Matrix2d::Identity();  ///< H
    Vector turn = Vector::Zero();                                                         ///< w_ref
    Vec<kStates> x = Vec<kStates>::Zero();                                                ///< x_ref
    Vec<kInputs> u = Vec<kInputs>::Zero(), lower = Vec<kInputs>::Zero(), upper = Vec<kInputs>::Zero();
    Vec<kInputs> R = Vec<kInputs>::Ones();  ///< weights of the inputs, per time

    Node() { nominal.fill(Vec<2>::Zero()); }
  };

  std::vector<Node> nodes;  ///< N + 1; only x of the last one is used
  Eigen::Matrix<double, 3, 4, Eigen::DontAlign> edges = Eigen::Matrix<double, 3, 4>::Zero();  ///< e_j
  Vec<kStates> Q = Vec<kStates>::Zero();    ///< weights of the errors of the state, per time
  Vec<kStates> Q_f = Vec<kStates>::Zero();  ///< weights of the final errors
  /// weight of |c + v|^2, horizontally, at the end: the divergent component of the motion
  double final_divergence = 0;

  explicit CentroidalWalkProblem(int num_steps) : nodes(static_cast<std::size_t>(num_steps) + 1) {}

  int num_states() const { return kStates; }
  int num_inputs() const { return kInputs; }
  double StageCost(int k, const State& x, const Input& u) const;
  void AddStageCost(int k, const State& x, const Input& u, double h, State& gx, Input& gu, StateMatrix& Hxx,
                    InputMatrix& Huu) const;
  double TerminalCost(const State& x) const;
  void AddTerminalCost(const State& x, State& gx, StateMatrix& Hxx) const;
  const Vec<kInputs>& Lower(int k) const { return At(k).lower; }
  const Vec<kInputs>& Upper(int k) const { return At(k).upper; }

  struct StepWorkspace {
    explicit StepWorkspace(int) {}
  };
  /// The step above, whatever the method; see TakesOwnSteps.
  void Step(int k, StepMethod, double T, const State& x, const Input& u, State& next) const;
  void LinearizeSteps(StepMethod, int count, const double* T, const State* x, const Input* u,
                      Tangent* tangents, StepWorkspace&) const;

  const Node& At(int k) const { return nodes[k]; }
  /// s_i f_i of a foot.
  Vector Force(int k, int leg, const Input& u) const {
    return At(k).stands[leg] * (edges * u.segment<4>(4 * leg));
  }
};

}  // namespace tenon
